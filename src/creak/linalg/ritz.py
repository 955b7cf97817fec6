"""Ritz values of a growing Krylov space: which of them are the lowest modes, and whether they have converged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sla

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.linalg.threads import one_blas_thread

TOLERANCE = 1e-9
"""Lanczos residual relative to the eigenvalue; the eigenvalue's own error is of its square."""
FINITE = 1e-13
"""Smaller eigenvalues, relative to the largest, are those of massless motion (infinite frequency)."""
LOW = 1e-3
"""Modes far below the shift have nearly the same theta; their residual has to be smaller, down to this share."""


@dataclass(frozen=True)
class Sought:
    """Which eigenvalues of A are the lowest modes, and whether they have converged."""

    shift: float
    below: int
    """Modes below the shift, without those that are left out."""
    within: int
    """Eigenvalues that are known to be smaller than `upper`."""
    values: int
    lower: float
    upper: float

    def select(self, theta: FloatArray, error: FloatArray, exhausted: bool) -> tuple[IntArray, int]:
        """Positions of the lowest modes in the order of lam, and how many of `values` have not converged.

        Those with theta < 0 lie below the shift; those above it come with falling theta > 0. Eigenvalues that
        are nothing beside the largest are those of massless motion (infinite frequency).
        """
        finite, away = _inverse(theta)
        good = finite & (self.converged(theta, error) | exhausted)
        under, over = (np.flatnonzero(p) for p in (finite & (theta < 0.0), finite & (theta > 0.0)))
        under = under[np.argsort(away[under])]
        under = under[max(under.size - self.below, 0) :]
        over = over[np.argsort(away[over])][: self.values - self.below]
        order = np.concatenate([under, over])
        missing = self.values - int(np.count_nonzero(good[order]))
        first, last = np.inf, -np.inf
        if 0 < self.within <= order.size:
            first, last = self.shift + away[order[[0, self.within - 1]]]
        return order, max(missing, int(first <= self.lower), int(last >= self.upper))

    def converged(self, theta: FloatArray, error: FloatArray) -> BoolArray:
        """Which of the finite eigenvalues are as good as they have to be."""
        size, (_, away) = np.abs(theta), _inverse(theta)
        return np.asarray(error <= TOLERANCE * size * np.clip(np.abs(self.shift + away) * size, LOW, 1.0))


def _inverse(theta: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Which eigenvalues are something beside the largest, and 1 / theta of those; 0 of others."""
    finite = np.abs(theta) > FINITE * np.abs(theta).max(initial=0.0)
    return finite, np.divide(1.0, theta, out=np.zeros_like(theta), where=finite)


class Projection:
    """A in the Krylov space, T = Q' M A Q, block tridiagonal, and its eigenvalues, looked at again and again.

    Most have converged at the first look. Further blocks are coupled to them by their residuals alone, which are
    nothing: until all seem to have converged, T is looked at in the Ritz vectors of the look before without those.
    """

    def __init__(self, sought: Sought) -> None:
        self._sought = sought
        self._T, self._few = np.zeros((0, 0)), np.zeros((0, 0))
        self._last: FloatArray | None = None
        self._done: tuple[FloatArray, FloatArray] | None = None
        self.theta, self.vectors, self.order = np.zeros(0), np.zeros((0, 0)), np.zeros(0, dtype=np.int64)

    def border(self, back: FloatArray, alpha: FloatArray) -> float:
        """One more block, which `back` (previous, new) couples to the last one; the largest entry until now."""
        scale = float(np.abs(self._T).max(initial=np.abs(alpha).max()))
        self._T = _bordered(self._T, back, alpha)
        if self._last is not None:  # all Ritz vectors of the last look reach into the block before
            back, self._last = self._last.T @ back, None
        if self._done is not None:
            self._few = _bordered(self._few, back, alpha)
        self._width = alpha.shape[0]
        return scale

    def missing(self, R: FloatArray, exhausted: bool) -> int:
        """How many eigenvalues have not converged, R the coupling to the next block."""
        if self._done is not None and not exhausted and (missing := self._look(self._few, R, *self._done)):
            return missing
        nothing = np.zeros(0)
        return self._look(self._T, R, nothing, nothing, exhausted)

    def _look(
        self, T: FloatArray, R: FloatArray, known: FloatArray, errors: FloatArray, exhausted: bool = False
    ) -> int:
        """The same by T and by `known` eigenvalues, with their `errors`, that are not in it."""
        self.theta, self.vectors = theta, S = _eigen(T)
        last = S[-self._width :]
        error = np.linalg.norm(R @ last, axis=0)
        both = np.concatenate([known, theta]), np.concatenate([errors, error])
        self.order, missing = self._sought.select(*both, exhausted)
        done = self._sought.converged(theta, error)
        self._done = np.concatenate([known, theta[done]]), np.concatenate([errors, error[done]])
        self._few, self._last = np.diag(theta[~done]), last[:, ~done]
        return missing


def _bordered(T: FloatArray, back: FloatArray, alpha: FloatArray) -> FloatArray:
    """T with one more diagonal block; `back` (previous, new) couples it to the last one."""
    old, new = T.shape[0], alpha.shape[0]
    bigger = np.zeros((old + new, old + new))
    bigger[:old, :old] = T
    bigger[old - back.shape[0] : old, old:] = back
    bigger[old:, old - back.shape[0] : old] = back.T
    bigger[old:, old:] = alpha
    return bigger


def _eigen(T: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eigenvalues and vectors of T."""
    with one_blas_thread():  # its tridiagonalisation is bound by memory, and the solver's threads are still awake
        return sla.eigh(T, driver="evd")
