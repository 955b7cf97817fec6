"""Precision, recall, errors of common events, and statistics of chaotic runs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import ks_2samp

from creak.verify.events import Event
from creak.verify.matching import EventMatch, match_events
from creak.verify.statistics import compare_statistics, is_crowded, ks_distance

RECORDED = {"section": "verdicts", "source": "by hand"}


def event(t: float, force: float = 1.0, impulse: float = 1.0) -> Event:
    return Event("a", "a:1", 0, t, t, t, force, force, impulse, 0.0, 1, force)


def test_precision_and_recall(measured):
    match = match_events(
        [event(t) for t in (1.0, 2.0, 3.0, 4.0)], [event(1.001), event(2.002), event(5.0)], 0.01, (0, 9)
    )
    measured("precision of matched events", match.precision, 2 / 3, rel=1e-6)
    measured("recall of matched events", match.recall, 0.5, rel=1e-6)
    assert match.time_error.each == pytest.approx([0.001, 0.002])


def test_errors_of_each_event_and_of_the_mean(measured):
    """Force errors of +10 % and -10 % of equal events cancel in the mean and not event by event."""
    pairs = [(event(1.0, 10.0, 2.0), event(1.004, 11.0, 2.2)), (event(2.0, 10.0, 4.0), event(1.998, 9.0, 4.2))]
    match = EventMatch(pairs, [], [])
    assert match.force_error.each == pytest.approx([0.1, -0.1])
    assert match.force_error.bias == pytest.approx(0.0, abs=1e-12)
    assert match.amplitude_ratio_mean == pytest.approx(1.0)
    assert match.impulse_error.each == pytest.approx([0.1, 0.05])
    assert match.impulse_error.mean == pytest.approx(0.075)
    assert match.time_error.mean == pytest.approx(0.003)
    measured("events: mean force error", match.force_error.mean, 0.1, rel=1e-6)
    # linear between .002 and .004
    measured("events: time error, 95th percentile", match.time_error.percentile_95, 0.0039, rel=1e-6, unit="s")


def test_no_events_no_figures():
    match = EventMatch([], [], [])
    assert match.precision is None
    assert match.recall is None
    assert match.time_error.mean is None
    assert match.force_error.percentile_95 is None
    assert EventMatch([], [event(1.0)], []).recall == 0.0


def test_distance_is_that_of_kolmogorov_and_smirnov(measured):
    rng = np.random.default_rng(0)
    a, b = rng.exponential(1.0, 37), rng.exponential(1.7, 52)
    found = ks_distance(a, b)
    assert found is not None
    measured(
        "distance of two distributions",
        found.value,
        ks_2samp(a, b).statistic,
        rel=1e-6,
        source="Kolmogorov, Smirnov; SciPy",
    )
    assert ks_distance(a, a).value == 0.0
    assert ks_distance(a, a + 100.0).value == 1.0
    assert ks_distance(a, np.zeros(0)) is None


def test_critical_distance_is_passed_by_one_pair_of_samples_in_twenty(measured):
    rng = np.random.default_rng(1)
    beyond = sum(not ks_distance(*rng.exponential(1.0, (2, 150))).alike for _ in range(600))
    # 5 % of 600 are 30, standard deviation 5.3; the asymptotic bound errs to the safe side (fewer).
    measured("like samples called different, of 600", beyond, 30.0, between=(10.0, 46.0), source="5 %, binomial")


def test_statistics_of_two_runs_in_a_window():
    rng = np.random.default_rng(2)
    times = rng.uniform(0.0, 2.0, 240)
    reference = [event(t, f, f / 100) for t, f in zip(times, rng.exponential(5.0, 240), strict=True)]
    alike = [event(t, f, f / 100) for t, f in zip(times + 0.03, rng.exponential(5.0, 240), strict=True)]
    harder = [event(t, f, f / 100) for t, f in zip(times[::2], rng.exponential(15.0, 120), strict=True)]
    good, bad = (compare_statistics(reference, other, (1.0, 2.0)) for other in (alike, harder))
    assert good.count[0] == sum(1.0 <= t <= 2.0 for t in times)
    assert good.rate[0] == good.count[0]
    assert good.rates_alike
    assert good.force.alike
    assert good.impulse.alike
    assert not bad.rates_alike
    assert not bad.force.alike


def test_events_are_crowded_from_some_share_of_the_excitation():
    """The same in any time scale."""
    for scale in (1e-6, 1.0, 1e3):
        assert is_crowded(50, 1.0 * scale, 100.0 / scale)
        assert not is_crowded(39, 1.0 * scale, 100.0 / scale)
        assert not is_crowded(9, 0.1 * scale, 100.0 / scale)  # too few to have a rate
    assert not is_crowded(50, 0.0, 100.0)
    assert not is_crowded(50, 1.0, 0.0)
