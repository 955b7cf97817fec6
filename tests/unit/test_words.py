"""Shares, times and lists in plain words.

What tells one creak from another.
Records that are made when they are asked for.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace

import pytest

from creak import version
from creak.errors import shortened, told_apart
from creak.later import is_made, later
from creak.words import duration, first_few, listed, percent


@pytest.mark.parametrize(
    ("share", "digits", "text"),
    [
        (0.0, 2, "0 %"),
        (3e-9, 2, "0 %"),
        (3.4e-5, 2, "0.0034 %"),
        (-0.0034, 2, "-0.34 %"),
        (0.0999, 2, "10 %"),
        (0.994, 2, "99 %"),
        (12.34, 2, "1234 %"),
        (0.12345, 3, "12.3 %"),
        (1.2345, 3, "123 %"),
    ],
)
def test_shares_have_so_many_digits_and_no_powers_of_ten(share, digits, text):
    assert percent(share, digits) == text


def test_lists_end_in_and():
    assert [listed(items) for items in (["a"], ["a", "b"], ["a", "b", "c"])] == ["a", "a and b", "a, b and c"]


def test_the_first_few_and_how_many_there_are_besides():
    assert [first_few(items, 2) for items in ([], ["a"], ["a", "b"], ["a", "b", "c", "d"])] == [
        "",
        "a",
        "a, b",
        "a, b and 2 more",
    ]
    assert first_few(range(7), name=lambda k: f"N{k}") == "N0, N1, N2, N3, N4 and 2 more"


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (2.1e-5, "21 us"),
        (1.54e-4, "154 us"),
        (4.2e-3, "4.2 ms"),
        (0.0997, "100 ms"),
        (38.0, "38 s"),
        (99.7, "100 s"),
        (720.0, "12 min"),
        (18720.0, "5.2 h"),
        (5.4e5, "150 h"),
    ],
)
def test_times_have_two_digits_and_no_powers_of_ten(seconds, text):
    assert duration(seconds) == text


def test_the_edition_of_a_source_tree_changes_with_its_files(tmp_path, monkeypatch):
    here = tmp_path / "src" / "creak"
    here.mkdir(parents=True)
    (here / "version.py").write_text("", encoding="utf-8")
    monkeypatch.setattr(version, "__file__", str(here / "version.py"))
    edition = version.edition.__wrapped__
    assert edition() == version.version()  # installed: no sources of its own
    (tmp_path / "pyproject.toml").write_text("", encoding="utf-8")
    before = edition()
    assert before.startswith(version.version())
    os.utime(here / "version.py", (1e9, 1e9))
    assert edition() != before


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


LONG = [f"BRACKET_DASHBOARD_LEFT_UPPER_REINFORCEMENT_{x}_TO_GLOVEBOX_LID_INNER_SKIN {n}" for x, n in ("A1", "B1", "B2")]


@pytest.mark.parametrize("most", [48, [48, 40, 44]])
def test_long_names_that_stand_together_do_not_look_alike(most):
    """A cut in the middle would take what tells the first from the second, and keeps what tells the others apart."""
    short = told_apart([*LONG, "short"], most if isinstance(most, int) else [*most, 10])
    assert max(map(len, short)) <= 48
    assert "_A_TO" in short[0]
    assert "_B_TO" in short[1]
    assert short[2].endswith("SKIN 2")
    assert short[3] == "short"


def test_names_that_no_cut_tells_apart_are_whole():
    names = [f"{x}{'-' * 90}{y}" for x, y in ("ab", "ab", "bb", "ba")]
    mixed = [f"{'-' * 40}{x}{'-' * 40}{y}{'-' * 20}" for x, y in ("ab", "aa", "bb")]
    assert told_apart(names[:2], 20) == [shortened(names[0], 20)] * 2
    assert told_apart(mixed, 30) == mixed
