"""Free modes of a part: the superelement's against the full part's, and the estimated error of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.errors import NumericalError
from creak.linalg.modes import modes
from creak.progress import Progress
from creak.reduction.health.estimate import blocks, error_bound, error_of, first_left_out, residual_energy
from creak.reduction.health.rigid import floats
from creak.reduction.inside import Inside

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
    stage = _stage(progress, "free modes of the full part")
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


def _stage(progress: Progress | None, stage: str) -> Callable[[int, int], None] | None:
    return None if progress is None else lambda done, total: progress(stage, done, total)
