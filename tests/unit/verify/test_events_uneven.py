"""Events where steps are shorter near contact, where contact is exact, and what impulse means."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.signals import resampling
from creak.verify.events import find_events
from helpers_core import channels, free_run, system_of

V, HALF, DEPTH, K, START = 3.0, 0.01, 0.1, 1e3, 0.1004


def history_of(time: np.ndarray, gap: np.ndarray, force: np.ndarray) -> History:
    gap, force = (np.asarray(a, dtype=float).reshape(time.size, -1) for a in (gap, force))
    return History(
        time,
        gap,
        force,
        np.zeros_like(gap),
        np.arange(time.size),
        np.zeros((time.size, 0)),
        np.zeros((time.size, len(ENERGIES))),
        0,
        0.0,
    )


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
    measured(
        "verdicts",
        "event of uneven steps: impulse",
        found[1].impulse,
        K * DEPTH * 4 * HALF / np.pi,
        rel=2e-5,
        unit="N s",
        source="closed form",
    )


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
    measured(
        "verdicts",
        "exact contact inside a step: onset",
        event.t_start,
        closes,
        abs=1e-9,
        unit="s",
        source="closed form",
    )
    measured(
        "verdicts",
        "exact contact inside a step: closing speed",
        event.closing_speed,
        V,
        rel=1e-9,
        unit="m/s",
        source="closed form",
    )


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
    measured(
        "verdicts",
        "impulse of an event",
        event.impulse,
        m * (after + v),
        rel=1e-10,
        unit="N s",
        source="change of momentum",
    )
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
    monkeypatch.setattr(resampling, "BLOCK", 500)
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
