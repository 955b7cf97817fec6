"""Bounded least squares, and what of it can be believed: uncertainty, what is not determined, what is over-fitted."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray

Z95 = 1.959963984540054
"""Half the width of the interval that holds 95 % of a normal distribution, in standard deviations."""
NEAR = 1e-3
"""Share of the way between its bounds within which a parameter has stopped at one."""
NOTHING = 1e-12
"""Share of the largest singular value that is round-off."""
LARGE = 0.3
"""Share in a direction from which a parameter is named with it."""
ALONE = 0.999
"""Leverage of a residual that a parameter depends on alone."""
INSIDE = 1e-9
"""Share of the way between its bounds by which a start lies inside."""
TRIALS = 40
TOLERANCES = {"xtol": 1e-6, "ftol": 1e-8, "gtol": 1e-8}

Function = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class Fit:
    """Parameters x that make sum r^2 least between bounds, and the linear statistics there."""

    x: FloatArray
    """(n,)"""
    residuals: FloatArray
    """(m,) in standard deviations of the data."""
    jacobian: FloatArray
    """(m, n)"""
    on_bound: BoolArray
    """(n,) stopped at a bound: where it would go is not known, and the others hold for it there."""

    @property
    def spare(self) -> int:
        """Data beyond those that the parameters take."""
        return self.residuals.size - int((~self.on_bound).sum())

    @property
    def found(self) -> float:
        """Standard deviation of the residuals, sqrt(r'r / (m - n)); 0 where no datum is to spare."""
        return math.sqrt(float(self.residuals @ self.residuals) / self.spare) if self.spare > 0 else 0.0

    @property
    def scatter(self) -> float:
        """The larger of what was stated, 1, and what was found."""
        return max(1.0, self.found)

    @property
    def wide(self) -> float:
        """Half the width of 95 % in stated standard deviations: the larger of the normal distribution's with what was
        stated and of Student's t with what was found, which few data know badly (Draper and Smith, 1998, 1.4)."""
        from scipy.special import stdtrit  # see `signals.spectra.low_pass`

        return max(Z95, float(stdtrit(self.spare, 0.975)) * self.found) if self.spare > 0 else Z95

    @cached_property
    def _svd(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        U, s, Vt = np.linalg.svd(self.jacobian[:, ~self.on_bound], full_matrices=False)
        return U, np.maximum(s, NOTHING * s.max(initial=1e-300)), Vt

    @property
    def covariance(self) -> FloatArray:
        """(n, n) scatter^2 (J'J)^-1; nan for parameters at a bound."""
        _, s, Vt = self._svd
        full, free = np.full((self.x.size, self.x.size), np.nan), np.flatnonzero(~self.on_bound)
        full[np.ix_(free, free)] = self.scatter**2 * (Vt.T / s**2) @ Vt
        return full

    @property
    def half_width(self) -> FloatArray:
        """(n,) half of the 95 % interval of each parameter; nan at a bound."""
        return np.asarray(self.wide / self.scatter * np.sqrt(np.diag(self.covariance)))

    @property
    def correlation(self) -> FloatArray:
        """(n, n) of the parameters, -1 to 1; nan at a bound."""
        covariance = self.covariance
        deviation = np.sqrt(np.diag(covariance))
        return np.asarray(covariance / np.outer(deviation, deviation))

    def undetermined(self, width: float) -> list[IntArray]:
        """Parameters of each direction whose 95 % interval is wider than +-width: alone, or only together known.

        The directions are right singular vectors of J, with parameters at a bound: it may be why they are there.
        """
        _, s, Vt = np.linalg.svd(self.jacobian, full_matrices=False)
        wide = self.wide > width * s
        return [np.flatnonzero(np.abs(v) >= LARGE) for v in Vt[wide]]

    @property
    def foretold(self) -> FloatArray:
        """(m,) residual of each datum when the others alone are fitted, r / (1 - h), to first order.

        h is the diagonal of J (J'J)^-1 J'; nan where a parameter depends on that datum alone.
        """
        leverage = (self._svd[0] ** 2).sum(axis=1)
        known = leverage < ALONE
        return np.divide(self.residuals, 1.0 - leverage, out=np.full(leverage.shape, np.nan), where=known)


def bounded_fit(residuals: Function, jacobian: Function, start: FloatArray, low: FloatArray, high: FloatArray) -> Fit:
    """Least squares between bounds (trust region reflective; Branch, Coleman, Li, SIAM J. Sci. Comput. 21, 1999).

    Parameters
    ----------
    residuals : x (n,) -> (m,) in standard deviations of the data. jacobian : x -> (m, n), asked for where residuals
        were asked for last. start, low, high : (n,); a start at a bound begins just inside.
    """
    from scipy.optimize import least_squares  # see `signals.spectra.low_pass`

    margin = INSIDE * (high - low)
    begin = np.clip(start, low + margin, high - margin)
    found = least_squares(residuals, begin, jac=jacobian, bounds=(low, high), max_nfev=TRIALS, **TOLERANCES)
    x = np.asarray(found.x)
    on_bound = np.minimum(x - low, high - x) <= NEAR * (high - low)
    return Fit(x, residuals(x), jacobian(x), on_bound)
