"""Elastic constants -> elasticity matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.model.expansion import IN_PLANE
from creak.model.materials import AnisotropicMaterial, AnyMaterial, Isotropic, Material, SheetMaterial

SOFTEST = 1e-12
"""Transverse shear modulus over the largest one, below which a sheet has none."""


def plane_stress(material: Material) -> FloatArray:
    """D (3, 3), force / length^2: (sxx, syy, sxy) = D (exx, eyy, 2 exy) of an isotropic sheet."""
    nu = material.poisson_ratio
    factor = material.youngs_modulus / (1.0 - nu * nu)
    return factor * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])


def hooke(material: Material | AnisotropicMaterial) -> FloatArray:
    """D (6, 6), force / length^2: stresses xx, yy, zz, xy, yz, zx from strains exx, eyy, ezz, 2 exy, 2 eyz, 2 ezx."""
    if isinstance(material, AnisotropicMaterial):
        return material.elasticity
    shear, nu = material.shear_modulus, material.poisson_ratio
    D = np.diag([2.0 * shear] * 3 + [shear] * 3)
    D[:3, :3] += 2.0 * shear * nu / (1.0 - 2.0 * nu)
    return D


def lamina(
    E1: float, E2: float, nu12: float, G12: float, G13: float, G23: float, *, where: object = ""
) -> tuple[FloatArray, FloatArray]:
    """In-plane (3, 3) and shear (2, 2) matrices of an orthotropic sheet in plane stress.

    e11 = s11/E1 - nu12 s22/E1,  e22 = s22/E2 - nu12 s11/E1 (Jones, Mechanics of Composite Materials, eq. 2.61).

    Raises
    ------
    InputError : the constants store negative energy.
    """
    flexibility = np.array([[1.0 / E1, -nu12 / E1, 0.0], [-nu12 / E1, 1.0 / E2, 0.0], [0.0, 0.0, 1.0 / G12]])
    require_stable(flexibility, where)
    if not min(G13, G23) > SOFTEST * max(G12, G13, G23):
        raise InputError(
            f"the transverse shear moduli are {G13:g} and {G23:g}, against {G12:g} in the plane",
            where=where,
            expected="moduli of one order",
            fix="Correct G13 and G23.",
        )
    return np.linalg.inv(flexibility), np.diag([G13, G23])


def orthotropic(
    E: tuple[float, float, float],
    nu: tuple[float, float, float],
    G: tuple[float, float, float],
    *,
    where: object = "",
) -> FloatArray:
    """Elasticity (6, 6) from E1, E2, E3, nu12, nu13, nu23 and G12, G13, G23, in the order of `hooke`.

    Raises
    ------
    InputError : the constants store negative energy.
    """
    flexibility = np.diag([1.0 / E[0], 1.0 / E[1], 1.0 / E[2], 1.0 / G[0], 1.0 / G[2], 1.0 / G[1]])
    for (i, j), ratio in zip(((0, 1), (0, 2), (1, 2)), nu, strict=True):
        flexibility[i, j] = flexibility[j, i] = -ratio / E[i]
    require_stable(flexibility, where)
    stiffness = np.linalg.inv(flexibility)
    return np.asarray(0.5 * (stiffness + stiffness.T), dtype=np.float64)


def isotropic_sheet(made_of: Isotropic) -> SheetMaterial:
    """A sheet with a shear modulus of its own, or in plane strain.

    Its matrices are those of `plane_stress`, or the in-plane rows of `hooke` with (1 + nu) alpha, the shear terms times
    `shear_factor`; of plane strain the transverse shear matrix is G of E and nu.
    """
    m, factor, heat = made_of.material, made_of.shear_factor, made_of.material.expansion
    in_plane = hooke(m)[np.ix_(IN_PLANE, IN_PLANE)] if made_of.strained else plane_stress(m)
    in_plane[2, 2] *= factor
    if made_of.strained and heat is not None:
        strain = (1.0 + m.poisson_ratio) * np.array(heat.strain)
        heat = replace(heat, strain=tuple(strain.tolist()))
    shear = (m.shear_modulus if made_of.strained else m.shear_modulus * factor) * np.eye(2)
    return SheetMaterial(m.name, in_plane, shear, m.density, m.alpha, m.beta, expansion=heat, isotropic=made_of)


def require_stable(matrix: FloatArray, where: object) -> None:
    """Raise InputError unless the symmetric matrix is finite and positive definite."""
    scale = np.sqrt(np.abs(np.diag(matrix)))
    with np.errstate(all="ignore"):
        relative = matrix / np.outer(scale, scale)
    if not np.isfinite(relative).all() or np.linalg.eigvalsh(relative)[0] <= 1e-12:
        raise InputError(
            "the elastic constants are those of no stable material (a strain without energy, or worse)",
            expected="a positive definite elasticity matrix",
            where=where,
            fix="Check the moduli and Poisson's ratios; nu12 belongs to E1: |nu12| < sqrt(E1/E2).",
        )


def sheet_matrices(material: AnyMaterial) -> tuple[FloatArray, FloatArray]:
    """In-plane (3, 3) and transverse shear (2, 2: 13, 23) matrices of a sheet of any material, in plane stress."""
    if isinstance(material, SheetMaterial):
        return material.in_plane, material.shear
    if isinstance(material, Material):
        return plane_stress(material), material.shear_modulus * np.eye(2)
    flexibility = np.linalg.inv(material.elasticity)
    shear = np.array([5, 4])
    return (
        np.linalg.inv(flexibility[np.ix_(IN_PLANE, IN_PLANE)]),
        np.linalg.inv(flexibility[np.ix_(shear, shear)]),
    )


def sheet_stress(material: AnyMaterial) -> FloatArray:
    """(3,) s11, s22, s12 that hold a sheet in plane stress as it is against one degree; zero without expansion."""
    if material.expansion is None:
        return np.zeros(3)
    return np.asarray(sheet_matrices(material)[0] @ np.array(material.expansion.strain)[IN_PLANE], dtype=np.float64)


def turned_sheet(matrix: FloatArray, angle: float) -> FloatArray:
    """In-plane (3, 3) matrix of a sheet whose axis 1 stands at `angle` (radian) to the axis 1 of the result."""
    T = strain_turn(angle)
    return np.asarray(T.T @ matrix @ T, dtype=np.float64)


def turned_stress(stress: FloatArray, angle: float) -> FloatArray:
    """In-plane stress (3,) of a sheet whose axis 1 stands at `angle` (radian) to the axis 1 of the result."""
    return np.asarray(strain_turn(angle).T @ stress, dtype=np.float64)


def strain_turn(angle: float | FloatArray) -> FloatArray:
    """(..., 3, 3) strains (shear doubled) in axes at `angle` from those in the axes it is measured from."""
    c, s = np.cos(angle), np.sin(angle)
    rows = [(c * c, s * s, c * s), (s * s, c * c, -c * s), (-2 * c * s, 2 * c * s, c * c - s * s)]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def turned_shear(matrix: FloatArray, angle: float) -> FloatArray:
    """Transverse shear (2, 2) matrix of a sheet whose axis 1 stands at `angle` to the axis 1 of the result."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, s], [-s, c]])
    return np.asarray(R.T @ matrix @ R, dtype=np.float64)


def symmetric(values: Sequence[float], n: int) -> FloatArray:
    """(n, n) symmetric matrix from the columns of its upper triangle: 11, 12, 22, 13, 23, 33, ..."""
    rows, columns = np.tril_indices(n)
    out = np.zeros((n, n))
    out[rows, columns] = out[columns, rows] = values
    return out
