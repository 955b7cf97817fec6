"""What solid elements share: Hooke's law, strains from gradients, the consistent mass, rotations left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import DEGENERATE, in_chunks, require_sound
from creak.elements.shell_common import weighted_gram
from creak.model.materials import Material, SolidSection


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


def hooke(material: Material) -> FloatArray:
    """D (6, 6), force / length^2: stresses xx, yy, zz, xy, yz, zx from strains exx, eyy, ezz, 2 exy, 2 eyz, 2 ezx."""
    shear, nu = material.shear_modulus, material.poisson_ratio
    D = np.diag([2.0 * shear] * 3 + [shear] * 3)
    D[:3, :3] += 2.0 * shear * nu / (1.0 - 2.0 * nu)
    return D


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


def isoparametric_stiffness(coords: FloatArray, section: SolidSection, reference: Reference) -> FloatArray:
    """K = integral of B' D B of displacements alone, (n, 6 n_node, 6 n_node)."""
    D = hooke(section.material)

    def kernel(piece: FloatArray) -> FloatArray:
        inverse, det = jacobians(piece, reference.slopes)
        operator = strains(inverse @ reference.slopes)
        return with_rotations(weighted_gram(operator, D, det * reference.weights))

    return _over_block(kernel, coords, reference)


def consistent_mass(coords: FloatArray, section: SolidSection, reference: Reference) -> FloatArray:
    """M = integral of rho N_i N_j on each translation, (n, 6 n_node, 6 n_node); rotations have no mass."""
    products = np.einsum("gi,gj,g->gij", reference.shapes, reference.shapes, reference.weights)

    def kernel(piece: FloatArray) -> FloatArray:
        det = np.linalg.det(np.einsum("gai,nix->ngax", reference.slopes, piece))
        out = np.zeros((len(piece), reference.n_node, 6, reference.n_node, 6))
        for axis in range(3):
            out[:, :, axis, :, axis] = section.material.density * np.einsum("ng,gij->nij", det, products)
        return out.reshape(len(piece), 6 * reference.n_node, 6 * reference.n_node)

    return _over_block(kernel, coords, reference)


def _over_block(
    kernel: Callable[[FloatArray], FloatArray], coords: FloatArray, reference: Reference
) -> FloatArray:
    coords = np.asarray(coords, dtype=np.float64)
    require_volume(coords, reference.slopes)
    return in_chunks(kernel, coords, 6 * reference.n_node)
