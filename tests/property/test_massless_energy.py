"""The massless boundary creates no energy: random chains, gaps, laws, friction and steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from creak.contact.laws.parameters import Friction
from creak.dynamics.channels import channel_matrices
from creak.dynamics.history import ENERGIES
from creak.dynamics.loads import at_rest
from creak.dynamics.modal.coefficients import MasslessBoundary
from creak.dynamics.modal.march import simulate_modal
from creak.dynamics.modal.massless import FRACTION, massless_substeps
from creak.dynamics.modal.taper import tapered
from creak.reduction.diagonal import diagonalise
from creak.reduction.massless_boundary import massless_boundary
from helpers_core import chain, channels, system_of

pytestmark = pytest.mark.slow

CREATED = 0.25 * FRACTION**2
"""Share of the energy at hand: an onset or a release in the middle of a step misses (omega_c h)^2 / 8 of the contact
spring's energy at most; twice that."""
N = 10


def random_case(seed: int, hard: bool, mu: float):
    """Two grounded chains along x and y whose ends meet rigid stops; an end that is stopped also rubs."""
    rng = np.random.default_rng(seed)
    M, K = np.zeros((2 * N, 2 * N)), np.zeros((2 * N, 2 * N))
    for k in range(2):
        here = slice(k * N, (k + 1) * N)
        M[here, here], K[here, here] = chain(N, mass=rng.uniform(0.5, 2.0), stiffness=rng.uniform(1e4, 1e5))
    system = system_of(M, K, beta=float(rng.uniform(0.0, 1e-5)), velocity=rng.uniform(-1.0, 1.0, 2 * N))
    G = np.zeros((2, 2 * N))
    G[0, N - 1], G[1, N // 2] = rng.choice([-1.0, 1.0], 2)
    along = np.zeros((2, 2 * N))
    along[0, 2 * N - 1], along[1, N + N // 2] = 1.0, 1.0
    gaps = channels(G, rng.uniform(0.0, 5e-3, 2), np.inf if hard else rng.uniform(1e4, 1e6, 2))
    if mu > 0.0:
        tangent = channels(along, 0.0, 0.0).G
        friction = Friction(np.full(2, mu), np.full(2, 0.7 * mu), np.full(2, float(rng.choice([0.0, 0.1]))))
        gaps = replace(gaps, tangents=(tangent, 0.0 * tangent), friction=friction)
    return system, gaps, float(rng.uniform(1e-4, 2e-3))


@settings(max_examples=1000, derandomize=True, deadline=None)
@given(st.integers(0, 10**6), st.booleans(), st.sampled_from([0.0, 0.3, 1.0]), st.integers(4, 2 * N - 3))
def test_no_energy_is_created(measured, seed, hard, mu, count):
    system, gaps, step = random_case(seed, hard, mu)
    rows = channel_matrices(system, gaps).rows
    small = diagonalise(massless_boundary(system, rows, count=count))
    small = tapered(small, channel_matrices(small, gaps).rows)
    parts = massless_substeps(small, gaps, step)
    loads = at_rest(step / parts * np.arange(100 * parts + 1))
    run = simulate_modal(small, gaps, loads, MasslessBoundary(), observed=np.zeros(0, dtype=np.int64), substeps=parts)
    measured(
        "energy",
        "massless boundary, random chains: share of energy created",
        run.energy_created,
        at_most=CREATED,
        source="conservation",
    )
    friction = run.energy[:, ENERGIES.index("friction")]
    # Its work is booked by the trapezoidal rule: a step in which the sliding turns round may give some back.
    assert np.diff(friction).min() >= -CREATED * run.energy_scale
    if hard:
        assert run.gap.min() >= -1e-9
