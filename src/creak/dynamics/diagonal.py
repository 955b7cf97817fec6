"""Is a System its own modes, and what is the mass, damping and stiffness of each?"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.errors import InputError
from creak.linalg.complex_modes import coupled
from creak.linalg.diagonal import Diagonal


def modal_damping(system: System) -> FloatArray | None:
    """(n,) diagonal of C; None where M or K is not Diagonal or C couples coordinates.

    C = alpha M + beta K + W diag(d) W', the last term diagonal within `OFF_DIAGONAL` where the modes it was made for
    are those of the System.
    """
    d = system.damping
    if not (isinstance(system.M, Diagonal) and isinstance(system.K, Diagonal)) or d.extra is not None:
        return None
    m, k = system.M.d, system.K.d
    if d.is_rayleigh:
        return np.asarray(d.alpha * m + d.beta * k)
    C = d.matrix(m, k)
    return None if coupled(C).any() else C.diagonal().copy()


def is_modal(system: System) -> bool:
    """Are M, C and K diagonal, so that each coordinate moves by itself between contacts?"""
    return modal_damping(system) is not None


def modal_matrices(system: System) -> tuple[FloatArray, FloatArray, FloatArray]:
    """m, c, k (n,) of a diagonal System.

    Raises
    ------
    InputError : the System is not diagonal, or a coordinate has neither mass nor stiffness.
    """
    c = modal_damping(system)
    if c is None:
        raise InputError(
            "M, C or K is not diagonal, but modes are to move one by one",
            where=system.name,
            fix="Diagonalise the System, or leave out dashpots; damping by Rayleigh's rule or by its own modes.",
        )
    m, k = np.asarray(system.M.diagonal(), dtype=float), np.asarray(system.K.diagonal(), dtype=float)
    empty = np.count_nonzero((m <= 0.0) & (k <= 0.0))
    if empty:
        raise InputError(f"{empty} coordinates have neither mass nor stiffness", where=system.name)
    return m, c, k
