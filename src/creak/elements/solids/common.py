"""What solid elements share: elasticity in global axes, strains from gradients, mass, rotations left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import DEGENERATE, in_chunks, material_frames, require_sound
from creak.elements.shells.common import weighted_gram, weighted_sum
from creak.model.elasticity import hooke
from creak.model.materials import AnisotropicMaterial, Material, SolidSection
from creak.model.mesh import COMMON, Own


@dataclass(frozen=True)
class Reference:
    """Shape functions of an element at its integration points."""

    points: FloatArray
    """(n_point, 3) natural coordinates."""
    weights: FloatArray
    """(n_point,) weights; they sum to the volume of the natural domain."""
    shapes: FloatArray
    """(n_point, n_node)"""
    slopes: FloatArray
    """(n_point, 3, n_node) derivatives by the natural coordinates."""

    @property
    def n_node(self) -> int:
        return int(self.shapes.shape[1])


def serendipity(nodes: FloatArray, points: FloatArray, weights: FloatArray) -> Reference:
    """Shape functions of squares (d = 2) and cubes (3) with corners and the middles of their edges, at the points.

    Corners: h_i = prod(1 + x x_i) (sum x x_i - d + 1) / 2^d; between them, where one x_i is 0:
    h_i = (1 - x^2) prod(1 + y y_i) / 2^(d - 1) with y the others.

    Parameters
    ----------
    nodes : (n_node, d) natural coordinates, corners first. points : (n_point, d).
    """
    d = nodes.shape[1]
    x = points[:, None, :]
    corner = np.arange(len(nodes)) < 2**d
    factor = np.where(nodes == 0.0, 1.0 - x**2, 1.0 + x * nodes)
    slope = np.where(nodes == 0.0, -2.0 * x, nodes + 0.0 * x)
    cut = np.where(corner, (x * nodes).sum(axis=2) - (d - 1.0), 1.0)
    scale = np.where(corner, 0.5**d, 0.5 ** (d - 1))
    product = factor.prod(axis=2)
    slopes = []
    for axis in range(d):
        others = np.delete(factor, axis, axis=2).prod(axis=2)
        slopes.append(scale * (slope[..., axis] * others * cut + product * np.where(corner, nodes[:, axis], 0.0)))
    return Reference(points, weights, scale * product * cut, np.stack(slopes, axis=1))


VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
"""Axes of the six strains."""


def elasticity(material: Material | AnisotropicMaterial, own: Own) -> FloatArray:
    """D in global axes: (6, 6), or (n, 1, 6, 6) where elements have material axes of their own."""
    D = hooke(material)
    if isinstance(material, Material) or own.axis1 is None:
        return D
    T = strain_rotation(material_frames(own, len(own.axis1)))
    return np.asarray(T.transpose(0, 2, 1) @ D @ T, dtype=np.float64)[:, None]


def heat_stress(material: Material | AnisotropicMaterial, own: Own) -> FloatArray:
    """D alpha in global axes, (6,) or (n, 1, 6): the stress that holds solids as they are against one degree."""
    if material.expansion is None:
        return np.zeros(6)
    stress = hooke(material) @ np.array(material.expansion.strain)
    if own.axis1 is None:
        return np.asarray(stress, dtype=np.float64)
    T = strain_rotation(material_frames(own, len(own.axis1)))
    return np.asarray(T.transpose(0, 2, 1) @ stress, dtype=np.float64)[:, None]


def heat_load(
    coords: FloatArray, section: SolidSection, own: Own, rise: FloatArray, *, reference: Reference
) -> FloatArray:
    """f = integral of B' D alpha dT of displacements alone, (n, 6 n_node); dT interpolated as the displacements."""
    inverse, det = jacobians(coords, reference.slopes)
    stress = heat_stress(section.material, own) * (rise @ reference.shapes.T)[..., None]
    return without_turns(weighted_sum(strains(inverse @ reference.slopes), stress, det * reference.weights))


def geometric_stiffness(
    coords: FloatArray, section: SolidSection, own: Own, u: FloatArray, *, reference: Reference
) -> FloatArray:
    """K_g of the stress of displacements u (n, n_node, 6), see `of_stress`."""
    inverse, det = jacobians(coords, reference.slopes)
    gradient = inverse @ reference.slopes
    strain = strains(gradient) @ u[:, None, :, :3].reshape(len(u), 1, -1, 1)
    stress = (elasticity(section.material, own) @ strain)[..., 0]
    return of_stress(gradient, stress, det * reference.weights)


def of_stress(gradient: FloatArray, stress: FloatArray, volume: FloatArray) -> FloatArray:
    """K_g = integral of sigma_ij u_k,i u_k,j, (n, 6 n_node, 6 n_node), the same for each translation.

    Zienkiewicz and Taylor, The Finite Element Method, vol. 2 (2000), chapter 10.

    Parameters
    ----------
    gradient : (n, n_point, 3, n_node). stress : (n, n_point, 6). volume : (n, n_point).
    """
    tensor = np.zeros((*stress.shape[:2], 3, 3))
    for k, (i, j) in enumerate(VOIGT):
        tensor[..., i, j] = tensor[..., j, i] = stress[..., k]
    scaled = (tensor * volume[:, :, None, None]) @ gradient
    pairs = np.einsum("ngia,ngib->nab", gradient, scaled)
    each = np.einsum("nab,ij->naibj", pairs, np.eye(3))
    return with_rotations(each.reshape(len(pairs), 3 * pairs.shape[1], -1))


def without_turns(forces: FloatArray) -> FloatArray:
    """(n, 6 n_node) from forces on the translations (n, 3 n_node)."""
    n, d = forces.shape
    out = np.zeros((n, d // 3, 6))
    out[:, :, :3] = forces.reshape(n, d // 3, 3)
    return out.reshape(n, 2 * d)


def strain_rotation(frames: FloatArray) -> FloatArray:
    """(n, 6, 6): strains (shear doubled) in axes with rows `frames` (n, 3, 3) from those in global axes."""
    T = np.empty((len(frames), 6, 6))
    for row, (a, b) in enumerate(VOIGT):
        for column, (i, j) in enumerate(VOIGT):
            term = frames[:, a, i] * frames[:, b, j]
            if i != j:
                term = 0.5 * (term + frames[:, a, j] * frames[:, b, i])
            T[:, row, column] = term if a == b else 2.0 * term
    return T


def jacobians(coords: FloatArray, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """d(natural)/d(x) (n, n_point, 3, 3) with rows x, y, z, and det dx/d(natural) (n, n_point).

    Not to be called before `require_volume`.
    """
    jacobian = np.einsum("gai,nix->ngax", slopes, coords)
    return np.linalg.inv(jacobian), np.linalg.det(jacobian)


def require_volume(coords: FloatArray, slopes: FloatArray) -> None:
    """Check every element of coords (n, n_node, 3).

    Raises
    ------
    DegenerateElement : no volume, or the nodes run the wrong way round (det dx/d(natural) not positive).
    """
    extent = np.ptp(coords, axis=1).max(axis=1)
    det = np.linalg.det(np.einsum("gai,nix->ngax", slopes, coords)).min(axis=1)
    require_sound(~(det > DEGENERATE * extent**3), "no volume, or nodes in the wrong order (Jacobian not positive)")


def strains(gradient: FloatArray) -> FloatArray:
    """(..., 6, 3 k): strains of the displacements (ux, uy, uz) x k modes with gradients (..., 3, k)."""
    x, y, z = (gradient[..., axis, :] for axis in range(3))
    out = np.zeros((*gradient.shape[:-2], 6, gradient.shape[-1], 3))
    out[..., 0, :, 0], out[..., 1, :, 1], out[..., 2, :, 2] = x, y, z
    out[..., 3, :, 0], out[..., 3, :, 1] = y, x
    out[..., 4, :, 1], out[..., 4, :, 2] = z, y
    out[..., 5, :, 2], out[..., 5, :, 0] = x, z
    return out.reshape(*gradient.shape[:-2], 6, 3 * gradient.shape[-1])


def with_rotations(blocks: FloatArray) -> FloatArray:
    """(n, 6 n_node, 6 n_node) from matrices of the translations (n, 3 n_node, 3 n_node); rotations get zeros."""
    n, d, _ = blocks.shape
    out = np.zeros((n, d // 3, 6, d // 3, 6))
    out[:, :, :3, :, :3] = blocks.reshape(n, d // 3, 3, d // 3, 3)
    return out.reshape(n, 2 * d, 2 * d)


def isoparametric_stiffness(
    coords: FloatArray, section: SolidSection, own: Own = COMMON, *, reference: Reference
) -> FloatArray:
    """K = integral of B' D B of displacements alone, (n, 6 n_node, 6 n_node)."""

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        inverse, det = jacobians(piece, reference.slopes)
        operator = strains(inverse @ reference.slopes)
        return with_rotations(weighted_gram(operator, elasticity(section.material, mine), det * reference.weights))

    return _over_block(kernel, coords, reference, own)


def consistent_mass(
    coords: FloatArray, section: SolidSection, own: Own = COMMON, *, reference: Reference
) -> FloatArray:
    """M = integral of rho N_i N_j on each translation, (n, 6 n_node, 6 n_node); rotations have no mass."""
    products = np.einsum("gi,gj,g->gij", reference.shapes, reference.shapes, reference.weights)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        det = np.linalg.det(np.einsum("gai,nix->ngax", reference.slopes, piece))
        out = np.zeros((len(piece), reference.n_node, 6, reference.n_node, 6))
        for axis in range(3):
            out[:, :, axis, :, axis] = section.material.density * np.einsum("ng,gij->nij", det, products)
        return out.reshape(len(piece), 6 * reference.n_node, 6 * reference.n_node)

    return _over_block(kernel, coords, reference, own)


def _over_block(
    kernel: Callable[[FloatArray, Own], FloatArray], coords: FloatArray, reference: Reference, own: Own
) -> FloatArray:
    coords = np.asarray(coords, dtype=np.float64)
    require_volume(coords, reference.slopes)
    return in_chunks(kernel, coords, 6 * reference.n_node, own)
