"""The largest value of a motion between the instants at which it is known."""

from __future__ import annotations

import numpy as np
import pytest

from creak.signals.peaks import largest


@pytest.mark.parametrize("per_period", [8, 10, 20])
def test_top_of_a_sine_lies_between_samples(per_period):
    """All phases: the largest sample is off by (pi / k)^2 / 2 at worst, the top of the parabola by .38 (pi / k)^4."""
    late = np.linspace(-0.5, 0.5, 101)
    x = np.cos(2.0 * np.pi / per_period * (np.arange(-3, 4)[:, None] + late))
    step = np.pi / per_period
    assert (1.0 - x.max(axis=0)).max() > 0.4 * step**2
    assert np.abs(largest(x) - 1.0).max() < 0.4 * step**4


def test_ends_and_plateaus_are_samples():
    x = np.array([[3.0, 0.0, 1.0], [2.0, 1.0, 1.0], [0.0, 2.0, 1.0]])
    np.testing.assert_array_equal(largest(x), [3.0, 2.0, 1.0])
    np.testing.assert_array_equal(largest(x[:1]), x[0])


def test_a_parabola_is_exact():
    t = np.arange(5.0)[:, None]
    np.testing.assert_allclose(largest(2.0 - 0.3 * (t - np.array([1.7, 2.4])) ** 2), 2.0, rtol=1e-14)
