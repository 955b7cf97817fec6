"""How far gaps close between the ends of flight steps without contact: steps are halved where a mode is too fast.

In a step h a gap lies above the cubic through its values and rates at both ends less `bound_of`. Where that leaves room
for more than `CLOSE` of what the gap closes besides, the step is flown in two halves. All in NumPy, many steps at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.dynamics.flow.model import FlowForm, FlowModel
from creak.dynamics.flow.propagator import Q0, SINGLE, UU, UV, VU, VV
from creak.dynamics.flow.resolution import bands, bound_of

CLOSE = 0.02
"""Of what a gap closes: so exactly its lowest value is found. Nobody asks for more of a gap that stays open."""
LITTLE = 0.1
"""Of a gap, that counts as closed at least: what closes less comes near nothing."""
DEEPEST = 12
"""Most halvings of a flight step."""
AT_ONCE = 1_000
"""Steps."""


@dataclass(frozen=True)
class Pieces:
    """Steps or parts of steps: what there is at their beginning, values and derivatives."""

    z: FloatArray
    """(k, 2 n) both members of the pairs"""
    D: FloatArray
    """(k, 4, p) load on them, a cubic"""
    s: FloatArray
    """(k, 6, n_support) supports, a quintic"""

    def some(self, which: BoolArray | slice) -> Pieces:
        return Pieces(self.z[which], self.D[which], self.s[which])


class Lowest:
    """Keeps the lowest value of each gap of a run without contact."""

    def __init__(self, form: FlowForm, gap0: FloatArray, lowest: FloatArray) -> None:
        self._form, self._gap0, self.found = form, gap0, lowest.copy()
        self._band, self._count = bands(form.omega)
        self._far = form.ways(form.rows[: gap0.size])

    def look(self, steps: Pieces, h: float, level: int = 0) -> None:
        """At steps h long, and at halves of those that need it."""
        form, model, m = self._form, self._form.model, self._gap0.size
        if not len(steps.z):
            return
        end = Pieces(flown(form.flow(h), steps.z, steps.D), later(steps.D, h), later(steps.s, h))
        (g0, d0), (g1, d1) = (self._seen(p, h) for p in (steps, end))
        self.found = np.minimum(self.found, np.minimum(g0, g1).min(axis=0))
        room = CLOSE * np.maximum(self._gap0 - self.found, LITTLE * np.abs(self._gap0))
        off = energies(form, self._band, self._count, steps) @ bound_of(form, self._band, self._count, h, self._far)
        bends = np.abs(steps.s[:, 4]) + h * np.abs(steps.s[:, 5])
        off += h**4 / 384.0 * bends @ np.abs(model.rows_s[:m]).T
        low = np.minimum(g0, g1) - 4.0 / 27.0 * (np.maximum(-d0, 0.0) + np.maximum(d1, 0.0)) - off
        split: BoolArray = np.any(low < self.found - room, axis=1)
        if level == DEEPEST or not split.any():
            return
        steps, half = steps.some(split), 0.5 * h
        P = form.flow(half)
        for first in range(0, len(steps.z), AT_ONCE):
            a = steps.some(slice(first, first + AT_ONCE))
            b = Pieces(flown(P, a.z, a.D), later(a.D, half), later(a.s, half))
            self.look(Pieces(*(np.concatenate(x) for x in ((a.z, b.z), (a.D, b.D), (a.s, b.s)))), half, level + 1)

    def _seen(self, at: Pieces, h: float) -> tuple[FloatArray, FloatArray]:
        """(k, m) gaps and h times their rates."""
        model, m = self._form.model, self._gap0.size
        gap = at.z[:, model.u0 : model.u1] @ model.rows[:m].T + at.s[:, 0] @ model.rows_s[:m].T + self._gap0
        return gap, h * (at.z[:, model.v0 : model.v1] @ model.rates[:m].T + at.s[:, 1] @ model.rates_s[:m].T)


def later(x: FloatArray, h: float) -> FloatArray:
    """Polynomials (k, r, p), values and derivatives, h later."""
    r = x.shape[1]
    by = np.array([[h ** (i - j) / math.factorial(i - j) if i >= j else 0.0 for i in range(r)] for j in range(r)])
    return np.asarray(np.einsum("ji,kip->kjp", by, x))


def flown(P: FloatArray, z: FloatArray, D: FloatArray) -> FloatArray:
    """(k, 2 n) pairs at the end of steps."""
    a, b = np.hsplit(z, 2)
    to_a, to_b = driven(P, D, a.shape[1])
    return np.hstack([P[UU] * a + P[UV] * b + to_a, P[VU] * a + P[VV] * b + to_b])


def driven(P: FloatArray, D: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """(k, n) what the loads add to both members of each pair over a step; both of pairs are loaded."""
    if P.shape[0] == SINGLE:
        return _times(D, P[Q0 + 1 : Q0 + 5]), _times(D, P[Q0 : Q0 + 4])
    by, own, other = P[4:20].reshape(4, 4, n), D[:, :, :n], D[:, :, n:]
    return _times(own, by[:, 0]) + _times(other, by[:, 1]), _times(own, by[:, 2]) + _times(other, by[:, 3])


def _times(D: FloatArray, by: FloatArray) -> FloatArray:
    """(k, n) sum over the four coefficients."""
    return np.asarray(np.einsum("krn,rn->kn", D, by))


def energies(form: FlowForm, band: IntArray, count: int, at: Pieces) -> FloatArray:
    """(k, n_band) sqrt(2 E) of the motion about the cubics that loads make pairs follow (`motion.band_energies`)."""
    a, b = np.hsplit(at.z, 2)
    free = _free(form.model, a, b, at.D.transpose(1, 0, 2))
    return np.stack([np.sqrt(free[:, band == b].sum(axis=1)) for b in range(count)], axis=1)


def _free(model: FlowModel, a: FloatArray, b: FloatArray, D: FloatArray) -> FloatArray:
    """(k, n) twice the energy of the pairs."""
    if not model.still.shape[0]:
        moves = (model.k > 0.0) & (model.m > 0.0)
        m, c, k = (np.where(moves, x, 1.0) for x in (model.m, model.c, model.k))
        p3 = D[3] / k
        p2 = (D[2] - c * p3) / k
        p1 = (D[1] - c * p2 - m * p3) / k
        return np.asarray(np.where(moves, m * (b - p1) ** 2 + k * (a - (D[0] - c * p1 - m * p2) / k) ** 2, 0.0))
    R, n = model.still, a.shape[1]
    p, q = np.zeros_like(a), np.zeros_like(b)
    for r in range(3, -1, -1):
        da, db = D[r, :, :n] - p, D[r, :, n:] - q
        p, q = R[0] * da + R[1] * db, R[2] * da + R[3] * db
    return np.asarray((a - p) ** 2 + (b - q) ** 2)
