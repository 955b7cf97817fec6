"""Which touches are one event: the way they push, the contact's own time scale, and contact that was there before.

Events where steps are shorter near contact, where contact is exact, and what impulse means.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import History
from creak.dynamics.loads import Loads, at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.reduction.diagonal import diagonalise
from creak.signals import spectra
from creak.verify.events import find_events, resting, sides
from creak.verify.matching import match_events
from helpers_core import channels, free_run, history_of, system_of

RECORDED = {"section": "verdicts", "source": "closed form"}

STEP = 1e-3


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
    measured("hits of a two-sided play at 130 Hz", len(events), 267, abs=0)


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


@pytest.mark.parametrize(("depth", "count"), [(1e-12, 0), (1e-8, 1)])
def test_what_only_round_off_presses_is_no_event(depth, count):
    """Beside a channel that rests pressed by .2."""
    t = 1e-4 * np.arange(2001)
    touch = np.where(np.abs(t - 0.1) < 0.002, -depth, depth)
    history = history_of(t, np.column_stack([np.full_like(t, -0.2), touch]))
    assert len(find_events(history, channels(np.eye(2), [-0.2, 0.0], 1e3))) == count


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
    (event,) = find_events(history_of(time, gap, stiffness=1e9), channels([[1.0]], 0.0, 1e9))
    assert event.t_start == pytest.approx(touched, abs=1e-8)


V, HALF, DEPTH, K, START = 3.0, 0.01, 0.1, 1e3, 0.1004


def stop(m: int = 1, stiffness: float = K):
    return channels(np.eye(m), 1.0, stiffness)


def dip(time: np.ndarray, start: float = START) -> np.ndarray:
    """A gap that falls steadily, dips below zero for a half sine and rises again."""
    x = time - start
    speed = DEPTH * np.pi / (2 * HALF)
    inside = -DEPTH * np.sin(np.pi * np.clip(x, 0.0, 2 * HALF) / (2 * HALF))
    return np.where(x < 0, -speed * x, np.where(x > 2 * HALF, speed * (x - 2 * HALF), inside))


def refined(end: float, coarse: float, fine: float, near: tuple[float, float]) -> np.ndarray:
    """Coarse steps, each divided evenly where it touches `near`."""
    steps = np.arange(round(end / coarse)) * coarse
    pieces = round(coarse / fine)
    times = [t + fine * np.arange(pieces) if near[0] - coarse < t < near[1] else np.array([t]) for t in steps]
    return np.append(np.concatenate(times), end)


def test_uneven_steps_give_the_event_of_even_ones(measured):
    even = 5e-5 * np.arange(8001)
    uneven = refined(0.4, 1e-3, 5e-5, (START - 2e-3, START + 2 * HALF + 2e-3))
    assert uneven.size < even.size / 9
    found = [
        find_events(history_of(t, dip(t), K * np.maximum(0.0, -dip(t))), stop(), 0.0, 200.0)[0] for t in (even, uneven)
    ]
    for name in ("t_start", "t_peak", "t_end", "force_peak", "impulse", "closing_speed"):
        assert getattr(found[1], name) == pytest.approx(getattr(found[0], name), rel=1e-9)
    # Coarse steps outside carry no force, so the filter sees the same; its grid is shifted by less than a cell.
    assert found[1].force_peak_filtered == pytest.approx(found[0].force_peak_filtered, rel=1e-3)
    # Half sine of 20 ms through a low-pass of 200 Hz: kept.
    assert found[0].force_peak_filtered == pytest.approx(K * DEPTH, rel=0.01)
    assert found[1].step == pytest.approx(5e-5)
    # Trapezoidal rule of a half sine of n = 400 steps: 1 - (pi / n)^2 / 12.
    measured("event of uneven steps: impulse", found[1].impulse, K * DEPTH * 4 * HALF / np.pi, rel=2e-5, unit="N s")


def test_low_passed_click_does_not_depend_on_the_axis():
    """A click of 1 ms on steps of 0.5 ms divided by 2, 5 and 10: its low-passed peak at 50 Hz is 2 B J each time."""
    peaks = []
    for pieces in (2, 5, 10):
        time = refined(1.0, 5e-4, 5e-4 / pieces, (0.498, 0.502))
        force = 1e3 * np.maximum(0.0, 1.0 - np.abs(time - 0.5) / 1e-3)
        event = find_events(history_of(time, np.where(force > 0, -1e-3, 1e-3), force), stop(), 0.0, 50.0)[0]
        assert event.impulse == pytest.approx(1.0, rel=1e-9)
        peaks.append(event.force_peak_filtered)
    np.testing.assert_allclose(peaks, peaks[-1], rtol=2e-3)
    assert peaks[0] == pytest.approx(2 * 50.0 * 1.0, rel=0.2)


def test_impulses_of_the_events_add_up_to_that_of_the_run():
    rng = np.random.default_rng(0)
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(1e-4, 1e-3, 3000))])
    force = np.maximum(0.0, rng.standard_normal((time.size, 4)).cumsum(axis=0))
    history = history_of(time, np.where(force > 0, -1e-3, 1e-3), force)
    gaps = replace(stop(4), group=("a", "a", "b", "b"))
    for merge in (0.0, 0.01):
        total = sum(e.impulse for e in find_events(history, gaps, merge, 1e9))
        assert total == pytest.approx((history.weights @ force).sum(), rel=1e-12)


def test_micro_contacts_are_listed_with_their_times():
    time = 1e-4 * np.arange(4001)
    gap = np.minimum.reduce([dip(time, s) for s in (0.05, 0.09, 0.2)])
    event, alone = find_events(history_of(time, gap, K * np.maximum(0.0, -gap)), stop(), 0.025, 1e9)
    assert event.contacts == len(event.touches) == 2
    np.testing.assert_allclose(event.touches, [(0.05, 0.07), (0.09, 0.11)], atol=1e-6)
    assert (event.t_start, event.t_end) == (event.touches[0][0], event.touches[-1][1])
    assert alone.touches == ((alone.t_start, alone.t_end),)


# --- onset, release and speed ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [0.0, 0.13, 0.5, 0.87])
def test_exact_contact_is_located_inside_the_step(offset, measured):
    """A gap that is held at zero tells nothing about when it closed: the speeds before and after do."""
    h = 1e-3
    time = h * np.arange(201)
    closes, opens = (80 + offset) * h, (120 + offset) * h
    gap = np.maximum(0.0, np.maximum(V * (closes - time), V * (time - opens)))
    force = np.where((time > closes) & (time < opens), 2.0, 0.0)
    gap[force > 0] = 0.0
    gaps = stop(stiffness=np.inf)
    event = find_events(history_of(time, gap, force), gaps, 0.0, 1e9)[0]
    assert event.t_end == pytest.approx(opens, abs=1e-9)
    measured("exact contact inside a step: onset", event.t_start, closes, abs=1e-9, unit="s")
    measured("exact contact inside a step: closing speed", event.closing_speed, V, rel=1e-9, unit="m/s")


def test_closing_speed_is_exact_for_a_falling_body():
    """gap = H - g t^2 / 2: the parabola through its last three values has the speed of the impact."""
    H, g, h = 0.05, 10.0, 1e-3
    time = h * np.arange(150)
    gap = H - 0.5 * g * time**2
    force = np.maximum(0.0, -1e4 * gap)
    event = find_events(history_of(time, gap, force), stop(), 0.0, 1e9)[0]
    # The onset is linear between two gaps: off by at most g h^2 / (8 v).
    assert event.t_start == pytest.approx(np.sqrt(2 * H / g), abs=g * h * h / 8)
    assert event.closing_speed == pytest.approx(np.sqrt(2 * g * H), abs=2 * g * g * h * h)


@pytest.mark.parametrize("open_instants", [1, 2])
def test_few_open_instants_give_a_speed_of_lower_order(open_instants):
    h = 1e-3
    time = h * np.arange(20)
    gap = V * (h * (open_instants - 0.5) - time)
    event = find_events(history_of(time, gap, np.maximum(0.0, -gap)), stop(), 0.0, 1e9)[0]
    assert event.closing_speed == pytest.approx(V)
    assert event.t_start == pytest.approx((open_instants - 0.5) * h)


def test_speed_before_a_second_touch_does_not_see_the_first():
    """Two open instants between touches: the rate is theirs, not that of the touch before."""
    h = 1e-3
    time = h * np.arange(12)
    gap = np.array([2.0, 1.0, -5.0, -5.0, 0.4, 0.2, -0.1, -0.1, 1.0, 2.0, 3.0, 4.0])
    first, second = find_events(history_of(time, gap, np.maximum(0.0, -gap)), stop(), 0.0, 1e9)
    assert second.closing_speed == pytest.approx(0.2 / h)
    assert first.closing_speed == pytest.approx(1.0 / h)


# --- impulse --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("alpha", [-0.05, 1.0 - np.sqrt(2.0), 0.0])
def test_impulse_is_the_change_of_momentum_to_round_off(alpha, measured):
    """A free mass on a stop, some seven steps long: Newmark's family gives it just the trapezoidal sum of the force."""
    m, k, v, h = 2.0, 8e4, 0.7, 2.3e-3
    gaps = channels([[1.0]], 0.05, k)
    history = free_run(system_of(np.array([[m]]), np.zeros((1, 1)), velocity=np.array([-v])), gaps, 0.2, h, alpha)
    event = find_events(history, gaps, 0.0, 1e9)[0]
    after = (history.displacement[-1, 0] - history.displacement[-2, 0]) / h
    measured("impulse of an event", event.impulse, m * (after + v), rel=1e-10, unit="N s", source="change of momentum")
    assert after > 0.5 * v


def test_impulse_with_divided_steps_is_the_change_of_momentum():
    """Eight steps instead of one near contact.

    Where the step grows again just after the release, HHT gives the last force -(1 - gamma) alpha = 2 % of the longer
    step instead of the shorter one: at most .08 (omega h)^2 of the impulse, as that force is at most k v h.
    """
    m, k, v, h, pieces = 2.0, 8e4, 0.7, 1e-3, 8
    time = h / pieces * np.arange(1601)
    system = system_of(np.array([[m]]), np.zeros((1, 1)), velocity=np.array([-v]))
    for offset in (0.0, 0.3, 0.7):
        gaps = channels([[1.0]], 0.05 + offset * h * v, k)
        history = simulate(system, gaps, at_rest(time), HHT(), OutputRequest(np.arange(1)), substeps=pieces)
        assert history.time.size < time.size / 2
        event = find_events(history, gaps, 0.0, 1e9)[0]
        after = (history.displacement[-1, 0] - history.displacement[-2, 0]) / h
        assert event.impulse == pytest.approx(m * (after + v), rel=0.08 * k / m * (h / pieces) ** 2)
        assert event.step == pytest.approx(h / pieces)
        assert event.closing_speed == pytest.approx(v, rel=1e-9)


# --- size -----------------------------------------------------------------------------------------------------------


def test_many_small_blocks_find_the_same_events(monkeypatch):
    """Work is cut into blocks so that long runs need little memory; the cuts change nothing."""
    time = 1e-4 * np.arange(3001)
    gap = 0.6 + np.sin(2 * np.pi * time[:, None] * np.array([11.0, 13.0, 17.0, 23.0, 29.0, 31.0]))
    history = history_of(time, gap, np.maximum(0.0, -gap))
    whole = find_events(history, stop(6), 0.002, 300.0)
    monkeypatch.setattr(spectra, "BLOCK", 500)
    pieces = find_events(history, stop(6), 0.002, 300.0)
    assert len(whole) == len(pieces) > 1
    for a, b in zip(whole, pieces, strict=True):
        assert (a.channel, a.t_start, a.t_peak, a.contacts) == (b.channel, b.t_start, b.t_peak, b.contacts)
        assert a.force_peak_filtered == pytest.approx(b.force_peak_filtered, rel=1e-9)
        assert a.impulse == pytest.approx(b.impulse, rel=1e-12)


def test_an_event_between_two_samples_of_a_slow_low_pass_has_a_peak():
    """0.5 Hz is sampled every 1 / 16 s, the event of 20 ms at 0.1 s lies between two: the mean over 62.5 ms is below the peak."""
    t = 5e-5 * np.arange(8001)
    (event,) = find_events(history_of(t, dip(t), K * np.maximum(0.0, -dip(t))), stop(), 0.0, 0.5)
    assert 0.0 <= event.force_peak_filtered < 0.5 * event.force_peak


def test_an_event_that_presses_at_the_last_instant_is_unfinished():
    """A half sine of force cut after a quarter of its period: half of its impulse, K DEPTH 2 HALF / pi each."""
    time = 1e-5 * np.arange(14001)
    whole = dip(time)
    force = K * np.maximum(-whole, 0.0)
    (event,) = find_events(history_of(time, whole, force), stop())
    assert not event.unfinished
    n = int(np.searchsorted(time, START + HALF)) + 1
    (cut,) = find_events(history_of(time[:n], whole[:n], force[:n]), stop())
    assert cut.unfinished
    assert cut.t_end == time[n - 1]
    assert cut.impulse == pytest.approx(K * DEPTH * 2.0 * HALF / np.pi, rel=1e-2)
    assert event.impulse == pytest.approx(2.0 * K * DEPTH * 2.0 * HALF / np.pi, rel=1e-3)


def test_a_faint_touch_beside_a_hard_one_has_no_force_below_zero():
    """The low-pass of the hard one swings below zero where the faint one is."""
    time = 5e-5 * np.arange(8001)
    hard, least = dip(time), 0.0
    for after in np.arange(0.001, 0.015, 0.001):
        faint = np.abs(time - START - 2.0 * HALF - after) < 2e-4
        gap = np.where(faint, -1e-5, hard)
        events = find_events(history_of(time, gap, K * np.maximum(0.0, -gap)), stop(), 0.0, 100.0)
        least = min(least, *(e.force_place for e in events), *(e.force_peak_filtered for e in events))
    assert least == 0.0
