"""What the quadrilateral and the triangular shell share: material matrices and the consistent mass."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import unit
from creak.model.materials import Material, ShellSection

SHEAR_CORRECTION = 5.0 / 6.0
"""Transverse shear correction of a homogeneous section (Reissner)."""


def plane_stress(material: Material) -> FloatArray:
    """D (3, 3), force / length^2: (sxx, syy, sxy) = D (exx, eyy, 2 exy) of an isotropic sheet."""
    nu = material.poisson_ratio
    factor = material.youngs_modulus / (1.0 - nu * nu)
    return factor * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])


def shear_stiffness(section: ShellSection) -> float:
    """kappa G t, force / length: transverse shear force per unit width over shear strain."""
    return SHEAR_CORRECTION * section.material.shear_modulus * section.thickness


def weighted_gram(operator: FloatArray, material: FloatArray, weights: FloatArray) -> FloatArray:
    """Sum over the points of w B' D B.

    Parameters
    ----------
    operator : (n, n_point, m, d) rows B.
    material : (m, m) symmetric D.
    weights : (n, n_point) weight times area.

    Returns
    -------
    (n, d, d).
    """
    n, n_point, m, d = operator.shape
    scaled = (material @ operator) * weights[:, :, None, None]
    flat = operator.reshape(n, n_point * m, d)
    return flat.transpose(0, 2, 1) @ scaled.reshape(n, n_point * m, d)


def shell_mass(
    coords: FloatArray,
    normal: FloatArray,
    weights: FloatArray,
    shapes: FloatArray,
    edge_shapes: FloatArray,
    section: ShellSection,
) -> FloatArray:
    """Consistent mass with a deflection that is quadratic along the edges, and rotary inertia.

    u = sum h_i u_i + n sum_e q_e w_e,   w_e = (1/8) n . (L_e x (theta_j - theta_i)),   L_e = x_j - x_i
    M = integral of rho t N_u' N_u + rho t^3/12 h_i h_j on the three rotations

    w_e is the deflection at the middle of an edge that the end rotations imply (linked interpolation:
    Zienkiewicz, Xu, Zeng, Samuelsson and Wiberg, Int. J. Numer. Meth. Eng. 36 (1993) 3043). It vanishes in
    rigid-body motion, so mass, centre of gravity and inertia are those of the plain bilinear mass, and it
    takes away the error (kh)^2/12 that the bilinear mass puts on the frequency of a bending wave of
    number k on elements of length h.

    The rotary inertia is isotropic, so it is the same in every frame. Its share about the shell normal is
    not physical (a director has no inertia about itself); it is of the same small size as the bending
    share and keeps M positive definite.

    Parameters
    ----------
    coords : (n, n_node, 3) global coordinates, length.
    normal : (n, 3) unit normals.
    weights : (n, n_point) quadrature weights times area, length^2.
    shapes : (n_point, n_node) values h_i.
    edge_shapes : (n_point, n_node) values q_e; edge e runs from node e to the next.
    section : thickness and density.

    Returns
    -------
    (n, 6 n_node, 6 n_node), node by node (ux, uy, uz, rx, ry, rz).
    """
    n, n_node, _ = coords.shape
    moment_arm = 0.125 * np.cross(normal[:, None], np.roll(coords, -1, axis=1) - coords)
    per_edge = edge_shapes[None, :, :, None] * moment_arm[:, None]
    per_node = np.roll(per_edge, 1, axis=2) - per_edge
    operator = np.zeros((n, len(shapes), 3, n_node, 6))
    for axis in range(3):
        operator[:, :, axis, :, axis] = shapes
        operator[:, :, axis, :, 3:] = normal[:, None, axis, None, None] * per_node
    density = section.material.density * section.thickness
    flat = operator.reshape(n, len(shapes), 3, 6 * n_node)
    out = weighted_gram(flat, density * np.eye(3), weights).reshape(n, n_node, 6, n_node, 6)
    products = np.einsum("ng,gi,gj->nij", weights, shapes, shapes, optimize=True)
    for dof in (3, 4, 5):
        out[:, :, dof, :, dof] += density * section.thickness**2 / 12.0 * products
    return out.reshape(n, 6 * n_node, 6 * n_node)


def mean_normal(coords: FloatArray) -> FloatArray:
    """Unit normals (n, 3) of triangles or quadrilaterals (n, n_node, 3)."""
    first = coords[:, 2] - coords[:, 0]
    second = coords[:, -1] - coords[:, 1]
    return unit(np.cross(first, second))
