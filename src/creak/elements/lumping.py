"""Mass lumped at the nodes."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray


def lumped(mass: FloatArray) -> FloatArray:
    """Diagonal masses on the translations of each node, nothing on the rotations.

    The row sums of the consistent mass; where one of them is not positive (quadratic elements) its diagonal scaled
    to the element's mass (Hinton, Rock and Zienkiewicz, Earthquake Eng. Struct. Dyn. 4 (1976) 245). Mass and, for
    elements symmetric about their centre, the centre of mass are kept; moments of inertia change by the order of
    the mesh. Rotations without mass are massless coordinates.

    Parameters
    ----------
    mass : (n, 6 n_node, 6 n_node) consistent mass, node by node (ux, uy, uz, rx, ry, rz).

    Returns
    -------
    (n, 6 n_node, 6 n_node).
    """
    d = mass.shape[1]
    x = np.arange(0, d, 6)
    sums = mass[:, x][:, :, x].sum(axis=2)
    diagonal = mass[:, x, x]
    scaled = diagonal * (sums.sum(axis=1) / np.maximum(diagonal.sum(axis=1), 1e-300))[:, None]
    share = np.where((sums > 0.0).all(axis=1)[:, None], sums, scaled)
    out = np.zeros_like(mass)
    for axis in range(3):
        out[:, x + axis, x + axis] = share
    return out
