"""Three-node flat shell: DKMT bending and shear, optimal ANDES membrane with drilling rotations."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import BoolArray, FloatArray
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
from creak.elements.shells.rigidity import Rigidity, heat_resultants, rigidity
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import COMMON, Own

MEMBRANE_DOFS = np.array([0, 1, 5, 6, 7, 11, 12, 13, 17])
"""(ux, uy, rz) of the three nodes in local axes."""
PLATE_DOFS = np.array([2, 3, 4, 8, 9, 10, 14, 15, 16])
"""(uz, rx, ry) of the three nodes in local axes."""
CENTRE = np.full((1, 3), 1.0 / 3.0)
LINEAR = np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
"""Derivatives of the linear shape functions by r and s."""


@dataclass(frozen=True)
class Sides:
    """Sides 12, 23, 31 of triangles in their plane, and what happens along them, on (w, rx, ry) of each node."""

    direction: FloatArray
    """(n, 3, 2) unit vectors."""
    length: FloatArray
    """(n, 3)."""
    bent: FloatArray
    """(n, 3, 9): rotation along the side in its middle, beyond the mean of its ends."""
    sheared: FloatArray
    """(n, 3, 9): shear strain along the side."""


def stiffness(coords: FloatArray, section: ShellSection | GeneralShell, own: Own = COMMON) -> FloatArray:
    """Stiffness of flat triangular shells.

    K = K_membrane(ux, uy, rz) + K_plate(uz, rx, ry) in the plane of the element, turned to global axes.
    The membrane is Felippa's optimal ANDES triangle, which is exact in in-plane bending of a rectangle cut
    along its diagonal; bending and shear are DKMT, good from thin to moderately thick plates, with the layers in
    which a twisting moment falls to nothing at edges (`own.free_sides`). Drilling rotations of neighbours in different
    planes work against bending: doubly curved shells that bend without stretching are too stiff until L^2 < 2 R t
    (element side L, radius R). Use quadrilaterals there.
    """
    _require_area(coords)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        frame, plane = _to_plane(piece)
        stiff = _one_each(rigidity(section, frame[:, None], mine, CENTRE))
        return rotate_to_global(_local(plane, stiff, mine.free_sides), frame)

    return in_chunks(kernel, coords, 18, own)


def _local(plane: FloatArray, stiff: Rigidity, free: BoolArray | None) -> FloatArray:
    """(n, 18, 18) in local axes.

    Membrane, coupling and bending are the energy of one field, (e, k)' [A B; B D] (e, k) of the means of membrane
    strain and curvature, and positive wherever [A B; B D] is. What varies of the curvature within the element bends the
    shell about its neutral surface.
    """
    local = np.zeros((plane.shape[0], 18, 18))
    local[:, MEMBRANE_DOFS[:, None], MEMBRANE_DOFS] = _membrane(plane, stiff)
    local[:, PLATE_DOFS[:, None], PLATE_DOFS] = _plate(plane, stiff, free)
    if stiff.B is not None:
        mean, area = _mean_curvature(plane, stiff), _plane_area(plane)[:, None, None]
        across = np.asarray(_force_lumping(plane) @ stiff.B @ mean, dtype=np.float64)
        local[:, MEMBRANE_DOFS[:, None], PLATE_DOFS] += across
        local[:, PLATE_DOFS[:, None], MEMBRANE_DOFS] += across.transpose(0, 2, 1)
        both = mean.transpose(0, 2, 1) @ (stiff.D - stiff.neutral) @ mean
        local[:, PLATE_DOFS[:, None], PLATE_DOFS] += area * both
    return local


def heat_load(coords: FloatArray, section: ShellSection | GeneralShell, own: Own, rise: FloatArray) -> FloatArray:
    """Of the mean rise: N on the mean membrane strain, M on the mean curvature."""
    frame, plane = _to_plane(coords)
    stiff = _one_each(rigidity(section, frame[:, None], own, CENTRE))
    N, M = (r[:, 0, :, None] for r in heat_resultants(section, frame[:, None], own, CENTRE, rise))
    local = np.zeros((len(coords), 18))
    local[:, MEMBRANE_DOFS] = (_force_lumping(plane) @ N)[..., 0]
    if M.any():
        mean = _mean_curvature(plane, stiff).transpose(0, 2, 1)
        local[:, PLATE_DOFS] = _plane_area(plane)[:, None] * (mean @ M)[..., 0]
    return turn_to_global(local, frame)


def geometric_stiffness(
    coords: FloatArray, section: ShellSection | GeneralShell, own: Own, u: FloatArray
) -> FloatArray:
    """Of the membrane force that displacements u (n, 3, 6) leave, see `stressed_stiffness`."""
    frame, plane = _to_plane(coords)
    stiff = _one_each(rigidity(section, frame[:, None], own, CENTRE))
    area = _plane_area(plane)
    local = (u.reshape(len(u), 3, 2, 3) @ frame.transpose(0, 2, 1)[:, None]).reshape(len(u), 18, 1)
    force = stiff.A @ (_force_lumping(plane).transpose(0, 2, 1) @ local[:, MEMBRANE_DOFS] / area[:, None, None])
    if stiff.B is not None:
        force = force + stiff.B @ (_mean_curvature(plane, stiff) @ local[:, PLATE_DOFS])
    points, weights = gauss_triangle()
    L = np.column_stack([1.0 - points.sum(axis=1), points])
    slopes = np.broadcast_to(_gradients(plane)[:, None], (len(plane), len(points), 2, 3))
    edges = 4.0 * (L[:, None] * np.roll(slopes, -1, axis=3) + np.roll(L, -1, axis=1)[:, None] * slopes)
    return stressed_stiffness(
        coords, frame[:, 2], slopes, edges, force[:, [[0, 2], [2, 1]], 0], area[:, None] * weights, section
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


def _plate(plane: FloatArray, stiff: Rigidity, free: BoolArray | None) -> FloatArray:
    """DKMT plate about its neutral surface: rotations are quadratic along the sides, less so where the shell is thick.

    beta = sum N_i beta_i + sum_k 4 N_i N_j bent_k t_k,   beta = (ry, -rx), t_k along side k from node i to j
    bent_k = -(3/2) gamma_k / (1 + f_k),   gamma_k = (w_j - w_i)/L_k + t_k . (beta_i + beta_j)/2
    f_k = 12 D_k / (S_k L_k^2),   shear strain along the side f_k / (1 + f_k) gamma_k, carried into the element by
    sum L_k (N_i grad N_j - N_j grad N_i): what varies linearly along a side is left to bending, so that a thin plate
    is a discrete Kirchhoff triangle (DKT) and a thick one a linear element.

    Katili, Int. J. Numer. Meth. Eng. 36 (1993) 1859.

    Parameters
    ----------
    plane : (n, 3, 2) node coordinates.
    stiff : of the section.

    Returns
    -------
    (n, 9, 9) on (uz, rx, ry) of each node.
    """
    points, weights = gauss_triangle()
    sides, gradients = _sides(plane, stiff), _gradients(plane)
    full = np.zeros((plane.shape[0], 9, 9))
    for (r, s), weight in zip(points, weights, strict=True):
        N = np.array([1.0 - r - s, r, s])
        curvature, gamma = _curvature(sides, gradients, N), _shear(sides, gradients, N)
        full += weight * (curvature.transpose(0, 2, 1) @ stiff.neutral @ curvature)
        full += weight * (gamma.transpose(0, 2, 1) @ stiff.S @ gamma)
    if free is not None and free.any():
        full -= _edge_layers(plane, stiff, sides, gradients, free)
    return np.asarray(full * _plane_area(plane)[:, None, None], dtype=np.float64)


def _edge_layers(
    plane: FloatArray, stiff: Rigidity, sides: Sides, gradients: FloatArray, free: BoolArray
) -> FloatArray:
    """(n, 9, 9) per area: what the layers at free sides take of the energy of twist.

    Near a free edge the twisting moment M_ts falls to nothing within a layer of thickness l = (D_t/S_t)^(1/2), where
    rotations along the edge give way: beta_t = b exp(-y/l). Eliminating b frees l M_ts^2/(2 D_t) per length of the
    edge. Of the moment in the middle of the side that is 1/3 of the element's energy of M_ts at most (the rule of the
    middles of the sides is exact), so l becomes w tanh(l^-1 w) l/w, w = A/(3 L): a layer in a strip of width w.
    Where the mesh resolves the layer there is no moment at the side, and nothing to free.
    """
    total = np.zeros((plane.shape[0], 9, 9))
    c, s = sides.direction.transpose(2, 0, 1)
    twist = np.stack([-c * s, c * s, c * c - s * s], axis=2)
    twisted = twist @ stiff.neutral
    D = (twisted * twist).sum(axis=2)
    S = ((sides.direction @ stiff.S) * sides.direction).sum(axis=2)
    there = free & (D > 0.0) & (S > 0.0)
    D, S = np.where(there, D, 1.0), np.where(there, S, 1.0)
    z = _plane_area(plane)[:, None] / (3.0 * sides.length) * np.sqrt(S / D)
    share = np.where(there, np.tanh(z) / (3.0 * z * D), 0.0)
    for k in range(3):
        N = np.full(3, 0.5)
        N[k - 1] = 0.0
        moment = twisted[:, k, None] @ _curvature(sides, gradients, N)
        total += share[:, k, None, None] * (moment.transpose(0, 2, 1) @ moment)
    return total


def _gradients(plane: FloatArray) -> FloatArray:
    """(n, 2, 3): derivatives of the linear shape functions by x and y."""
    jacobian = np.stack([plane[:, 1] - plane[:, 0], plane[:, 2] - plane[:, 0]], axis=1)
    return np.linalg.inv(jacobian).astype(np.float64) @ LINEAR


def _sides(plane: FloatArray, stiff: Rigidity) -> Sides:
    """What the sides take of the shear strain that their ends imply for bending, and what is left of it."""
    side = np.roll(plane, -1, axis=1) - plane
    length = np.linalg.norm(side, axis=2)
    direction = side / length[:, :, None]
    c, s = direction[:, :, 0], direction[:, :, 1]
    implied = np.zeros((plane.shape[0], 3, 3, 3))
    for k in range(3):
        ends = [k, (k + 1) % 3]
        implied[:, k, ends, 0] = np.array([-1.0, 1.0]) / length[:, k, None]
        implied[:, k, ends, 1] = -0.5 * s[:, k, None]
        implied[:, k, ends, 2] = 0.5 * c[:, k, None]
    along = np.stack([c * c, s * s, 2.0 * c * s], axis=2)
    bending = ((along @ stiff.neutral) * along).sum(axis=2)
    shear = ((direction @ stiff.S) * direction).sum(axis=2) * length**2
    both = shear + 12.0 * bending
    taken = np.divide(shear, both, out=np.zeros_like(both), where=both > 0.0)[:, :, None]
    strain = implied.reshape(-1, 3, 9)
    return Sides(direction, length, -1.5 * taken * strain, (1.0 - taken) * strain)


def _curvature(sides: Sides, gradients: FloatArray, N: FloatArray) -> FloatArray:
    """(n, 3, 9): d(ry)/dx, -d(rx)/dy, d(ry)/dy - d(rx)/dx at the point whose linear shape functions are N."""
    out = np.zeros((gradients.shape[0], 3, 3, 3))
    out[:, 0, :, 2] = gradients[:, 0]
    out[:, 1, :, 1] = -gradients[:, 1]
    out[:, 2, :, 2] = gradients[:, 1]
    out[:, 2, :, 1] = -gradients[:, 0]
    slope = 4.0 * (N * np.roll(gradients, -1, axis=2) + np.roll(N, -1) * gradients)
    x, y = slope.transpose(1, 0, 2)
    c, s = sides.direction.transpose(2, 0, 1)
    each = np.stack([x * c, y * s, y * c + x * s], axis=1)
    return np.asarray(out.reshape(-1, 3, 9) + each @ sides.bent, dtype=np.float64)


def _shear(sides: Sides, gradients: FloatArray, N: FloatArray) -> FloatArray:
    """(n, 2, 9): transverse shear strains at the point whose linear shape functions are N."""
    edge = N * np.roll(gradients, -1, axis=2) - np.roll(N, -1) * gradients
    return np.asarray((edge * sides.length[:, None]) @ sides.sheared, dtype=np.float64)


def _mean_curvature(plane: FloatArray, stiff: Rigidity) -> FloatArray:
    """(n, 3, 9): it is linear over the element, so it is that of the centre."""
    return _curvature(_sides(plane, stiff), _gradients(plane), CENTRE[0])
