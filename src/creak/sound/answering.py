"""What a structure answers to forces in the Laplace domain, mode by mode or, where damping couples them, pair by pair.

With forces F(s), their rows X and rows R that see the motion, R q(s) = R H(s) X' F(s),

    H(s) = diag(1 / (m s^2 + c s + k)),   or   H(s) = basis (s - B)^-1 push

of pairs of complex modes z' = B z + push f, whose blocks B are 2 x 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.arrays import BoolArray, FloatArray

Terms = list[tuple[int, FloatArray]]
"""Powers of s and what stands behind them."""


@dataclass(frozen=True)
class Modes:
    """Diagonal m, c, k (n_mode,) of a structure and the work of unit forces on its modes."""

    m: FloatArray
    c: FloatArray
    k: FloatArray
    push: FloatArray
    """(n_force, n_mode)"""

    @property
    def shape(self) -> tuple[int, int]:
        """Forces, and coordinates of the rows that see them."""
        return self.push.shape[0], self.m.size

    @property
    def omega(self) -> FloatArray:
        """(n_mode,) rad/s"""
        return np.asarray(np.sqrt(self.k / self.m))

    @property
    def decay(self) -> FloatArray:
        """(n_mode,) 1/s"""
        return np.asarray(0.5 * self.c / self.m)

    def seen(self, rows: FloatArray) -> FloatArray:
        """(k, width) of what answers, by rows (k, n_mode)."""
        return rows

    def select(self, which: BoolArray, seen: FloatArray) -> tuple[Modes, FloatArray]:
        """Some of the modes, and their part of what is seen."""
        return Modes(self.m[which], self.c[which], self.k[which], self.push[:, which]), seen[:, which]

    def beside(self, push: FloatArray) -> Modes:
        """With more coordinates behind them, of mass 1 and held by nothing, that are pushed by (n_force, k)."""
        one, none = np.ones(push.shape[1]), np.zeros(push.shape[1])
        m, c, k = (np.append(own, more) for own, more in ((self.m, one), (self.c, none), (self.k, none)))
        return Modes(m, c, k, np.hstack([self.push, push]))

    def answer(self, x: Any, s: Any) -> Any:
        """x (k, width) times H(s), s (k, 1)."""
        return x / ((self.m * s + self.c) * s + self.k)

    def answered(self, x: Any, s: Any) -> Any:
        """H(s) times x."""
        return self.answer(x, s)

    def series(self, seen: FloatArray) -> Terms:
        """Rows (k, n_force) of R H(s) X' for modes far above: 1 / (k + c s + m s^2) is 1 / k - c s / k^2 - m s^2 / k^2
        within (f / f_m)^4."""
        weights = enumerate((1.0 / self.k, -self.c / self.k**2, -self.m / self.k**2))
        return [(power, seen @ (self.push * w).T) for power, w in weights if w.any()]


@dataclass(frozen=True)
class CoupledModes:
    """The same of n pairs of complex modes; the rows that see them are on q (n_mode,) = basis z."""

    blocks: FloatArray
    """(4, n) B as (00, 01, 10, 11)."""
    basis: FloatArray
    """(n_mode, 2 n)"""
    push: FloatArray
    """(n_force, 2 n)"""

    @property
    def shape(self) -> tuple[int, int]:
        """As of `Modes`."""
        return self.push.shape[0], self.basis.shape[0]

    @property
    def omega(self) -> FloatArray:
        """(n,) rad/s; of two real eigenvalues the smaller."""
        half, product = self._halves()
        apart = half**2 - product
        slower = np.abs(half) - np.sqrt(np.maximum(apart, 0.0))
        return np.asarray(np.where(apart > 0.0, slower, np.sqrt(np.abs(product))))

    @property
    def decay(self) -> FloatArray:
        """(n,) 1/s; of two real eigenvalues the smaller."""
        half, product = self._halves()
        return np.asarray(-half - np.sqrt(np.maximum(half**2 - product, 0.0)))

    def _halves(self) -> tuple[FloatArray, FloatArray]:
        a, b, c, d = self.blocks
        return 0.5 * (a + d), a * d - b * c

    def seen(self, rows: FloatArray) -> FloatArray:
        """(k, 2 n)"""
        return np.asarray(rows @ self.basis)

    def select(self, which: BoolArray, seen: FloatArray) -> tuple[CoupledModes, FloatArray]:
        """As of `Modes`, `which` (n,)."""
        both = np.concatenate([which, which])
        return CoupledModes(self.blocks[:, which], self.basis[:, both], self.push[:, both]), seen[:, both]

    def beside(self, push: FloatArray) -> CoupledModes:
        """As of `Modes`."""
        n, count = self.basis.shape[0], push.shape[1]
        basis = np.zeros((n + count, 2, n + count))
        basis[:n, :, :n], basis[n:, 0, n:] = self.basis.reshape(n, 2, n), np.eye(count)
        both = np.zeros((push.shape[0], 2, n + count))
        both[:, :, :n], both[:, 1, n:] = self.push.reshape(-1, 2, n), push
        drifts = np.tile([[0.0], [1.0], [0.0], [0.0]], count)
        width = 2 * (n + count)
        return CoupledModes(np.hstack([self.blocks, drifts]), basis.reshape(-1, width), both.reshape(-1, width))

    def answer(self, x: Any, s: Any) -> Any:
        """As of `Modes`."""
        a, b, c, d = self.blocks
        return _times(x, (s - d, b, c, s - a)) / np.tile((s - a) * (s - d) - b * c, 2)

    def answered(self, x: Any, s: Any) -> Any:
        """As of `Modes`."""
        a, b, c, d = self.blocks
        return _times(x, (s - d, c, b, s - a)) / np.tile((s - a) * (s - d) - b * c, 2)

    def series(self, seen: FloatArray) -> Terms:
        """As of `Modes`: (s - B)^-1 is -B^-1 - B^-2 s - B^-3 s^2."""
        a, b, c, d = self.blocks
        rests = np.stack([-d, b, c, -a]) / (a * d - b * c)
        out, x = [], seen
        for power in range(3):
            x = _times(x, tuple(rests)) if power == 0 else -_times(x, tuple(rests))
            out.append((power, np.asarray(x @ self.push.T)))
        return out


Answering = Modes | CoupledModes


def transfer(modes: Answering, rows: FloatArray, s: float) -> FloatArray:
    """(k, n_force) R H(s) X' at a real s, rows (k, n_mode)."""
    return np.asarray(modes.answer(modes.seen(rows), s) @ modes.push.T)


def _times(x: Any, blocks: tuple[Any, Any, Any, Any]) -> Any:
    """Rows x (k, 2 n) times a 2 x 2 block of each pair."""
    first, second = np.hsplit(x, 2)
    a, b, c, d = blocks
    return np.hstack([first * a + second * c, first * b + second * d])
