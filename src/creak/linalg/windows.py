"""The lowest modes, window by window: the Lanczos vectors of a few modes are held at a time, not those of all.

Every window has a shift of its own, and the inertia of its factor says how many modes lie below it. Lanczos finds
those nearest to it on either side; where they end, the next window goes on. Windows end where neighbours
differ most, so that a mode belongs to one of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from creak.arrays import FloatArray
from creak.errors import NumericalError
from creak.linalg.dense_product import inner
from creak.linalg.factor import Factor, SingularMatrixError
from creak.linalg.lanczos import Ritz, basis_bytes, lanczos
from creak.linalg.memory import free_bytes, held_in_memory, vectors
from creak.linalg.pencil import Pencil
from creak.linalg.sparse_product import BlockProduct
from creak.progress import Steps

FEWEST = 24
"""Modes of the smallest window."""
SLACK = 12
"""Modes beyond a window among which its end is sought."""
WIDTHS = (8, 16, 32, 64)
"""Of a block of vectors: 8 take half the memory of 16, and in windows no more time; wider where modes were missed."""
SPREAD = 1.5
"""Lanczos vectors of a window over those of as many lowest modes (measured: 1.3 to 1.6)."""
AMID = 0.55
"""The shift amid modes, of all or of the last window, as a share of their range of eigenvalues (measured: .5 to .6)."""
RAISED = 10
"""How often the frequency is doubled below which further modes are sought window by window."""
WINDOWS = 0.8
"""Share of the free memory that modes take where they are found window by window."""
TRIALS = 8
"""Shifts that are tried for a window."""
TWINS = 1e-7
"""Largest |x' M y| of modes x and y on either side of an end."""

TOO_MANY = (
    f"more than {SLACK} equal eigenvalues where a window of modes ends, since memory does not hold the vectors of all "
    "modes at once. Ask for fewer modes, or give the process more memory."
)

At = Callable[[Factor | None, float], Factor]
"""The factor of K - shift M, in the place of the one given."""


def window_bytes(n: int, modes: int = FEWEST) -> float:
    """Memory that the Lanczos vectors of a window take, the smallest by default."""
    return basis_bytes(n, int(SPREAD * (modes + SLACK)), width=WIDTHS[0])


def window_size(n: int, free: float) -> int:
    """Most modes of a window whose Lanczos vectors `free` bytes hold; `FEWEST` where not even those fit."""
    most = FEWEST
    while window_bytes(n, int(1.1 * most)) <= free and most < n:
        most = int(1.1 * most)
    return most


def in_windows(
    at: At, solver: Factor, mass: BlockProduct, wanted: int, upper: float, most: int, progress: Steps | None = None
) -> tuple[Ritz, float]:
    """The `wanted` lowest eigenpairs of K x = lam M x, one eigenvalue more, and the lowest shift.

    Parameters
    ----------
    solver : a factor of K - upper M, which is used up. upper : rad^2/s^2, above `wanted` eigenvalues.
    most : modes of a window.

    Raises
    ------
    NumericalError : a group of equal eigenvalues has no end to cut at, or modes are missing.
    """
    lam, shapes, columns, lowest = np.zeros(0), vectors(mass.n, wanted), 0, 0.0
    rate = np.sqrt(upper) / wanted  # of frequency, per mode
    search = _Search(at, mass, wanted, upper, most, progress)
    held: Factor | None = solver
    del solver
    while lam.size < wanted:
        held, shift = search.placed(held, lam, rate)
        lowest = lowest if lam.size else shift
        found, last, held, solved = search.counted(held, lam, shift)
        _check_end(mass, shapes[max(lam.size - SLACK, 0) : lam.size].T, found.shapes[:, :SLACK])
        shapes[lam.size : lam.size + last] = found.shapes[:, :last].T
        start = np.sqrt(max(lam[-1] if lam.size else 0.0, 0.0))
        rate = max((np.sqrt(max(found.lam[last - 1], 0.0)) - start) / last, 0.1 * rate)
        columns += solved
        lam = np.concatenate([lam, found.lam if lam.size + last == wanted else found.lam[:last]])
        del found
    return Ritz(lam, shapes.T, columns), lowest


def amid_or_in_windows(
    pencil: Pencil, upper: float, counted: Factor, placed: float, wanted: int, within: int, progress: Steps | None
) -> tuple[Ritz, float]:
    """The modes with a factor amid them, or window by window where memory does not hold the vectors of all at once.

    `within` of those that are wanted lie below `upper`; `counted` is a factor of K - placed M, there or amid them.
    """
    n = pencil.mass.n
    free = free_bytes()
    if basis_bytes(n, wanted + 1) + 8.0 * n * wanted <= WINDOWS * free:
        amid = placed if placed < upper else AMID * upper
        solver = counted if amid == placed else pencil.refactor(counted, amid)
        above = upper * (1.0 + 1e-6)
        found = lanczos(solver, pencil.mass, amid, wanted, extra=1, upper=above, within=within, progress=progress)
        return found, amid
    for _ in range(RAISED):
        if within < wanted:
            upper *= 4.0
            counted = pencil.counted(upper, counted)
            within = counted.n_negative
    wanted = min(wanted, within)

    def at(held: Factor | None, shift: float) -> Factor:
        return pencil.factor(shift, definite=False) if held is None else pencil.refactor(held, shift)

    left = WINDOWS * free - (8.0 * n * wanted if held_in_memory(n, wanted) else 0.0)
    return in_windows(at, counted, pencil.mass, wanted, upper, window_size(n, left), progress)


@dataclass(frozen=True)
class _Search:
    """What `in_windows` looks for; `lam` are the eigenvalues that it has found."""

    at: At
    mass: BlockProduct
    wanted: int
    upper: float
    most: int
    progress: Steps | None

    def counted(self, held: Factor, lam: FloatArray, shift: float) -> tuple[Ritz, int, Factor, int]:
        """A window whose modes are as many as the inertia at its end says; with wider blocks where it missed some."""
        solved = 0
        for width in WIDTHS:
            found, last = self._window(held, lam, shift, width)
            solved += found.columns
            if lam.size + last == self.wanted:
                return found, last, held, solved
            held = self.at(held, 0.5 * (found.lam[last - 1] + found.lam[last]))
            if held.n_negative == lam.size + last:
                return found, last, held, solved
            held = self.at(held, shift)
        raise NumericalError(TOO_MANY)

    def placed(self, held: Factor | None, lam: FloatArray, rate: float) -> tuple[Factor, float]:
        """A factor, and its shift, with at most `most` modes between the last one found and that; half of them at
        best."""
        most, rest = self.most, self.wanted - lam.size
        low = max(lam[-1], 0.0) if lam.size else 0.0
        shift = final = low + AMID * (self.upper - low)
        if rest > most:
            shift = min((np.sqrt(low) + 0.5 * most * rate) ** 2, final)
        for left in reversed(range(TRIALS)):
            try:
                held = self.at(held, shift)
            except SingularMatrixError:  # an eigenvalue, exactly
                held, shift = None, low + (1.0 - 1e-6) * (shift - low)
                continue
            below = held.n_negative - lam.size
            if below <= 0.75 * most or rest <= most or not left:
                return held, shift
            shift = (np.sqrt(low) + (np.sqrt(shift) - np.sqrt(low)) * 0.5 * most / below) ** 2
        raise NumericalError("no shift was found between the modes")

    def _window(self, held: Factor, lam: FloatArray, shift: float, width: int) -> tuple[Ritz, int]:
        """Modes nearest to the shift beyond those found, and how many of them the window keeps."""
        skip, left = lam.size, self.wanted - lam.size
        size = max(self.most, held.n_negative - skip + FEWEST // 2)

        def report(done: int, _: int) -> None:
            if self.progress is not None:
                self.progress(skip + min(done, size, left), self.wanted)

        seek = partial(lanczos, held, self.mass, shift, width=width, progress=report)
        seek = partial(seek, skip=skip, lower=float(lam[-1]) if skip else -np.inf)
        if left <= size + SLACK:
            return seek(left, extra=1, upper=self.upper * (1.0 + 1e-6)), left
        found = seek(size + SLACK)
        return found, size + int(np.argmax(np.diff(found.lam[size - 1 :])))


def _check_end(mass: BlockProduct, before: FloatArray, after: FloatArray) -> None:
    """Raise NumericalError where a window has found modes of the one before again."""
    if not are_apart(mass, before, after):
        raise NumericalError(TOO_MANY)


def are_apart(mass: BlockProduct, before: FloatArray, after: FloatArray) -> bool:
    """Whether no mode `after` is one of those `before`."""
    if not before.shape[1] or not after.shape[1]:
        return True
    return bool(np.abs(inner(np.asfortranarray(before), mass(np.asfortranarray(after)))).max() <= TWINS)
