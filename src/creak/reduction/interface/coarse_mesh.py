"""Interface motion taken from the modes of a coarse mesh."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import InputError
from creak.model.dofs import PER_NODE, node_dofs
from creak.model.projection import Nearest, nearest_points
from creak.reduction.interface.interpolation import levers, rigid_motions

NEGLIGIBLE = 1e-3
"""Singular values of the modes' motion below this share of the largest are dropped."""


def coarse_basis(
    coarse_coords: FloatArray,
    coarse_elements: IntArray,
    coarse_shapes: FloatArray,
    fine_coords: FloatArray,
    *,
    count: int | None = None,
) -> FloatArray:
    """Basis of the fine interface from the modes of the assembly computed on a coarse mesh.

    Each fine node takes part in the coarse motion at the nearest point of the coarse mesh, with linked shape functions
    (`linked`), so that thin shells bend without shear. To these come the six rigid-body motions of the interface; the
    modes, made orthogonal to them, are ordered by a singular value decomposition and truncated. The modes enter with
    the amplitude they have at the interface: normalise them alike (Phi' M Phi = I), so that those that hardly move it
    count little.

    Parameters
    ----------
    coarse_coords : (m, 3). coarse_elements : (p, 4) rows of the nodes of quadrilaterals; -1 last for triangles.
    coarse_shapes : (6 m, n_mode) modes of the whole coarse assembly in the range of interest (better: up to twice
        its end), at these nodes, node by node 1..6.
    fine_coords : (n, 3) interface nodes of the fine mesh.
    count : largest number of columns, the six rigid ones included.

    Returns
    -------
    B (6 n, k), rigid-body motion first; (S B)' (S B) = I, S = diag(1 for translations, the mean edge of the coarse
    mesh for rotations). Both parts that meet at the interface use the same B: it is compatible.

    Raises
    ------
    InputError : no coarse elements; shapes that do not fit the nodes.

    Source: idea of Gibanica, Abrahamsson and Rixen, Procedia Engineering 199, 2017; the linked shape functions are
    creak's. Free steel plate 600 x 400 x 1 mm of 24 x 24 elements, 150 dofs in a cut, first 20 elastic frequencies:
    20 columns from the 26 lowest modes of 12 x 12 elements give errors below 0.1 % (their own frequencies are 4 %
    off), 21 columns from 8 x 8 elements 0.25 %; 20 from 12 x 12 x 2 triangles, plate curved, 0.3 %.

    Valid as far as the coarse mesh resolves the modes. What it cannot do is motion that the modes do not contain:
    forces at single points of the interface (contact) need dofs of their own. The coarse mesh must follow the same
    surface (nearest point within an edge length).
    """
    if coarse_elements.shape[0] == 0:
        raise InputError("the coarse mesh has no elements", expected="shells around the interface")
    if coarse_shapes.shape[0] != 6 * coarse_coords.shape[0]:
        raise InputError(
            f"coarse modes of {coarse_shapes.shape[0]} rows", expected=f"{6 * coarse_coords.shape[0]}, six per node"
        )
    corners = np.where(coarse_elements < 0, coarse_elements[:, [2]], coarse_elements)
    S = np.tile(np.repeat([1.0, _mean_edge(coarse_coords[corners])], 3), fine_coords.shape[0])[:, None]
    modes = S * (_to_fine(coarse_coords, corners, fine_coords) @ coarse_shapes)
    rigid = np.linalg.qr(S * rigid_motions(fine_coords - fine_coords.mean(axis=0)))[0]
    modes -= rigid @ (rigid.T @ modes)
    U, sigma, _ = np.linalg.svd(modes, full_matrices=False)
    shapes = U[:, sigma > NEGLIGIBLE * sigma.max(initial=0.0)]
    return np.hstack([rigid, shapes])[:, :count] / S


def linked(weights: Matrix, coords: FloatArray, sources: FloatArray) -> Matrix:
    """(6 n, 6 k) motion of n nodes from that of k others, their rotations linked to the displacements.

    theta_j = sum_k w_jk theta_k,
    u_j = sum_k w_jk u_k + 1/2 sum_k w_jk theta_k x (x_j - x_k) + 1/2 theta_j x (x_j - sum_k w_jk x_k)

    Rigid-body motion is exact for any weights that sum to 1. Where the weights are exact for x, so are displacements
    quadratic in x whose gradient the rotations are: a thin shell in constant curvature gets no shear strain. (Plain
    shape functions kink there, and the shear of the fine mesh makes that kink very stiff.) Source of the idea: linked
    interpolation of plates, Auricchio and Taylor, Comput. Methods Appl. Mech. Eng. 117, 1994.

    weights : (n, k) csr, rows sum to 1. coords : (n, 3), sources : (k, 3).
    """
    W = sp.csr_matrix(weights)
    at, source = np.repeat(np.arange(W.shape[0]), np.diff(W.indptr)), W.indices.astype(np.int64)
    offset = coords - W @ sources
    blocks = W.data[:, None, None] * np.eye(6)
    blocks[:, :3, 3:] = W.data[:, None, None] * levers(0.5 * (coords[at] - sources[source] + offset[at]))
    row = np.broadcast_to(node_dofs(at).reshape(-1, PER_NODE, 1), blocks.shape)
    column = np.broadcast_to(node_dofs(source).reshape(-1, 1, PER_NODE), blocks.shape)
    shape = (PER_NODE * W.shape[0], PER_NODE * W.shape[1])
    return sp.csr_matrix((blocks.ravel(), (row.ravel(), column.ravel())), shape=shape)


def _to_fine(coords: FloatArray, corners: IntArray, fine: FloatArray) -> Matrix:
    triangle = corners[:, 2] == corners[:, 3]
    found: Nearest = nearest_points(fine, coords[corners], triangle, np.inf)
    at = np.repeat(np.arange(fine.shape[0]), 4), corners[found.facet].ravel()
    W = sp.csr_matrix((found.shape.ravel(), at), shape=(fine.shape[0], coords.shape[0]))
    W.eliminate_zeros()
    return linked(W, fine, coords)


def _mean_edge(X: FloatArray) -> float:
    sides = np.linalg.norm(np.roll(X, -1, axis=1) - X, axis=2)
    return float(sides[sides > 0.0].mean())
