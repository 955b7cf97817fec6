"""Fields of gaps against the exact covariance: correlations, and the odds that the smallest of many gaps closes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm, qmc

from creak.studies.robust.draws import EDGE, field_shapes


def flange(rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Places on a grid of 10, and the distances between them."""
    places = np.array([[10.0 * i, 10.0 * j, 0.0] for j in range(rows) for i in range(columns)])
    return places, np.linalg.norm(places[:, None] - places[None], axis=2)


@pytest.mark.parametrize(("rows", "columns", "length"), [(4, 4, 20.0), (1, 40, 200.0), (5, 60, 60.0)])
def test_correlations_are_those_of_the_field(rows, columns, length):
    places, apart = flange(rows, columns)
    shapes = field_shapes(places, length)
    assert np.abs(shapes @ shapes.T - np.exp(-((apart / length) ** 2))).max() < 1e-3
    assert shapes.shape[1] < 60


def test_odds_that_the_smallest_gap_closes_are_exact():
    """All of 16 gaps are above a limit with the probability of the multivariate normal distribution (Genz)."""
    (places, apart), limit = flange(4, 4), 1.28
    exact = 1.0 - multivariate_normal.cdf(
        np.full(16, limit), cov=np.exp(-((apart / 20.0) ** 2)), abseps=5e-4, releps=1e-3, rng=np.random.default_rng(1)
    )
    shapes = field_shapes(places, 20.0)
    unit = np.clip(qmc.Sobol(shapes.shape[1], rng=1).random(2**15), EDGE, 1.0 - EDGE)
    closes = float(((norm.ppf(unit) @ shapes.T).min(axis=1) < -limit).mean())
    assert closes == pytest.approx(exact, abs=2e-3)
