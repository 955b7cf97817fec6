"""Element matrices of a block as they are assembled: rigid arms and lumped mass included."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.elements.bushing import arm_matrix
from creak.elements.mass_forms import mass_matrices
from creak.elements.registry import FORMULATIONS
from creak.model.materials import GeneralShell
from creak.model.mesh import ElementBlock


def block_matrices(
    block: ElementBlock, rows: slice | IntArray, coords: FloatArray, *, form: str = "consistent"
) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """K, M and C (None without dashpots) of some elements of a block.

    Where elements have arms, their corners are at node + arm and follow the node as a rigid body:
    K = T' K_corner T with T = diag([I, -(arm x); 0, I]).

    Parameters
    ----------
    rows : which elements.
    coords : (n_node, 3) of all nodes of the model.
    form : of the mass of structural elements, see `mass_forms`. With lumped or linear mass quadrilateral shells get
        the stiffness that goes with it (`Formulation.softened`).

    Returns
    -------
    (n, d, d) each, node by node (ux, uy, uz, rx, ry, rz) in global axes.

    Raises
    ------
    DegenerateElement : see the formulation.
    """
    formulation, own = FORMULATIONS[block.kind], block.own.take(rows)
    x = coords[block.nodes_idx[rows]]
    if isinstance(block.section, GeneralShell) and block.section.rigid:
        nothing = np.zeros((len(x), 6 * x.shape[1], 6 * x.shape[1]))
        return nothing, nothing, None
    if own.arms is not None:
        x = x + own.arms
    stiffness = formulation.stiffness if form == "consistent" else formulation.softened or formulation.stiffness
    K = stiffness(x, block.section, own)
    M = mass_matrices(block, x, own, form)
    C = formulation.damping(x, block.section, own) if formulation.damping else None
    if own.arms is None:
        return K, M, C
    return _follow(K, own.arms), _follow(M, own.arms), None if C is None else _follow(C, own.arms)


def _follow(matrix: FloatArray, arms: FloatArray) -> FloatArray:
    """T' matrix T, exactly symmetric."""
    n, n_node, _ = arms.shape
    T = np.zeros((n, n_node, 6, n_node, 6))
    each = arm_matrix(arms.reshape(-1, 3)).reshape(n, n_node, 6, 6)
    for i in range(n_node):
        T[:, i, :, i, :] = each[:, i]
    flat = T.reshape(n, 6 * n_node, 6 * n_node)
    out = flat.transpose(0, 2, 1) @ matrix @ flat
    return np.asarray(0.5 * (out + out.transpose(0, 2, 1)), dtype=np.float64)
