"""What the excitation radiates without contact: a piston on a spring on a shaken support, against its closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.assembly.damping import Damping
from creak.assembly.system import Supports, System
from creak.dynamics.loads import Loads
from creak.linalg.diagonal import Diagonal
from creak.model.skin import skin_of
from creak.sound.head import Sphere
from creak.sound.rayleigh import AIR
from creak.sound.zwicker_tables import REFERENCE_PRESSURE
from creak.studies.sound.cabin import NOTHING
from creak.studies.sound.ear import Ear
from creak.studies.sound.listeners import Listener
from creak.studies.sound.radiation import radiation, record_of
from creak.studies.sound.road import _driven, _with_supports, road_levels, sum_of_levels
from helpers_core import block, model_of, plate, shell

RECORDED = {"section": "sound"}

SIDE, AWAY, MASS, STIFFNESS, ALPHA, BETA = 0.1, 1.5, 2.0, 2.0 * (2 * np.pi * 80.0) ** 2, 40.0, 1e-4
FREQ, ACCELERATION = 63.0, 3.0
"""Hz, m/s^2"""
BAND = 4
"""Row of the third octave of 63 Hz."""


@pytest.fixture(scope="module")
def piston():
    """All nodes of a small plate move together: with the support, and with the spring on it."""
    coords, elements = plate(4, 4, (SIDE, SIDE))
    model = model_of(coords, [block("quad4", elements, shell(1e-3))])
    labels = np.arange(6 * len(coords))

    def rows(wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        across = (wanted % 6 == 2).astype(float)[:, None]
        return across, across

    one, none = np.array([[MASS]]), np.zeros((1, 1))
    supports = Supports(("z",), one, none, none, one, none, none, one)
    alone = Diagonal(np.array([MASS])), Diagonal(np.array([STIFFNESS]))
    damping = Damping(ALPHA, BETA)
    return model, System("piston", *alone, damping, rows, supports, np.array([-1]), np.zeros(1), labels=labels)


def ear(model, band: float = 1000.0) -> Ear:
    position = np.array([SIDE / 2, SIDE / 2, AWAY])
    return Ear(Listener("ear", position, skin_of(model), ("PLATE",), True), band, 1.0)


def loads(acceleration: float, force: float = 0.0) -> Loads:
    """A support that swings around where it starts, and a force at one node."""
    time = np.arange(2001) / 1000.0
    omega = 2 * np.pi * FREQ
    a = acceleration * np.sin(omega * time)
    support = np.stack([0.3 - a / omega**2, -acceleration / omega * np.cos(omega * time), a])[:, :, None]
    return Loads(time, support, (5.0 + force * np.sin(omega * time))[:, None], (np.array([2]),))


def level(amplitude: complex) -> float:
    """dB of an acceleration of the piston."""
    pressure = AIR.density * SIDE**2 * abs(amplitude) / (2 * np.pi * AWAY)
    return 20 * np.log10(pressure / 2**0.5 / REFERENCE_PRESSURE)


def answer() -> complex:
    """Acceleration of the spring's mass per unit of force on it."""
    omega = 2 * np.pi * FREQ
    return -(omega**2) / (STIFFNESS - MASS * omega**2 + 1j * omega * (ALPHA * MASS + BETA * STIFFNESS))


def test_a_shaken_support_and_what_hangs_on_it_radiate_as_the_closed_form(piston, measured):
    """Damping alpha of the mass acts on the support's motion too: M q'' + C q' + K q = -M s'' - alpha M s'."""
    model, system = piston
    omega = 2 * np.pi * FREQ
    found = road_levels(system, loads(ACCELERATION), ear(model), (0.0, 2.0))
    push = -MASS * (1 + ALPHA / (1j * omega))
    true = level(ACCELERATION * (1 + push * answer()))
    measured("piston on a shaken support: level without contact", found[BAND], true, abs=0.2, unit="dB")
    assert found.argmax() == BAND
    assert (found[16:] == NOTHING).all()  # 1 kHz and above


def test_a_force_counts_with_what_changes_of_it(piston):
    model, system = piston
    found = road_levels(system, loads(0.0, force=4.0), ear(model), (0.5, 1.5))
    assert found[BAND] == pytest.approx(level(4.0 * answer()), abs=0.2)
    at_rest = road_levels(system, loads(0.0), ear(model), (0.0, 2.0))
    assert (at_rest == NOTHING).all()


def repeating(end: float, step: float = 1e-3, *, drift: float = 0.0, fade: float = 0.0) -> Loads:
    """A support that swings at 60 Hz, the sixth line of 10 Hz, and one of 20 Hz as strong, up to an end, s; it goes away
    at a mean acceleration and velocity, and comes in over a time."""
    time = step * np.arange(round(end / step) + 1)
    support = drift * np.stack([time + 0.5 * time**2, 1.0 + time, np.ones_like(time)])
    rise = np.clip(time / fade, 0.0, 1.0) ** 3 if fade else 1.0
    for f in (20.0, 60.0):
        omega = 2 * np.pi * f
        turns = [np.sin(omega * time + phase) for phase in (0.3, 0.3 + np.pi / 2, 0.3 + np.pi)]
        support += np.stack([ACCELERATION / omega**k * turn for k, turn in zip((2, 1, 0), turns, strict=True)])
    support[2] *= rise
    return Loads(time, support[:, :, None], np.zeros((time.size, 0)))


def steady() -> float:
    """dB that the piston on its spring sends at 60 Hz, of the support's acceleration."""
    omega = 2 * np.pi * 60.0
    held = STIFFNESS - MASS * omega**2 + 1j * omega * (ALPHA * MASS + BETA * STIFFNESS)
    push = -MASS * (1 + ALPHA / (1j * omega))
    return level(ACCELERATION * (1 - omega**2 * push / held))


@pytest.mark.parametrize("end", [0.1, 0.2, 0.5, 0.8, 0.9, 1.0, 1.037, 1.1, 1.7])
def test_levels_are_those_of_steady_motion_whatever_the_number_of_periods(piston, end):
    """Of the first period too, and of a run that ends within one."""
    model, system = piston
    found = road_levels(system, repeating(end), ear(model), (max(end - 0.1, 0.0), end), 0.1)
    assert found[BAND] == pytest.approx(steady(), abs=0.1)
    assert (found[[3, 5]] < found[BAND] - 10.0).all()  # 50 and 80 Hz: a filter's skirts, nothing that comes or goes


def test_what_goes_away_at_a_mean_velocity_and_acceleration_swings_as_loud(piston):
    model, system = piston
    found = road_levels(system, repeating(1.0, drift=5.0), ear(model), (0.9, 1.0), 0.1)
    np.testing.assert_allclose(found, road_levels(system, repeating(1.0), ear(model), (0.9, 1.0), 0.1), atol=1e-3)


def test_short_periods_are_as_loud_as_many_of_them(piston):
    """Half a period of 50 ms, 2.4 samples of 48 kHz off its own."""
    model, system = piston
    found = road_levels(system, repeating(0.35), ear(model), (0.3, 0.35), 0.05)
    assert found[BAND] == pytest.approx(steady(), abs=0.1)


@pytest.mark.parametrize("window", [(0.0, 0.1), (0.0, 0.6), (0.0, 2.0)])
def test_what_does_not_repeat_counts_where_it_neither_comes_nor_goes(piston, window):
    """Runs that are compared up to a time, and as a whole: at 60 Hz, within the steps of a part of its turns."""
    model, system = piston
    found = road_levels(system, repeating(2.0), ear(model), window)
    assert found[BAND] == pytest.approx(steady(), abs=0.6 if window[1] < 0.2 else 0.2)


def test_a_first_period_that_still_comes_in_is_not_repeated(piston):
    """Repeated it would jump; and there is none before a run that is shorter."""
    model, system = piston
    given = system, repeating(0.52, fade=0.45), ear(model)
    plain = road_levels(*given, (0.0, 0.52))
    np.testing.assert_array_equal(road_levels(*given, (0.02, 0.52), 0.5), plain)
    np.testing.assert_array_equal(road_levels(*given, (0.0, 0.52), 0.7), plain)


def test_both_ears_hear_a_small_source_as_the_head_says(piston, measured):
    """The piston at the left ear's side, node by node around the head, and its sound at the middle sent to the ears."""
    model, system = piston
    source, whole, left = _driven(system, loads(ACCELERATION)), _with_supports(system), np.array([0.0, 0.6, -0.8])
    middle = replace(ear(model).listener, looks=np.array([1.0, 0.0, 0.0]), left=left)
    offset = np.array([SIDE / 2, SIDE / 2, 0.0]) - middle.position
    plain, *both = (
        record_of(source, [np.arange(2)], radiation(whole, one, 1.0, 1000.0))[0] for one in (middle, *middle.ears)
    )
    for one, found, side in zip(middle.ears, both, (1, -1), strict=True):
        assert one.ear == {1: "left", -1: "right"}[side]
        exact = Sphere(side * left).at_ear(plain, 48_000.0, offset)
        off = np.abs(found - exact).max() / np.abs(exact).max()
        measured(f"small source at the {one.ear} ear: error over the peak", off, at_most=0.01)
    assert np.abs(both[0] - both[1]).max() > 0.05 * np.abs(plain).max()


def test_two_backgrounds_add_up_by_their_energy():
    one = np.full(28, 40.0)
    assert sum_of_levels(None, one) is one
    assert sum_of_levels(one, one) == pytest.approx(one + 10 * np.log10(2.0))
