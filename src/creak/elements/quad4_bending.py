"""Bending and transverse shear of the four-node shell: tied shear, residual bending, nodal quadrature, edge layers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.elements.quad4_geometry import (
    Surface,
    directors,
    inverse_2x2,
    shape,
    shape_derivatives,
    strain_transform,
    tangents,
    zero_mean,
)
from creak.elements.shell_rigidity import Rigidity

SHEAR_TYING = np.array([[0.0, 1.0], [0.0, -1.0], [1.0, 0.0], [-1.0, 0.0]])
"""Mid-edge points: the first two tie the shear strain along r, the last two along s."""
NODAL = np.sqrt(3.0)
"""What is linear over an element is this much larger at its nodes than at its 2 x 2 points."""
SLENDER = 3.0
"""Length over width above which an element is taken for a part of a strip."""
SMALL = 1e-2
"""Half-width over layer thickness below which the layer factor is 1 to 1e-5."""


@dataclass(frozen=True)
class TiedShear:
    """gamma_r = mean_r + s slope_r, gamma_s = mean_s + r slope_s, covariant."""

    mean: FloatArray
    """(n, 2, 24)."""
    slope: FloatArray
    """(n, 2, 24)."""

    def strains(self, surface: Surface) -> FloatArray:
        """(n, n_point, 2, 24) gamma_1, gamma_2."""
        across = surface.points[None, :, ::-1, None]
        return np.asarray(surface.inverse @ (self.mean[:, None] + across * self.slope[:, None]), dtype=np.float64)


def curvature(coords: FloatArray, surface: Surface) -> FloatArray:
    """(n, n_point, 3, 24): the part of the strains that is linear in z."""
    n = coords.shape[0]
    slopes = shape_derivatives(surface.points)
    normals = directors(coords)
    v_r, v_s = np.einsum("gai,nic->angc", slopes, normals)[:, :, :, None]
    x_r, x_s = surface.x_r[:, :, None], surface.x_s[:, :, None]
    h_r, h_s = slopes[:, 0, :, None], slopes[:, 1, :, None]
    turn_r, turn_s = np.cross(normals[:, None], x_r), np.cross(normals[:, None], x_s)
    operator = np.empty((n, len(slopes), 3, 4, 6))
    operator[:, :, 0, :, :3], operator[:, :, 0, :, 3:] = h_r * v_r, h_r * turn_r
    operator[:, :, 1, :, :3], operator[:, :, 1, :, 3:] = h_s * v_s, h_s * turn_s
    operator[:, :, 2, :, :3] = h_s * v_r + h_r * v_s
    operator[:, :, 2, :, 3:] = h_s * turn_r + h_r * turn_s
    return np.asarray(strain_transform(surface.inverse) @ operator.reshape(n, -1, 3, 24), dtype=np.float64)


def nodal_curvature(operator: FloatArray, surface: Surface) -> FloatArray:
    """`curvature`, (n, n_point, 3, 24), its deviation from the mean over the element enlarged to that at the nodes.

    A wave cos(k y) that is linear between nodes at a distance h has the mean square (2 + cos kh)/6 instead of 1/2: the
    bending stiffness of a wave that varies in both directions is (kh)^2/6 too low. The trapezoidal rule is exact for
    it, and for constant curvature on any shape.

    What varies along the longer side L counts (3 W/L)^10 times as much where L > 3 W, W the shorter side. Anticlastic
    bending of a strip one element wide settles within some W/3 of a clamped end; linear rotations spread that over all
    of L, with a restraint that grows with what their varying curvature costs. The shape is all that an element can tell
    a strip from a plate by; the 3 and the 10 are a choice. Waves along such elements lose (kL)^2/4 of their bending
    stiffness, as with one point along L; plate meshes are made of shorter elements.
    """
    n, n_point, m, d = operator.shape
    spread = _nodal_weights(surface) @ operator.reshape(n, n_point, m * d)
    return np.asarray(spread.reshape(operator.shape), dtype=np.float64)


def tied_shear(coords: FloatArray) -> TiedShear:
    """gamma_a = x_,a . (theta x V) + V . u_,a sampled at mid-edges, linear in between."""
    n = coords.shape[0]
    slopes, shapes = shape_derivatives(SHEAR_TYING), shape(SHEAR_TYING)
    along = tangents(coords, SHEAR_TYING)
    normals = directors(coords)
    director = np.einsum("gi,nic->ngc", shapes, normals)
    tied = np.empty((n, 4, 4, 6))
    for k, axis in enumerate((0, 0, 1, 1)):
        tied[:, k, :, :3] = slopes[k, axis][:, None] * director[:, k, None]
        tied[:, k, :, 3:] = shapes[k][:, None] * np.cross(normals, along[axis][:, k, None])
    plus, minus = (tied.reshape(n, 2, 2, 24)[:, :, k] for k in (0, 1))
    return TiedShear(0.5 * (plus + minus), 0.5 * (plus - minus))


def bending_share(surface: Surface, bending: FloatArray, stiff: Rigidity) -> FloatArray:
    """(n, 2): share 1/(1 + phi) of the mean shear strain along r and s that bending within the element takes.

    Rotations (1 - r^2) delta along a length L and a width W give, with V = D (theta,_ss + theta,_nn), the equilibrium
    of a plate, phi = (12 D/S) (1/L^2 + 1/W^2). The term of the length is that of a beam; the width keeps the shear of
    elements that are narrow enough to resolve the layers of thickness (D/S)^(1/2) at free edges.
    """
    middle = np.stack([surface.x_r.mean(axis=1), surface.x_s.mean(axis=1)], axis=1)
    length = 2.0 * np.linalg.norm(middle, axis=2)
    width = surface.weights.sum(axis=1)[:, None] / length
    cosines = np.einsum("ngax,nex->ngea", surface.axes[:, :, :2], middle)
    cosines = cosines / np.linalg.norm(cosines, axis=3, keepdims=True)
    c, s = cosines[..., 0], cosines[..., 1]
    D = _along(np.stack([c * c, s * s, c * s], axis=-1), bending)
    S = _along(cosines, stiff.S)
    stiffer = S + 12.0 * D * (length**-2 + width**-2)
    return np.divide(S, stiffer, out=np.zeros_like(S), where=D > 0.0)


def residual_bending(
    coords: FloatArray, surface: Surface, shear: TiedShear, share: FloatArray
) -> tuple[FloatArray, TiedShear]:
    """(n, n_point, 3, 24) curvature of the rotations (1 - r^2) delta, and the shear strains that are left.

    delta = -3/2 share gamma takes its share of the mean shear strain gamma: a slender element then bends as a cubic.
    The curvature has zero mean on any shape, so constant moments see nothing of it. Local elimination of the rotation
    as in Katili, Int. J. Numer. Meth. Eng. 36 (1993) 1859, per element instead of per edge; the flexibility that it
    adds to a beam is that of MacNeal, Computers and Structures 8 (1978) 175.
    """
    taken = share[:, :, None] * shear.mean
    modes = np.zeros((len(surface.points), 3, 2))
    modes[:, 0, 0], modes[:, 1, 1] = 3.0 * surface.points.T
    curved = zero_mean(coords, surface, modes) @ taken[:, None]
    return np.asarray(curved, dtype=np.float64), TiedShear(shear.mean - taken, shear.slope)


def layered_shear(operator: FloatArray, surface: Surface, bending: FloatArray, stiff: Rigidity) -> FloatArray:
    """Shear strains whose deviation from the mean over the element has the energy of the layers at free edges.

    A twisted strip of width b has D_t gamma'' = S gamma across it, layers of thickness (D_t/S)^(1/2). Linear strain
    overestimates their energy; the factor 3 (z coth z - 1)/z^2, z = (b/2)(S/D_t)^(1/2), makes the torsional stiffness
    of one element exact: 4 D_t b (1 - tanh(z)/z). It tends to 1 on fine meshes and leaves constant shear alone.
    """
    mean = _mean(operator, surface)
    S, D = 0.5 * (stiff.S[..., 0, 0] + stiff.S[..., 1, 1]), np.asarray(bending[..., 2, 2])
    squared = np.broadcast_to(np.divide(S, D, out=np.zeros_like(D), where=D > 0.0), surface.area.shape).mean(axis=1)
    sides = np.stack([np.linalg.norm(x, axis=2).mean(axis=1) for x in (surface.x_r, surface.x_s)], axis=1)
    half_width = 0.25 * surface.weights.sum(axis=1)[:, None] / sides
    z = np.maximum(half_width * np.sqrt(squared)[:, None], SMALL)
    factor = np.sqrt(3.0 * (z / np.tanh(z) - 1.0)) / z
    scale = surface.inverse @ (factor[:, None, :, None] * inverse_2x2(surface.inverse))
    return np.asarray(mean + scale @ (operator - mean), dtype=np.float64)


def _along(direction: FloatArray, stiffness: FloatArray) -> FloatArray:
    """(n, m): v' C v, the mean over the points; v (n, n_point, m, d), C (d, d) or (n or 1, n_point or 1, d, d)."""
    return np.asarray(((direction @ stiffness) * direction).sum(axis=3).mean(axis=1), dtype=np.float64)


def _nodal_weights(surface: Surface) -> FloatArray:
    """(n, n_point, n_point): values at the points of a field whose parts that vary as r, s and r s are scaled.

    The mean over the area is kept, and so are constant fields.
    """
    r, s = np.sign(surface.points).T
    along_r, along_s = (np.linalg.norm(x.mean(axis=1), axis=1) for x in (surface.x_r, surface.x_s))
    slender = along_r / along_s
    of_r, of_s = (np.minimum(1.0, SLENDER / ratio) ** 5 for ratio in (slender, 1.0 / slender))
    signs = np.stack([r, s, r * s])
    factors = 0.25 * NODAL * np.stack([of_r, of_s, of_r * of_s], axis=1)
    scaled = np.einsum("nk,kg,kh->ngh", factors, signs, signs)
    share = _share(surface)
    scaled -= scaled.sum(axis=2, keepdims=True) * share
    return np.asarray(scaled - share @ scaled + share, dtype=np.float64)


def _mean(operator: FloatArray, surface: Surface) -> FloatArray:
    """(n, 1, m, d): mean over the area."""
    n, n_point, m, d = operator.shape
    return np.asarray((_share(surface) @ operator.reshape(n, n_point, m * d)).reshape(n, 1, m, d), dtype=np.float64)


def _share(surface: Surface) -> FloatArray:
    """(n, 1, n_point): part of the area that a point stands for."""
    return np.asarray((surface.weights / surface.weights.sum(axis=1, keepdims=True))[:, None], dtype=np.float64)
