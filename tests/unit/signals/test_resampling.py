"""Uneven records on other axes: integrals are kept, and an even record is filtered as it is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid

from creak.signals import spectra
from creak.signals.spectra import cell_means, cells, low_pass, low_pass_uneven


def uneven(n: int = 400, seed: int = 0) -> np.ndarray:
    """Times from 0 to 1 whose steps differ by up to a factor of 20."""
    step = np.random.default_rng(seed).uniform(0.05, 1.0, n)
    return np.concatenate([[0.0], np.cumsum(step) / step.sum()])


@pytest.mark.parametrize("n_out", [7, 50, 1500])
def test_means_keep_the_integral(n_out):
    """Coarser or finer: the means times their cells are the trapezoidal integral, to round-off."""
    time = uneven()
    x = np.random.default_rng(1).standard_normal((time.size, 3))
    at = np.linspace(0.0, 1.0, n_out)
    width = np.diff(cells(at, 0.0, 1.0))
    np.testing.assert_allclose(width @ cell_means(time, x, at), trapezoid(x, time, axis=0), atol=1e-13)


def test_a_spike_goes_where_it_was():
    time = uneven()
    x = np.zeros((time.size, 1))
    x[200] = 5.0
    at = np.linspace(0.0, 1.0, 21)
    found = cell_means(time, x, at)[:, 0]
    near = round(time[200] * 20)
    assert found[near] > 0.0
    assert np.count_nonzero(found) <= 2
    assert np.count_nonzero(np.delete(found, [near - 1, near, near + 1])) == 0


def test_a_constant_stays_and_the_same_axis_changes_nothing():
    time = uneven()
    np.testing.assert_allclose(cell_means(time, np.full((time.size, 1), 3.0), np.linspace(0, 1, 33)), 3.0)
    x = np.random.default_rng(2).standard_normal((time.size, 2))
    assert cell_means(time, x, time) is x
    # Every instant its own cell: the value itself.
    np.testing.assert_allclose(cell_means(time, x, time + 1e-15), x, atol=1e-9)


def test_outputs_that_end_before_the_record_leave_the_rest_out():
    time = np.linspace(0.0, 1.0, 101)
    at = time[:91:10]
    np.testing.assert_allclose(cell_means(time, time[:, None], at)[1:, 0], at[1:], atol=1e-12)


def test_small_blocks_give_the_same(monkeypatch):
    time = uneven()
    x = np.random.default_rng(3).standard_normal((time.size, 5))
    at = np.linspace(0.0, 1.0, 40)
    whole = cell_means(time, x, at)
    monkeypatch.setattr(spectra, "BLOCK", 2 * time.size)
    np.testing.assert_array_equal(cell_means(time, x, at), whole)


def test_an_even_record_is_filtered_on_its_own_axis():
    h, f_max = 1e-3, 100.0
    x = np.random.default_rng(4).standard_normal((600, 2))
    time = h * np.arange(600)
    even, smooth = low_pass_uneven(time, x, f_max)
    np.testing.assert_allclose(even, time, atol=1e-12)
    # The axis is the same to round-off of the times, 1e-13 of a second against steps of 1e-3.
    np.testing.assert_allclose(smooth, low_pass(x, h, f_max), atol=1e-8)


def test_low_pass_of_uneven_samples_is_that_of_the_signal():
    """Short steps in the middle, long ones outside: slow stays, fast goes."""
    coarse, fine = np.arange(0.0, 0.2, 5e-4), np.arange(0.2, 0.3, 2e-5)
    time = np.concatenate([coarse, fine, np.arange(0.3, 0.5, 5e-4)])
    burst = np.where(np.abs(time - 0.25) < 0.05, np.cos(np.pi * (time - 0.25) / 0.1) ** 2, 0.0)
    slow, fast = np.sin(2 * np.pi * 20 * time), burst * np.sin(2 * np.pi * 900 * time)
    even, smooth = low_pass_uneven(time, (slow + fast)[:, None], 100.0)
    inside = (even > 0.1) & (even < 0.4)
    # (20 / 100)^8 of the slow part; a value is held over its cell, which changes place by at most (h / 2)^2 / 6 x w^2
    # in the coarse part and where the steps change.
    np.testing.assert_allclose(smooth[inside, 0], np.sin(2 * np.pi * 20 * even[inside]), atol=5e-3)


@pytest.mark.parametrize("phase", [0.0, 0.2, 0.4, 0.6, 0.8])
def test_the_low_pass_of_a_short_blow_hangs_on_its_impulse_alone(phase):
    """10 us in 2 ms, wherever it lies between the samples: of a Butterworth low-pass of order 4, forwards and backwards,
    the peak is 2 I times the integral of 1 / (1 + (f / f_max)^8)."""
    f_max, lasts = 500.0, 1e-5
    start = 0.02 + phase / (128.0 * f_max)
    blow = np.linspace(start, start + lasts, 21)
    time = np.concatenate([np.linspace(0.0, start - lasts, 200), blow, np.linspace(start + 2.0 * lasts, 0.04, 200)])
    force = np.where((time >= blow[0]) & (time <= blow[-1]), np.sin(np.pi * (time - start) / lasts), 0.0)
    exact = 2.0 * trapezoid(force, time) * f_max * (np.pi / 8.0) / np.sin(np.pi / 8.0)
    _, smooth = low_pass_uneven(time, force[:, None], f_max)
    assert smooth.max() == pytest.approx(exact, rel=1e-3)
