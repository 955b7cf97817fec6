"""Each contact law against its equation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid

from creak.contact.laws.friction import coefficient, coefficient_slope, friction_violations
from creak.contact.laws.linear import linear_energy, linear_pieces
from creak.contact.laws.pieces import Pieces, force_against, overclosure_at, piece_of
from creak.contact.laws.tabular import curve_energy, curve_force, tabular_pieces
from creak.contact.laws.unilateral import hard_pieces

X = np.array([0.0, 1e-3, 2e-3, 5e-3])
Y = np.array([0.0, 10.0, 100.0, 130.0])


def room(n: int = 8) -> Pieces:
    return Pieces(np.zeros(2, dtype=np.int64), np.zeros(n), np.zeros(n), np.zeros(n))


def one_channel(law: Pieces, end: int) -> Pieces:
    law.first[1] = end
    return law


def overclosure_of(law: Pieces, p: float) -> float:
    return overclosure_at(law, piece_of(law, 0, p), p)


@pytest.mark.parametrize("rate_free", [-3.0, 0.0, 3.0])
def test_pieces_of_a_spring_with_damper_are_its_equation(rate_free):
    """For every p > 0 the pieces give the gap at which -k g - c g' is p, or zero gap within the jump."""
    k, c, gain, gap_free = 1e5, 20.0, 1e3, -1e-4
    c_hat = c * (rate_free - gain * gap_free)
    law = room()
    one_channel(law, linear_pieces(law, 0, k + c * gain, c_hat))
    for p in np.geomspace(0.1, 1e4, 30):
        g = -overclosure_of(law, p)
        rate = rate_free + gain * (g - gap_free)
        if g == 0.0:
            assert p <= max(0.0, -c * rate)
        else:
            assert -k * g - c * rate == pytest.approx(p, rel=1e-12)


def test_an_opening_damper_delays_the_force():
    law = room()
    one_channel(law, linear_pieces(law, 0, 100.0, 5.0))
    assert overclosure_of(law, 0.0) == pytest.approx(0.05, rel=1e-15)
    assert force_against(law, 0, -0.04, 1.0) == 0.0


def test_energy_of_the_spring_is_the_work_of_its_force():
    g = np.linspace(0.0, -1e-3, 201)
    assert linear_energy(2e4, g[-1]) == pytest.approx(trapezoid(-2e4 * g, -g), rel=1e-12)
    assert linear_energy(2e4, 1e-3) == 0.0


def test_table_is_interpolated_and_goes_on_with_its_last_slope():
    for overclosure in np.linspace(0.0, 5e-3, 41):
        assert curve_force(X, Y, 0, 4, overclosure) == pytest.approx(np.interp(overclosure, X, Y), rel=1e-13)
    assert curve_force(X, Y, 0, 4, 8e-3) == pytest.approx(160.0, rel=1e-13)
    assert curve_force(X, Y, 0, 4, -1e-3) == 0.0


def test_energy_of_a_table_is_the_area_below_it():
    for end in (0.5e-3, 1.7e-3, 4e-3, 9e-3):
        x = np.unique([*np.linspace(0.0, end, 7), *X[end > X]])
        area = trapezoid([curve_force(X, Y, 0, 4, v) for v in x], x)
        assert curve_energy(X, Y, 0, 4, end) == pytest.approx(area, rel=1e-12)
    assert curve_energy(X, Y, 0, 4, -1.0) == 0.0


@pytest.mark.parametrize("c_hat", [-30.0, 0.0, 30.0])
def test_pieces_of_a_table_with_damper_are_its_equation(c_hat):
    scale, slope = 2.5, 1e3
    law = room()
    one_channel(law, tabular_pieces(law, 0, X, Y, 0, 4, scale, slope, c_hat))
    for p in np.geomspace(0.1, 1e4, 40):
        y = overclosure_of(law, p)
        if y == 0.0:
            assert p <= -c_hat
        else:
            assert scale * curve_force(X, Y, 0, 4, y) + slope * y - c_hat == pytest.approx(p, rel=1e-12)


def test_a_plateau_keeps_the_force_unique():
    """A flat stretch of the table gets a slope too small to be seen in the force."""
    x, y = np.array([0.0, 1e-3, 3e-3, 4e-3]), np.array([0.0, 50.0, 50.0, 90.0])
    law = room()
    one_channel(law, tabular_pieces(law, 0, x, y, 0, 4, 1.0, 0.0, 0.0))
    p = force_against(law, 0, -2e-3 - 50.0 * 1e-9, 1e-9)
    assert p == pytest.approx(50.0, rel=1e-6)
    assert curve_force(x, y, 0, 4, 2e-3) == pytest.approx(50.0, rel=1e-6)


def test_one_channel_against_a_compliance():
    """gap + a p + y(p) = 0: hard, linear and tabular."""
    a = 1e-5
    laws = [room() for _ in range(3)]
    one_channel(laws[0], hard_pieces(laws[0], 0))
    one_channel(laws[1], linear_pieces(laws[1], 0, 1e5, -2.0))
    one_channel(laws[2], tabular_pieces(laws[2], 0, X, Y, 0, 4, 1.0, 0.0, 0.0))
    for law in laws:
        assert force_against(law, 0, 1e-6, a) == 0.0
        for gap in -np.geomspace(1e-6, 1e-2, 20):
            p = force_against(law, 0, gap, a)
            # Round-off of three terms, each at most as large as the gap.
            assert gap + a * p + overclosure_of(law, p) == pytest.approx(0.0, abs=4e-16 * abs(gap))
    assert force_against(laws[0], 0, -1e-3, a) == pytest.approx(100.0, rel=1e-15)


def test_coefficient_of_friction_falls_from_static_to_kinetic():
    assert coefficient(0.0, 0.5, 0.2, 0.1, False) == 0.5
    assert coefficient(0.1, 0.5, 0.2, 0.1, True) == pytest.approx(0.2 + 0.3 / np.e, rel=1e-15)
    assert coefficient(10.0, 0.5, 0.2, 0.1, True) == pytest.approx(0.2, rel=1e-15)
    assert coefficient(0.0, 0.5, 0.2, 0.0, True) == 0.5
    assert coefficient(0.0, 0.5, 0.2, 0.0, False) == 0.2
    h = 1e-6
    difference = (coefficient(0.1 + h, 0.5, 0.2, 0.1, True) - coefficient(0.1 - h, 0.5, 0.2, 0.1, True)) / (2 * h)
    # Central difference: h^2 / 6 of the third derivative, 1e-10 relative.
    assert coefficient_slope(0.1, 0.5, 0.2, 0.1) == pytest.approx(difference, rel=1e-8)
    assert coefficient_slope(0.1, 0.5, 0.2, 0.0) == 0.0


def violation(tau, d, p=2.0, mu=0.5):
    return min(friction_violations(p, *tau, *d, mu, mu, 1e-3))


def test_violation_of_friction_is_zero_on_the_law_only():
    turn = np.array([0.6, 0.8])
    assert violation(0.7 * turn, (0.0, 0.0)) == 0.0
    assert violation(-turn, 3e-4 * turn) < 1e-15
    assert violation(1.2 * turn, (0.0, 0.0)) == pytest.approx(0.2, rel=1e-12)
    assert violation(turn, 3e-4 * turn) == pytest.approx(0.3, rel=1e-12), "friction that drives the sliding"
    assert violation(-0.5 * turn, 3e-4 * turn) >= 0.3 - 1e-15, "sliding below the limit"
    assert violation((-1.0, 0.0), 3e-4 * turn) > 0.1, "friction across the sliding"
    assert violation((0.0, 0.0), 3e-4 * turn, p=0.0) == 0.0
