"""Bounds of probabilities cover, Sobol indices of Ishigami's function, the quantile behind a needed gap."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, qmc

from creak.verify.odds import Forecast, counted, odds, shift_needed, sobol_index, with_forecast


def test_bounds_cover_in_95_of_100_repeats():
    """In at least 95 % of many repeats, and in no less than 91 of each hundred, which 1 in 50 hundreds may miss."""
    random, hundreds = np.random.default_rng(7), []
    for p in (0.02, 0.1, 0.4, 0.9):
        for _ in range(10):
            found = [counted(random.random(60) < p) for _ in range(100)]
            hundreds.append(sum(o.low <= p <= o.high for o in found))
    assert np.mean(hundreds) >= 95.0
    assert min(hundreds) >= 91


def test_bounds_at_the_ends():
    assert odds(0, 10).low == 0.0
    assert odds(10, 10).high == 1.0
    assert odds(0, 10).high == pytest.approx(1.0 - 0.025**0.1)


def two_phases(random, p, wrong, n, times=64):
    """Odds of independent draws: hits are foretold but for a share `wrong` of those that can hit; p can hit to 1.2 p."""

    def drawn(count):
        x = random.random(count)
        can, told = x < 1.2 * p, x < p
        return can, told, np.where(can & (random.random(count) < wrong), ~told, told)

    can, told, came = drawn(n)
    can_far, told_far, came_far = drawn(times * n)
    rows = np.flatnonzero(can_far)[:20]
    return with_forecast(came, Forecast(told, can), Forecast(told_far, can_far), rows, came_far[rows])


@pytest.mark.parametrize(("p", "n"), [(0.3, 64), (0.01, 256), (1e-3, 64)])
@pytest.mark.parametrize("wrong", [0.0, 0.05, 0.5])
def test_bounds_with_a_forecast_cover_in_95_of_100_repeats(p, n, wrong):
    """However good the forecast is; a good one makes them narrower."""
    random = np.random.default_rng(11)
    true = p * (1.0 - wrong) + 0.2 * p * wrong
    found = [two_phases(random, p, wrong, n) for _ in range(300)]
    assert np.mean([o.low <= true <= o.high for o in found]) >= 0.95
    assert np.mean([o.p for o in found]) == pytest.approx(true, rel=0.15)
    width, plain = (np.mean([o.high - o.low for o in each]) for each in (found, [odds(o.hits, n) for o in found]))
    assert width <= plain
    if wrong < 0.1:
        assert width < 0.5 * plain


def test_a_forecast_that_tells_nothing_is_left_alone():
    random = np.random.default_rng(3)
    hit, here, far = random.random(200) < 0.3, random.random(200) < 0.5, random.random(10_000) < 0.5
    every = np.ones(200, dtype=bool), np.ones(10_000, dtype=bool)
    none = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=bool)
    found = with_forecast(hit, Forecast(here, every[0]), Forecast(far, every[1]), *none)
    assert found == counted(hit)
    assert found.foretold == 0


def test_sobol_indices_of_ishigami():
    """f = sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1: first .3139, .4424, 0; total .5576, .4424, .2437."""

    def f(u):
        x = np.pi * (2.0 * u - 1.0)
        return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])

    both = qmc.Sobol(6, seed=3).random(4096)
    A, B = both[:, :3], both[:, 3:]
    for k, (first, total) in enumerate([(0.3139, 0.5576), (0.4424, 0.4424), (0.0, 0.2437)]):
        mixed = A.copy()
        mixed[:, k] = B[:, k]
        index = sobol_index((f(A), f(B), f(mixed)))
        assert index.first == pytest.approx(first, abs=0.02)
        assert index.total == pytest.approx(total, abs=0.02)
        assert index.first_bounds[0] - 0.02 <= first <= index.first_bounds[1] + 0.02
    assert sobol_index((np.ones(8), np.ones(8), np.ones(8))) is None


@pytest.mark.parametrize("n", [16, 64])
@pytest.mark.parametrize("off", [None, 0.0, 0.1])
def test_bounds_of_indices_cover_in_95_of_100_repeats(n, off):
    """Of whether 18 a > g, a uniform in 0.4 .. 1 and g normal about 10, from 2 n even points; exact ones by quadrature.

    A forecast that has the limit off by a share, known at 32 n points more, makes them narrower and leaves them true.
    """

    def closes(u, most=18.0):
        return (most * (0.4 + 0.6 * u[..., 1]) > 10.0 + 1.5 * norm.ppf(u[..., 0])).astype(float)

    def blocks(points, k, most=18.0):
        A, B = points[:, :2], points[:, 2:]
        mixed = A.copy()
        mixed[:, k] = B[:, k]
        return tuple(closes(x, most) for x in (A, B, mixed))

    grid = (np.arange(500) + 0.5) / 500
    every = closes(np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1))
    alone = every.mean(axis=1).var() / every.var(), every.mean(axis=0).var() / every.var()
    hits, wide, plain = np.zeros(4), 0.0, 0.0
    for seed in range(100):
        points, many = qmc.Sobol(4, seed=seed).random(n), qmc.Sobol(4, seed=1000 + seed).random(32 * n)
        for k in range(2):
            own = blocks(points, k)
            told = () if off is None else (blocks(points, k, 18.0 * (1 + off)), blocks(many, k, 18.0 * (1 + off)))
            index, counted_one = sobol_index(own, *told), sobol_index(own)
            hits[2 * k] += index.first_bounds[0] <= alone[k] <= index.first_bounds[1]
            hits[2 * k + 1] += index.total_bounds[0] <= 1.0 - alone[1 - k] <= index.total_bounds[1]
            wide += np.ptp(index.first_bounds) + np.ptp(index.total_bounds)
            plain += np.ptp(counted_one.first_bounds) + np.ptp(counted_one.total_bounds)
    assert hits.min() >= 95
    if off is not None and n == 64:
        assert wide < (0.6 if off == 0.0 else 0.9) * plain


def test_bounds_of_a_needed_shift_cover():
    random, hits = np.random.default_rng(5), 0
    truth = 1.6448536  # the 5 % quantile of a standard normal, turned
    for _ in range(200):
        shift, low, high = shift_needed(random.standard_normal(400), 0.05)
        assert low <= shift <= high
        hits += low <= truth <= high
    assert hits >= 186
    assert shift_needed(random.standard_normal(8), 0.05)[2] == np.inf
