"""Eight-node hexahedron with incompatible modes."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import in_chunks
from creak.elements.shells.common import weighted_gram, weighted_sum
from creak.elements.shells.quad4_membrane import condensed_load
from creak.elements.solids.common import (
    Reference,
    consistent_mass,
    elasticity,
    heat_stress,
    jacobians,
    of_stress,
    require_volume,
    strains,
    with_rotations,
    without_turns,
)
from creak.model.materials import SolidSection
from creak.model.mesh import COMMON, Own

CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]],
    dtype=np.float64,
)
"""(r, s, t) of the eight nodes, in Abaqus's order."""


def reference(points: FloatArray, weights: FloatArray) -> Reference:
    """h_i = (1 + r r_i)(1 + s s_i)(1 + t t_i)/8 at the points (n_point, 3)."""
    factor = 1.0 + points[:, None, :] * CORNERS
    r, s, t = factor[..., 0], factor[..., 1], factor[..., 2]
    slopes = np.stack([CORNERS[:, 0] * s * t, CORNERS[:, 1] * r * t, CORNERS[:, 2] * r * s], axis=1)
    return Reference(points, weights, r * s * t / 8.0, slopes / 8.0)


GAUSS = reference(CORNERS / np.sqrt(3.0), np.ones(8))
"""2 x 2 x 2 points."""
CENTRE = reference(np.zeros((1, 3)), np.array([8.0]))


def stiffness(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """K = K_uu - K_ua K_aa^-1 K_au with strains B u + G a.

    B is the trilinear strain. G has 13 modes that are condensed out, all scaled by j0/j (Jacobian at the centre
    over that at the point), so that their mean vanishes and constant strains are exact on any shape:

    * the nine of the displacements 1 - r^2, 1 - s^2, 1 - t^2 with gradients taken at the centre, which free
      bending from parasitic shear (Wilson et al., 1973; Taylor, Beresford and Wilson, Int. J. Numer. Meth. Eng.
      10 (1976) 1211);
    * the volume strains r s, s t, t r and r s t, which leave one volume constraint per element, so that nearly
      incompressible material does not lock (Simo, Armero and Taylor, Comput. Methods Appl. Mech. Eng. 110 (1993)
      359; C3D8I of Abaqus has 13 modes too).

    Exact in bending of a rectangular block, whatever its aspect ratio. Trapezoidal elements are stiffer in bending
    (MacNeal, Int. J. Numer. Meth. Eng. 24 (1987) 1793): keep the angles near 90 degrees where one element goes
    through the thickness. Integrated with 2 x 2 x 2 points, no hourglass modes.

    Nodes: four nodes round one face, then those opposite them. The rotations have no stiffness.
    """
    coords = np.asarray(coords, dtype=np.float64)
    require_volume(coords, GAUSS.slopes)
    require_volume(coords, CENTRE.slopes)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        inverse, det = jacobians(piece, GAUSS.slopes)
        operator = np.concatenate([strains(inverse @ GAUSS.slopes), _incompatible(piece, det)], axis=3)
        full = weighted_gram(operator, elasticity(section.material, mine), det)
        kept, coupling, inner = full[:, :24, :24], full[:, 24:, :24], full[:, 24:, 24:]
        return with_rotations(kept - coupling.transpose(0, 2, 1) @ np.linalg.solve(inner, coupling))

    return in_chunks(kernel, coords, 48, own)


def stress(coords: FloatArray, section: SolidSection, own: Own, u: FloatArray) -> FloatArray:
    """(n, 8, 6) at the integration points, of translations u (n, 24) and the inner modes that go with them."""
    inverse, det = jacobians(coords, GAUSS.slopes)
    operator = np.concatenate([strains(inverse @ GAUSS.slopes), _incompatible(coords, det)], axis=3)
    D = elasticity(section.material, own)
    full = weighted_gram(operator, D, det)
    modes = -np.linalg.solve(full[:, 24:, 24:], full[:, 24:, :24] @ u[:, :, None])
    return np.asarray((D @ (operator @ np.concatenate([u[:, :, None], modes], axis=1)[:, None]))[..., 0])


def geometric_stiffness(coords: FloatArray, section: SolidSection, own: Own, u: FloatArray) -> FloatArray:
    """K_g of the stress of displacements u (n, 8, 6) and of the inner modes that go with them."""
    inverse, det = jacobians(coords, GAUSS.slopes)
    at_points = stress(coords, section, own, u[:, :, :3].reshape(len(u), 24))
    return of_stress(inverse @ GAUSS.slopes, at_points, det)


def heat_load(coords: FloatArray, section: SolidSection, own: Own, rise: FloatArray) -> FloatArray:
    """integral of B' D alpha dT, the inner modes condensed out."""
    inverse, det = jacobians(coords, GAUSS.slopes)
    operator = np.concatenate([strains(inverse @ GAUSS.slopes), _incompatible(coords, det)], axis=3)
    stress = heat_stress(section.material, own) * (rise @ GAUSS.shapes.T)[..., None]
    full = weighted_gram(operator, elasticity(section.material, own), det)
    return without_turns(condensed_load(full, weighted_sum(operator, stress, det), 24))


def mass(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """Consistent mass of the trilinear displacements, see `consistent_mass`."""
    return consistent_mass(coords, section, own, reference=GAUSS)


def _incompatible(coords: FloatArray, det: FloatArray) -> FloatArray:
    """(n, 8, 6, 13) strains of the inner modes at the integration points."""
    inverse, centre = jacobians(coords, CENTRE.slopes)
    ratio = centre / det
    size = np.cbrt(centre)[:, :, None, None]
    gradient = (size * inverse) * GAUSS.points[None, :, None, :]
    r, s, t = GAUSS.points.T
    volume = np.zeros((8, 6, 4))
    volume[:, :3] = np.stack([r * s, s * t, t * r, r * s * t], axis=1)[:, None, :]
    modes = np.concatenate([strains(gradient), np.broadcast_to(volume, (len(coords), 8, 6, 4))], axis=3)
    return ratio[:, :, None, None] * modes
