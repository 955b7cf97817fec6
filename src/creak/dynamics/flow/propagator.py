"""Exact motion of single modes over a step under a load that is a cubic of time.

m u'' + c u' + k u = D0 + D1 t + D2 t^2/2 + D3 t^3/6. With s(t) the motion after a unit velocity at t = 0 and
S_r(h) = integral of s(t) (h - t)^(r-1) / (r-1)! over the step, S_0 = s(h), S_-1 = s'(h):

    u(h) = (S_-1 + c/m S_0) u + S_0 v + (S_1 D0 + S_2 D1 + S_3 D2 + S_4 D3) / m
    v(h) =         -k/m S_0 u + S_-1 v + (S_0 D0 + S_1 D1 + S_2 D2 + S_3 D3) / m

and the mean of u over the step, whose integral raises each index by one,

    mean u = ((S_0 + c/m S_1) u + S_1 v + (S_2 D0 + S_3 D1 + S_4 D2 + S_5 D3) / m) / h

Integrating the equation of s r times gives S_(r+1) = (h^r/r! - S_(r-1) - c/m S_r) m/k; for small omega h, where that
loses digits, S_r is the power series sum_j s_j h^(j+r) / (j+r)! with s_0 = 0, s_1 = 1, s_(j+2) = -(c s_(j+1) + k s_j)
over m. Slow modes with heavy damping have two real roots far apart, and S_r is the divided difference of
h^(r+1) phi_r(z) between them, z being a root times h.
Source: Duhamel's integral (Clough, Penzien, Dynamics of Structures, 1993, chapter 6). Exact for any h.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from creak.arrays import FloatArray

SLOW, HEAVY = 0.5, 1.5
"""omega h, and c h / m, below which S comes from its power series."""
TERMS = 24
"""Of power series: 1.5^24 / 24! is below round-off."""
UU, UV, VU, VV, Q0, MEAN = 0, 1, 2, 3, 4, 9
"""Rows of a propagator; S_r / m is row Q0 + r, the mean of u begins at row MEAN."""
SINGLE = 15
"""Rows of a propagator of single modes; one of pairs has 40."""


def propagator(m: FloatArray, c: FloatArray, k: FloatArray, h: float) -> FloatArray:
    """(15, n): u <- (u, v), v <- (u, v), then S_0 to S_4 over m; mean u <- (u, v, D0, D1, D2, D3).

    Coordinates without mass follow the load at once, u = D / k.
    """
    P = np.zeros((SINGLE, m.size))
    heavy = m > 0.0
    if heavy.any():
        P[:, heavy] = _heavy(m[heavy], c[heavy], k[heavy], h)
    light = ~heavy
    for r in range(1, 5):
        P[Q0 + r, light] = h ** (r - 1) / math.factorial(r - 1) / k[light]
        P[MEAN + 1 + r, light] = h ** (r - 1) / math.factorial(r) / k[light]
    return P


def _heavy(m: FloatArray, c: FloatArray, k: FloatArray, h: float) -> FloatArray:
    stiff, damp = k / m, c / m
    slow = h * np.sqrt(stiff) < SLOW
    weak, viscous, fast = slow & (h * damp < HEAVY), slow & (h * damp >= HEAVY), ~slow
    S = np.empty((7, m.size))
    for which, rule in ((weak, _by_series), (viscous, _by_roots), (fast, _in_closed_form)):
        S[:, which] = rule(damp[which], stiff[which], h)
    mean = np.concatenate([[S[1] + damp * S[2], S[2]], S[3:] / m]) / h
    return np.concatenate([[S[0] + damp * S[1], S[1], -stiff * S[1], S[0]], S[1:6] / m, mean])


def in_kicks(damp: FloatArray, stiff: FloatArray, h: float) -> tuple[FloatArray, FloatArray]:
    """Single modes of mass 1 in kicks h that do not change: u in their middle over that under the force 1, and v; (n,).

    Between kicks z = (u, v) moves by P; in the middle of each z = P (z + a) + a with half a kick, a = (0, h / 2):

        k u = h S_0 / d,   v = h (S_1 / d - 1/2),   d = (1 - S_-1) S_1 + S_0^2

    Without damping u is (omega h / 2) / tan(omega h / 2) of that at rest, and v is 0. Damping brings back what each
    kick throws up: then u is lower in the middle of a kick than in the mean, and v is up to h / 2.
    """
    P = propagator(np.ones(damp.size), damp, stiff, h)
    back = (1.0 - P[VV]) * P[Q0 + 1] + P[UV] * P[Q0]
    return np.asarray(h * P[UV] / back), np.asarray(h * (P[Q0 + 1] / back - 0.5))


def _by_series(damp: FloatArray, stiff: FloatArray, h: float) -> FloatArray:
    """(7, n) S_-1 to S_5."""
    S = np.zeros((7, damp.size))
    before, s = np.zeros_like(damp), np.ones_like(damp)
    for j in range(1, TERMS):
        for r in range(-1, 6):
            S[r + 1] += s * (h ** (j + r) / math.factorial(j + r))
        before, s = s, -(damp * s + stiff * before)
    return S


def _in_closed_form(damp: FloatArray, stiff: FloatArray, h: float) -> FloatArray:
    """(7, n) S_-1 to S_5 of under-, over- and critically damped modes."""
    delta = 0.5 * damp
    cosine, sine = damped_waves(delta, stiff, h)
    S = np.empty((7, damp.size))
    S[0], S[1] = cosine - delta * sine, sine
    for r in range(5):
        S[r + 2] = (h**r / math.factorial(r) - S[r] - damp * S[r + 1]) / stiff
    return S


def damped_waves(delta: FloatArray, omega2: FloatArray, h: float) -> tuple[FloatArray, FloatArray]:
    """Of u'' + 2 delta u' + omega^2 u = 0: exp(-delta h) times cos(w h) and sin(w h) / w, (n,) each.

    w^2 = omega^2 - delta^2 may have any sign, or be 0.
    """
    root = np.sqrt((omega2 - delta**2).astype(complex))
    still = np.abs(root) * h < 1e-8
    root = np.where(still, 1.0, root)
    grow, fall = np.exp((1j * root - delta) * h), np.exp((-1j * root - delta) * h)
    cosine = np.where(still, np.exp(-delta * h), (0.5 * (grow + fall)).real)
    sine = np.where(still, h * np.exp(-delta * h), (0.5 * (grow - fall) / (1j * root)).real)
    return cosine, sine


def _by_roots(damp: FloatArray, stiff: FloatArray, h: float) -> FloatArray:
    """(7, n) S_-1 to S_5 of modes that are damped so heavily that their stiffness hardly shows."""
    apart = np.sqrt((h * damp) ** 2 - 4.0 * h * h * stiff)
    steep = -0.5 * (h * damp + apart)
    flat = h * h * stiff / steep
    first, second = phi(flat, 6), phi(steep, 6)
    S = np.empty((7, damp.size))
    S[0] = (flat * first[0] - steep * second[0]) / apart
    for r in range(6):
        S[r + 1] = h ** (r + 1) * (first[r] - second[r]) / apart
    return S


def phi(z: Any, count: int) -> list[Any]:
    """phi_0 = e^z, phi_(r+1) = (phi_r - 1 / r!) / z: `count` of them, of z (n,), real or complex."""
    small = np.abs(z) < 1.0
    far, near = np.where(small, 1.0, z), np.where(small, z, 0.0)
    found, by_rule = [], np.exp(z)
    for r in range(count):
        series = sum(near**j / float(math.factorial(j + r)) for j in range(TERMS))
        found.append(np.where(small, series, by_rule))
        by_rule = (by_rule - 1.0 / math.factorial(r)) / far
    return found
