"""Records that are made when they are asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace

from creak.later import is_made, later


@dataclass(frozen=True)
class Beam:
    length: float
    area: float = 1.0
    """A default, which must not be taken for the value."""

    @property
    def volume(self) -> float:
        return self.length * self.area


def test_what_is_known_is_told_and_the_rest_is_made_once():
    made = []

    def make():
        made.append(1)
        return Beam(2.0, 3.0)

    beam = later(Beam, make, length=2.0)
    assert isinstance(beam, Beam)
    assert (beam.length, is_made(beam), made) == (2.0, False, [])
    assert (beam.area, beam.volume, is_made(beam), made) == (3.0, 6.0, True, [1])


def test_a_copy_has_all_fields_and_two_records_do_not_share_them():
    beam, other = (later(Beam, lambda area=area: Beam(2.0, area), length=2.0) for area in (3.0, 4.0))
    assert replace(beam, length=5.0).volume == 15.0
    assert (beam.area, other.area) == (3.0, 4.0)
