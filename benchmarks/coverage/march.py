"""An integration of linear modes with contact that has nothing of creak: exact modes, Coulomb's law, tiny steps.

Every mode moves by its own closed form over a step in which its load is linear. The forces of springs that press follow
their law at both ends of a step and are linear between; friction is constant within it and brings the slip to rest at
its end, or reaches its limit. In flight a step is so long that no gap can close in it, by the energy of the modes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

from creak.arrays import FloatArray, IntArray

PARTS = 8
"""Coefficients of a mode over a step: displacement and speed from both, and from the load at its start and end."""
PER_CONTACT, PER_RUN = 20.0, 2e5
"""Instants kept in the shortest period of the contact springs, where the whole run has no more than these."""
WAKE = 16
"""Steps in contact after which all gaps are looked at again."""


@dataclass(frozen=True)
class Modes:
    """Modes x'' + c x' + omega^2 x = L sig(t) + G' p + T' tau, and gaps gap0 + G x + G_s sig(t)."""

    omega: FloatArray
    """(n,) rad/s, 0: rigid."""
    c: FloatArray
    """(n,) 1/s"""
    load: FloatArray
    """L, (n, n_sig)"""
    normal: FloatArray
    """G, (m, n)"""
    normal_sig: FloatArray
    """(m, n_sig)"""
    gap0: FloatArray
    """(m,)"""
    stiffness: FloatArray
    """(m,)"""
    tangent: FloatArray
    """T, (2 f, n): slip velocity = T x' + T_s sig."""
    tangent_sig: FloatArray
    """(2 f, n_sig)"""
    rubs: IntArray
    """(f,) channels that rub."""
    side: IntArray
    """(m,) number of the side of its contact that a channel is on: sides touch."""
    mu: FloatArray
    """(f, 3) static, kinetic, decay (speed, 0: kinetic as soon as it slides)."""
    start: FloatArray
    """(2, n) displacement and speed at t = 0."""

    @property
    def contact_omega(self) -> float:
        """Highest frequency of the springs of all channels against the masses behind them, rad/s."""
        if not self.gap0.size:
            return 0.0
        k = np.sqrt(self.stiffness)
        return float(np.sqrt(np.linalg.eigvalsh((k[:, None] * (self.normal @ self.normal.T)) * k).max()))


@dataclass(frozen=True)
class Course:
    """What a march leaves, at uneven instants: both sides of every change of a side that touches, and between them."""

    time: FloatArray
    gap: FloatArray
    """(n_time, m)"""
    force: FloatArray
    """(n_time, m) means whose trapezoidal sum is the impulse of all steps; 0 where the side is open."""
    friction_work: float
    """Taken by sliding."""
    slip_time: float
    """s in which any channel that presses slides, summed over the channels."""
    steps: int
    full: bool
    """It ended early: there was no room for more instants."""


def coefficients(omega: FloatArray, c: FloatArray, h: float) -> FloatArray:
    """(8, n) of a step h: x1 = a0 x + a1 v + a4 p0 + a5 p1, v1 = a2 x + a3 v + a6 p0 + a7 p1.

    By both roots of the characteristic equation; double ones are moved apart by 1e-7 of themselves, rigid modes have
    their own polynomials.
    """
    root = np.sqrt((0.25 * c**2 - omega**2).astype(complex))
    size = np.maximum(np.abs(root), 1e-7 * np.maximum(omega, 0.5 * c))
    rigid = size * h < 1e-12
    root = np.where(np.abs(root) < size, size.astype(complex), root)
    root[rigid] = 1.0 / h
    one, two = -0.5 * c + root, -0.5 * c - root
    e1, e2 = np.exp(one * h), np.exp(two * h)
    apart = one - two

    def psi(z: FloatArray, order: int) -> FloatArray:
        """phi_order(z): (e^z - 1) / z, or (e^z - 1 - z) / z^2; by series where z is small."""
        small = np.abs(z) < 0.3
        safe = np.where(small, 1.0, z)
        exact = (np.exp(safe) - 1.0) / safe if order == 1 else (np.exp(safe) - 1.0 - safe) / safe**2
        series, term = np.zeros_like(z), np.ones_like(z) / (1.0 if order == 1 else 2.0)
        for k in range(14):
            series = series + term
            term = term * z / (k + 1 + order)
        return np.where(small, series, exact)

    constant = h * (psi(one * h, 1) - psi(two * h, 1)) / apart
    ramp = h * (psi(one * h, 2) - psi(two * h, 2)) / apart
    v_constant = (e1 - e2) / apart
    v_ramp = constant / h
    a = np.array(
        [
            (one * e2 - two * e1) / apart,
            (e1 - e2) / apart,
            one * two * (e2 - e1) / apart,
            (one * e1 - two * e2) / apart,
            constant - ramp,
            ramp,
            v_constant - v_ramp,
            v_ramp,
        ]
    ).real
    a[:, rigid] = np.array([1.0, h, 0.0, 1.0, h * h / 3.0, h * h / 6.0, 0.5 * h, 0.5 * h])[:, None]
    return np.ascontiguousarray(a)


def march(modes: Modes, signals: FloatArray, spacing: float, end: float, h: float, longest: float) -> Course:
    """March to `end`.

    Parameters
    ----------
    signals : (n_sig, n_time), every `spacing` s from t = 0 on, linear between.
    h : step in contact, s. longest : in flight, s.
    """
    levels = max(1, int(np.log2(longest / h)) + 1)
    co = np.array([coefficients(modes.omega, modes.c, h * 2.0**k) for k in range(levels)])
    first, constant = co[0], co[0][4:8:2] + co[0][5:8:2]
    G, T = np.ascontiguousarray(modes.normal), np.ascontiguousarray(modes.tangent)
    stiff = np.where(modes.omega > 0.0, modes.omega, np.inf)
    quasi = modes.normal_sig + (G / stiff**2) @ modes.load
    compliances = (
        (G * first[5]) @ G.T,
        (G * constant[0]) @ T.T,
        (T * first[7]) @ G.T,
        (T * constant[1]) @ T.T,
    )
    m = modes.gap0.size
    table = np.empty((int(min(3e6, 4e7 / (2 * m + 1))), 1 + 2 * m))
    kept = max(2.0 * np.pi / max(modes.contact_omega, 1e-3 / end) / PER_CONTACT, end / PER_RUN)
    rows, steps, full, work, slip_time = _march(
        co,
        np.where(modes.omega > 0.0, modes.omega, 1e-300),
        np.ascontiguousarray(modes.load),
        G,
        np.ascontiguousarray(modes.normal_sig),
        np.abs(G),
        np.ascontiguousarray(quasi),
        modes.gap0,
        modes.stiffness,
        T,
        np.ascontiguousarray(modes.tangent_sig),
        modes.rubs,
        modes.side,
        np.ascontiguousarray(modes.mu),
        *(np.ascontiguousarray(x) for x in compliances),
        np.ascontiguousarray(signals),
        spacing,
        int(np.ceil(end / h)),
        h,
        modes.start[0].copy(),
        modes.start[1].copy(),
        max(1, int(kept / h)),
        table,
    )
    time, gap, impulse = (np.array(x) for x in np.split(table[:rows], [1, 1 + m], axis=1))
    half = 0.5 * np.diff(time[:, 0])
    weights = np.concatenate([[0.0], half]) + np.concatenate([half, [0.0]])
    return Course(time[:, 0], gap, impulse / weights[:, None], float(work), float(slip_time), int(steps), bool(full))


@numba.njit(cache=True, fastmath={"reassoc", "contract"})
def _dot(a, b):
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@numba.njit(cache=True)
def _signal(signals, spacing, t, out):
    j = min(int(t / spacing), signals.shape[1] - 2)
    share = t / spacing - j
    for s in range(out.size):
        out[s] = signals[s, j] + share * (signals[s, j + 1] - signals[s, j])


@numba.njit(cache=True)
def _press(g, awake, k, D, p):
    """Springs at the end of a step, by Gauss-Seidel: p_j = k_j max(0, -(g_j + sum D p))."""
    for _ in range(100):
        change, size = 0.0, 0.0
        for j in range(g.size):
            if awake[j]:
                at = g[j]
                for i in range(g.size):
                    if i != j and p[i] != 0.0:
                        at += D[j, i] * p[i]
                new = max(0.0, -k[j] * at / (1.0 + k[j] * D[j, j]))
                change = max(change, abs(new - p[j]))
                size = max(size, new)
                p[j] = new
        if change <= 1e-13 * size:
            break


@numba.njit(cache=True)
def _rub(w, limit, B, tau):
    """Friction that holds or slides at its limit: tau <- the disc's nearest to tau - slip / B, channel by channel."""
    for _ in range(300):
        change, size = 0.0, 0.0
        for r in range(limit.size):
            a = 2 * r
            if limit[r] <= 0.0:
                tau[a] = tau[a + 1] = 0.0
                continue
            u, v = w[a], w[a + 1]
            for i in range(tau.size):
                u += B[a, i] * tau[i]
                v += B[a + 1, i] * tau[i]
            by = max(B[a, a], B[a + 1, a + 1]) + abs(B[a, a + 1])
            x, y = tau[a] - u / by, tau[a + 1] - v / by
            long = np.sqrt(x * x + y * y)
            if long > limit[r]:
                x, y = x * limit[r] / long, y * limit[r] / long
            change = max(change, abs(x - tau[a]) + abs(y - tau[a + 1]))
            size = max(size, limit[r])
            tau[a], tau[a + 1] = x, y
        if change <= 1e-11 * size:
            break


@numba.njit(cache=True)
def _march(
    co,
    omega,
    load,
    G,
    G_sig,
    G_abs,
    quasi,
    gap0,
    k,
    T,
    T_sig,
    rubs,
    side,
    mu,
    D,
    E,
    Dv,
    B,
    signals,
    spacing,
    last,
    h,
    x,
    v,
    stride,
    table,
):
    n, m, f = omega.size, gap0.size, rubs.size
    n_sig = load.shape[1]
    x1, v1, swing = np.empty(n), np.empty(n), np.empty(n)
    f0, f1, fc = np.zeros(n), np.zeros(n), np.zeros(n)
    sig, sig1 = np.zeros(n_sig), np.zeros(n_sig)
    g, g1, p, p1 = np.empty(m), np.empty(m), np.zeros(m), np.zeros(m)
    tau, w, limit = np.zeros(2 * f), np.zeros(2 * f), np.zeros(f)
    slide, stuck = np.zeros(2 * f), np.zeros(f, dtype=np.bool_)
    awake = np.ones(m, dtype=np.bool_)
    _signal(signals, spacing, 0.0, sig)
    for i in range(n):
        f0[i] = _dot(load[i], sig)
    for j in range(m):
        g[j] = gap0[j] + _dot(G_sig[j], sig) + _dot(G[j], x)
        p[j] = max(0.0, -k[j] * g[j])
    pressing = False
    for j in range(m):
        if p[j] > 0.0:
            pressing = True
            for i in range(n):
                fc[i] += p[j] * G[j, i]
    n_side = 0 if m == 0 else side.max() + 1
    touching, before = np.zeros(n_side, dtype=np.bool_), np.zeros(n_side, dtype=np.bool_)
    open_row = np.zeros(n_side, dtype=np.bool_)
    held, whole, moment = np.empty(1 + m), np.zeros(m), np.zeros(m)
    holding, since, steps = False, 0, 0
    full, work, slip_time = False, 0.0, 0.0
    tick, look = 0, 0
    for j in range(m):
        touching[side[j]] = touching[side[j]] or p[j] > 0.0
    table[0] = 0.0
    table[0, 1 : 1 + m] = g
    rows = 1
    for s in range(n_side):
        open_row[s] = not touching[s]
    while tick < last:
        # --- how far may the step go, and which gaps can close in it
        level = 0
        if not pressing or look == 0:
            for i in range(n):
                swing[i] = np.sqrt(v[i] ** 2 + (omega[i] * x[i] - (f0[i] + fc[i]) / omega[i]) ** 2)
                if omega[i] < 1e-200:
                    swing[i] = abs(v[i]) + h * abs(f0[i] + fc[i]) * 1000.0
            ahead = min((tick + 1) * h, (signals.shape[1] - 1) * spacing)
            _signal(signals, spacing, ahead, sig1)
            safe = 1e300
            for j in range(m):
                if pressing and not awake[j]:
                    g[j] = gap0[j] + _dot(G_sig[j], sig) + _dot(G[j], x)
                fast = _dot(G_abs[j], swing)
                for s in range(n_sig):
                    fast += abs(quasi[j, s] * (sig1[s] - sig[s])) / h
                time = max(g[j], 0.0) / max(fast, 1e-300)
                awake[j] = p[j] > 0.0 or not pressing or time < 3.0 * WAKE * h
                safe = min(safe, 0.5 * time)
            look = WAKE
            if not pressing:
                while level + 1 < co.shape[0] and 2.0 ** (level + 1) * h <= safe and tick + 2 ** (level + 1) <= last:
                    level += 1
        look -= 1
        accepted = closes = False
        while not accepted:
            by = 2**level
            a = co[level]
            t1 = (tick + by) * h
            _signal(signals, spacing, min(t1, (signals.shape[1] - 1) * spacing), sig1)
            for i in range(n):
                f1[i] = _dot(load[i], sig1)
            for i in range(n):
                p0 = f0[i] + fc[i]
                x1[i] = a[0, i] * x[i] + a[1, i] * v[i] + a[4, i] * p0 + a[5, i] * f1[i]
                v1[i] = a[2, i] * x[i] + a[3, i] * v[i] + a[6, i] * p0 + a[7, i] * f1[i]
            closes = False
            for j in range(m):
                if awake[j]:
                    g1[j] = gap0[j] + _dot(G_sig[j], sig1) + _dot(G[j], x1)
                    closes = closes or g1[j] < 0.0
                else:
                    g1[j] = g[j]
            accepted = level == 0 or not closes
            if not accepted:
                level = max(0, level - 3)
        steps += 1

        # --- contact at the end of the step
        touched = pressing
        if pressing or closes:
            p1[:] = p
            for _ in range(1 if f == 0 else 4):
                if f > 0:
                    for j in range(m):
                        at = g1[j]
                        for r in range(2 * f):
                            at += E[j, r] * tau[r]
                        g[j] = at
                    _press(g, awake, k, D, p1)
                    for r in range(f):
                        j = rubs[r]
                        mean = 0.5 * (p[j] + p1[j])
                        speed = np.sqrt(slide[2 * r] ** 2 + slide[2 * r + 1] ** 2)
                        if stuck[r]:
                            c = mu[r, 0]
                        elif mu[r, 2] > 0.0:
                            c = mu[r, 1] + (mu[r, 0] - mu[r, 1]) * np.exp(-speed / mu[r, 2])
                        else:
                            c = mu[r, 1]
                        limit[r] = c * mean
                        if mean > 0.0:
                            for a2 in range(2 * r, 2 * r + 2):
                                w[a2] = _dot(T_sig[a2], sig1) + _dot(T[a2], v1)
                                for i in range(m):
                                    if p1[i] != 0.0:
                                        w[a2] += Dv[a2, i] * p1[i]
                    _rub(w, limit, B, tau)
                else:
                    _press(g1, awake, k, D, p1)
            for i in range(n):
                fc[i] = 0.0
            pressing = False
            for j in range(m):
                if p1[j] > 0.0:
                    pressing = True
                    for i in range(n):
                        fc[i] += p1[j] * G[j, i]
            if touched or pressing:
                for i in range(n):
                    x1[i] += a[5, i] * fc[i]
                    v1[i] += a[7, i] * fc[i]
            for r in range(f):
                if limit[r] > 0.0:
                    for a2 in range(2 * r, 2 * r + 2):
                        for i in range(n):
                            x1[i] += (a[4, i] + a[5, i]) * tau[a2] * T[a2, i]
                            v1[i] += (a[6, i] + a[7, i]) * tau[a2] * T[a2, i]
            for j in range(m):
                if awake[j]:
                    at = g1[j]
                    for i in range(m):
                        if p1[i] != 0.0:
                            at += D[j, i] * p1[i]
                    for r in range(2 * f):
                        at += E[j, r] * tau[r]
                    g1[j] = at
            for r in range(f):
                if limit[r] > 0.0:
                    stuck[r] = np.sqrt(tau[2 * r] ** 2 + tau[2 * r + 1] ** 2) < limit[r] * (1.0 - 1e-9)
                    for a2 in range(2 * r, 2 * r + 2):
                        fresh = 0.0 if stuck[r] else _dot(T_sig[a2], sig1) + _dot(T[a2], v1)
                        work -= 0.5 * h * tau[a2] * (slide[a2] + fresh)
                        slide[a2] = fresh
                    if not stuck[r]:
                        slip_time += h
                else:
                    stuck[r] = False
                    slide[2 * r] = slide[2 * r + 1] = 0.0
                    tau[2 * r] = tau[2 * r + 1] = 0.0
            if touched != pressing:
                look = 0
                for j in range(m):
                    awake[j] = True
        changed = False
        for q in range(n_side):
            before[q], touching[q] = touching[q], False
        for j in range(m):
            touching[side[j]] = touching[side[j]] or p1[j] > 0.0
        for q in range(n_side):
            changed = changed or before[q] != touching[q]
        for i in range(n):
            x[i], v[i], f0[i] = x1[i], v1[i], f1[i]
        for q in range(n_sig):
            sig[q] = sig1[q]
        tick += by

        # --- what is kept: both sides of every change, every stride-th step in contact, all flight steps
        if rows + 2 >= table.shape[0]:
            full = True
            break
        if (changed or not (pressing or touched)) and holding:
            rows = _keep(table, rows, held, whole, moment, side, open_row, before)
            since, holding = 0, False
        for j in range(m):
            if p[j] > 0.0 or p1[j] > 0.0:
                from_row = t1 - by * h - table[rows - 1, 0]
                whole[j] += 0.5 * h * (p[j] + p1[j])
                moment[j] += 0.5 * h * (p[j] + p1[j]) * from_row + h * h * (p[j] / 6.0 + p1[j] / 3.0)
            g[j], p[j] = g1[j], p1[j]
        p1[:] = 0.0
        since += 1
        held[0] = t1
        held[1:] = g
        holding = True
        if changed or not pressing or since >= stride:
            rows = _keep(table, rows, held, whole, moment, side, open_row, touching)
            since, holding = 0, False
    return rows, steps, full, work, slip_time


@numba.njit(cache=True)
def _keep(table, rows, held, whole, moment, side, open_row, touching):
    """A row of time, gaps and impulses: those since the row before go to both by their lever, or all to the one that
    is not open."""
    m = whole.size
    table[rows] = 0.0
    table[rows, : 1 + m] = held
    by = held[0] - table[rows - 1, 0]
    for j in range(m):
        here = moment[j] / by
        if open_row[side[j]]:
            here = whole[j]
        elif not touching[side[j]]:
            here = 0.0
        table[rows - 1, 1 + m + j] += whole[j] - here
        table[rows, 1 + m + j] += here
        whole[j], moment[j] = 0.0, 0.0
    for q in range(open_row.size):
        open_row[q] = not touching[q]
    return rows + 1
