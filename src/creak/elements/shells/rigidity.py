"""Stiffness and mass per area of shell sections, turned to the axes of the elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import require_sound
from creak.model.elasticity import plane_stress, sheet_stress, strain_turn
from creak.model.laminates import SHEAR_CORRECTION
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import Own

ACROSS = 1.7e-3
"""Sine of the angle to the normal (0.1 degree) below which a direction cannot be projected on the surface."""


@dataclass(frozen=True)
class Rigidity:
    """N = A e + B k, M = B e + D k, Q = S gamma in the axes of the element.

    Each is one matrix for all, or (n, n_point, ...) where it differs from point to point.
    """

    A: FloatArray
    B: FloatArray | None
    """None: no coupling."""
    D: FloatArray
    S: FloatArray
    drilling: FloatArray | float
    """Mean in-plane shear stiffness G t, force / length."""
    poisson: float
    """Poisson's ratio of the isotropic part of A."""

    @property
    def neutral(self) -> FloatArray:
        """Bending stiffness about the neutral surface, D - B A^-1 B."""
        if self.B is None:
            return self.D
        return np.asarray(self.D - self.B @ np.linalg.solve(self.A, self.B), dtype=np.float64)

    @property
    def coupled(self) -> FloatArray:
        """[A B; B D], (..., 6, 6)."""
        B = np.zeros_like(self.A) if self.B is None else self.B
        top, bottom = np.concatenate([self.A, B], axis=-1), np.concatenate([B, self.D], axis=-1)
        return np.concatenate([top, bottom], axis=-2)


def areal_mass(
    section: ShellSection | GeneralShell, ratio: FloatArray | float = 1.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass per area, rotary inertia per area about the centre of mass, and the height of that centre, where the section
    is stretched in thickness by `ratio`; each has its shape."""
    r, added = np.asarray(ratio, dtype=np.float64), section.area_mass
    if isinstance(section, ShellSection):
        mass = section.material.density * section.thickness * r + added
        return mass, mass * (section.thickness * r) ** 2 / 12.0, np.zeros_like(r)
    mass = section.mass * r + added
    moment = section.first_moment * r**2 + added * section.offset * r
    inertia = section.rotary_inertia * r**3 + added * (section.offset * r) ** 2
    centre = moment / np.where(mass > 0.0, mass, 1.0)
    return mass, inertia - centre * moment, centre


def bending_stiffness(section: ShellSection | GeneralShell) -> tuple[float, float]:
    """Bending stiffness along the material axes 1 and 2 about the neutral surface, force times length."""
    if isinstance(section, ShellSection):
        E, nu = section.material.youngs_modulus, section.material.poisson_ratio
        D = E * section.thickness**3 / (12.0 * (1.0 - nu * nu))
        return D, D
    D_n = section.D - section.B @ np.linalg.solve(section.A, section.B) if section.B.any() else section.D
    return float(D_n[0, 0]), float(D_n[1, 1])


def is_membrane(section: ShellSection | GeneralShell) -> bool:
    """Whether the section has no bending to speak of."""
    return isinstance(section, GeneralShell) and section.is_membrane


def rigidity(section: ShellSection | GeneralShell, axes: FloatArray, own: Own, shapes: FloatArray) -> Rigidity:
    """Section stiffness at the points of n elements.

    Parameters
    ----------
    axes : (n, n_point or 1, 3, 3) rows are the local axes 1, 2 and the normal.
    own : of these elements: material direction and thickness.
    shapes : (n_point, n_node) shape functions at the points, for the thickness.

    Raises
    ------
    DegenerateElement : the material direction is normal to the surface.
    """
    ratio = None if own.thickness is None else (own.thickness @ shapes.T)[:, :, None, None]
    if isinstance(section, ShellSection):
        return _scaled(_isotropic(section), ratio)
    angle = material_angle(axes, own.axis1)
    A, B, D = (turned(matrix, angle) for matrix in (section.A, section.B, section.D))
    c, s = np.cos(angle), np.sin(angle)
    R = np.stack([np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)], axis=-2)
    S = R.swapaxes(-1, -2) @ section.S @ R
    a = section.A
    first = (3.0 * a[0, 0] + 3.0 * a[1, 1] + 2.0 * a[0, 1] + 4.0 * a[2, 2]) / 8.0
    fourth = (a[0, 0] + a[1, 1] + 6.0 * a[0, 1] - 4.0 * a[2, 2]) / 8.0
    shear = (a[0, 0] + a[1, 1] - 2.0 * a[0, 1] + 4.0 * a[2, 2]) / 8.0
    return _scaled(Rigidity(A, B if section.B.any() else None, D, S, float(shear), float(fourth / first)), ratio)


def _isotropic(section: ShellSection) -> Rigidity:
    material, t = section.material, section.thickness
    sheet, shear = plane_stress(material), SHEAR_CORRECTION * material.shear_modulus * t
    bending = sheet * (t**3 / 12.0)
    return Rigidity(sheet * t, None, bending, shear * np.eye(2), material.shear_modulus * t, material.poisson_ratio)


def _scaled(r: Rigidity, ratio: FloatArray | None) -> Rigidity:
    """The section stretched in thickness by `ratio` (n, n_point, 1, 1)."""
    if ratio is None:
        return r
    B = None if r.B is None else r.B * ratio**2
    return Rigidity(r.A * ratio, B, r.D * ratio**3, r.S * ratio, r.drilling * ratio, r.poisson)


def material_angle(axes: FloatArray, axis1: FloatArray | None) -> FloatArray:
    """Angle (n, n_point) from local axis 1 to the projection of the material direction, radian.

    Without a direction it is global x, or global z where x is within 0.1 degree of the normal (as in Abaqus).

    Raises
    ------
    DegenerateElement : the direction is within 0.1 degree of the normal.
    """
    if axis1 is None:
        x, z = axes[..., 0], axes[..., 2]
        along_x = np.hypot(x[..., 0], x[..., 1])
        near = along_x < ACROSS
        return np.where(near, np.arctan2(z[..., 1], z[..., 0]), np.arctan2(x[..., 1], x[..., 0]))
    parts = np.einsum("nc,ngac->nga", axis1, axes)
    across = np.hypot(parts[..., 0], parts[..., 1]) < ACROSS * np.linalg.norm(axis1, axis=1)[:, None]
    require_sound(across.any(axis=1), "the material direction is normal to the element")
    return np.asarray(np.arctan2(parts[..., 1], parts[..., 0]), dtype=np.float64)


def turned(matrix: FloatArray, angle: FloatArray) -> FloatArray:
    """T' matrix T (..., 3, 3): from axes at `angle` (...) to the axes the angle is measured from."""
    T = strain_turn(angle)
    return np.asarray(T.swapaxes(-1, -2) @ matrix @ T, dtype=np.float64)


def heat_resultants(
    section: ShellSection | GeneralShell, axes: FloatArray, own: Own, shapes: FloatArray, rise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """N, M (n, n_point, 3) that hold shells as they are against a rise in temperature.

    Parameters
    ----------
    axes, own, shapes : as of `rigidity`. rise : (n, n_node) at the nodes, constant through the thickness.
    """
    ratio = np.ones((1, 1)) if own.thickness is None else own.thickness @ shapes.T
    rise = rise @ shapes.T
    if isinstance(section, ShellSection):
        force = sheet_stress(section.material) * section.thickness
        N = (rise * ratio)[..., None] * force
        return N, np.zeros_like(N)
    if section.expansion is None:
        return np.zeros((*rise.shape, 3)), np.zeros((*rise.shape, 3))
    turn = strain_turn(material_angle(axes, own.axis1)).swapaxes(-1, -2)
    return turn @ section.expansion.force * (rise * ratio)[..., None], turn @ section.expansion.moment * (
        rise * ratio**2
    )[..., None]
