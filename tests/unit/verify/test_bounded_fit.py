"""Bounded least squares: closed forms of the linear problem, coverage of the intervals, what cannot be determined."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla

from creak.studies.models.trials import frequency_slopes
from creak.verify.bounded_fit import Z95, Fit, bounded_fit

RECORDED = {"section": "models"}

WIDE = np.full(3, 5.0)


def line(n: int = 8):
    """A straight line through n points, in standard deviations of the data."""
    return np.column_stack([np.ones(n), np.arange(n, dtype=float)])


def linear(A, data, start=None, low=-9.0, high=9.0):
    n = A.shape[1]
    begin = np.zeros(n) if start is None else start
    return bounded_fit(lambda x: A @ x - data, lambda x: A, begin, np.full(n, low), np.full(n, high))


def test_linear_fit_is_that_of_the_normal_equations():
    A, data = line(), np.array([0.1, 1.2, 1.9, 3.1, 4.05, 4.8, 6.1, 7.0])
    fit = linear(A, data)
    exact = np.linalg.solve(A.T @ A, A.T @ data)
    np.testing.assert_allclose(fit.x, exact, rtol=1e-6)
    assert fit.scatter == 1.0  # the residuals are smaller than was stated
    np.testing.assert_allclose(fit.covariance, np.linalg.inv(A.T @ A), rtol=1e-9)
    np.testing.assert_allclose(fit.half_width, Z95 * np.sqrt(np.diag(np.linalg.inv(A.T @ A))), rtol=1e-9)


def test_residuals_larger_than_stated_widen_the_intervals():
    A, data = line(), 5.0 * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    fit = linear(A, data)
    spread = np.sqrt(fit.residuals @ fit.residuals / 6.0)
    assert fit.scatter == pytest.approx(spread, rel=1e-12)
    assert spread > 4.0
    np.testing.assert_allclose(fit.covariance, spread**2 * np.linalg.inv(A.T @ A), rtol=1e-9)


def test_each_datum_as_the_others_foretell_it():
    A, data = line(), np.array([0.1, 1.2, 1.9, 3.1, 4.05, 4.8, 6.1, 7.0])
    fit = linear(A, data)
    for k in range(data.size):
        rest = np.arange(data.size) != k
        without = np.linalg.lstsq(A[rest], data[rest], rcond=None)[0]
        assert fit.foretold[k] == pytest.approx(A[k] @ without - data[k], abs=1e-5)


def test_a_datum_that_alone_determines_a_parameter_foretells_nothing():
    A = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    fit = linear(A, np.array([1.0, 1.1, 2.0]))
    assert np.isnan(fit.foretold).tolist() == [False, False, True]


def test_what_is_known_only_together_is_named():
    """A product of two parameters, and a third beside it."""
    A = 9.0 * np.column_stack([line()[:, 1], line()[:, 1], np.ones(8)])
    fit = linear(A, np.ones(8))
    assert [rows.tolist() for rows in fit.undetermined(np.log(2.0))] == [[0, 1]]
    weak = linear(line() * [1e-3, 1.0], np.ones(8))
    assert [rows.tolist() for rows in weak.undetermined(np.log(2.0))] == [[0]]
    assert linear(line(), np.ones(8)).undetermined(2.0) == []


def test_a_parameter_at_its_bound_has_no_interval():
    fit = linear(line(), np.full(8, 20.0))
    assert fit.on_bound.tolist() == [True, False]
    assert np.isnan(fit.half_width).tolist() == [True, False]
    assert fit.x[0] == pytest.approx(9.0, abs=1e-2)


def chain(p):
    """Masses on springs to ground and to one another: stiffness of ground, of the links, and mass of every second."""
    n = 20
    ground, link = np.eye(n), 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    heavy = np.diag(np.arange(n) % 2.0)
    dK, dM = [p[0] * ground, p[1] * link, 0.0 * link], [0.0 * link, 0.0 * link, p[2] * heavy]
    return sum(dK), np.diag(1.0 - np.arange(n) % 2.0) + sum(dM), dK, dM


def modes_and_slopes(x):
    K, M, dK, dM = chain(np.exp(x))
    omega2, shapes = sla.eigh(K, M)
    slopes = np.column_stack([frequency_slopes(k, m, shapes, omega2) for k, m in zip(dK, dM, strict=True)])
    return np.sqrt(omega2), slopes


def test_slopes_of_a_chain_are_those_of_differences():
    x, h = np.log([2.0, 30.0, 1.5]), 1e-4
    for j, e in enumerate(np.eye(3)):
        differences = (np.log(modes_and_slopes(x + h * e)[0]) - np.log(modes_and_slopes(x - h * e)[0])) / (2.0 * h)
        np.testing.assert_allclose(modes_and_slopes(x)[1][:, j], differences, atol=1e-7)


def test_intervals_hold_the_truth_in_95_of_100_tests(measured):
    """100 tests of the chain with 1 % noise in each frequency, begun from wrong values: three intervals each."""
    truth, sigma = np.log([2.0, 30.0, 1.5]), 0.01
    exact = modes_and_slopes(truth)[0]
    held, near = np.zeros((100, 3), dtype=bool), np.zeros((100, 3))
    for seed in range(100):
        test = exact * (1.0 + sigma * np.random.default_rng(seed).standard_normal(exact.size))
        fit = bounded_fit(
            lambda x, test=test: (modes_and_slopes(x)[0] / test - 1.0) / sigma,
            lambda x, test=test: modes_and_slopes(x)[1] * (modes_and_slopes(x)[0] / test)[:, None] / sigma,
            truth + np.log([1.5, 0.7, 0.8]),
            truth - WIDE,
            truth + WIDE,
        )
        held[seed] = np.abs(fit.x - truth) <= fit.half_width
        near[seed] = fit.x - truth
    source = "100 tests with noise, seeds 0 to 99"
    for j, name in enumerate(("stiffness to ground", "stiffness of the links", "mass")):
        measured(
            f"update of a chain, {name}: truth within the 95 % interval, of 100",
            int(held[:, j].sum()),
            between=(91, 100),
            source=source,
        )
    assert np.abs(near.mean(axis=0)).max() < 0.3 * near.std(axis=0).max()
    assert 0.92 <= held.mean() <= 0.99


@pytest.mark.parametrize(("data", "parameters", "least"), [(2, 1, 0.94), (3, 1, 0.94), (4, 2, 0.94), (10, 2, 0.94)])
def test_intervals_of_few_data_whose_noise_is_more_than_was_stated(data, parameters, least, measured):
    """Noise of three times what was stated: with 1.96 for Student's t, 76, 83, 83 and 92 of 100 hold the truth. Two data
    that happen to agree count as uncertain as was stated."""
    rng = np.random.default_rng(5)
    held = 0
    for _ in range(4000):
        A, noise = rng.normal(size=(data, parameters)), 3.0 * rng.normal(size=data)
        x = np.linalg.lstsq(A, noise, rcond=None)[0]
        fit = Fit(x, A @ x - noise, A, np.zeros(parameters, dtype=bool))
        held += int(abs(x[0]) <= fit.half_width[0])
    measured(
        f"update of {parameters} from {data} data with 3 times the noise stated: truth within the interval, of 100",
        held / 40.0,
        between=(100.0 * least, 97.0),
        source="4000 linear problems",
    )
