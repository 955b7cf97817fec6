"""Bending and transverse shear of the four-node shell: tied shear, curvature that varies, edge layers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray
from creak.elements.shells.quad4_geometry import (
    CENTRE,
    Surface,
    bending_strains,
    directors,
    evaluate,
    inverse_2x2,
    shape,
    shape_derivatives,
    strain_transform,
    tangents,
)
from creak.elements.shells.rigidity import Rigidity

SHEAR_TYING = np.array([[0.0, 1.0], [0.0, -1.0], [1.0, 0.0], [-1.0, 0.0]])
"""Mid-edge points: the first two tie the shear strain along r, the last two along s."""
ALONG = np.array([[0.5, 1.5, 1.0], [1.5, 0.5, 1.0]])
"""P of what varies along r and along s, see `varying_curvature`: (rr, ss, rs)."""
THIN_TWIST, THICK_TWIST = 3.0, 8.0
"""Energy of twist that varies, over that of bilinear rotations, in thin and in thick elements, see `_twist_factor`."""
LEAST = 0.5
"""Least share of the energy of varying curvature that the correction for waves leaves in any direction."""
LAYERS = 9.0
"""An element takes at most 1/(1 + 9/z^2) of the shear for bending of its own, z its half-width in layers."""
SLENDER = 3.0
"""Length over width above which an element at a free edge is taken for a part of a strip."""
NODAL = np.sqrt(3.0)
"""What is linear over an element is this much larger at its nodes than at its 2 x 2 points."""
ROUND_OFF = 1e-12
"""Added to the unit diagonal of D, so that a section without bending stiffness is no division by 0."""
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


@dataclass(frozen=True)
class Sides:
    """The element as seen along r and along s, each (n, 2), and its stiffness in covariant components."""

    length: FloatArray
    width: FloatArray
    bending: FloatArray
    """D of the curvature along the direction."""
    shear: FloatArray
    """S of the shear strain along it."""
    layers: FloatArray
    """z = (width/2) (S/D_t)^(1/2), D_t of the twist: half the width in layers of free edges."""
    frame: FloatArray
    """(n, 3, 3) strains in local axes from covariant ones, at the centre."""
    covariant: FloatArray
    """(n, 3, 3) mean D on (rr, ss, 2 rs)."""


def sides_of(coords: FloatArray, surface: Surface, bending: FloatArray, stiff: Rigidity) -> Sides:
    """Lengths and stiffness along r and s, means over the element."""
    middle = np.stack([surface.x_r.mean(axis=1), surface.x_s.mean(axis=1)], axis=1)
    length = 2.0 * np.linalg.norm(middle, axis=2)
    width = surface.weights.sum(axis=1)[:, None] / length
    cosines = np.einsum("nax,nex->nea", surface.axes.mean(axis=1)[:, :2], middle)
    cosines = cosines / np.linalg.norm(cosines, axis=2, keepdims=True)
    c, s = cosines[..., 0], cosines[..., 1]
    D, S = _mean_of(bending, surface), _mean_of(stiff.S, surface)
    along, twist = np.stack([c * c, s * s, 2.0 * c * s], axis=-1), np.stack([-c * s, c * s, c * c - s * s], axis=-1)
    bent, twisted, sheared = _along(along, D), _along(twist, D), _along(cosines, S)
    ratio = np.divide(sheared, twisted, out=np.zeros_like(twisted), where=twisted > 0.0)
    frame = strain_transform(evaluate(coords, CENTRE, np.array([4.0])).inverse)[:, 0]
    layers = np.maximum(0.5 * width * np.sqrt(ratio), SMALL)
    return Sides(length, width, bent, sheared, layers, frame, frame.transpose(0, 2, 1) @ D @ frame)


def curvature(coords: FloatArray, surface: Surface) -> FloatArray:
    """(n, n_point, 3, 24): the part of the strains that is linear in z."""
    return bending_strains(directors(coords), shape_derivatives(surface.points), surface)


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


def varying_curvature(
    operator: FloatArray, surface: Surface, shear: TiedShear, sides: Sides, free: BoolArray | None, *, softened: bool
) -> tuple[FloatArray, TiedShear]:
    """(n, n_point, 3, 24) curvature whose variation has the energy of a plate, and the shear strains that are left.

    `operator` is that of bilinear rotations: along r they give no kappa_rr that varies. Rotations (1 - r^2) of the
    element's own do, v = (3 tau, kappa_ss,r, kappa_rs,r), where tau is what they take of the mean shear strain gamma:

        tau = sigma gamma + (1 - sigma) tau_0,   1/sigma = 1 + (12/S) D/L^2 + 9/z^2

    tau_0 is the one of least energy v' T v, which frees bending of Poisson's ratio times that across: without it,
    sections with D_12 near D_11 lock. The term of the length is that of a beam (MacNeal, Computers and Structures 8
    (1978) 175); z keeps the shear of elements that are narrow enough to resolve the layers at free edges, and
    elements with two free sides have no neighbour to keep it for.

    T = D + q (P D + D P - D), P = diag(1/2, 3/2, 1), makes a wave of number k across a thin plate exact to (kh)^4. The
    mean over the element of what nodal rotations give is cos(kh/2)/(sin(kh/2)/(kh/2)) times that of the wave: (kh)^2
    (1/24, 1/8, 1/12) are missing of kappa_rr, kappa_ss, kappa_rs, and the energy of what varies, (kh)^2/12, gives it
    back. q = 1 where T >= `LEAST` D, less where D_12 is too near D_11. Constant curvature sees nothing of all this.

    Where a long side is free (`free`, (n, 4) of each side), what varies along it counts (3 W/L)^10 times as much where
    L > 3 W. Anticlastic bending of a strip settles within some W/3 of a clamped end, linear rotations spread that over
    all of L. The 3 and the 10 are a choice.

    softened : T = D, 1/sigma = 1 + (12/S) D/L^2.
    """
    sigma = _taken_share(sides, free, softened)
    back, lifted = np.linalg.inv(sides.frame), []
    taken = np.empty_like(shear.mean)
    for axis, at in enumerate(surface.points.T):
        v = back @ (0.25 * NODAL * np.einsum("g,ngij->nij", np.sign(at), operator))
        lift, across = np.broadcast_to(np.eye(3), back.shape), [1 - axis, 2]
        if not softened:
            v[:, 2] *= _twist_factor(sides.layers[:, axis])[:, None]
            v *= _strip_factor(sides, free, axis)[:, None, None]
            lift = _lift(sides.covariant, axis)
        T = lift.transpose(0, 2, 1) @ sides.covariant @ lift
        freed = -_over(T[:, axis, across], T[:, axis, axis, None])[:, None] @ v[:, across]
        share = sigma[:, axis, None]
        taken[:, axis] = share * shear.mean[:, axis] + (1.0 - share) * freed[:, 0] / 3.0
        v[:, axis] += 3.0 * taken[:, axis]
        lifted.append(sides.frame @ lift @ v)
    r, s = surface.points.T[:, :, None, None]
    mixed = 0.75 * np.einsum("g,ngij->nij", np.sign(r * s)[:, 0, 0], operator)
    varying = r * lifted[0][:, None] + s * lifted[1][:, None] + r * s * mixed[:, None]
    curved = _mean(operator, surface) + varying - _mean(varying, surface)
    return np.asarray(curved, dtype=np.float64), TiedShear(shear.mean - taken, shear.slope)


def layered_shear(operator: FloatArray, surface: Surface, sides: Sides) -> FloatArray:
    """Shear strains whose deviation from the mean over the element has the energy of the layers at free edges.

    A twisted strip of width b has D_t gamma'' = S gamma across it, layers of thickness (D_t/S)^(1/2). Linear strain
    overestimates their energy; the factor 3 (z coth z - 1)/z^2, z = (b/2)(S/D_t)^(1/2), makes the torsional stiffness
    of one element exact: 4 D_t b (1 - tanh(z)/z). It tends to 1 on fine meshes and leaves constant shear alone.
    """
    mean, z = _mean(operator, surface), sides.layers
    factor = np.sqrt(3.0 * (z / np.tanh(z) - 1.0)) / z
    scale = surface.inverse @ (factor[:, None, :, None] * inverse_2x2(surface.inverse))
    return np.asarray(mean + scale @ (operator - mean), dtype=np.float64)


def _taken_share(sides: Sides, free: BoolArray | None, softened: bool) -> FloatArray:
    """sigma (n, 2) of `varying_curvature`."""
    layers = np.zeros_like(sides.layers) if softened else LAYERS / sides.layers**2
    if free is not None:
        layers = np.where(free[:, :2] & free[:, 2:], 0.0, layers)
    return _over(sides.shear, sides.shear * (1.0 + layers) + 12.0 * sides.bending / sides.length**2)


def _twist_factor(z: FloatArray) -> FloatArray:
    """(n,): varying twist over that of bilinear rotations.

    2, with P_33 = 1, is that of a wave, 8 times the energy. Thin elements hold their twist by shear that varies too
    and are too stiff on coarse meshes with more than 3, the energy at the nodes; (tanh(z)/z)^2 leads from 8 to 3.
    """
    return np.asarray(
        np.sqrt(0.5 * (THIN_TWIST + (THICK_TWIST - THIN_TWIST) * (np.tanh(z) / z) ** 2)), dtype=np.float64
    )


def _strip_factor(sides: Sides, free: BoolArray | None, axis: int) -> FloatArray:
    """(n,): (3 W/L)^5 of long elements whose side along `axis` is free, else 1."""
    if free is None:
        return np.ones(len(sides.length))
    slender = np.minimum(1.0, SLENDER * sides.width[:, axis] / sides.length[:, axis])
    return np.where(free[:, axis] | free[:, axis + 2], slender**5, 1.0)


def _lift(covariant: FloatArray, axis: int) -> FloatArray:
    """L (n, 3, 3) with L' D L = T of `varying_curvature`, by symmetric roots: the same whatever the first node."""
    scale = np.sqrt(np.einsum("nii->ni", covariant))
    scale[scale == 0.0] = 1.0
    D = covariant / (scale[:, :, None] * scale[:, None, :]) + ROUND_OFF * np.eye(3)
    P = ALONG[axis]
    values, vectors = np.linalg.eigh(D)
    root, back = (_with_values(vectors, np.sqrt(values) ** power) for power in (1, -1))
    values, vectors = np.linalg.eigh(back @ (D * (P[:, None] + P - 1.0)) @ back)
    q = np.minimum(1.0, (1.0 - LEAST) / np.maximum(-values[:, 0], ROUND_OFF))
    lift = back @ _with_values(vectors, np.sqrt(1.0 + q[:, None] * values)) @ root
    return np.asarray(lift / scale[:, :, None] * scale[:, None, :], dtype=np.float64)


def _with_values(vectors: FloatArray, values: FloatArray) -> FloatArray:
    """V diag(values) V'."""
    return np.asarray((vectors * values[:, None]) @ vectors.transpose(0, 2, 1), dtype=np.float64)


def _along(direction: FloatArray, stiffness: FloatArray) -> FloatArray:
    """(n, 2): v' C v of v (n, 2, d), C (n, d, d)."""
    return np.asarray(((direction @ stiffness) * direction).sum(axis=2), dtype=np.float64)


def _over(above: FloatArray, below: FloatArray) -> FloatArray:
    """above / below, 0 where below is."""
    return np.divide(above, below, out=np.zeros_like(above), where=below > 0.0)


def _mean_of(matrix: FloatArray, surface: Surface) -> FloatArray:
    """(n, d, d): mean over the area of a section matrix, one for all or one for each point."""
    each = np.broadcast_to(matrix, (*surface.weights.shape, *matrix.shape[-2:]))
    return np.asarray(np.einsum("nog,ngij->nij", _share(surface), each), dtype=np.float64)


def _mean(operator: FloatArray, surface: Surface) -> FloatArray:
    """(n, 1, m, d): mean over the area."""
    n, n_point, m, d = operator.shape
    return np.asarray((_share(surface) @ operator.reshape(n, n_point, m * d)).reshape(n, 1, m, d), dtype=np.float64)


def _share(surface: Surface) -> FloatArray:
    """(n, 1, n_point): part of the area that a point stands for."""
    return np.asarray((surface.weights / surface.weights.sum(axis=1, keepdims=True))[:, None], dtype=np.float64)
