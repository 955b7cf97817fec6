"""Rounded tables, smooth steps and periodic sums against formulas; derivatives and integrals against each other."""

import numpy as np
import pytest

from creak.signals.curves import Periodic, Rounded, SmoothStep
from creak.signals.sources import Table, acceleration_motion, displacement_motion

T = np.linspace(0.0, 2.0, 4001)
CURVES = {
    "smooth step": SmoothStep(np.array([0.1, 0.6, 1.5]), np.array([1.0, 3.0, -2.0])),
    "rounded": Rounded(np.array([0.0, 0.5, 0.8, 1.5]), np.array([0.0, 2.0, -1.0, 1.0]), 0.25),
    "periodic": Periodic(1.5, np.array([0.3, -0.3]), np.array([1.0, -0.5]), mean=0.2, start=0.4),
}


def test_smooth_step_formula():
    x = (T - 0.6) / 0.9
    exact = np.where(x < 1.0, 3.0 - 5.0 * x**3 * (10.0 - 15.0 * x + 6.0 * x**2), -2.0)
    here = T >= 0.6
    assert np.abs(CURVES["smooth step"].derivative(T, 0) - exact)[here].max() < 1e-12  # round-off
    assert CURVES["smooth step"].derivative(np.array([0.0, 0.1]), 0).tolist() == [1.0, 1.0]


def test_rounded_is_the_table_away_from_its_corners():
    curve = CURVES["rounded"]
    line = np.interp(T, curve.time, curve.value)
    # Corners reach 0.25 x 0.3 = 0.075 at 0.5 and 0.8, 0.25 x 0.7 = 0.175 at the end; none at t = 0.
    away = (np.abs(T - 0.5) > 0.075) & (np.abs(T - 0.8) > 0.075) & (np.abs(T - 1.5) > 0.175)
    found = curve.derivative(T, 0)
    assert np.abs(found - line)[away].max() < 1e-12
    # Half a parabola's rise lies between corner and curve: reach (slope_2 - slope_1) / 4.
    at = curve.derivative(np.array([0.5]), 0)[0]
    assert at - 2.0 == pytest.approx(0.075 * (-10.0 - 4.0) / 4.0)
    assert curve.derivative(np.array([0.0]), 1)[0] == pytest.approx(4.0)


def test_rounded_of_one_point_is_constant():
    one = Rounded(np.array([0.3]), np.array([2.0]), 0.25)
    assert np.array_equal(one.derivative(T, 0), np.full(T.size, 2.0))
    assert np.array_equal(one.derivative(T, 1), np.zeros(T.size))


def test_corners_may_meet():
    """With a share of 0.5 a zigzag of even intervals has no straight piece left."""
    zigzag = Rounded(np.arange(5.0), np.array([0.0, 1.0, 0.0, 1.0, 0.0]), 0.5)
    assert zigzag.derivative(np.array([0.5, 1.0, 1.5, 2.0]), 0) == pytest.approx([0.5, 0.75, 0.5, 0.25])
    assert zigzag.derivative(np.array([0.5, 1.0, 1.5]), 1) == pytest.approx([1.0, 0.0, -1.0])


def test_periodic_formula():
    w = 2.0 * np.pi * 1.5
    t = T - 0.4
    exact = 0.2 + 0.3 * (np.cos(w * t) - np.cos(2.0 * w * t)) + np.sin(w * t) - 0.5 * np.sin(2.0 * w * t)
    found = CURVES["periodic"].derivative(T, 0)
    assert np.abs(found - exact)[T >= 0.4].max() < 1e-12
    assert (found[T < 0.4] == 0.2).all()


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("order", [-2, -1, 0])
def test_each_order_is_the_derivative_of_the_one_below(name, order):
    """Sums by the trapezoidal rule: its error is half a step times the jumps of the rate, else far smaller."""
    curve, h = CURVES[name], T[1]
    rate = curve.derivative(T, order + 1)
    summed = np.concatenate([[0.0], np.cumsum(0.5 * h * (rate[1:] + rate[:-1]))])
    found = curve.derivative(T, order)
    assert np.abs(found - found[0] - summed).max() < h * np.abs(rate).max()
    if order < 0:
        assert found[0] == 0.0


def test_motion_from_displacement_velocity_and_acceleration():
    curve = CURVES["smooth step"]
    assert np.array_equal(displacement_motion(curve, T).displacement, curve.values(T))
    assert np.array_equal(curve.motion(T, 1).velocity, curve.values(T))
    assert np.array_equal(acceleration_motion(curve, T).acceleration, curve.values(T))


def test_rounding_replaces_the_splines_of_a_table():
    time, value = np.array([0.0, 1.0]), np.array([0.0, 1.0])
    straight = displacement_motion(Table(time, value, 0.1), T)
    assert straight.velocity[0] == pytest.approx(1.0)
    assert straight.displacement[1000] == pytest.approx(0.5)
    corner = Table(time, value).motion(T, 1)
    assert corner.displacement[-1] == pytest.approx(0.5 + 1.0)
