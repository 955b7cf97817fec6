"""Complex modes of few dashpots by their secular equation, against the matrices of the whole structure."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import FloatArray
from creak.linalg import complex_modes as found_by
from creak.linalg.complex_modes import ComplexModes, complex_modes
from creak.linalg.secular import FEWEST, few_dashpots

P = FEWEST + 20


def structure(strength: float, count: int = 2) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """m, k, C and the dashpots' part of it; two frequencies all but coincide, one mode lies in a node of both."""
    rng = np.random.default_rng(5)
    omega = np.sort(np.exp(rng.uniform(np.log(100.0), np.log(3e6), P)))
    omega[5] = omega[4] * (1.0 + 1e-7)
    m = rng.uniform(0.1, 3.0, P)
    at = rng.normal(size=(P, count))
    at[7] = 0.0
    shared = strength * at @ at.T
    return m, omega**2 * m, np.diag(0.04 * omega * m) + shared, shared


def answer(pairs: ComplexModes, omega: float, F: FloatArray) -> np.ndarray:
    """q of q'' under F e^(i omega t), pair by pair."""
    a, b, c, d = pairs.blocks[:, :, None]
    s, (first, second) = 1j * omega, np.split(pairs.push @ F, 2)
    z = np.vstack([(s - d) * first + b * second, c * first + (s - a) * second])
    return np.asarray(pairs.basis @ (z / np.tile((s - a) * (s - d) - b * c, (2, 1))))


@pytest.mark.parametrize("strength", [0.1, 20.0, 3000.0])
def test_the_structure_answers_as_its_matrices(strength, monkeypatch):
    """Strong dashpots make overdamped pairs."""
    m, k, C, shared = structure(strength)

    def not_asked(*_):
        raise AssertionError("all eigenvectors were asked for at once")

    monkeypatch.setattr(found_by, "_eigenpairs", not_asked)
    pairs = complex_modes(m, k, C, shared)
    assert pairs.alone == 1
    assert np.any(pairs.blocks[1, 1:] == 0.0) == (strength > 1.0)
    F = np.random.default_rng(6).normal(size=(P, 3))
    for omega in (300.0, 5e4, 1e6):
        exact = np.linalg.solve(np.diag(k - omega**2 * m) + 1j * omega * C, F)
        np.testing.assert_allclose(answer(pairs, omega, F), exact, atol=1e-9 * np.abs(exact).max())


def test_many_dashpots_are_left_to_all_at_once():
    *_, C, shared = structure(1.0, count=40)
    assert few_dashpots(C, shared) is None
