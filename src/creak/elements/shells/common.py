"""What the quadrilateral and the triangular shell share: the integral of B' D B and the consistent mass."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import unit
from creak.elements.shells.rigidity import areal_mass, is_membrane
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import COMMON, Own

SPIN = 0.01
"""Inertia about the normal as a share of that of bending, for drilling rotations that are held softly
(`shells.quad4.DRILLING`): with all of it those of a sandwich or of foam have frequencies of some 100 Hz."""


def weighted_gram(operator: FloatArray, material: FloatArray, weights: FloatArray) -> FloatArray:
    """Sum over the points of w B' D B.

    Parameters
    ----------
    operator : (n, n_point, m, d) rows B.
    material : (m, m) symmetric D, or one for each point, (n or 1, n_point or 1, m, m).
    weights : (n, n_point) weight times area.

    Returns
    -------
    (n, d, d).
    """
    n, n_point, m, d = operator.shape
    scaled = (material @ operator) * weights[:, :, None, None]
    flat = operator.reshape(n, n_point * m, d)
    return flat.transpose(0, 2, 1) @ scaled.reshape(n, n_point * m, d)


def weighted_sum(operator: FloatArray, stress: FloatArray, weights: FloatArray) -> FloatArray:
    """Sum over the points of w B' s: operator (n, n_point, m, d), stress (n, n_point, m) -> (n, d)."""
    return np.asarray(np.einsum("ngmd,ngm->nd", operator, stress * weights[..., None]), dtype=np.float64)


def shell_mass(
    coords: FloatArray,
    normal: FloatArray,
    weights: FloatArray,
    shapes: FloatArray,
    edge_shapes: FloatArray,
    section: ShellSection | GeneralShell,
    own: Own = COMMON,
    spin: float = SPIN,
) -> FloatArray:
    """Consistent mass with a deflection that is quadratic along the edges, and rotary inertia.

    u = sum h_i u_i + n sum_e q_e w_e,   w_e = (1/8) n . (L_e x (theta_j - theta_i)),   L_e = x_j - x_i
    M = integral of m N_u' N_u + I h_i h_j (1 - (1 - s) n n') on the rotations, m = rho t, I = rho t^3/12

    w_e is the deflection at the middle of an edge that the end rotations imply (linked interpolation:
    Zienkiewicz, Xu, Zeng, Samuelsson and Wiberg, Int. J. Numer. Meth. Eng. 36 (1993) 3043). It vanishes in
    rigid-body motion, so mass, centre of gravity and inertia are those of the plain bilinear mass, and it
    takes away the error (kh)^2/12 that the bilinear mass puts on the frequency of a bending wave of
    number k on elements of length h.

    A director has no inertia about itself: the share s = `spin` about the shell normal keeps M positive definite.
    Rotations of a membrane have neither stiffness nor mass: u = sum h_i u_i.
    Where the centre of mass lies at a height c above the nodes, u + c theta x n stands for u, and I is about that
    centre.

    Parameters
    ----------
    coords : (n, n_node, 3) global coordinates, length.
    normal : (n, 3) unit normals.
    weights : (n, n_point) quadrature weights times area, length^2.
    shapes : (n_point, n_node) values h_i.
    edge_shapes : (n_point, n_node) values q_e; edge e runs from node e to the next.
    section : mass and inertia per area.
    own : of these elements; the thickness at their nodes counts.

    Returns
    -------
    (n, 6 n_node, 6 n_node), node by node (ux, uy, uz, rx, ry, rz).
    """
    n, n_node, _ = coords.shape
    density, inertia, centre = areal_mass(section, 1.0 if own.thickness is None else own.thickness @ shapes.T)
    if is_membrane(section):
        inertia, centre, edge_shapes = np.zeros_like(inertia), np.zeros_like(centre), np.zeros_like(edge_shapes)
    moment_arm = 0.125 * np.cross(normal[:, None], np.roll(coords, -1, axis=1) - coords)
    per_edge = edge_shapes[None, :, :, None] * moment_arm[:, None]
    per_node = np.roll(per_edge, 1, axis=2) - per_edge
    operator = np.zeros((n, len(shapes), 3, n_node, 6))
    for axis in range(3):
        operator[:, :, axis, :, axis] = shapes
        operator[:, :, axis, :, 3:] = normal[:, None, axis, None, None] * per_node
    if centre.any():
        turn = np.cross(np.eye(3), normal[:, None, :])
        height = np.broadcast_to(centre, weights.shape)
        per_point = height[:, :, None, None, None] * shapes[:, :, None, None] * turn[:, None, None]
        operator[:, :, :, :, 3:] += per_point.transpose(0, 1, 4, 2, 3)
    flat = operator.reshape(n, len(shapes), 3, 6 * n_node)
    out = weighted_gram(flat, np.eye(3), weights * density).reshape(n, n_node, 6, n_node, 6)
    products = np.einsum("ng,gi,gj->nij", weights * inertia, shapes, shapes, optimize=True)
    turning = np.eye(3) - (1.0 - spin) * normal[:, :, None] * normal[:, None]
    out[:, :, 3:, :, 3:] += products[:, :, None, :, None] * turning[:, None, :, None]
    return out.reshape(n, 6 * n_node, 6 * n_node)


def stressed_stiffness(
    coords: FloatArray,
    normal: FloatArray,
    gradients: FloatArray,
    edge_gradients: FloatArray,
    force: FloatArray,
    areas: FloatArray,
    section: ShellSection | GeneralShell,
) -> FloatArray:
    """integral of N_ab u_,a . u_,b with the deflection of `shell_mass`: quadratic along the edges.

    Parameters
    ----------
    normal : (n, 3). gradients, edge_gradients : (n, n_point, 2, n_node) of h_i and q_e along the axes of N.
    force : (n, 2, 2) membrane force N. areas : (n, n_point) weights times area.

    Returns
    -------
    (n, 6 n_node, 6 n_node).
    """
    n, n_point, _, n_node = gradients.shape
    if is_membrane(section):
        edge_gradients = np.zeros_like(edge_gradients)
    moment_arm = 0.125 * np.cross(normal[:, None], np.roll(coords, -1, axis=1) - coords)
    per_edge = edge_gradients[..., None] * moment_arm[:, None, None]
    per_node = np.roll(per_edge, 1, axis=3) - per_edge
    operator = np.zeros((n, n_point, 3, 2, n_node, 6))
    for axis in range(3):
        operator[:, :, axis, :, :, axis] = gradients
        operator[:, :, axis, :, :, 3:] = normal[:, None, axis, None, None, None] * per_node
    flat = operator.reshape(n, n_point, 6, 6 * n_node)
    return weighted_gram(flat, np.asarray(np.kron(np.eye(3), force[:, None]), dtype=np.float64), areas)


def mean_normal(coords: FloatArray) -> FloatArray:
    """Unit normals (n, 3) of triangles or quadrilaterals (n, n_node, 3)."""
    first = coords[:, 2] - coords[:, 0]
    second = coords[:, -1] - coords[:, 1]
    return unit(np.cross(first, second))
