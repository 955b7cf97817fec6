"""Geometry that all elements share: quadrature points, local frames, blocks, bad elements."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import CreakError
from creak.model.mesh import COMMON, Own
from creak.words import first_few

CHUNK = 1024
"""Elements computed at once: their scratch memory, some 25 MB, stays in the caches."""

DEGENERATE = 1e-6
"""Smallest ratio of an element's extent to its nominal size that still counts as an element."""


class DegenerateElement(CreakError):
    """Elements whose geometry admits no stiffness.

    Parameters
    ----------
    rows : (n_bad,) rows of the block, in ascending order; the caller turns them into labels.
    reason : what is wrong with them.
    """

    def __init__(self, rows: IntArray, reason: str) -> None:
        self.rows, self.reason = rows, reason
        super().__init__(f"{reason} (rows {first_few(rows.tolist())} of the block)")


def require_sound(bad: BoolArray, reason: str) -> None:
    """Raise for the elements marked in `bad` (n,).

    Raises
    ------
    DegenerateElement : at least one element is marked.
    """
    if bad.any():
        raise DegenerateElement(np.flatnonzero(bad).astype(np.int64), reason)


def in_chunks(
    kernel: Callable[[FloatArray, Own], FloatArray], coords: FloatArray, n_dof: int, own: Own = COMMON
) -> FloatArray:
    """Run `kernel` over a block piece by piece and make the result exactly symmetric.

    Parameters
    ----------
    kernel : maps coords (m, n_node, 3) and what these elements have of their own to matrices (m, n_dof, n_dof).
    coords : (n, n_node, 3) global coordinates.
    n_dof : size of one element matrix.
    own : of all n elements.

    Returns
    -------
    (n, n_dof, n_dof) symmetric matrices.
    """
    coords = np.asarray(coords, dtype=np.float64)
    out = np.empty((coords.shape[0], n_dof, n_dof))
    for start in range(0, coords.shape[0], CHUNK):
        rows = slice(start, start + CHUNK)
        try:
            piece = kernel(coords[rows], own.take(rows))
        except DegenerateElement as error:
            raise DegenerateElement(start + error.rows, error.reason) from None
        out[rows] = 0.5 * (piece + piece.transpose(0, 2, 1))
    return out


def gauss_square(n_side: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre product rule on [-1, 1]^2: points (n_side^2, 2) and weights (n_side^2,)."""
    at, weight = np.polynomial.legendre.leggauss(n_side)
    r, s = np.meshgrid(at, at, indexing="ij")
    return np.column_stack([r.ravel(), s.ravel()]), np.outer(weight, weight).ravel()


def gauss_triangle() -> tuple[FloatArray, FloatArray]:
    """Six-point rule on the unit triangle, exact to degree four.

    Points (6, 2) in (r, s) and weights (6,) that sum to one (multiply by the area).
    Source: Strang and Fix (1973); Dunavant, Int. J. Numer. Meth. Eng. 21 (1985) 1129, degree 4.
    """
    a, b = 0.445948490915965, 0.091576213509771
    points = [(a, a), (1 - 2 * a, a), (a, 1 - 2 * a), (b, b), (1 - 2 * b, b), (b, 1 - 2 * b)]
    weights = [0.223381589678011] * 3 + [0.109951743655322] * 3
    return np.array(points), np.array(weights) / sum(weights)


def unit(vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3) scaled to length one."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def material_frames(own: Own, n: int) -> FloatArray:
    """(n, 3, 3): rows are the material axes of solids and bushings in global components.

    Axis 1, then axis 2 made perpendicular to it, then their cross product; global axes where there are none.

    Raises
    ------
    DegenerateElement : axes of no length, or parallel ones.
    """
    if own.axis1 is None:
        return np.broadcast_to(np.eye(3), (n, 3, 3))
    fallback = np.eye(3)[np.argmin(np.abs(own.axis1), axis=1)]
    second = fallback if own.axis2 is None else own.axis2
    third = np.cross(own.axis1, second)
    size = np.linalg.norm(own.axis1, axis=1) * np.linalg.norm(second, axis=1)
    require_sound(~(np.linalg.norm(third, axis=1) > DEGENERATE * size), "the two material axes are parallel or zero")
    first, third = unit(own.axis1), unit(third)
    return np.stack([first, np.cross(third, first), third], axis=1)


def rotate_to_global(local: FloatArray, frame: FloatArray) -> FloatArray:
    """K_global = T' K_local T with T = diag(frame, frame, ...).

    Parameters
    ----------
    local : (n, 3 m, 3 m) matrices in the local axes.
    frame : (n, 3, 3) rows are the local axes in global components.

    Returns
    -------
    (n, 3 m, 3 m) matrices in global axes.
    """
    n, d, _ = local.shape
    right = (local.reshape(n, d * d // 3, 3) @ frame).reshape(n, d, d)
    swapped = np.ascontiguousarray(right.transpose(0, 2, 1))
    both = (swapped.reshape(n, d * d // 3, 3) @ frame).reshape(n, d, d)
    return both.transpose(0, 2, 1)


def turn_to_global(local: FloatArray, frame: FloatArray) -> FloatArray:
    """T' f of vectors (n, 3 m) in local axes with rows `frame` (n, 3, 3)."""
    return np.asarray((local.reshape(len(local), -1, 3) @ frame).reshape(local.shape), dtype=np.float64)
