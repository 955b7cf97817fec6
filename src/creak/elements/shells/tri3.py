"""Three-node flat shell: MITC3+ bending and shear, optimal ANDES membrane with drilling rotations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import (
    DEGENERATE,
    gauss_triangle,
    in_chunks,
    require_sound,
    rotate_to_global,
    turn_to_global,
    unit,
)
from creak.elements.shells.common import mean_normal, shell_mass, stressed_stiffness
from creak.elements.shells.quad4_membrane import condensed
from creak.elements.shells.rigidity import Rigidity, heat_resultants, rigidity
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import COMMON, Own

MEMBRANE_DOFS = np.array([0, 1, 5, 6, 7, 11, 12, 13, 17])
"""(ux, uy, rz) of the three nodes in local axes."""
PLATE_DOFS = np.array([2, 3, 4, 8, 9, 10, 14, 15, 16, 18, 19])
"""(uz, rx, ry) of the three nodes in local axes, then (rx, ry) of the bubble."""
CENTRE = np.full((1, 3), 1.0 / 3.0)
TYING_SHIFT = 1e-4
"""Distance of the inner tying points from the centroid (Lee, Lee and Bathe 2014)."""


def stiffness(coords: FloatArray, section: ShellSection | GeneralShell, own: Own = COMMON) -> FloatArray:
    """Stiffness of flat triangular shells.

    K = K_membrane(ux, uy, rz) + K_plate(uz, rx, ry) in the plane of the element, turned to global axes.
    The membrane is Felippa's optimal ANDES triangle, which is exact in in-plane bending of a rectangle cut
    along its diagonal; bending and shear are MITC3+, good from thin to moderately thick plates. Drilling
    rotations of neighbours in different planes work against bending: doubly curved shells that bend without
    stretching are too stiff until L^2 < 2 R t (element side L, radius R). Use quadrilaterals there.
    """
    _require_area(coords)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        frame, plane = _to_plane(piece)
        stiff = _one_each(rigidity(section, frame[:, None], mine, CENTRE))
        return rotate_to_global(condensed(_local(plane, stiff), 18), frame)

    return in_chunks(kernel, coords, 18, own)


def _local(plane: FloatArray, stiff: Rigidity) -> FloatArray:
    """(n, 20, 20) in local axes, with the two rotations of the bubble."""
    local = np.zeros((plane.shape[0], 20, 20))
    local[:, MEMBRANE_DOFS[:, None], MEMBRANE_DOFS] = _membrane(plane, stiff)
    local[:, PLATE_DOFS[:, None], PLATE_DOFS] = _plate(plane, stiff)
    if stiff.B is not None:
        across = _coupling(plane, stiff.B)
        local[:, MEMBRANE_DOFS[:, None], PLATE_DOFS] += across
        local[:, PLATE_DOFS[:, None], MEMBRANE_DOFS] += across.transpose(0, 2, 1)
    return local


def heat_load(coords: FloatArray, section: ShellSection | GeneralShell, own: Own, rise: FloatArray) -> FloatArray:
    """Of the mean rise: N on the mean membrane strain, M on the mean curvature."""
    frame, plane = _to_plane(coords)
    N, M = (r[:, 0, :, None] for r in heat_resultants(section, frame[:, None], own, CENTRE, rise))
    local = np.zeros((len(coords), 20))
    local[:, MEMBRANE_DOFS] = (_force_lumping(plane) @ N)[..., 0]
    if M.any():
        mean = _mean_curvature(plane).transpose(0, 2, 1)
        local[:, PLATE_DOFS] = _plane_area(plane)[:, None] * (mean @ M)[..., 0]
    return turn_to_global(local[:, :18], frame)


def geometric_stiffness(
    coords: FloatArray, section: ShellSection | GeneralShell, own: Own, u: FloatArray
) -> FloatArray:
    """Of the membrane force that displacements u (n, 3, 6) leave, see `stressed_stiffness`."""
    frame, plane = _to_plane(coords)
    stiff = _one_each(rigidity(section, frame[:, None], own, CENTRE))
    area = _plane_area(plane)
    local = (u.reshape(len(u), 3, 2, 3) @ frame.transpose(0, 2, 1)[:, None]).reshape(len(u), 18, 1)
    force = stiff.A @ (_force_lumping(plane).transpose(0, 2, 1) @ local[:, MEMBRANE_DOFS] / area[:, None, None])
    jacobian = np.stack([plane[:, 1] - plane[:, 0], plane[:, 2] - plane[:, 0]], axis=1)
    inverse = np.linalg.inv(jacobian).astype(np.float64)
    if stiff.B is not None:
        force = force + stiff.B @ (_curvature(inverse, CENTRE[0])[:, :, :9] @ local[:, PLATE_DOFS[:9]])
    points, weights = gauss_triangle()
    L = np.column_stack([1.0 - points.sum(axis=1), points])
    slopes = np.broadcast_to(np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]), (len(points), 2, 3))
    after = np.roll(slopes, -1, axis=2)
    edges = 4.0 * (L[:, None] * after + np.roll(L, -1, axis=1)[:, None] * slopes)
    along, over = inverse[:, None] @ slopes, inverse[:, None] @ edges
    return stressed_stiffness(
        coords, frame[:, 2], along, over, force[:, [[0, 2], [2, 1]], 0], area[:, None] * weights, section
    )


def _one_each(stiff: Rigidity) -> Rigidity:
    """Matrices (n, 1, k, k) as (n, k, k)."""
    B = None if stiff.B is None else _squeezed(stiff.B)
    return replace(stiff, A=_squeezed(stiff.A), B=B, D=_squeezed(stiff.D), S=_squeezed(stiff.S))


def _squeezed(matrix: FloatArray) -> FloatArray:
    return matrix[:, 0] if matrix.ndim == 4 else matrix


def mass(coords: FloatArray, section: ShellSection | GeneralShell, own: Own = COMMON) -> FloatArray:
    """Consistent mass of flat triangular shells with rotary inertia, see `shell_mass`; drilling is stiff: all of it."""
    _require_area(coords)
    points, weights = gauss_triangle()
    r, s = points[:, 0], points[:, 1]
    shapes = np.column_stack([1 - r - s, r, s])
    edges = 4.0 * shapes * np.roll(shapes, -1, axis=1)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        area = _area(piece)[:, None] * weights
        return shell_mass(piece, mean_normal(piece), area, shapes, edges, section, mine, spin=1.0)

    return in_chunks(kernel, coords, 18, own)


def _area(coords: FloatArray) -> FloatArray:
    """Areas (n,)."""
    normal = np.cross(coords[:, 1] - coords[:, 0], coords[:, 2] - coords[:, 0])
    return 0.5 * np.linalg.norm(normal, axis=1)


def _require_area(coords: FloatArray) -> None:
    """Raise `DegenerateElement` for triangles whose height is nothing against their longest side."""
    sides = coords - np.roll(coords, 1, axis=1)
    longest = (sides**2).sum(axis=2).max(axis=1)
    require_sound(~(_area(coords) > DEGENERATE * longest), "the element has no area")


def _to_plane(coords: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Local axes (n, 3, 3) as rows and the node coordinates (n, 3, 2) in the plane, from node 1."""
    edge = coords[:, 1] - coords[:, 0]
    e1 = unit(edge)
    e3 = unit(np.cross(edge, coords[:, 2] - coords[:, 0]))
    frame = np.stack([e1, np.cross(e3, e1), e3], axis=1)
    plane = np.einsum("nic,nac->nia", coords - coords[:, :1], frame[:, :2])
    return frame, plane


def _membrane(plane: FloatArray, stiff: Rigidity) -> FloatArray:
    """Optimal ANDES triangle: K = L D L'/(A t) + 3/4 beta0 T' K_theta T, with t D the rigidity A of the section.

    Felippa, Comput. Methods Appl. Mech. Eng. 192 (2003) 2125, parameters OPT.

    Parameters
    ----------
    plane : (n, 3, 2) node coordinates.
    stiff : of the section.

    Returns
    -------
    (n, 9, 9) on (ux, uy, rz) of each node.
    """
    area = _plane_area(plane)
    lumping = _force_lumping(plane)
    basic = (lumping @ stiff.A @ lumping.transpose(0, 2, 1)) / area[:, None, None]
    beta0 = max(0.5 * (1.0 - 4.0 * stiff.poisson**2), 0.01)
    hierarchical = _deviatoric_rotation(plane)
    bending = _higher_order(plane, stiff.A)
    factor = (0.75 * beta0 * area)[:, None, None]
    return basic + factor * (hierarchical.transpose(0, 2, 1) @ bending @ hierarchical)


def _plane_area(plane: FloatArray) -> FloatArray:
    a, b = plane[:, 1] - plane[:, 0], plane[:, 2] - plane[:, 0]
    return 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _force_lumping(plane: FloatArray) -> FloatArray:
    """L / t (n, 9, 3): nodal forces of a constant stress, drilling moments with alpha = 3/2."""
    x, y = plane[:, :, 0], plane[:, :, 1]
    out = np.zeros((plane.shape[0], 3, 3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        x_kj, y_jk = x[:, k] - x[:, j], y[:, j] - y[:, k]
        x_ki, x_ij = x[:, k] - x[:, i], x[:, i] - x[:, j]
        y_ik, y_ji = y[:, i] - y[:, k], y[:, j] - y[:, i]
        out[:, i, 0, 0] = out[:, i, 1, 2] = 0.5 * y_jk
        out[:, i, 1, 1] = out[:, i, 0, 2] = 0.5 * x_kj
        out[:, i, 2, 0] = 0.125 * y_jk * (y_ik - y_ji)
        out[:, i, 2, 1] = 0.125 * x_kj * (x_ki - x_ij)
        out[:, i, 2, 2] = 0.25 * (x_ki * y_ik - x_ij * y_ji)
    return out.reshape(-1, 9, 3)


def _deviatoric_rotation(plane: FloatArray) -> FloatArray:
    """T (n, 3, 9): nodal rotations less the mean rotation of the linear displacement field."""
    x, y = plane[:, :, 0], plane[:, :, 1]
    four_area = 4.0 * _plane_area(plane)
    out = np.zeros((plane.shape[0], 3, 3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[:, :, i, 0] = ((x[:, k] - x[:, j]) / four_area)[:, None]
        out[:, :, i, 1] = ((y[:, k] - y[:, j]) / four_area)[:, None]
        out[:, i, i, 2] = 1.0
    return out.reshape(-1, 3, 9)


def _higher_order(plane: FloatArray, d_matrix: FloatArray) -> FloatArray:
    """K_theta / area (n, 3, 3) = Q4' E Q4 + Q5' E Q5 + Q6' E Q6 in natural strains along the sides."""
    area = _plane_area(plane)
    side = np.roll(plane, -1, axis=1) - plane  # sides 21, 32, 13
    length2 = (side**2).sum(axis=2)
    to_cartesian = _natural_to_cartesian(side, length2)
    natural = to_cartesian.transpose(0, 2, 1) @ d_matrix @ to_cartesian
    corner = [
        (2.0 * area / 3.0)[:, None, None] * np.array(table, dtype=float) / length2[:, :, None]
        for table in (
            [[1, 2, 1], [0, 1, -1], [-1, -1, -2]],
            [[-2, -1, -1], [1, 1, 2], [-1, 0, 1]],
            [[1, -1, 0], [-1, -2, -1], [2, 1, 1]],
        )
    ]
    total = np.zeros_like(natural)
    for i in range(3):
        mid = 0.5 * (corner[i] + corner[(i + 1) % 3])
        total += mid.transpose(0, 2, 1) @ natural @ mid
    return total


def _natural_to_cartesian(side: FloatArray, length2: FloatArray) -> FloatArray:
    """T_e (n, 3, 3): (exx, eyy, 2 exy) from the strains along the sides 21, 32, 13.

    It is the inverse of rows (c^2, s^2, c s) of the side directions.
    """
    dx, dy = side[:, :, 0], side[:, :, 1]
    rows = np.stack([dx * dx, dy * dy, dx * dy], axis=2) / length2[:, :, None]
    return np.linalg.inv(rows).astype(np.float64)


def _coupling(plane: FloatArray, B: FloatArray) -> FloatArray:
    """(n, 9, 11): area e' B k of the mean membrane strain e = L' u / area and the mean curvature k.

    The membrane's basic part has that constant strain, so membrane, coupling and bending together are the
    energy of one field and positive wherever [A B; B D] is.
    """
    return np.asarray(_force_lumping(plane) @ B @ _mean_curvature(plane), dtype=np.float64)


def _mean_curvature(plane: FloatArray) -> FloatArray:
    """(n, 3, 11): mean over the element; the bubble, whose slopes have no mean, has no part in it."""
    points, weights = gauss_triangle()
    jacobian = np.stack([plane[:, 1] - plane[:, 0], plane[:, 2] - plane[:, 0]], axis=1)
    inverse = np.linalg.inv(jacobian).astype(np.float64)
    each = [w * _curvature(inverse, point) for point, w in zip(points, weights, strict=True)]
    return np.asarray(sum(each), dtype=np.float64)


def _plate(plane: FloatArray, stiff: Rigidity) -> FloatArray:
    """MITC3+ plate: bending and tied shear with a rotation bubble, which the caller condenses out.

    Lee, Lee and Bathe, Comput. Struct. 138 (2014) 12.

    Parameters
    ----------
    plane : (n, 3, 2) node coordinates.
    stiff : of the section.

    Returns
    -------
    (n, 11, 11) on (uz, rx, ry) of each node and (rx, ry) of the bubble.
    """
    points, weights = gauss_triangle()
    jacobian = np.stack([plane[:, 1] - plane[:, 0], plane[:, 2] - plane[:, 0]], axis=1)
    inverse = np.linalg.inv(jacobian).astype(np.float64)
    area = _plane_area(plane)
    full = np.zeros((plane.shape[0], 11, 11))
    for point, weight in zip(points, weights, strict=True):
        curvature = _curvature(inverse, point)
        gamma = inverse @ _tied_shear(jacobian, point)
        full += weight * (curvature.transpose(0, 2, 1) @ stiff.D @ curvature)
        full += weight * (gamma.transpose(0, 2, 1) @ stiff.S @ gamma)
    return np.asarray(full * area[:, None, None], dtype=np.float64)


def _rotation_shapes(point: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation functions f (4,) and df (2, 4) at (r, s): linear, and f4 = 27 r s (1-r-s)."""
    r, s = point
    q = 1.0 - r - s
    bubble = 27.0 * r * s * q
    slope = 27.0 * np.array([s * (q - r), r * (q - s)])
    f = np.array([q - bubble / 3, r - bubble / 3, s - bubble / 3, bubble])
    df = np.array([[-1.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 1.0, 0.0]])
    df[:, :3] -= slope[:, None] / 3
    df[:, 3] = slope
    return f, df


def _curvature(inverse: FloatArray, point: FloatArray) -> FloatArray:
    """(n, 3, 11): d(ry)/dx, -d(rx)/dy, d(ry)/dy - d(rx)/dx on (w, rx, ry) x 3 and the bubble (rx, ry)."""
    _, df = _rotation_shapes(point)
    slope = inverse @ df
    out = np.zeros((inverse.shape[0], 3, 11))
    at_rx, at_ry = np.array([1, 4, 7, 9]), np.array([2, 5, 8, 10])
    out[:, 0, at_ry] = slope[:, 0]
    out[:, 1, at_rx] = -slope[:, 1]
    out[:, 2, at_ry] = slope[:, 1]
    out[:, 2, at_rx] = -slope[:, 0]
    return out


def _covariant_shear(jacobian: FloatArray, point: tuple[float, float]) -> FloatArray:
    """(n, 2, 11): dw/dr + beta . x_r and dw/ds + beta . x_s with beta = (ry, -rx)."""
    f, _ = _rotation_shapes(np.array(point))
    out = np.zeros((jacobian.shape[0], 2, 11))
    out[:, 0, 0] = out[:, 1, 0] = -1.0
    out[:, 0, 3] = out[:, 1, 6] = 1.0
    at_rx, at_ry = np.array([1, 4, 7, 9]), np.array([2, 5, 8, 10])
    out[:, :, at_ry] = jacobian[:, :, 0, None] * f
    out[:, :, at_rx] = -jacobian[:, :, 1, None] * f
    return out


def _tied_shear(jacobian: FloatArray, point: FloatArray) -> FloatArray:
    """(n, 2, 11) covariant shear strains at (r, s), interpolated from six tying points.

    g_r = 2/3 (g_r - g_s/2)(B) + 1/3 (g_r + g_s)(C) + c (3 s - 1)/3
    g_s = 2/3 (g_s - g_r/2)(A) + 1/3 (g_r + g_s)(C) + c (1 - 3 r)/3
    c = (g_r - g_s)(F) - g_r(D) + g_s(E)
    """
    r, s = point
    d = TYING_SHIFT
    a, b, c = (_covariant_shear(jacobian, p) for p in ((1 / 6, 2 / 3), (2 / 3, 1 / 6), (1 / 6, 1 / 6)))
    near = (1 / 3 + d, 1 / 3 - 2 * d), (1 / 3 - 2 * d, 1 / 3 + d), (1 / 3 + d, 1 / 3 + d)
    at_d, at_e, at_f = (_covariant_shear(jacobian, p) for p in near)
    twist = at_f[:, 0] - at_f[:, 1] - at_d[:, 0] + at_e[:, 1]
    common = (c[:, 0] + c[:, 1]) / 3
    g_r = (2 * b[:, 0] - b[:, 1]) / 3 + common + twist * (3 * s - 1) / 3
    g_s = (2 * a[:, 1] - a[:, 0]) / 3 + common + twist * (1 - 3 * r) / 3
    return np.stack([g_r, g_s], axis=1)
