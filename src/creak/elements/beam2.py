"""Two-node beam in space, Timoshenko or Euler-Bernoulli."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import in_chunks, require_sound, rotate_to_global, turn_to_global, unit
from creak.model.materials import BeamSection
from creak.model.mesh import COMMON, Own

AXIAL, TWIST = np.array([0, 6]), np.array([3, 9])
ALONG_1, ALONG_2 = np.array([1, 5, 7, 11]), np.array([2, 4, 8, 10])
"""(deflection, rotation) of both ends: deflection along n1 turns about n2, along n2 about -n1."""
SIGN_2 = np.array([1.0, -1.0, 1.0, -1.0])
PARALLEL = 1e-6


def stiffness(coords: FloatArray, section: BeamSection, own: Own = COMMON) -> FloatArray:
    """Stiffness of straight prismatic beams: EA/L, GJ/L and exact bending with shear.

    Local axes are the tangent t from node 1 to node 2, n1 = axis 1 made perpendicular to t, and n2 = t x n1; the
    principal axes stand at `section.angle` to n1, n2. i11 resists bending about principal axis 1 (deflection along
    2), i22 about 2. With phi = 12 E I / (G A_s L^2), 0 where the shear area A_s is not given (Euler-Bernoulli):

        K = E I / (L^3 (1 + phi)) [12, 6 L, -12, 6 L; 6 L, (4 + phi) L^2, -6 L, (2 - phi) L^2; ...]

    so end loads on one element give the exact deflection. Axial force acts at the centroid, shear force and torque
    at the shear centre. No warping of open sections. Source: Przemieniecki, Theory of Matrix Structural Analysis
    (1968), section 5.6.
    """
    _require_sound(coords, section, own)
    young, shear = section.material.youngs_modulus, section.material.shear_modulus

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        length, frame = _line(piece, section, mine)
        local = np.zeros((piece.shape[0], 12, 12))
        pair = np.array([[1.0, -1.0], [-1.0, 1.0]]) / length[:, None, None]
        local[:, AXIAL[:, None], AXIAL] = young * section.area * pair
        local[:, TWIST[:, None], TWIST] = shear * section.torsion * pair
        phi1, phi2 = _shear_ratios(section, length)
        local[:, ALONG_1[:, None], ALONG_1] = young * section.i22 * _bending_stiffness(length, phi1)
        across = young * section.i11 * _bending_stiffness(length, phi2)
        local[:, ALONG_2[:, None], ALONG_2] = across * np.outer(SIGN_2, SIGN_2)
        return rotate_to_global(_off_axis(local, section, section.shear_centre), frame)

    return in_chunks(kernel, coords, 12, own)


def mass(coords: FloatArray, section: BeamSection, own: Own = COMMON) -> FloatArray:
    """Consistent mass: linear along the axis, the static deflection across it, rho (i11 + i22) in twist.

    The rotary inertia of bending belongs to the Timoshenko beam (shear areas given); Euler-Bernoulli leaves it out.
    All mass lies about the centroid. Source: Przemieniecki (1968), section 11.4; Friedman and Kosmatka, Comput.
    Struct. 47 (1993) 473, for the shape functions with shear.
    """
    _require_sound(coords, section, own)
    density = section.material.density
    line = density * section.area + section.line_mass

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        length, frame = _line(piece, section, mine)
        local = np.zeros((piece.shape[0], 12, 12))
        pair = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0 * length[:, None, None]
        local[:, AXIAL[:, None], AXIAL] = line * pair
        local[:, TWIST[:, None], TWIST] = section.polar_inertia * pair
        phi1, phi2 = _shear_ratios(section, length)
        rotary1, rotary2 = (density * section.i22, density * section.i11) if section.shear_area1 else (0.0, 0.0)
        local[:, ALONG_1[:, None], ALONG_1] = _bending_mass(length, phi1, line, rotary1)
        across = _bending_mass(length, phi2, line, rotary2)
        local[:, ALONG_2[:, None], ALONG_2] = across * np.outer(SIGN_2, SIGN_2)
        return rotate_to_global(_off_axis(local, section, section.centroid), frame)

    return in_chunks(kernel, coords, 12, own)


def geometric_stiffness(coords: FloatArray, section: BeamSection, own: Own, u: FloatArray) -> FloatArray:
    """integral of N w' w' of the static deflection in both planes; N = EA/L times the stretch of the line of centroids.

    N/(30 L) [36, 3 L, -36, 3 L; ...] without shear. Source: Przemieniecki (1968), section 15.2.
    """
    length, frame = _line(coords, section, own)
    stretch = np.einsum("ni,ni->n", frame[:, 0], u[:, 1, :3] - u[:, 0, :3])
    if any(section.centroid):
        c, s = np.cos(section.angle), np.sin(section.angle)
        c1, c2 = np.array([[c, s], [-s, c]]) @ np.array(section.centroid)
        turned = np.einsum("nai,ni->na", frame, u[:, 1, 3:] - u[:, 0, 3:])
        stretch = stretch + c2 * turned[:, 1] - c1 * turned[:, 2]
    force = section.material.youngs_modulus * section.area * stretch / length
    local = np.zeros((len(coords), 12, 12))
    phi1, phi2 = _shear_ratios(section, length)
    local[:, ALONG_1[:, None], ALONG_1] = force[:, None, None] * _slope_products(length, phi1)
    across = force[:, None, None] * _slope_products(length, phi2)
    local[:, ALONG_2[:, None], ALONG_2] = across * np.outer(SIGN_2, SIGN_2)
    return rotate_to_global(_off_axis(local, section, section.centroid), frame)


def heat_load(coords: FloatArray, section: BeamSection, own: Own, rise: FloatArray) -> FloatArray:
    """EA alpha dT [-t; t] at the centroid, dT the mean; no gradient over the section."""
    _, frame = _line(coords, section, own)
    expansion = section.material.expansion
    alpha = 0.0 if expansion is None else expansion.strain[0]
    force = section.material.youngs_modulus * section.area * alpha * rise.mean(axis=1)
    local = np.zeros((len(coords), 12))
    local[:, AXIAL] = force[:, None] * np.array([-1.0, 1.0])
    return turn_to_global(local @ _lever(section, section.centroid), frame)


def _slope_products(length: FloatArray, phi: FloatArray) -> FloatArray:
    """(n, 4, 4) integral of w' w' on (w1, theta1, w2, theta2), exact with three points."""
    at, weights = np.polynomial.legendre.leggauss(3)
    z, one = 0.5 * (at + 1.0), np.ones(3)
    w = np.stack([6 * z**2 - 6 * z, 1 - 4 * z + 3 * z**2, 6 * z - 6 * z**2, 3 * z**2 - 2 * z], axis=1)
    w_phi = np.stack([-one, 0.5 - z, one, z - 0.5], axis=1)
    W = w + phi[:, None, None] * w_phi
    total = W.transpose(0, 2, 1) @ (0.5 * weights[:, None] * W)
    return total * _scale(length) / (length * (1.0 + phi) ** 2)[:, None, None]


def _require_sound(coords: FloatArray, section: BeamSection, own: Own) -> None:
    """Raise `DegenerateElement` for beams without length or without a direction of axis 1."""
    line = coords[:, 1] - coords[:, 0]
    length = np.linalg.norm(line, axis=1)
    require_sound(~(length > 0.0), "the two nodes coincide")
    axis = _axis1(section, own)
    sine = np.linalg.norm(np.cross(line, axis), axis=1)
    parallel = ~(sine > PARALLEL * length * np.linalg.norm(axis, axis=-1))
    shown = f", {section.axis1}," if own.axis1 is None else ""
    require_sound(parallel, f"axis 1 of the section{shown} is parallel to the beam")


def _axis1(section: BeamSection, own: Own) -> FloatArray:
    return np.array(section.axis1, dtype=float) if own.axis1 is None else own.axis1


def _line(coords: FloatArray, section: BeamSection, own: Own) -> tuple[FloatArray, FloatArray]:
    """Lengths (n,) and local axes (n, 3, 3) with rows t and principal axes 1, 2."""
    line = coords[:, 1] - coords[:, 0]
    length = np.linalg.norm(line, axis=1)
    tangent = line / length[:, None]
    second = unit(np.cross(tangent, _axis1(section, own)))
    first = np.cross(second, tangent)
    if section.angle:
        c, s = np.cos(section.angle), np.sin(section.angle)
        first, second = c * first + s * second, c * second - s * first
    return length, np.stack([tangent, first, second], axis=1)


def _off_axis(local: FloatArray, section: BeamSection, point: tuple[float, float]) -> FloatArray:
    """Matrices on the dofs of the nodes' line, from those that act at the centroid (axial) and at `point` (across).

    u_t = u_t0 + x2 r_1 - x1 r_2,  u_1 = u_10 - x2 r_t,  u_2 = u_20 + x1 r_t at (x1, x2) of a section.
    """
    if not any((*section.centroid, *section.shear_centre)):
        return local
    T = _lever(section, point)
    return np.asarray(T.T @ local @ T, dtype=np.float64)


def _lever(section: BeamSection, point: tuple[float, float]) -> FloatArray:
    """(12, 12) motion of the centroid (axial) and of `point` (across) from that of the nodes' line."""
    c, s = np.cos(section.angle), np.sin(section.angle)
    turn = np.array([[c, s], [-s, c]])
    (c1, c2), (s1, s2) = turn @ np.array(section.centroid), turn @ np.array(point)
    one = np.eye(6)
    one[0, 4], one[0, 5], one[1, 3], one[2, 3] = c2, -c1, -s2, s1
    return np.asarray(np.kron(np.eye(2), one), dtype=np.float64)


def _shear_ratios(section: BeamSection, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """phi (n,) of deflection along principal axes 1 and 2."""
    young, shear = section.material.youngs_modulus, section.material.shear_modulus
    pairs = ((section.i22, section.shear_area1), (section.i11, section.shear_area2))
    phi = [12.0 * young * i / (shear * a) / length**2 if a else np.zeros_like(length) for i, a in pairs]
    return phi[0], phi[1]


def _bending_stiffness(length: FloatArray, phi: FloatArray) -> FloatArray:
    """(n, 4, 4) on (w1, w1', w2, w2'), 1 / length^3."""
    plain = np.array([[12.0, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    turned = np.zeros((4, 4))
    turned[1::2, 1::2] = [[1.0, -1.0], [-1.0, 1.0]]
    unit_length = plain + phi[:, None, None] * turned
    return unit_length * _scale(length) / (length**3 * (1.0 + phi))[:, None, None]


def _bending_mass(length: FloatArray, phi: FloatArray, line: float, rotary: float) -> FloatArray:
    """(n, 4, 4) on (w1, theta1, w2, theta2): integral of line w w + rotary theta theta, exact with four points.

    With z = x/L and 1/(1 + phi): w = {1 - 3z^2 + 2z^3 + phi (1 - z), ...}, theta = {6 (z^2 - z)/L, ...}.
    """
    at, weights = np.polynomial.legendre.leggauss(4)
    z, share = 0.5 * (at + 1.0), 0.5 * weights
    zero = np.zeros_like(z)
    w = np.stack([1 - 3 * z**2 + 2 * z**3, z - 2 * z**2 + z**3, 3 * z**2 - 2 * z**3, z**3 - z**2], axis=1)
    w_phi = np.stack([1 - z, 0.5 * (z - z**2), z, 0.5 * (z**2 - z)], axis=1)
    turn = np.stack([6 * (z**2 - z), 1 - 4 * z + 3 * z**2, 6 * (z - z**2), 3 * z**2 - 2 * z], axis=1)
    turn_phi = np.stack([zero, 1 - z, zero, z], axis=1)
    p = phi[:, None, None]
    W, R = w + p * w_phi, turn + p * turn_phi
    total = line * (W.transpose(0, 2, 1) @ (share[:, None] * W))
    total += rotary / length[:, None, None] ** 2 * (R.transpose(0, 2, 1) @ (share[:, None] * R))
    return total * _scale(length) * (length / (1.0 + phi) ** 2)[:, None, None]


def _scale(length: FloatArray) -> FloatArray:
    """(n, 4, 4): a factor L for each rotation."""
    one = np.ones_like(length)
    factors = np.stack([one, length, one, length], axis=1)
    return factors[:, :, None] * factors[:, None, :]
