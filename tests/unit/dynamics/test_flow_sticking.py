"""Exact flow where several nodes stick under changing pressure, against an integration of the full matrices."""

from __future__ import annotations

import numba
import numpy as np
import pytest

import creak
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import ENERGIES
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise

RECORDED = {"section": "time"}

NODES, STIFFNESS, FRICTION, END, STEP = 12, 100.0, 0.5, 0.06, 1e-6
X, Z = 1 + np.arange(NODES), 2 + NODES + np.arange(NODES)
"""Along the floor and across it; before each a base that is moved."""


def strip(dashpot):
    """Stiffness, mass and damping of a strip that is dragged by its first node and pressed on a floor by springs."""
    n = 2 * NODES + 2

    def join(by, *dofs):
        row = np.zeros(n)
        row[list(dofs)] = by
        return np.outer(row, row)

    K = 60.0 * join((-1, 1), 0, X[0])
    for i in range(NODES):
        K += 20.0 * join((-1, 1), Z[0] - 1, Z[i])
    for i in range(NODES - 1):
        K += 1e5 * join((-1, 1), X[i], X[i + 1]) + 1e4 * join((-1, 1, -0.3, 0.3), X[i], X[i + 1], Z[i], Z[i + 1])
    for i in range(1, NODES - 1):
        K += 2e3 * join((1, -2, 1), Z[i - 1], Z[i], Z[i + 1])
    C = dashpot * (join((-1, 1), X[0], X[2]) + join((-1, 1), Z[1], Z[2]))
    return K, 1e-6 * (1.0 + np.arange(n) % 3), C


def ways(time):
    """Of both bases: drawn by .08 and to and fro by .02; pressed by .2, half of which swings."""

    def rise(begin, end):
        x = np.clip((time - begin) / (end - begin), 0.0, 1.0)
        return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)

    along = 0.08 * rise(0.01, 0.04) + 0.02 * np.sin(2.0 * np.pi * 43.0 * (time - 0.01)) * rise(0.01, 0.03)
    return along, -0.2 * rise(0.0, 0.01) * (1.0 + 0.5 * np.sin(2.0 * np.pi * 77.0 * time) * rise(0.0, 0.02))


def implicit_euler(M, C, K, pulls, h, k, mu):
    """Backward Euler with projected Gauss-Seidel, nodes along the floor before those across it: u, heat of friction."""
    A = np.linalg.inv(M + h * C + h * h * K)
    return _implicit_euler(A, A @ M, h * A @ K, h * pulls @ A, h, k, mu)


@numba.njit
def _implicit_euler(A, AM, AK, pulled, h, k, mu):  # type: ignore[no-untyped-def]
    """The same with products of A = (M + h C + h^2 K)^-1; in plain loops, which take a third as long to compile."""
    n = A.shape[0] // 2
    u, v, w, f, heat = np.zeros(2 * n), np.zeros(2 * n), np.zeros(2 * n), np.zeros(2 * n), 0.0
    for s in range(pulled.shape[0]):
        for i in range(2 * n):
            w[i] = pulled[s, i]
            for j in range(2 * n):
                w[i] += AM[i, j] * v[j] - AK[i, j] * u[j] + h * A[i, j] * f[j]
        change = 1.0
        while change > 1e-10:
            change = 0.0
            for i in range(n):
                z = n + i
                gap = u[z] + h * w[z] - h * h * A[z, z] * f[z]
                pressure = max(0.0, -k * gap / (1.0 + k * h * h * A[z, z]))
                along = f[i] - w[i] / (h * A[i, i])
                friction = min(max(along, -mu * pressure), mu * pressure)
                more, pulls = pressure - f[z], friction - f[i]
                change = max(change, abs(more), abs(pulls))
                for j in range(2 * n):
                    w[j] += h * (more * A[z, j] + pulls * A[i, j])
                f[z], f[i] = pressure, friction
        for j in range(2 * n):
            v[j] = w[j]
            u[j] += h * w[j]
        for i in range(n):
            heat -= h * f[i] * v[i]
    return u, heat


@pytest.mark.parametrize(("beta", "dashpot"), [(1e-5, 0.0), (1e-5, 0.02), (0.0, 0.02)])
def test_several_nodes_stick_and_slip_where_fast_modes_are_damped(beta, dashpot, measured):
    """Modes of up to 100 kHz with .1 to 30 of critical damping; what sticks neither creeps nor gives energy."""
    K, mass, C = strip(dashpot)
    time = np.linspace(0.0, END, 200 * SAMPLES + 1)
    free = creak.system_from_matrices(K, np.diag(mass), C=C if dashpot else None, beta=beta)
    system = diagonalise(creak.couple(free, driven={"along": [0], "across": [Z[0] - 1]}))
    rows = np.eye(K.shape[0])
    tangents = [rows[X], np.zeros((NODES, K.shape[0]))]
    gaps = creak.gap_channels(rows[Z], 0.0, STIFFNESS, tangents=tangents, friction=(FRICTION, FRICTION, 0.0))
    motion = dict(zip(("along", "across"), (creak.Table(time, way) for way in ways(time)), strict=True))
    loads = creak.make_loads(system, time, motion=motion)
    history = simulate_flow(system, gaps, loads, OutputRequest(np.arange(K.shape[0])))
    inner, base = np.concatenate([X, Z]), np.array([0, Z[0] - 1])
    s = np.stack(ways(STEP * np.arange(round(END / STEP) + 1)), axis=1)
    C = C + beta * K
    pulls = -s[1:] @ K[np.ix_(base, inner)] - np.diff(s, axis=0) @ C[np.ix_(base, inner)] / STEP
    own = np.ix_(inner, inner)
    u, heat = implicit_euler(np.diag(mass)[own], C[own], K[own], pulls, STEP, STIFFNESS, FRICTION)
    place = u[:NODES]
    energy = dict(zip(ENERGIES, history.energy[-1], strict=True))
    measured(
        f"heat of nodes that stick and slip, beta {beta:g}, dashpots {dashpot:g}: share off",
        abs(energy["friction"] / heat - 1.0),
        at_most=3e-2,
        source="backward Euler of the full matrices, projected Gauss-Seidel",
    )
    np.testing.assert_allclose(history.displacement[-1, X], place, rtol=0, atol=3e-2 * np.abs(place).max())
    assert energy["damping"] > 0.0
    assert history.energy_created < 1e-4


def test_what_sticks_does_not_walk_where_it_is_shaken_unevenly(measured):
    """A mass that is pulled one way quickly and back slowly, by up to three quarters of what holds it, 50 times: short
    steps one way and long ones back. A walk of a ten-thousandth of its way each time would show."""
    period, quick, way = 0.02, 6e-4, 0.06
    time = np.linspace(0.0, 0.05 + 50 * period, 3500 * SAMPLES + 1)
    knots = np.concatenate(
        [[0.0, 0.03], *(0.05 + period * k + np.array([0.0, quick, 0.5 * period]) for k in range(50))]
    )
    pulls = np.concatenate([[0.0, 0.0], *([[-1.0, 1.0, 1.0]] * 50)])
    piece = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, knots.size - 2)
    x = np.clip((time - knots[piece]) / np.diff(knots)[piece], 0.0, 1.0)
    smooth, size = x**3 * (10.0 - 15.0 * x + 6.0 * x**2), np.diff(pulls)[piece]
    rate, bend = 30.0 * x**2 * (1.0 - x) ** 2, 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)
    span = np.diff(knots)[piece]
    along = creak.Motion(
        *(way * row for row in (pulls[piece] + size * smooth, size * rate / span, size * bend / span**2))
    )
    K = np.diag([20.0, 20.0, 20.0, 20.0])
    K[0, 1] = K[1, 0] = K[2, 3] = K[3, 2] = -20.0
    free = creak.system_from_matrices(K, 1e-6 * np.eye(4), beta=1e-5)
    system = diagonalise(creak.couple(free, driven={"along": [0]}))
    tangents = [[[0.0, 1.0, 0.0, 0.0]], [[0.0] * 4]]
    normal = {"preload": 4.0, "tangents": tangents, "friction": (0.5, 0.5, 0.0)}
    gaps = creak.gap_channels([[0.0, 0.0, 0.0, 1.0]], 0.0, STIFFNESS, **normal)
    loads = creak.make_loads(system, time, motion={"along": along})
    history = simulate_flow(system, gaps, loads, OutputRequest(np.arange(4)))
    pull = np.abs(history.tangential[:, 0]) / (FRICTION * history.force[:, 0])
    assert 0.5 < pull.max() < 0.9
    assert not history.sliding.any()
    measured(
        "way of a mass that sticks while it is shaken unevenly 50 times, share of the shaking",
        np.abs(history.displacement[-1, 1]) / way,
        at_most=1e-4,
        source="it sticks",
    )


@numba.njit
def explicit(K, pull, gap0, k, mu, m, h, steps):  # type: ignore[no-untyped-def]
    """Heat of two nodes that press (dofs 0, 1), rub (2, 3; across: 4, 5) and stick where they stand: symplectic Euler."""
    u, v, F, heat, sticks = np.zeros(6), np.zeros(6), np.zeros(6), 0.0, np.ones(2, dtype=np.bool_)
    for s in range(steps):
        t = (s + 0.5) * h
        one, other = np.sin(74.0 * np.pi * t), np.sin(22.0 * np.pi * t)
        for i in range(6):
            F[i] = pull[0, i] * one + pull[1, i] * other
            for j in range(6):
                F[i] -= K[i, j] * u[j]
        for c in range(2):
            pressure = k * max(0.0, -gap0 - u[c])
            F[c] += pressure
            x, y = v[2 + c] + h / m * F[2 + c], v[4 + c] + h / m * F[4 + c]
            speed = np.sqrt(x * x + y * y)
            sticks[c] = pressure == 0.0 or speed * m / h <= mu[0 if sticks[c] else 1] * pressure
            taken = min(1.0, mu[1] * pressure * h / m / max(speed, 1e-300))
            if pressure > 0.0:
                taken = 1.0 if sticks[c] else taken
                F[2 + c] -= taken * x * m / h
                F[4 + c] -= taken * y * m / h
                heat += 0.0 if sticks[c] else taken * (1.0 - 0.5 * taken) * m * speed**2
        for i in range(6):
            v[i] += h / m * F[i]
            u[i] += h * v[i]
    return heat


@pytest.mark.parametrize(("seed", "stiffness"), [(2, 1e6), (0, 1e8), (1, 1e8)])
def test_friction_stands_under_friction_and_not_under_damping(seed, stiffness, measured):
    """Masses without dampers that touch, stick and slide: after touches and long steps, too, all heat is friction's."""
    draw, n, end, static, kinetic = np.random.default_rng(seed), 6, 0.05, 0.5, 0.3
    B = draw.normal(size=(n, n))
    K = 1e5 * (B @ B.T / n + 0.1 * np.eye(n))
    pull = 8.0 * draw.normal(size=(2, n))
    time = np.linspace(0.0, end, 50 * SAMPLES + 1)
    system = diagonalise(creak.system_from_matrices(K, 0.1 * np.eye(n)))
    rows = np.eye(n)
    tangents = [rows[2:4], rows[4:]]
    gaps = creak.gap_channels(rows[:2], 1e-5, stiffness, tangents=tangents, friction=(static, kinetic, 0.0))
    swings = np.stack([np.sin(74.0 * np.pi * time), np.sin(22.0 * np.pi * time)], axis=1)
    loads = creak.make_loads(system, time, forces=[(list(range(n)), swings @ pull)])
    history = simulate_flow(system, gaps, loads, OutputRequest(np.arange(n)))
    friction, damping = (history.energy[:, ENERGIES.index(name)] for name in ("friction", "damping"))
    heat = explicit(K, pull, 1e-5, stiffness, np.array([static, kinetic]), 0.1, 2e-7, round(end / 2e-7))
    measured(
        f"heat of two nodes that touch, stick and slide, stiffness {stiffness:g}, seed {seed}",
        friction[-1],
        heat,
        rel=1e-3,
        source="symplectic Euler of the full matrices",
    )
    assert np.abs(damping).max() < 5e-5 * friction[-1]
