"""Cohesive layers between two faces: tractions from the separation of the faces."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import DEGENERATE, gauss_square, in_chunks, require_sound, unit
from creak.elements.shells import quad4_geometry
from creak.elements.shells.common import weighted_gram
from creak.elements.shells.rigidity import ACROSS
from creak.elements.solids.common import with_rotations
from creak.model.materials import AnisotropicMaterial, SolidSection
from creak.model.mesh import COMMON, Own

NORMAL, SHEAR = 2, (5, 4)
"""Rows of the elasticity that hold the stiffness per area along the normal, and along both directions of the face."""


def _triangle() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Shape functions, slopes and weights at the three middles of the sides, exact to degree two."""
    points = np.array([[0.5, 0.0], [0.5, 0.5], [0.0, 0.5]])
    shapes = np.column_stack([1.0 - points.sum(axis=1), points])
    slopes = np.tile(np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]), (3, 1, 1))
    return shapes, slopes, np.full(3, 1.0 / 6.0)


def _square() -> tuple[FloatArray, FloatArray, FloatArray]:
    points, weights = gauss_square(2)
    r, s = points.T[:, :, None]
    at = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    slopes = 0.25 * np.stack([at[:, 0] * (1.0 + s * at[:, 1]), at[:, 1] * (1.0 + r * at[:, 0])], axis=1)
    return quad4_geometry.shape(points), slopes, weights


RULES = {3: _triangle(), 4: _square()}


def stiffness(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """K = integral over the middle face of B' diag(k_n, k_s, k_t) B with the separation B u.

    The separation is that of the two faces less what the rotation of the middle face makes of the distance between
    them, delta = u_top - u_bottom - omega x d, in axes along the face (the first is the projection of global x, of z
    where x is within 0.1 degree of the normal) and across it. So rigid motion separates nothing, whatever the
    thickness of the layer in the mesh. Linear: nothing opens, breaks or slides. Source: the separation of Alfano and
    Crisfield, Int. J. Numer. Meth. Eng. 50 (2001) 1701, linearised about the undeformed place.

    Nodes: those of the bottom face, then the nodes opposite them. The rotations have no stiffness.
    """
    assert isinstance(section.material, AnisotropicMaterial)
    k = section.material.elasticity.diagonal()
    D = np.diag([k[SHEAR[0]], k[SHEAR[1]], k[NORMAL]])

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        B, area = _separation(piece)
        return with_rotations(weighted_gram(B, D, area))

    return in_chunks(kernel, coords, 6 * coords.shape[1])


def mass(coords: FloatArray, section: SolidSection, own: Own = COMMON) -> FloatArray:
    """Consistent mass of a layer with `density` per area, linear between the faces."""
    k = coords.shape[1] // 2
    shapes, slopes, weights = RULES[k]

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        area = _area(_middle(piece), slopes) * weights
        one = section.material.density * np.einsum("ng,gi,gj->nij", area, shapes, shapes)
        both = np.kron(np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0, np.ones((k, k))) * np.tile(one, (1, 2, 2))
        out = np.zeros((len(piece), 2 * k, 6, 2 * k, 6))
        for axis in range(3):
            out[:, :, axis, :, axis] = both
        return out.reshape(len(piece), 12 * k, 12 * k)

    return in_chunks(kernel, coords, 12 * k)


def _middle(coords: FloatArray) -> FloatArray:
    k = coords.shape[1] // 2
    return 0.5 * (coords[:, :k] + coords[:, k:])


def _area(middle: FloatArray, slopes: FloatArray) -> FloatArray:
    """(n, n_point) area over that of the reference face."""
    tangents = np.einsum("gai,nix->ngax", slopes, middle)
    size = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2)
    extent = np.ptp(middle, axis=1).max(axis=1)
    require_sound(~(size.min(axis=1) > DEGENERATE * extent**2), "the middle face has no area")
    return np.asarray(size, dtype=np.float64)


def _separation(coords: FloatArray) -> tuple[FloatArray, FloatArray]:
    """B (n, n_point, 3, 6 k) on the translations of all nodes, and the area that each point stands for."""
    n, k = coords.shape[0], coords.shape[1] // 2
    shapes, slopes, weights = RULES[k]
    middle = _middle(coords)
    area = _area(middle, slopes) * weights
    tangents = np.einsum("gai,nix->ngax", slopes, middle)
    # (n, n_point, 3, 3) rows along the face, twice, and along its normal.
    normal = unit(np.cross(tangents[:, :, 0], tangents[:, :, 1]))
    near_x = np.hypot(normal[..., 1], normal[..., 2]) < ACROSS
    wanted = np.where(near_x[..., None], np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))
    first = unit(wanted - (wanted * normal).sum(axis=-1, keepdims=True) * normal)
    frame = np.stack([first, np.cross(normal, first), normal], axis=2)
    inverse = np.linalg.inv(np.einsum("ngax,ngbx->ngab", tangents, frame[:, :, :2]))
    gradient = inverse @ slopes
    arm = np.einsum("ngax,gi,nix->nga", frame, shapes, coords[:, k:] - coords[:, :k])
    e1, e2, e3 = (frame[:, :, a, None, :] for a in range(3))
    along1, along2 = (gradient[:, :, a, :, None] for a in range(2))
    turn = np.stack([along2 * e3, -along1 * e3, 0.5 * (along1 * e2 - along2 * e1)], axis=2)
    jump = shapes[None, :, None, :, None] * frame[:, :, :, None, :]
    carried = np.cross(turn, arm[:, :, :, None, None], axisa=2, axisb=2, axisc=2)
    B = np.stack([-jump - 0.5 * carried, jump - 0.5 * carried], axis=3)
    return B.reshape(n, len(weights), 3, 6 * k), area
