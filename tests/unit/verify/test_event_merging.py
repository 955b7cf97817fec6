"""Which touches are one event: the way they push, the contact's own time scale, and contact that was there before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from creak.verify.events import find_events, resting
from creak.verify.matching import match_events
from creak.verify.sides import sides
from helpers_core import channels, system_of

STEP = 1e-3


def history_of(time: np.ndarray, gap: np.ndarray, stiffness: float = 1e3) -> History:
    gap = np.asarray(gap, dtype=float).reshape(time.size, -1)
    nothing, energy = np.zeros((time.size, 0)), np.zeros((time.size, len(ENERGIES)))
    force = stiffness * np.maximum(0.0, -gap)
    return History(time, gap, force, np.zeros_like(gap), np.arange(time.size), nothing, energy, 0, 0.0)


def fly(M: np.ndarray, K: np.ndarray, v: np.ndarray, gaps: GapOperator, end: float, pull: float = 0.0) -> History:
    time = STEP / SAMPLES * np.arange(SAMPLES * round(end / STEP) + 1)
    loads = Loads(time, np.zeros((3, time.size, 0)), np.full((time.size, 1), pull), (np.array([0]),))
    return simulate_flow(diagonalise(system_of(M, K, velocity=v)), gaps, loads, OutputRequest(np.arange(M.shape[0])))


def two_faces(play: float, stiffness: float) -> GapOperator:
    """Stops on both sides of the relative motion of dofs 0 and 1, one contact."""
    return channels([[-1.0, 1.0], [1.0, -1.0]], play, stiffness, group="hook")


# --- the way they push ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.0, 0.1, 0.3])
def test_an_event_ends_where_its_force_does(share):
    """A mass on a stop with a damper, of a share of the critical one, is let go before the gap is open again.

    k x + c x' = 0 at omega_d t = pi - atan(2 d (1 - d^2)^(1/2) / (1 - 2 d^2)), the gap alone would cross at pi.
    """
    v, omega, play = 1.0, 100.0, 1e-3
    gaps = channels([[-1.0]], play, omega**2, damping=2.0 * share * omega)
    event = find_events(history := fly(np.eye(1), np.zeros((1, 1)), np.array([v]), gaps, 0.08), gaps)[0]
    root = np.sqrt(1.0 - share**2)
    attached = (np.pi - np.arctan2(2.0 * share * root, 1.0 - 2.0 * share**2)) / (omega * root)
    assert event.t_start == pytest.approx(play / v, rel=1e-9)
    assert event.t_end - event.t_start == pytest.approx(attached, rel=1e-3)
    last = history.gap[np.searchsorted(history.time, event.t_end), 0]
    assert (last < -0.05 * v / omega) == (share > 0.0)


def test_both_sides_of_a_play_have_their_own_hits(measured):
    """Two free masses, play of 2.35 ms of flight, touches of 1.5 ms: 130 cycles a second, a hit on each side of each.

    Relative motion: speed 1, reduced mass 1/3, omega = pi / 1.5 ms; a hit carries the impulse 2 mu v.
    """
    v, flight, lasts, mu = 1.0, 2.346e-3, 1.5e-3, 1.0 / 3.0
    play, stiffness = 0.5 * flight * v, mu * (np.pi / lasts) ** 2
    history = fly(np.diag([1.0, 0.5]), np.zeros((2, 2)), np.array([0.0, v]), two_faces(play, stiffness), 1.026)
    gaps = two_faces(play, stiffness)
    for merge in (None, 0.005):
        events = find_events(history, gaps, merge)
        assert len(events) == 267
        assert [e.channel for e in events[:4]] == ["hook:1", "hook:0", "hook:1", "hook:0"]
        assert {e.contacts for e in events} == {1}
        assert sum(e.impulse for e in events) == pytest.approx(267 * 2.0 * mu * v, rel=1e-3)
        assert [e.closing_speed for e in events] == pytest.approx([v] * 267, rel=1e-4)
    measured("verdicts", "hits of a two-sided play at 130 Hz", len(events), 267, abs=0, source="closed form")


def test_sides_are_found_from_where_channels_push():
    slot = channels(np.vstack([np.eye(3)[[0, 0, 2]], -np.eye(3)[[0]]]), 1.0, 1e3)  # left wall, bottom, right wall
    slot = replace(slot, nodes_idx=np.zeros(4, dtype=np.int64))
    assert [s.tolist() for s in sides(slot)] == [[0, 1, 2], [3]]
    both = join([two_faces(1.0, 1e3), slot])
    assert [s.tolist() for s in sides(both)] == [[0], [1], [2, 3, 4], [5]]


def test_events_of_different_sides_do_not_match():
    t = 1e-4 * np.arange(1001)
    dip = np.where(np.abs(t - 0.05) < 0.002, -1.0, 1.0)
    open_ = np.ones_like(t)
    gaps = two_faces(1.0, 1e3)
    a, b = (find_events(history_of(t, np.column_stack(g)), gaps) for g in ((dip, open_), (open_, dip)))
    assert [e.side for e in a + b] == [0, 1]
    assert len(match_events(a, a, 0.01, (0.0, 1.0)).pairs) == 1
    match = match_events(a, b, 0.01, (0.0, 1.0))
    assert (len(match.pairs), len(match.missed), len(match.extra)) == (0, 1, 1)


# --- the contact's own time scale -----------------------------------------------------------------------------------


def test_a_body_that_hits_at_130_hz_has_an_event_for_each_hit():
    """Thrown back 130 times a second, off the stop for 4.6 ms each time, on it for the rest: impulse 2 m v + m g t."""
    v, flight, lasts = 1.0, 4.6e-3, 1.0 / 130.0 - 4.6e-3
    g = 2.0 * v / flight
    omega = brentq(lambda w: 2.0 / w * (np.pi - np.arctan(w * v / g)) - lasts, 1.0, 1e4)
    gaps = channels([[1.0]], 0.5 * v * v / g, omega**2)
    history = fly(np.eye(1), np.zeros((1, 1)), np.zeros(1), gaps, 0.5, -g)
    events = find_events(history, gaps, f_max=500.0)
    assert len(events) == 65
    assert [e.impulse for e in events] == pytest.approx([2.0 * v + g * lasts] * 65, rel=1e-3)
    np.testing.assert_allclose(np.diff([e.t_start for e in events]), 1.0 / 130.0, rtol=1e-4)


def test_chatter_within_a_blow_is_one_event():
    """Three touches of .1 ms, .3 and .6 ms apart, then the same 3 ms later: two blows at 500 Hz, eight at 5 kHz."""
    t = 1e-5 * np.arange(2001)
    starts = np.concatenate([0.002 + np.array([0.0, 0.4e-3, 1.1e-3]), 0.0062 + np.array([0.0, 0.4e-3, 1.1e-3])])
    gap = np.ones_like(t)
    for s in starts:
        gap[(t >= s - 1e-9) & (t < s + 1e-4 - 1e-9)] = -1.0
    found = {f: find_events(history_of(t, gap), channels([[1.0]], 1.0, 1e3), f_max=f) for f in (500.0, 5000.0)}
    assert [e.contacts for e in found[500.0]] == [3, 3]
    assert [e.contacts for e in found[5000.0]] == [1] * 6
    assert found[500.0][1].t_start == pytest.approx(0.0062, abs=1e-5)


@pytest.mark.parametrize(("pause", "count"), [(1.5e-3, 1), (2.5e-3, 2), (4.5e-3, 2)])
def test_contact_lost_for_less_than_it_lasts_is_one_event(pause, count):
    t = 1e-5 * np.arange(3001)
    begin = (0.005, 0.007 + pause)
    gap = np.ones_like(t)
    for s in begin:
        gap[(t > s) & (t < s + 0.002)] = -1.0
    assert len(find_events(history_of(t, gap), channels([[1.0]], 1.0, 1e3))) == count


def test_no_contact_is_lost_for_5_ms_within_an_event():
    t = 1e-4 * np.arange(1001)
    gap = np.where(np.abs(t - 0.05) < 0.003, 1.0, -1.0)
    gap[:10] = 1.0
    first, second = find_events(history_of(t, gap), channels([[1.0]], 1.0, 1e3))
    assert second.t_start - first.t_end == pytest.approx(0.006, abs=2e-4)


@pytest.mark.parametrize("merge", [None, 0.0, 0.003])
def test_merging_keeps_the_impulse(merge):
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(1e-5, 4e-4, 4000))
    t -= t[0]
    tones = [(rng.uniform(20, 900, 6), rng.uniform(0, 7, 6)) for _ in range(4)]
    gap = np.column_stack([0.8 + sum(np.sin(2 * np.pi * f * t + p) for f, p in zip(*x, strict=True)) for x in tones])
    gap[0] = 0.5
    history = history_of(t, gap)
    gaps = channels(np.vstack([np.eye(2), -np.eye(2)]), 1.0, 1e3)
    events = find_events(history, gaps, merge, 500.0)
    assert len({e.side for e in events}) > 1
    assert sum(e.impulse for e in events) == pytest.approx(float((history.weights @ history.force).sum()), rel=1e-12)


# --- contact that was there before ----------------------------------------------------------------------------------


def test_rest_contact_is_no_event_but_losing_and_closing_it_is():
    t = 1e-4 * np.arange(2001)
    gap = np.where((t > 0.05) & (t < 0.08), 0.5, -0.2)
    history = history_of(t, gap)
    (event,) = find_events(history, channels([[1.0]], -0.2, 1e3))
    assert resting(history).tolist() == [True]
    assert event.t_start == pytest.approx(0.08, abs=1e-4)
    assert find_events(history_of(t, np.full_like(t, -0.2)), channels([[1.0]], -0.2, 1e3)) == []


def test_a_resting_channel_does_not_hide_the_hits_of_its_neighbour():
    t = 1e-4 * np.arange(2001)
    hits = np.where((np.abs(t - 0.05) < 0.002) | (np.abs(t - 0.1) < 0.002), -0.1, 0.3)
    history = history_of(t, np.column_stack([np.full_like(t, -0.2), hits]))
    events = find_events(history, channels(np.eye(2), [-0.2, 0.3], 1e3))
    assert [e.channel for e in events] == ["stop:1", "stop:1"]
    # The neighbour's rest is no part of their force or impulse.
    assert [e.impulse for e in events] == pytest.approx([100.0 * 0.004] * 2, rel=0.03)
    assert max(e.force_place for e in events) < 130.0


@pytest.mark.parametrize(("speed", "count"), [(0.0, 0), (-0.5, 1)])
def test_a_body_laid_on_a_stop_rests_one_thrown_at_it_hits(speed, count):
    """No clearance: under its weight alone it never lifts off; with a speed it is a blow."""
    gaps = channels([[1.0]], 0.0, 1e5)
    history = fly(np.eye(1), np.zeros((1, 1)), np.array([speed]), gaps, 0.03, -9.81)
    events = [e for e in find_events(history, gaps) if e.impulse > 1e-6]
    assert len(events) == count
    assert all(e.closing_speed == pytest.approx(0.5, rel=0.01) for e in events)


# --- closing speed --------------------------------------------------------------------------------------------------


def test_closing_speed_where_the_steps_before_are_long():
    """Fast ripple on a slow approach; the step of the onset is 10 us, those before it 1 ms."""
    close, ripple = 0.01, 2.0 * np.pi * 400.0

    def gap(t):
        return 1.0 * (close - t) + 4e-4 * (np.sin(ripple * (close - t)))

    t = np.concatenate([1e-3 * np.arange(10), 0.01 - 5e-6 + 1e-5 * np.arange(20)])
    (event,) = find_events(history_of(t, gap(t)), channels([[1.0]], 1.0, 1e3))
    assert event.closing_speed == pytest.approx(1.0 + 4e-4 * ripple, rel=1e-3)


@pytest.mark.parametrize("longer", [2.0, 3.9, 20.0])
def test_closing_speed_where_the_step_before_is_somewhat_longer(longer):
    """A gap that rings at 400 Hz while it closes; up to 16 % by the parabola of the open gaps alone."""
    w, step = 2 * np.pi * 400.0, 1e-4
    for phase in np.linspace(0.0, 6.0, 7):
        time = step * (longer * np.array([-4.0, -3.0, -2.0, -1.0, 0.0, 0.0]) + np.array([0, 0, 0, 0, 0, 1.0]) - 0.5)
        gap = -0.1 * time - 0.03 / w * (np.sin(w * time + phase) - np.sin(phase))
        (event,) = find_events(history_of(time + 1.0, gap), channels([[1.0]], 0.0, 1e3))
        assert event.closing_speed == pytest.approx(0.1 + 0.03 * np.cos(phase), rel=5e-3)


def test_a_stiff_spring_does_not_hide_when_the_gap_closed():
    """Speed .1 m/s, the spring holds the gap at a thousandth of what the step would have closed."""
    time, touched = 1e-5 * np.arange(8), 4.3e-5
    gap = np.where(time < touched, 0.1 * (touched - time), -1e-9)
    (event,) = find_events(history_of(time, gap, 1e9), channels([[1.0]], 0.0, 1e9))
    assert event.t_start == pytest.approx(touched, abs=1e-8)
