"""What structures answer to forces: pairs of complex modes against the inverse of the whole matrices."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import FloatArray
from creak.linalg.complex_modes import complex_modes
from creak.sound.answering import CoupledModes, transfer

OMEGA = np.array([0.0, 60.0, 61.0, 400.0, 3000.0, 9000.0, 40000.0])
"""rad/s, a rigid mode and two that nearly coincide among them"""


def damped_by(strength: float) -> tuple[CoupledModes, FloatArray, FloatArray, FloatArray]:
    """Modes that two dashpots couple, under three forces, seen by two rows; mass, stiffness and damping matrices."""
    rng = np.random.default_rng(3)
    m = rng.uniform(0.5, 2.0, OMEGA.size)
    at = rng.normal(size=(OMEGA.size, 2))
    C = np.diag(0.02 * OMEGA * m) + strength * at @ at.T
    pairs = complex_modes(m, OMEGA**2 * m, C)
    return CoupledModes(pairs.blocks, pairs.basis, PUSH @ pairs.push.T), m, OMEGA**2 * m, C


PUSH, ROWS = (np.random.default_rng(7).normal(size=(k, OMEGA.size)) for k in (3, 2))


@pytest.mark.parametrize("strength", [0.5, 50.0, 5000.0])
def test_pairs_answer_as_the_whole_matrices(strength):
    modes, m, k, C = damped_by(strength)
    for s in (3.0 + 0.0j, 5.0 + 60.5j, 2.0 + 3000.0j, 10.0 + 20000.0j):
        exact = ROWS @ np.linalg.inv(np.diag(m * s**2 + k) + C * s) @ PUSH.T
        z = np.array([[s]])
        np.testing.assert_allclose(modes.answer(modes.seen(ROWS), z) @ modes.push.T, exact, rtol=1e-7)
        np.testing.assert_allclose(modes.seen(ROWS) @ modes.answered(modes.push, z).T, exact, rtol=1e-7)
    assert np.isrealobj(transfer(modes, ROWS, 3.0))


def test_modes_far_above_are_a_series():
    """Off by the fourth power of the frequency over theirs, and by what their damping has of that."""
    modes, *_ = damped_by(0.5)
    fast, seen = modes.select(modes.omega > 2000.0, modes.seen(ROWS))
    for s in (30.0 + 200.0j, 30.0 + 400.0j):
        exact = fast.answer(seen, np.array([[s]])) @ fast.push.T
        found = sum(s**power * table for power, table in fast.series(seen))
        np.testing.assert_allclose(found, exact, rtol=3.0 * (abs(s) / 3000.0) ** 3)


def test_frequencies_and_decay_of_pairs():
    """Lightly damped pairs ring at the frequency of their mode, and decay with half of its damping."""
    modes, m, _, C = damped_by(1e-3)
    moves = OMEGA > 100.0
    order = np.argsort(modes.omega)
    np.testing.assert_allclose(modes.omega[order][moves], OMEGA[moves], rtol=1e-3)
    np.testing.assert_allclose(modes.decay[order][moves], 0.5 * (C.diagonal() / m)[moves], rtol=1e-3)


def test_coordinates_that_nothing_holds_stand_beside():
    """They move by their own push, whatever is beside them."""
    modes, *_ = damped_by(50.0)
    push, s = np.array([[0.0, 2.0], [1.0, 0.0], [0.0, 0.0]]), 7.0
    found = transfer(modes.beside(push), np.eye(OMEGA.size + 2), s)
    np.testing.assert_allclose(found[: OMEGA.size], transfer(modes, np.eye(OMEGA.size), s), rtol=1e-12)
    np.testing.assert_allclose(found[OMEGA.size :], push.T / s**2, rtol=1e-12)
