"""Stick, stick-slip and sliding told apart on made-up records and on the closed form of a mass on a belt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.contact.laws.parameters import Friction
from creak.dynamics.history import History
from creak.verify.rubbing import SLIDING, STICK, STICK_SLIP, pressing, rub_of, rubbing
from helpers_core import channels, history_of

H, END, N = 1e-4, 1.0, 10.0
TIME = H * np.arange(round(END / H) + 1)
WHOLE = (0.0, END)


def gaps(m: int = 1):
    friction = Friction(np.full(m, 0.5), np.full(m, 0.3), np.zeros(m))
    return replace(channels(np.eye(m), 0.0, 1e3), friction=friction)


def record(speed: np.ndarray, force: np.ndarray | float = N) -> History:
    """Slip speeds (n_time,) or (n_time, m) along the first tangent, with kinetic friction .3."""
    speed = np.asarray(speed, dtype=float).reshape(TIME.size, -1)
    m = speed.shape[1]
    force = np.broadcast_to(np.reshape(force, (-1, 1)), (TIME.size, m)).copy()
    sliding, tangential = np.zeros((TIME.size, 2 * m)), np.zeros((TIME.size, 2 * m))
    sliding[:, ::2], tangential[:, ::2] = speed * (force > 0.0), -0.3 * force * np.sign(speed)
    return history_of(TIME, np.zeros(force.shape), force, tangential=tangential, sliding=sliding)


def bumps(period: float, duration: float, end: float = END, speed: float = 0.02) -> np.ndarray:
    """Half waves of slip at the end of each period; trapezoidal length 2 / pi speed duration."""
    late = np.mod(TIME, period) - (period - duration)
    return np.where((late > 1e-12) & (end > TIME), speed * np.sin(np.pi * late / duration), 0.0)


def of(history: History, window: tuple[float, float] = WHOLE):
    found = rubbing(history, gaps(history.force.shape[1]), np.arange(history.force.shape[1]), window)
    assert found is not None
    assert sum(found.shares) == pytest.approx(1.0)
    return found


def test_stick_slip_as_regular_as_a_clock():
    """20 slips of .01 s, the last of which ends with the record, one each .05 s."""
    r = of(record(bumps(0.05, 0.01)))
    assert r.state == STICK_SLIP
    assert len(r.slips) == 20
    assert r.rate == pytest.approx(20.0, rel=1e-3)
    assert r.irregularity == pytest.approx(0.0, abs=1e-3)
    assert r.share == pytest.approx(0.2, rel=0.02)  # to a step at both ends of each slip
    length = 20 * 2.0 / np.pi * 0.02 * 0.01
    assert r.path == pytest.approx(length, rel=1e-3)
    assert r.energy == pytest.approx(0.3 * N * length, rel=1e-3)


def test_a_window_counts_what_begins_in_it():
    r = of(record(bumps(0.05, 0.01)), (0.5, 0.745))
    assert len(r.slips) == 5  # the last begins at .74 and is half in it
    assert r.slip_time == pytest.approx(0.045, rel=0.03)
    assert r.contact_time == pytest.approx(0.245, rel=1e-3)


@pytest.mark.parametrize("at", [0.1, 0.5])
def test_one_slip_is_no_stick_slip(at):
    r = of(record(np.where(abs(TIME - at) < 0.005, 0.01, 0.0)))
    assert r.state == STICK
    assert (len(r.slips), r.rate) == (1, None)


def test_a_long_slide_between_two_sticks_is_sliding():
    r = of(record(np.where((TIME > 0.1) & (TIME < 0.9), 0.01, 0.0)))
    assert r.state == SLIDING
    assert r.share == pytest.approx(0.8, abs=1e-3)


@pytest.mark.parametrize("stops", [False, True])
def test_a_squeak_that_dies_out_into_sliding(stops):
    """12 slips in .12 s, then it slides; whether it comes to rest once more at the end changes nothing."""
    speed = bumps(0.01, 0.004, 0.12)
    speed[TIME > 0.125] = 0.01
    if stops:
        speed[TIME > 0.99] = 0.0
    r = of(record(speed))
    assert r.state == SLIDING
    assert r.rate == pytest.approx(100.0, rel=0.02) or stops
    assert r.shares[1] == pytest.approx(0.114, abs=2e-3)


def test_reversals_of_sliding_are_no_sticks():
    r = of(record(np.sin(2.0 * np.pi * 5.0 * TIME + 0.3)))
    assert (r.state, len(r.slips)) == (SLIDING, 0)
    assert r.share == pytest.approx(1.0, abs=1e-3)
    assert r.speed_rms == pytest.approx(np.sqrt(0.5), rel=1e-3)


def test_contact_that_opens_ends_a_squeak():
    """Hits of .02 s, in the middle of each of which it slips once: each by itself, between two sticks."""
    pressed = np.mod(TIME, 0.1) < 0.02
    late = np.mod(TIME, 0.1)
    r = of(record(np.where((late > 0.005) & (late < 0.01), 0.1, 0.0), np.where(pressed, N, 0.0)))
    assert r.contact_time == pytest.approx(0.2, rel=0.02)
    assert len(r.slips) == 10
    assert r.shares[1] == 0.0
    assert r.state == STICK


def test_what_begins_with_the_run_is_no_slip():
    """A belt that starts with a jerk drags at once: what was before is not known."""
    speed = bumps(0.1, 0.01)
    speed[1:40] = 0.01
    r = of(record(speed))
    assert r.slips[0][0] > 0.05
    assert r.rate == pytest.approx(10.0, rel=1e-3)


def test_channels_slide_as_one_by_the_force_that_they_carry():
    """One that carries a third of the force slides throughout, one with two thirds slips by turns."""
    turns, on = bumps(0.05, 0.01), np.full(TIME.size, 0.01)
    history = record(np.stack([turns, on], axis=1))
    history.force[:, 1] *= 0.5
    history.tangential[:, 2] *= 0.5
    r = of(history)
    assert r.state == STICK_SLIP
    assert len(r.slips) == 20
    assert r.share == pytest.approx((2.0 * 0.2 + 1.0) / 3.0, rel=0.02)
    assert r.path == pytest.approx((2.0 * of(record(turns)).path + of(record(on)).path) / 3.0)
    assert r.energy == pytest.approx(of(record(turns)).energy + 0.5 * of(record(on)).energy)


def test_lasting_contact_is_told_by_its_force():
    """10 N and 2 N at 20 Hz, below the low-pass; 5 N at 2 kHz, above it."""
    slow, fast = np.sin(2.0 * np.pi * 20.0 * TIME), np.sin(2.0 * np.pi * 2000.0 * TIME)
    history = record(0.0 * TIME, N + 2.0 * slow + 5.0 * fast)
    found = pressing(history, np.array([0]), WHOLE, 500.0)
    assert found is not None
    assert found.mean == pytest.approx(N, rel=1e-3)
    assert found.rms == pytest.approx(2.0 / np.sqrt(2.0), rel=1e-2)
    hits = record(0.0 * TIME, np.where(np.mod(TIME, 0.5) < 0.4, N, 0.0))
    assert pressing(hits, np.array([0]), WHOLE, 500.0) is None


def test_force_in_a_window_shorter_than_a_period_of_the_low_pass():
    """None of the instants of the low-pass lies in it: five of the record do, over one period of the ripple."""
    history = record(0.0 * TIME, N + np.sin(2.0 * np.pi * TIME / 5e-4))
    found = pressing(history, np.array([0]), (0.5000999, 0.5005001), 50.0)
    assert found.mean == pytest.approx(N, rel=1e-9)
    assert found.rms == pytest.approx(np.sqrt(0.5), rel=1e-9)


def test_without_friction_there_is_force_alone():
    none = replace(gaps(), friction=None)
    rub = rub_of(record(0.0 * TIME), none, np.array([0]), WHOLE, 500.0)
    assert rub.friction is None
    assert set(rub.figures) == {"force_mean", "force_rms"}
    assert rub_of(record(0.0 * TIME, 0.0), none, np.array([0]), WHOLE, 500.0).figures == {}
