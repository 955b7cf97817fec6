"""Free modes of a part: the superelement's against the full part's, and how far each is off, by an a-posteriori
estimate and a bound that always holds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.errors import NumericalError
from creak.linalg.memory import blocks_that_fit
from creak.linalg.modes import modes
from creak.progress import Progress
from creak.reduction.health.rigid import floats, motion
from creak.reduction.inside import Inside

BLOCK, FEWEST, COPIES = 32, 4, 11
"""Modes checked at a time; where memory is short: at least, and copies of their motion that are there at a time."""
SUBSPACE_ITERATIONS = 6


def blocks(n: int, rows: int) -> Iterator[slice]:
    """Slices of BLOCK modes of so many rows, or of fewer where memory is short."""
    return blocks_that_fit(n, rows, COPIES, BLOCK, FEWEST)


def residual_energy(full: System, reduced: System, inside: Inside, q: FloatArray, omega2: FloatArray) -> FloatArray:
    """(2, k) r'y and y' M_ii y with y = K_ii^-1 r, r the inner residual of reduced modes; for `error_of`.

    Parameters
    ----------
    q : (n, k) this part's coordinates in the modes of the whole model, which are mass-normalised: q' M q = 1 over
        the whole. omega2 : (k,) their eigenvalues, rad^2/s^2.

    Cost: a back-substitution and a recovery per mode.
    """
    u = motion(full, reduced, q)
    u_i, u_b = u[inside.i], u[inside.b]
    r = inside.stiffness(u_i) + inside.K_ib @ u_b - (inside.mass(u_i) + inside.M_ib @ u_b) * omega2
    y = inside.solve(r)
    return np.array([np.einsum("ij,ij->j", r, y), np.einsum("ij,ij->j", y, inside.mass(y))])


def error_of(energy: FloatArray, omega2: FloatArray, cut: float) -> FloatArray:
    """Relative frequency error of reduced modes that a part's missing fixed-interface modes cause.

    The modes that were left out (l) couple to the kept coordinates only by the mass: condensing them exactly gives
    eta_l = lambda a_l / (lambda_l - lambda), a_l = phi_l' (M_ib + M_ii Psi) u_b, and the eigenvalue falls by

        lambda^2 sum_l a_l^2 / (lambda_l - lambda)   (u' M u = 1).

    The sum needs no missing mode: the inner residual of u = V q is r = [(K - lambda M) u]_i = -lambda M_ii sum_l
    phi_l a_l. With y = K_ii^-1 r, r'y = lambda^2 sum a_l^2 / lambda_l and y' M_ii y = lambda^2 sum a_l^2 / lambda_l^2,
    hence

        relative error of lambda <= [r'y + y' M_ii y lambda / (1 - lambda / lambda_cut)] / lambda,

    with lambda_cut the first eigenvalue left out; the frequency's is half of it. To first order this is an upper
    bound, and the errors of all parts of an assembly add up. It grows too large where lambda nears lambda_cut, and it
    does not see what a reduced boundary (interface modes) costs. An error belongs to its mode: close modes may change
    places, so compare with the unreduced model mode by mode (MAC), not by number.

    Parameters
    ----------
    energy : (2, k) `residual_energy` of the modes. omega2 : (k,) their eigenvalues. cut : lambda_cut.

    Returns
    -------
    (k,) contribution of this part to (f_reduced - f) / f; 0 for rigid motion, infinite from lambda_cut on.

    Sources: Jakobsson, Bengzon, Larson, Int. J. Numer. Meth. Engng 86 (2011); Kim, Lee, Lee, Comput. Struct. 139
    (2014) and Boo, Kim, Lee, Comput. Struct. 164 (2016) for substructure contributions.
    """
    out = np.where(omega2 >= cut, np.inf, 0.0)
    fit = (omega2 > 0.0) & (omega2 < cut)
    lam, (stiff, heavy) = omega2[fit], energy[:, fit]
    out[fit] = 0.5 * (stiff + heavy * lam / (1.0 - lam / cut)) / lam
    return np.maximum(out, 0.0)


def error_bound(frequency: FloatArray, cut: float) -> FloatArray:
    """Bound on (f_reduced - f) / f that holds for every mode of any model: sqrt(1 + (f_reduced / f_cut)^2) - 1.

    For lambda < lambda_cut the condensed stiffness of the kept coordinates satisfies K - lambda M - lambda^2 sum_l
    a_l a_l' / (lambda_l - lambda) >= K - M lambda lambda_cut / (lambda_cut - lambda), since sum_l a_l a_l' <= M (M
    is positive with the missing modes, too). Counting negative eigenvalues (Sylvester) gives for the k-th mode
    1 / lambda_k <= 1 / lambda_k,reduced + 1 / lambda_cut. In an assembly lambda_cut is the lowest of all parts.

    Parameters
    ----------
    frequency : (k,) frequencies of the reduced model; cut : first fixed-interface frequency left out, same unit.
    """
    return np.sqrt(1.0 + (frequency / cut) ** 2) - 1.0


def first_left_out(reduced: System, inside: Inside) -> float:
    """First fixed-interface eigenvalue that was left out, (rad/s)^2; infinite where nothing is missing.

    As stated by the reduction. Where it states none: the last kept one, a lower bound; for Guyan, which keeps none,
    inverse iteration (a Ritz value, high by less than a per cent or so).
    """
    stated = reduced.stats.first_left_out
    if np.isfinite(stated):
        return float((2.0 * np.pi * stated) ** 2)
    count = reduced.stats.modes
    if count >= inside.i.size:
        return float(np.inf)
    if count == 0:
        return _lowest(inside)
    kept = slice(reduced.stats.retained, None)
    return float((reduced.K.diagonal()[kept] / reduced.M.diagonal()[kept]).max())


def _lowest(inside: Inside) -> float:
    """Lowest eigenvalue of (K_ii, M_ii) by subspace iteration; infinite where the inside has no mass."""
    x = np.random.default_rng(11).standard_normal((inside.i.size, min(BLOCK, inside.i.size)))
    x, lowest = inside.solve(x), np.inf
    for _ in range(SUBSPACE_ITERATIONS):
        f = inside.mass(x)
        stiffness, mass = x.T @ inside.stiffness(x), x.T @ f
        mu, turn = sla.eigh(mass, stiffness)
        if mu[-1] <= 0.0:
            return float(np.inf)
        lowest, x = float(1.0 / mu[-1]), inside.solve(f @ turn)
    return lowest


GOOD, VERY_GOOD = 1e-2, 1e-3
"""Relative frequency errors up to which a superelement counts as good and as very good."""
RIGID_MODES = 6
RIGID_FREQUENCY = 1e-3
"""Modes of a free part below this share of its 7th frequency are its rigid motions."""
MOST_CHECKED = 200
"""Free modes whose error is estimated at most."""


@dataclass(frozen=True)
class FreeModes:
    """Elastic modes of the part on its own, free in space."""

    full: tuple[float, ...]
    """Lowest of the full part, Hz; empty where they were not asked for."""
    reduced: tuple[float, ...]
    """Of the superelement, Hz; those whose error was estimated."""
    error: tuple[float, ...]
    """(f_reduced - f_full) / f_full, measured; as long as `full`."""
    estimate: tuple[float, ...]
    """Estimated error, as long as `reduced`."""
    rigid_full: int
    """Modes without stiffness (the softest elastic ones of a long thin part count as such where round-off hides
    them); -1 where the full part was not asked."""
    rigid_reduced: int
    usable: float
    """Hz up to which the estimated error stays below 1 %; infinite where nothing is left out."""
    usable_tight: float
    """Hz up to which it stays below 0.1 %."""
    at_least: bool
    """Not all modes up to there were checked: `usable` may be higher still."""
    definite: bool
    """The reduced matrices have modes: M is positive, K + s M too. All else is 0 or empty where they have none."""


def free_modes(
    full: System, reduced: System, inside: Inside, count: int, own_modes: bool, progress: Progress | None
) -> tuple[FreeModes, float]:
    """Free modes with their errors, and the first fixed-interface eigenvalue left out, (rad/s)^2."""
    wanted = min(reduced.n, RIGID_MODES + MOST_CHECKED)
    try:
        small = modes(reduced.K, reduced.M, count=wanted, free=True)
    except NumericalError:
        return FreeModes(
            full=(),
            reduced=(),
            error=(),
            estimate=(),
            rigid_full=-1,
            rigid_reduced=0,
            usable=0.0,
            usable_tight=0.0,
            at_least=False,
            definite=False,
        ), first_left_out(reduced, inside)
    rigid = _rigid_count(small.omega2)
    omega2 = small.omega2[rigid:]
    error, cut = _estimates(full, reduced, inside, small.shapes[:, rigid:], omega2, count, progress)
    more = small.omega2.size == wanted < reduced.n
    f = hertz(omega2)
    exact, rigid_full = _own_modes(full, count, rigid, progress) if own_modes else (np.zeros(0), -1)
    same = hertz(small.omega2[max(rigid_full, 0) :])[: exact.size]
    exact = exact[: same.size]
    return FreeModes(
        full=floats(exact),
        reduced=floats(f[: error.size]),
        error=floats(same / exact - 1.0),
        estimate=floats(error),
        rigid_full=rigid_full,
        rigid_reduced=rigid,
        usable=_usable(f, error, GOOD, cut, more),
        usable_tight=_usable(f, error, VERY_GOOD, cut, more),
        at_least=more and bool((error <= GOOD).all()),
        definite=True,
    ), cut


def hertz(omega2: FloatArray) -> FloatArray:
    """Frequencies of eigenvalues."""
    return np.sqrt(np.maximum(omega2, 0.0)) / (2.0 * np.pi)


def _own_modes(full: System, count: int, rigid: int, progress: Progress | None) -> tuple[FloatArray, int]:
    """Elastic frequencies of the full part, Hz, and how many modes are rigid.

    Parameters
    ----------
    rigid : how many of the superelement are: a part of several loose pieces has more than `RIGID_MODES`.
    """
    stage = None if progress is None else lambda done, total: progress("free modes of the full part", done, total)
    # A dof of a shared reference node may have neither stiffness nor mass in this part.
    used = np.flatnonzero(np.diff(sp.csr_matrix(full.K).indptr) + np.diff(sp.csr_matrix(full.M).indptr))
    K, M = (sp.csr_matrix(A)[used][:, used] for A in (full.K, full.M))
    wanted = min(used.size, max(RIGID_MODES, rigid) + count)
    omega2 = modes(K, M, count=wanted, free=True, sturm=False, progress=stage).omega2
    own = _rigid_count(omega2)
    return hertz(omega2[own:])[:count], own


def _rigid_count(omega2: FloatArray) -> int:
    """Modes without stiffness: exactly 0, or far below the 7th."""
    if omega2.size == 0:
        return 0
    reference = omega2[min(RIGID_MODES, omega2.size - 1)]
    return int(np.count_nonzero(omega2 <= RIGID_FREQUENCY**2 * reference))


def _estimates(
    full: System,
    reduced: System,
    inside: Inside,
    q: FloatArray,
    omega2: FloatArray,
    count: int,
    progress: Progress | None,
) -> tuple[FloatArray, float]:
    """Estimated errors, capped by the bound, block by block until one passes 1 % (`count` modes at least)."""
    out, cut = np.zeros(0), first_left_out(reduced, inside)
    for block in blocks(omega2.size, full.n):
        energy = residual_energy(full, reduced, inside, q[:, block], omega2[block])
        bound = error_bound(np.sqrt(omega2[block] / cut), 1.0)
        out = np.append(out, np.minimum(error_of(energy, omega2[block], cut), bound))
        if progress is not None:
            progress("error estimate", block.stop, omega2.size)
        if out.max() > GOOD and block.stop >= count:
            break
    return out, cut


def _usable(f: FloatArray, error: FloatArray, limit: float, cut: float, more: bool) -> float:
    """Lowest frequency, less its own error, among the modes that are off by more than the limit.

    Where all modes are good: the last that was checked if there are `more`, else the first frequency left out,
    below which the superelement misses no mode.
    """
    bad = np.flatnonzero(error > limit)
    if bad.size:
        return float((f[bad] / (1.0 + error[bad])).min())
    return float(f[-1]) if more else float(hertz(np.array(cut)))
