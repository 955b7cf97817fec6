"""Stick-slip events on the closed form of a mass on a belt and on made-up records."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.contact.laws.parameters import Friction
from creak.dynamics.history import ENERGIES
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.verify.slips import find_slips, find_squeaks, squeak_rates
from helpers_core import channels, history_of, system_of

RECORDED = {"section": "friction", "source": "closed form"}

H = 1e-4
# Belt squeak: m = 1, k = 1e4, N = 10, mu .5 / .3, belt .01 m/s.
OMEGA, NORMAL, STATIC, KINETIC, BELT = 100.0, 10.0, 0.5, 0.3, 0.01
STICK, SLIP = 0.04, 0.0406888


def rubbing(m: int = 1, groups: tuple[str, ...] | None = None):
    gaps = channels(np.eye(m), 0.0, 1e3)
    gaps = replace(gaps, friction=Friction(np.full(m, STATIC), np.full(m, KINETIC), np.zeros(m)))
    return gaps if groups is None else replace(gaps, group=groups)


def rubbed(time: np.ndarray, speed: np.ndarray, tau: np.ndarray | None = None, force: np.ndarray | None = None):
    """A record of signed slip speeds (n_time, m) along the first tangent, pressed with NORMAL throughout."""
    speed = np.asarray(speed, dtype=float).reshape(time.size, -1)
    m = speed.shape[1]
    force = np.full((time.size, m), NORMAL) if force is None else np.asarray(force, float).reshape(time.size, m)
    sliding, tangential = np.zeros((time.size, 2 * m)), np.zeros((time.size, 2 * m))
    sliding[:, ::2] = speed
    tangential[:, ::2] = -KINETIC * force * np.sign(speed) if tau is None else tau
    return history_of(time, np.zeros(force.shape), force, tangential=tangential, sliding=sliding)


def belt_speed(time: np.ndarray) -> np.ndarray:
    """Slip speed of the mass against the belt: it slides back as x_c + A cos(omega t + phi) until it has the belt's."""
    amplitude = np.hypot((STATIC - KINETIC) * NORMAL / OMEGA**2, BELT / OMEGA)
    phi = -np.arcsin(BELT / OMEGA / amplitude)
    late = np.mod(time, STICK + duration()) - STICK
    return np.where(late > 0.0, -amplitude * OMEGA * np.sin(OMEGA * late + phi) - BELT, 0.0)


def duration() -> float:
    return (np.pi + 2.0 * np.arctan(BELT * OMEGA / ((STATIC - KINETIC) * NORMAL))) / OMEGA


def test_numbers_of_the_belt_are_its_closed_form():
    assert duration() == pytest.approx(SLIP, abs=1e-6)
    assert 1.0 / (STICK + duration()) == pytest.approx(12.3932817, rel=1e-7)


@pytest.mark.parametrize("uneven", [False, True])
def test_squeak_of_a_mass_on_a_belt(uneven, measured):
    """Stick .04 s, slip .0406888 s, 12.3932817 Hz, .80688788 mm of belt per cycle."""
    time = H * np.arange(8001)
    if uneven:
        time = np.delete(time, np.flatnonzero((np.mod(time, STICK + duration()) < 0.035) & (np.arange(8001) % 7 > 0)))
    history, gaps = rubbed(time, belt_speed(time)), rubbing()
    events = find_slips(history, gaps, 0.005)
    assert len(events) == 9
    for k, e in enumerate(events):
        # Speed starts linearly in time: extrapolated, off by O(omega h) of a step.
        assert e.t_start == pytest.approx(k * (STICK + duration()) + STICK, abs=0.02 * H)
        assert e.t_end == pytest.approx((k + 1) * (STICK + duration()), abs=0.02 * H)
        # The mass comes back to where it was, so it slips what the belt travels; trapezoid, (omega h)^2 and the ends.
        assert e.slip_length == pytest.approx(0.80688788e-3, rel=1e-4)
        assert e.friction_work == pytest.approx(KINETIC * NORMAL * 0.80688788e-3, rel=1e-4)
        assert e.speed_peak == pytest.approx(np.hypot(0.02, BELT) + BELT, rel=1e-4)
        assert (e.group, e.channel, len(e.slips), e.rate) == ("stop", "stop:0", 1, None)
    chain = find_slips(history, gaps, 0.05)
    assert len(chain) == 1
    measured("squeak of a block on a belt: rate", chain[0].rate, 12.3932817, rel=1e-5, unit="Hz")
    measured("squeak of a block on a belt: belt per cycle", events[0].slip_length, 0.80688788e-3, rel=1e-4, unit="m")
    measured(
        "squeak of a block on a belt: end of the first slip",
        events[0].t_end,
        STICK + duration(),
        abs=0.02 * H,
        unit="s",
    )
    assert chain[0].slip_length == pytest.approx(9 * 0.80688788e-3, rel=1e-4)
    # Windows of whole periods hold whole numbers of slips.
    assert squeak_rates(chain, (0.0, 4 * (STICK + duration())))["stop"] == pytest.approx(12.3932817, rel=1e-7)


def test_impulses_per_length_of_travel_of_the_belt(measured):
    """One slip each .80688788 mm of belt: 1.2393 per mm. In whole cycles travel is that of the belt."""
    time, cycle = H * np.arange(8001), STICK + duration()
    history, gaps = rubbed(time, belt_speed(time)), rubbing()
    assert [e.per_length for e in find_slips(history, gaps, 0.005)] == pytest.approx([1e3 * 1.2393295] * 9, rel=1e-4)
    (one,) = find_squeaks(history, gaps, (0.0, 8.0 * cycle))
    assert (one.group, one.channel, one.slips) == ("stop", "stop:0", 8)
    assert one.travel == pytest.approx(8 * BELT * cycle, rel=1e-4)
    assert one.slip_length == pytest.approx(0.80688788e-3, rel=1e-4)
    assert one.energy == pytest.approx(8 * KINETIC * NORMAL * 0.80688788e-3, rel=1e-4)
    assert one.rate == pytest.approx(12.3932817, rel=1e-7)
    measured(
        "squeak of a block on a belt: impulses per length of travel", one.per_length, 1239.33, rel=1e-4, unit="1/m"
    )


def test_the_squeak_of_a_pair_is_that_of_its_hardest_worked_channel_in_the_window():
    time = H * np.arange(300)
    speed = np.zeros((300, 2))
    speed[20:30, 0], speed[25:60, 1], speed[80:90, 1], speed[200:210, 0] = 1.0, 2.0, 2.0, 1.0
    speed[220:, 1] = 1.0  # slides on to the end: travel, and no slip between two sticks
    history = rubbed(time, speed)
    (one,) = find_squeaks(history, rubbing(2), (0.0, 300 * H))
    assert (one.channel, one.slips) == ("stop:1", 2)
    assert one.travel == pytest.approx(H * (45 * 2.0 + 79.5))
    assert one.per_length == pytest.approx(2 / one.travel)
    (late,) = find_squeaks(history, rubbing(2), (150 * H, 215 * H))
    assert (late.channel, late.slips, late.slip_length) == ("stop:0", 1, pytest.approx(10 * H))
    assert find_squeaks(history, rubbing(2), (100 * H, 150 * H)) == []


def test_sliding_from_the_touch_or_into_the_release_is_no_stick_slip():
    time = H * np.arange(100)
    speed = np.zeros(100)
    speed[20:30] = 1.0
    closed = np.full(100, NORMAL)
    assert len(find_slips(rubbed(time, speed, force=closed), rubbing(), 0.0)) == 1
    for rows in (slice(0, 20), slice(30, 100)):
        force = closed.copy()
        force[rows] = 0.0
        assert find_slips(rubbed(time, speed, force=force), rubbing(), 0.0) == []
    speed[20:] = 1.0
    assert find_slips(rubbed(time, speed), rubbing(), 0.0) == []  # not over by the end


def test_a_reversal_is_no_stick():
    """Sliding that swings through zero rests for one instant at most; two are a stick."""
    time = H * np.arange(100)
    speed = np.zeros(100)
    speed[20:60] = np.sin(2 * np.pi * np.arange(40) / 40 + 0.01)
    speed[40] = 0.0
    one = find_slips(rubbed(time, speed), rubbing(), 0.0)
    assert len(one) == 1
    assert one[0].slip_length == pytest.approx(H * np.abs(speed).sum())
    speed[41] = 0.0
    assert len(find_slips(rubbed(time, speed), rubbing(), 0.0)) == 2


def test_slips_of_a_pair_merge_and_the_hardest_worked_channel_leads():
    time = H * np.arange(300)
    speed = np.zeros((300, 2))
    speed[20:30, 0], speed[25:60, 1], speed[80:90, 1], speed[200:210, 0] = 1.0, 2.0, 2.0, 1.0
    history = rubbed(time, speed)
    first, second = find_slips(history, rubbing(2), 0.003)
    assert (first.channel, len(first.slips), second.channel) == ("stop:1", 2, "stop:0")
    assert first.t_start == pytest.approx(19 * H)
    assert first.friction_work == pytest.approx(KINETIC * NORMAL * H * (10 * 1.0 + 45 * 2.0))
    assert first.slip_length == pytest.approx(H * 45 * 2.0)
    assert first.rate == pytest.approx(1.0 / (55 * H))
    apart = find_slips(history, rubbing(2, ("a", "b")), 0.003)
    assert [e.group for e in apart] == ["a", "b", "a"]
    assert squeak_rates(apart, (0.0, 0.01)) == pytest.approx({"a": 100.0, "b": 200.0})


def test_only_rubbing_channels_count():
    """Columns of sliding belong to the channels that rub, in their order."""
    time = H * np.arange(50)
    speed = np.zeros(50)
    speed[10:20] = 1.0
    gaps = channels(np.eye(3), 0.0, 1e3)
    gaps = replace(gaps, friction=Friction(np.array([0.0, 0.0, 0.4]), np.array([0.0, 0.0, 0.4]), np.zeros(3)))
    one = rubbed(time, speed)
    force = np.zeros((50, 3))
    force[:, 2] = NORMAL
    every = replace(one, force=force, gap=np.zeros((50, 3)))
    assert [e.channel for e in find_slips(every, gaps, 0.0)] == ["stop:2"]


def test_what_slides_by_atoms_sticks():
    """A slide of 2 mm, ten of 1e-8 mm before and after it; alone, these are none beside a penetration of 1e-4 mm."""
    time, speed = H * np.arange(400), np.zeros(400)
    speed[200:220] = 1.0
    dust = np.arange(20, 190, 35)
    speed[dust] = speed[dust + 200] = 1e-7
    (only,) = find_slips(rubbed(time, speed), rubbing(), 0.0)
    assert only.slip_length == pytest.approx(2e-3, rel=1e-6)
    assert len(only.slips) == 1
    (squeak,) = find_squeaks(rubbed(time, speed), rubbing(), (0.0, time[-1]))
    assert squeak.slips == 1
    alone = rubbed(time, np.where(speed < 1e-3, speed, 0.0))
    assert find_slips(replace(alone, gap=np.full((400, 1), -1e-7)), rubbing(), 0.0) == []
    assert len(find_slips(alone, rubbing(), 0.0)) == 10


def test_without_friction_nothing_slips():
    history = rubbed(H * np.arange(20), np.ones(20))
    assert find_slips(history, channels(np.eye(1), 0.0, 1e3), 0.0) == []
    bare = replace(history, tangential=np.zeros((0, 0)), sliding=np.zeros((0, 0)))
    assert find_slips(bare, rubbing(), 0.0) == []


def test_squeak_is_found_in_a_computed_run():
    """The same belt, marched: in the frame of the belt the mass is pulled back ever harder until it slips."""
    h = 1e-4
    time = h * np.arange(4001)
    gaps = channels([[0.0, 1.0]], -NORMAL / 1e6, 1e6)
    gaps = replace(
        gaps,
        tangents=(channels([[1.0, 0.0]], 0.0, 0.0).G, channels([[0.0, 0.0]], 0.0, 0.0).G),
        friction=Friction(np.array([STATIC]), np.array([KINETIC]), np.zeros(1)),
        preload=np.array([NORMAL]),
    )
    pull = np.column_stack([-(OMEGA**2) * BELT * time, np.zeros(time.size)])
    loads = Loads(time, np.zeros((3, time.size, 0)), pull, (np.array([0]), np.array([1])))
    history = simulate(system_of(np.eye(2), OMEGA**2 * np.eye(2)), gaps, loads, HHT(), OutputRequest(np.arange(2)))
    events = find_slips(history, gaps, 0.005)
    assert len(events) == 4
    for e in events:
        # It breaks loose within a step of belt travel, k v h below the static limit.
        assert e.force_drop == pytest.approx((STATIC - KINETIC) * NORMAL, abs=1.5 * OMEGA**2 * BELT * h)
    # Slip begins and ends in a step that is known to one h.
    np.testing.assert_allclose(np.diff([e.t_start for e in events]), STICK + duration(), atol=2 * h)
    np.testing.assert_allclose([e.t_end - e.t_start for e in events], duration(), atol=2 * h)
    # One step of belt travel more or less, h / T of the whole.
    np.testing.assert_allclose([e.slip_length for e in events], 0.80688788e-3, rtol=2 * h / duration())
    took = history.energy[np.searchsorted(time, events[-1].t_end) + 1, ENERGIES.index("friction")]
    # So far all of it between two sticks; trapezoids of force times path and of force times speed differ by O(h).
    assert sum(e.friction_work for e in events) == pytest.approx(took, rel=2 * h / duration())
