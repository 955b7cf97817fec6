"""Contact that presses at rest, or lasts: what goes on between its kicks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sla

from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from helpers_core import chain, channels, system_of

N, SPRING, PRESSED, PUSHED = 12, 1e8, [5, 11], 2
"""Masses of .01 kg in a row; two of them press on stops, which are ten times as stiff as what joins the masses."""
END, OMEGA, SWING = 0.02, 2.0 * np.pi * 300.0, 0.5
DASHPOTS = np.zeros((N, N))
DASHPOTS[np.ix_([3, 8], [3, 8])] = [[4.0, -4.0], [-4.0, 4.0]]
DASHPOTS[6, 6] = 1.0
M, K = chain(N, 0.01, 1e7)
DAMPED = {
    "none": np.zeros((N, N)),
    "modes by themselves": 20.0 * M + 1e-6 * K,
    "modes within a step": 400.0 * M + 1e-5 * K,
    "modes coupled": 20.0 * M + DASHPOTS,
}


def swung(C: np.ndarray, preload: float) -> History:
    """By a force of .5 N, so that the contact stays closed."""
    system = diagonalise(system_of(M, K, extra=C))
    time = np.linspace(0.0, END, 200 * SAMPLES + 1)
    force = SWING * np.sin(OMEGA * time)
    loads = Loads(time, np.zeros((3, time.size, 0)), force[:, None], (np.array([PUSHED]),))
    gaps = replace(channels(np.eye(N)[PRESSED], -preload / SPRING, SPRING), preload=np.full(2, preload))
    return simulate_flow(system, gaps, loads, OutputRequest(np.arange(N)))


def exactly(C: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, N) displacements and velocities with springs that never open, by the exponential of the whole equations."""
    held = K.copy()
    held[PRESSED, PRESSED] += SPRING
    A = np.zeros((2 * N + 2, 2 * N + 2))
    A[:N, N : 2 * N] = np.eye(N)
    A[N : 2 * N, :N], A[N : 2 * N, N : 2 * N] = -np.linalg.solve(M, held), -np.linalg.solve(M, C)
    A[N + PUSHED, -2] = SWING / M[PUSHED, PUSHED]
    A[-2, -1], A[-1, -2] = OMEGA, -OMEGA  # sin and cos of the force
    step, x = sla.expm(A * time[1]), np.zeros((time.size, 2 * N + 2))
    x[0, -1] = 1.0
    for i in range(1, time.size):
        x[i] = step @ x[i - 1]
    return x[:, :N], x[:, N : 2 * N]


@pytest.mark.parametrize("preload", [1.0, 100.0, 10_000.0])
@pytest.mark.parametrize("damped", DAMPED)
def test_a_preload_gives_a_small_vibration_no_energy(damped, preload):
    """However large it is: one of nanojoules beside springs that hold up to a joule. Held to the exponential."""
    C, time = DAMPED[damped], np.linspace(0.0, END, 20_001)
    history = swung(C, preload)
    assert (history.force > 0.0).all()
    u, v = exactly(C, time)
    work = np.trapezoid(SWING * np.sin(OMEGA * time) * v[:, PUSHED], time)
    lost = np.trapezoid(np.einsum("ti,ij,tj->t", v, C, v), time)
    most = 0.5 * np.einsum("ti,ij,tj->t", u, K, u).max()
    energy = dict(zip(ENERGIES, history.energy.T, strict=True))
    assert np.abs(energy["scheme"]).max() < 2e-4 * most
    assert energy["external"][-1] == pytest.approx(work, abs=0.02 * most)
    assert energy["damping"][-1] == pytest.approx(lost, abs=0.02 * most)
    at = np.arange(0, time.size, 100)
    own = -SPRING * u[at][:, PRESSED]
    for i in range(2):
        found = np.interp(time[at], history.time, history.force[:, i]) - preload
        np.testing.assert_allclose(found, own[:, i], rtol=0, atol=(0.02 + 4e-6 * preload) * np.abs(own).max())
