"""Mode pairing, NRMSE, contact events on synthetic histories, matching of events."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.dynamics.history import History
from creak.verify.events import Event, find_events
from creak.verify.mac import mac_matrix, pair_modes
from creak.verify.matching import match_events
from creak.verify.nrmse import nrmse_by_axis, nrmse_fit
from helpers_core import channels, history_of

RECORDED = {"section": "verdicts", "source": "by hand"}

# --- modes ------------------------------------------------------------------------------------------------------


def test_mac_of_a_tilted_shape_is_the_squared_cosine(measured):
    angle = 0.3
    a, b = np.array([[1.0], [0.0]]), np.array([[np.cos(angle)], [np.sin(angle)]])
    measured("MAC of a shape tilted by .3 rad", mac_matrix(a, b)[0, 0], np.cos(angle) ** 2, rel=1e-6)
    assert mac_matrix(a, np.zeros((2, 1)))[0, 0] == 0.0


def test_same_modes_in_another_order_pair_up():
    rng = np.random.default_rng(0)
    shapes = np.linalg.qr(rng.standard_normal((12, 4)))[0]
    freq = np.array([10.0, 10.5, 20.0, 21.0])
    order = [1, 0, 3, 2]
    found = pair_modes(freq, shapes, freq[[0, 1, 2, 3]], -shapes[:, order])
    np.testing.assert_array_equal(found.partner, order)
    np.testing.assert_allclose(found.mac, 1.0)


def test_repeated_modes_are_compared_as_a_subspace(measured):
    """Twins may come in any rotation: plain MAC says 1/2, the subspace says 1."""
    rng = np.random.default_rng(1)
    shapes = np.linalg.qr(rng.standard_normal((10, 3)))[0]
    turn = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2.0)
    turned = shapes.copy()
    turned[:, :2] = shapes[:, :2] @ turn
    freq = np.array([7.0, 7.0, 9.0])
    found = pair_modes(freq, shapes, freq, turned)
    assert found.matrix[0, 0] == pytest.approx(0.5)
    measured("MAC of repeated modes in any rotation", found.mac, 1.0, rel=1e-12)
    apart = pair_modes(np.array([7.0, 7.5, 9.0]), shapes, np.array([7.0, 7.5, 9.0]), turned)
    np.testing.assert_allclose(apart.mac[:2], 0.5)


def test_modes_far_apart_in_frequency_are_no_partners():
    shape = np.ones((5, 1))
    found = pair_modes(np.array([10.0]), shape, np.array([14.0]), shape)
    assert found.partner[0] == -1
    assert found.mac[0] == 0.0


@pytest.mark.parametrize(("n_ref", "n_red"), [(0, 3), (3, 0), (0, 0)])
def test_no_modes_are_no_error(n_ref, n_red):
    found = pair_modes(np.ones(n_ref), np.ones((4, n_ref)), np.ones(n_red), np.ones((4, n_red)))
    assert found.mac.shape == (n_ref,)


# --- NRMSE ------------------------------------------------------------------------------------------------------


def test_nrmse_is_one_minus_error_over_spread(measured):
    r, x = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 4.0])
    measured("NRMSE of three values", nrmse_fit(r, x), 1.0 - 1.0 / np.sqrt(2.0), rel=1e-6)
    assert nrmse_fit(r, r) == 1.0
    assert nrmse_fit(r, np.full(3, 2.0)) == pytest.approx(0.0)  # the mean is worth nothing
    assert nrmse_fit(r, -r) < 0.0


def test_nrmse_sees_phase():
    r = np.exp(1j * np.linspace(0, 6, 50))
    turned = r * np.exp(0.1j)
    spread = np.linalg.norm(r - r.mean())
    assert nrmse_fit(r, turned) == pytest.approx(1.0 - 2 * np.sin(0.05) * np.sqrt(50) / spread)


def test_reference_without_variation():
    flat = np.full(4, 2.0)
    assert nrmse_fit(flat, flat) == 1.0
    assert nrmse_fit(flat, flat + 1) == -np.inf


def test_nrmse_by_axis_and_over_all():
    rng = np.random.default_rng(0)
    r = rng.standard_normal((20, 3, 3)) + 1j * rng.standard_normal((20, 3, 3))
    x = r.copy()
    x[:, :, 2] *= 1.1
    fit = nrmse_by_axis(r, x)
    assert set(fit) == {"x", "y", "z", "all"}
    assert fit["x"] == fit["y"] == 1.0
    assert fit["z"] == nrmse_fit(r[:, :, 2], x[:, :, 2])
    assert fit["z"] < fit["all"] < 1.0


# --- events -----------------------------------------------------------------------------------------------------

H = 1e-3


def history(gap: np.ndarray, stiffness: float = 1e3) -> History:
    """A history of given gaps (n_time, m); the force is that of a penalty."""
    return history_of(H * np.arange(len(gap)), gap, stiffness=stiffness)


def operator(m: int, groups: tuple[str, ...] | None = None):
    op = channels(np.eye(m), 1.0, 1e3)
    return op if groups is None else replace(op, group=groups, names=tuple(f"{g}:{j}" for j, g in enumerate(groups)))


def bounces(*times: float, depth: float = 0.1, end: float = 0.4, half: float = 0.01, far: float = 0.5) -> np.ndarray:
    """A gap that is `far` open, with half-sine dips of duration 2 half at the given times (their start)."""
    t = H * np.arange(round(end / H) + 1)
    gap = np.full(t.size, far)
    for start in times:
        x = t - start
        near = (x > -0.02) & (x < 2 * half + 0.02)
        gap[near] = -depth * np.sin(np.pi * x[near] / (2 * half))
    return gap


def test_one_contact_gives_onset_release_peak_and_impulse(measured):
    start, half, depth, k = 0.1004, 0.01, 0.1, 1e3
    events = find_events(history(bounces(start, half=half, depth=depth)), operator(1), merge=0.002, f_max=1e6)
    assert len(events) == 1
    e = events[0]
    # Linear interpolation of a sine: curvature is zero at its zeros, so far better than a step.
    assert e.t_end == pytest.approx(start + 2 * half, abs=0.02 * H)
    assert e.t_peak == pytest.approx(start + half, abs=H)
    measured("event of a half sine: onset", e.t_start, start, abs=0.02 * H, unit="s", source="closed form")
    measured(
        "event of a half sine: peak force",
        e.force_peak,
        k * depth,
        rel=(np.pi * H / (4 * half)) ** 2,
        unit="N",
        source="closed form",
    )
    # trapezoid, (pi/20)^2/12
    measured(
        "event of a half sine: impulse",
        e.impulse,
        k * depth * 2 * (2 * half) / np.pi,
        rel=0.01,
        unit="N s",
        source="closed form",
    )
    # The gap closes with depth pi / (2 half); the difference over a step before contact.
    assert e.closing_speed == pytest.approx(depth * np.pi / (2 * half), rel=0.06)
    assert e.contacts == 1
    assert e.channel == "stop:0"


def test_micro_contacts_are_merged():
    gap = bounces(0.05, 0.09, 0.2, half=0.01)
    # Pauses: .09 - .07 = 20 ms and .2 - .11 = 90 ms.
    for merge, count in ((0.0, 3), (0.015, 3), (0.025, 2), (0.1, 1)):
        events = find_events(history(gap), operator(1), merge, 1e6)
        assert len(events) == count
        assert sum(e.contacts for e in events) == 3
    whole = find_events(history(gap), operator(1), 0.1, 1e6)[0]
    apart = find_events(history(gap), operator(1), 0.0, 1e6)
    assert whole.impulse == pytest.approx(sum(e.impulse for e in apart))
    assert whole.t_start == apart[0].t_start
    assert whole.t_end == apart[-1].t_end


def test_channels_of_one_pair_are_one_event():
    """Two channels touch 3 ms apart: one event, the peak of the louder, the impulse of both."""
    gap = np.column_stack([bounces(0.1, depth=0.1), bounces(0.103, depth=0.2)])
    events = find_events(history(gap), operator(2), 0.0, 1e6)
    assert len(events) == 1
    assert events[0].channel == "stop:1"
    assert events[0].node_idx == 1
    assert events[0].t_start == pytest.approx(0.1, abs=H)
    alone = [find_events(history(gap[:, [j]]), operator(1), 0.0, 1e6)[0].impulse for j in (0, 1)]
    assert events[0].impulse == pytest.approx(sum(alone))


def test_pairs_have_their_own_events_in_order_of_time():
    gap = np.column_stack([bounces(0.2), bounces(0.1)])
    events = find_events(history(gap), operator(2, ("flange", "hook")), 0.0, 1e6)
    assert [e.group for e in events] == ["hook", "flange"]


def test_contact_at_the_end_is_cut_off_there_and_contact_at_the_start_is_rest():
    gap = np.concatenate([np.full(10, -0.1), np.full(80, 0.5), np.full(10, -0.1)])
    (last,) = find_events(history(gap), operator(1), 0.0, 1e6)
    assert last.t_start == pytest.approx(0.09, abs=H)
    assert last.t_end == pytest.approx(0.099)


def test_filtered_peak_of_a_short_click_is_its_impulse_times_the_bandwidth():
    """A spike far above the filter's band loses height; a slow push keeps it."""
    click = np.full(2001, 0.5)
    click[1000] = -1.0
    e = find_events(history(click), operator(1), 0.0, 50.0)[0]
    assert e.force_peak == 1000.0
    assert e.force_peak_filtered < 0.2 * e.force_peak
    # A low-pass of bandwidth B turns an impulse J into a peak of 2 B J (ideal); Butterworth within 15 %.
    assert e.force_peak_filtered == pytest.approx(2 * 50.0 * e.impulse, rel=0.2)
    slow = find_events(history(bounces(0.1, half=0.1)), operator(1), 0.0, 200.0)[0]
    assert slow.force_peak_filtered == pytest.approx(slow.force_peak, rel=0.02)


def test_no_contact_no_event():
    assert find_events(history(np.full(50, 0.1)), operator(1), 0.0, 1e6) == []


# --- matching ---------------------------------------------------------------------------------------------------


def event(t: float, force: float = 1.0, group: str = "a", impulse: float = 1.0) -> Event:
    return Event(group, f"{group}:1", 0, t, t, t, force, force, impulse, 0.0, 1, force)


def test_events_match_one_to_one_nearest_first():
    match = match_events([event(1.0), event(1.008)], [event(1.006), event(1.014)], 0.01, (0.0, 9.0))
    # Nearest first takes 1.008 - 1.006; what is left, 1.0 - 1.014, lies beyond the tolerance.
    assert [(a.t_start, b.t_start) for a, b in match.pairs] == [(1.008, 1.006)]
    assert [e.t_start for e in match.missed] == [1.0]
    assert [e.t_start for e in match.extra] == [1.014]


def test_missed_and_extra_events():
    match = match_events([event(1.0), event(2.0)], [event(1.004), event(3.0)], 0.01, (0.0, 9.0))
    assert [(a.t_start, b.t_start) for a, b in match.pairs] == [(1.0, 1.004)]
    assert [e.t_start for e in match.missed] == [2.0]
    assert [e.t_start for e in match.extra] == [3.0]


def test_events_of_different_pairs_do_not_match():
    match = match_events([event(1.0, group="a")], [event(1.0, group="b")], 0.01, (0.0, 9.0))
    assert not match.pairs
    assert len(match.missed) == len(match.extra) == 1


def test_only_the_window_counts_but_partners_may_lie_outside():
    match = match_events([event(0.9), event(1.001), event(2.1)], [event(0.999), event(2.1)], 0.01, (1.0, 2.0))
    assert [(a.t_start, b.t_start) for a, b in match.pairs] == [(1.001, 0.999)]
    assert not match.missed
    assert not match.extra


def test_ratios_of_common_events():
    reference = [event(1.0, 10.0, impulse=4.0), event(2.0, 20.0, impulse=6.0)]
    reduced = [event(1.0, 10.4, impulse=5.0), event(2.0, 22.0, impulse=6.0)]
    match = match_events(reference, reduced, 0.01, (0.0, 9.0))
    assert match.amplitude_ratio_mean == pytest.approx(32.4 / 30.0)
    assert match.impulse_ratio_mean == pytest.approx(1.1)
    assert match.within_5_percent == 1
    nothing = match_events([], [], 0.01, (0.0, 9.0))
    assert nothing.amplitude_ratio_mean is None
    assert nothing.within_5_percent == 0
