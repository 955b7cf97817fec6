"""Complex modes made real, how real they are, and which measured modes belong to which of a model."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from creak.verify.mac import mac_matrix, pair_measured, phase_collinearity, real_shapes


@given(st.integers(0, 10**6), st.floats(-10.0, 10.0), st.floats(1e-290, 1e290))
@settings(max_examples=50, deadline=None)
def test_a_real_mode_of_any_phase_and_scale_comes_back(seed, phase, scale):
    x = np.random.default_rng(seed).normal(size=(7, 1))
    z = scale * np.exp(1j * phase) * x
    assert phase_collinearity(z)[0] == pytest.approx(1.0, abs=1e-12)
    found = real_shapes(z)
    assert mac_matrix(found, x)[0, 0] == pytest.approx(1.0, abs=1e-12)
    assert np.abs(found).max() == pytest.approx(1.0, rel=1e-12)


@given(st.integers(0, 10**6))
@settings(max_examples=50, deadline=None)
def test_no_other_phase_has_a_larger_real_part(seed):
    rng = np.random.default_rng(seed)
    z = rng.normal(size=(5, 2)) + 1j * rng.normal(size=(5, 2))
    z /= np.abs(z).max(axis=0)
    best = np.linalg.norm(real_shapes(z), axis=0)
    for theta in np.linspace(0.0, np.pi, 37):
        assert (np.linalg.norm((z * np.exp(1j * theta)).real, axis=0) <= best * (1.0 + 1e-12)).all()


@given(st.integers(0, 10**6))
@settings(max_examples=50, deadline=None)
def test_collinearity_is_that_of_the_scatter_of_real_and_imaginary_parts(seed):
    """((S_xx - S_yy)^2 + 4 S_xy^2) / (S_xx + S_yy)^2, which is (l1 - l2)^2 / (l1 + l2)^2 of its principal axes."""
    rng = np.random.default_rng(seed)
    z = rng.normal(size=9) + 1j * rng.normal(size=9)
    low, high = np.linalg.eigvalsh(
        np.cov(np.stack([z.real, z.imag]), bias=True) * 9 + 9 * np.outer(*[[z.real.mean(), z.imag.mean()]] * 2)
    )
    assert phase_collinearity(z[:, None])[0] == pytest.approx(((high - low) / (high + low)) ** 2, abs=1e-12)


def test_a_wave_round_a_disk_is_as_complex_as_can_be():
    angle = 2.0 * np.pi * np.arange(12) / 12
    assert phase_collinearity(np.exp(3j * angle)[:, None])[0] == pytest.approx(0.0, abs=1e-15)
    assert phase_collinearity(np.zeros((4, 1), dtype=complex))[0] == 0.0


def test_frequency_decides_between_shapes_that_look_alike():
    mac = np.array([[0.97, 0.0, 0.98], [0.0, 1.0, 0.0], [0.96, 0.0, 0.97]])
    partner = pair_measured(mac, np.array([100.0, 150.0, 180.0]), np.array([102.0, 149.0, 190.0]))
    assert partner.tolist() == [0, 1, 2]


def test_shape_decides_where_modes_change_places():
    mac = np.array([[0.02, 0.95], [0.9, 0.03]])
    assert pair_measured(mac, np.array([100.0, 110.0]), np.array([95.0, 120.0])).tolist() == [1, 0]


def test_a_mode_is_given_once_and_the_best_sum_counts():
    mac = np.array([[0.95, 0.90], [0.94, 0.10]])
    assert pair_measured(mac, np.array([100.0, 100.0]), np.array([100.0, 100.0])).tolist() == [1, 0]


@pytest.mark.parametrize(
    ("mac", "test", "model"),
    [
        ([[0.59]], [100.0], [100.0]),
        ([[1.0]], [100.0], [201.0]),
        ([[1.0]], [100.0], [49.0]),
        ([[1.0]], [100.0], [0.0]),
        ([[1.0]], [0.0], [100.0]),
    ],
)
def test_no_partner(mac, test, model):
    assert pair_measured(np.array(mac), np.array(test), np.array(model)).tolist() == [-1]


def test_no_modes_at_all():
    assert pair_measured(np.zeros((2, 0)), np.ones(2), np.zeros(0)).tolist() == [-1, -1]
