"""Is a System its own modes, and what is the mass, damping and stiffness of each?"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.errors import InputError
from creak.linalg.diagonal import Diagonal

OFF_DIAGONAL = 1e-6
"""Modal damping that couples modes by less than this share of their own damping counts as diagonal."""


def modal_damping(system: System) -> FloatArray | None:
    """(n,) diagonal of C; None where M or K is not Diagonal or C couples coordinates.

    C = alpha M + beta K + W diag(d) W', the last term diagonal within `OFF_DIAGONAL` where the modes it was made for
    are those of the System.
    """
    d = system.damping
    if not (isinstance(system.M, Diagonal) and isinstance(system.K, Diagonal)) or d.extra is not None:
        return None
    own = d.alpha * system.M.d + d.beta * system.K.d
    if d.modal_shapes is None or d.modal_values is None:
        return np.asarray(own)
    C = (d.modal_shapes * d.modal_values) @ d.modal_shapes.T
    diagonal = C.diagonal().copy()
    np.fill_diagonal(C, 0.0)
    size = np.sqrt(np.maximum(own + diagonal, 0.0))
    coupled = np.abs(C) > OFF_DIAGONAL * np.maximum(np.outer(size, size), OFF_DIAGONAL * diagonal.max(initial=0.0))
    return None if coupled.any() else np.asarray(own + diagonal)


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
