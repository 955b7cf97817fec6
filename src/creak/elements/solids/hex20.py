"""Twenty-node hexahedron (serendipity): integrated fully, reduced, or with reduced shear.

Nodes: four corners round one face, those opposite them, then the middles of the edges of the first face (from edge 1-2
on), of the second, and of those between (1-5, 2-6, 3-7, 4-8). The rotations have no stiffness.
"""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import in_chunks, material_frames, rotate_to_global, turn_to_global
from creak.elements.shells.common import weighted_gram, weighted_sum
from creak.elements.solids.common import (
    Reference,
    elasticity,
    heat_stress,
    isoparametric_stiffness,
    jacobians,
    require_volume,
    serendipity,
    strains,
    with_rotations,
    without_turns,
)
from creak.elements.solids.hex8 import CORNERS
from creak.model.faces import MIDDLES
from creak.model.materials import SolidSection
from creak.model.mesh import COMMON, Own

NODES = np.concatenate([CORNERS, CORNERS[np.array(MIDDLES["hex20"])].mean(axis=1)])
"""(r, s, t) of the twenty nodes, in Abaqus's order."""


def reference(points: FloatArray, weights: FloatArray) -> Reference:
    """Shape functions at the points (n_point, 3)."""
    return serendipity(NODES, points, weights)


def _rule(n: int) -> Reference:
    """Gauss-Legendre, n x n x n points."""
    at, weight = np.polynomial.legendre.leggauss(n)
    points = np.stack(np.meshgrid(at, at, at, indexing="ij"), axis=-1).reshape(-1, 3)
    return reference(points, np.multiply.outer(np.outer(weight, weight), weight).ravel())


EIGHT = _rule(2)
TWENTY_SEVEN = _rule(3)
"""No hourglass modes; stiff near incompressibility and, where it is thin or its angles are far from 90 degrees, in
bending. Source: Zienkiewicz and Taylor, The Finite Element Method, vol. 1 (2000), chapter 8. Of the mass it is exact
for parallelepipeds."""


def reduced_stiffness(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """K = integral of B' D B with 2 x 2 x 2 points (C3D20R).

    Good in bending and near incompressibility. An element alone has six hourglass modes and a straight row of elements
    several, clamped or not; a mesh with two elements in each of two directions has none.
    Source: Zienkiewicz, Taylor and Too, Int. J. Numer. Meth. Eng. 3 (1971) 275.
    """
    require_volume(np.asarray(coords, dtype=np.float64), TWENTY_SEVEN.slopes)
    return isoparametric_stiffness(coords, section, own, reference=EIGHT)


def reduced_shear_stiffness(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """K with 3 x 3 x 3 points for the direct strains and 2 x 2 x 2 for all that holds shear strains.

    The strains are those in the axes of the element, the rotation nearest to the lines between the middles of
    opposite faces. No hourglass modes, good in bending, stiff near incompressibility: the way of Nastran's CHEXA with
    mid-side grids (PSOLID with IN and ISOP blank), whose own points for shear are not published in detail.
    Constant strain is exact, since both rules integrate B exactly where edges are straight.
    """
    coords = np.asarray(coords, dtype=np.float64)
    require_volume(coords, TWENTY_SEVEN.slopes)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        frames = element_axes(piece)
        local = piece @ frames.transpose(0, 2, 1)
        material = material_frames(mine, len(piece)) @ frames.transpose(0, 2, 1)
        D = elasticity(section.material, Own(axis1=material[:, 0], axis2=material[:, 1]))
        direct, rest = D[..., :3, :3], D.copy()
        rest[..., :3, :3] = 0.0
        K = _energy(local, TWENTY_SEVEN, direct) + _energy(local, EIGHT, rest)
        return with_rotations(rotate_to_global(K, frames))

    return in_chunks(kernel, coords, 120, own)


def reduced_shear_heat_load(coords: FloatArray, section: SolidSection, own: Own, rise: FloatArray) -> FloatArray:
    """integral of B' D alpha dT with the points of `reduced_shear_stiffness`."""
    frames = element_axes(coords)
    local, material = coords @ frames.transpose(0, 2, 1), material_frames(own, len(coords))
    axes = material @ frames.transpose(0, 2, 1)
    mine = Own(axis1=axes[:, 0], axis2=axes[:, 1])
    whole = np.broadcast_to(heat_stress(section.material, mine), (len(coords), 1, 6))
    direct = _direct_stress(section, mine, whole)
    total = np.zeros((len(coords), 60))
    for rule, stress in ((TWENTY_SEVEN, direct), (EIGHT, whole - direct)):
        inverse, det = jacobians(local, rule.slopes)
        at_points = stress * (rise @ rule.shapes.T)[..., None]
        total += weighted_sum(strains(inverse @ rule.slopes), at_points, det * rule.weights)
    return without_turns(turn_to_global(total, frames))


def _direct_stress(section: SolidSection, own: Own, whole: FloatArray) -> FloatArray:
    """(n, 1, 6) the share of D alpha (n, 1, 6) that direct strains make of direct strains."""
    D = elasticity(section.material, own)
    D = np.broadcast_to(D, (len(whole), 1, 6, 6))
    strain = np.linalg.solve(D, whole[..., None])[..., :3, :]
    out = np.zeros_like(whole)
    out[..., :3] = (D[..., :3, :3] @ strain)[..., 0]
    return out


def element_axes(coords: FloatArray) -> FloatArray:
    """(n, 3, 3): rows are the axes of elements (n, 20, 3), the rotation nearest to the directions r, s, t."""
    lines = np.einsum("ia,nix->nax", CORNERS, coords[:, :8])
    lines = lines / np.linalg.norm(lines, axis=2, keepdims=True)
    U, _, Vt = np.linalg.svd(lines)
    return np.asarray(U @ Vt, dtype=np.float64)


def _energy(coords: FloatArray, rule: Reference, D: FloatArray) -> FloatArray:
    """(n, 60, 60) integral of B' D B over the first strains, as many as D has."""
    inverse, det = jacobians(coords, rule.slopes)
    operator = strains(inverse @ rule.slopes)[:, :, : D.shape[-1]]
    return weighted_gram(operator, D, det * rule.weights)
