"""General shell sections: homogeneous beside the nodes, of plies, or of separate moduli."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.model.elasticity import sheet_matrices, sheet_stress, turned_shear, turned_sheet, turned_stress
from creak.model.expansion import ShellExpansion, joined
from creak.model.materials import AnyMaterial, GeneralShell, Layup, Moduli, Ply

__all__ = [
    "Layup",
    "Moduli",
    "Ply",
    "denser",
    "homogeneous_shell",
    "laminate",
    "of_other_materials",
    "of_thickness",
    "remade",
    "sheet_expansion",
    "shell_of",
    "shifted",
]

SHEAR_CORRECTION = 5.0 / 6.0
"""Of a homogeneous section (Reissner)."""
LOOSE = 1e-6
"""Bending of a membrane (and membrane of a plate) against that of a whole shell, so that no dof is left loose."""
STIFF = 1e3
"""A shell that is rigid in transverse shear gets this many times the shear stiffness."""


def shell_of(name: str, made_of: Layup | Moduli) -> GeneralShell:
    """The general shell of plies (`laminate`), of which is left what `Layup.left` says, or of moduli (`Moduli`)."""
    if isinstance(made_of, Moduli):
        return _of_moduli(name, made_of)
    whole = _of_plies(name, made_of)
    if made_of.beta is not None:
        whole = replace(whole, beta=made_of.beta)
    return _partial(whole, made_of.left) if made_of.left else whole


def remade(shell: GeneralShell, made_of: Layup | Moduli) -> GeneralShell:
    """The shell as it would be of other materials or another thickness.

    What was not of these stays: the mass per area, the density added to that of the materials, a transverse shear
    stiffness of its own and the temperature without strain.
    """
    new, old = shell_of(shell.name, made_of), shell.expansion
    if new.expansion is not None and old is not None:
        new = replace(new, expansion=replace(new.expansion, reference=old.reference, flaw=old.flaw))
    new = replace(new, area_mass=shell.area_mass, S=shell.S if shell.own_shear else new.S, own_shear=shell.own_shear)
    return denser(new, shell.added_density) if shell.added_density else new


def of_other_materials(made_of: Layup | Moduli, change: Callable[[AnyMaterial], AnyMaterial]) -> Layup | Moduli:
    """The same of other materials."""
    if isinstance(made_of, Layup):
        return replace(made_of, plies=tuple(replace(p, material=change(p.material)) for p in made_of.plies))
    (a, m), (d, b), (s, g), coupling = made_of.membrane, made_of.bending, made_of.shear, made_of.coupling
    coupling = None if coupling is None else change(coupling)
    return replace(
        made_of,
        base=change(made_of.base),
        membrane=(a, change(m)),
        bending=(d, change(b)),
        shear=(s, change(g)),
        coupling=coupling,
    )


def of_thickness(made_of: Layup | Moduli, thickness: float) -> Layup | Moduli:
    """The same of another thickness; of plies there is one."""
    if isinstance(made_of, Moduli):
        return replace(made_of, thickness=thickness)
    return replace(made_of, plies=tuple(replace(p, thickness=thickness) for p in made_of.plies))


def denser(shell: GeneralShell, more: float) -> GeneralShell:
    """The shell with `more` mass per volume, spread through the thickness as its own is."""
    factor = 1.0 + more * shell.thickness / shell.mass
    return replace(
        shell,
        mass=factor * shell.mass,
        first_moment=factor * shell.first_moment,
        rotary_inertia=factor * shell.rotary_inertia,
        added_density=shell.added_density + more,
    )


def homogeneous_shell(name: str, material: AnyMaterial, thickness: float, offset: float = 0.0) -> GeneralShell:
    """One material through the thickness, its middle at height `offset` above the nodes (along the normal)."""
    return laminate(name, [Ply(material, thickness)], -0.5 * thickness + offset if offset else None)


def laminate(name: str, plies: Sequence[Ply], bottom: float | None = None, added_mass: float = 0.0) -> GeneralShell:
    """Classical laminate with transverse shear.

    A, B, D = integral of Q (1, z, z^2) dz with each ply's plane-stress matrix Q turned to the element's axes
    (Jones, Mechanics of Composite Materials, eq. 4.22-4.24). Transverse shear from equilibrium, see
    `_shear_stiffness`; 5/6 G t for one ply. alpha and beta are the plies' mean by mass, or by thickness.

    Parameters
    ----------
    plies : from the bottom (negative side) up.
    bottom : height z of the bottom above the nodes; None: the middle lies at the nodes.
    added_mass : per area, at the middle.
    """
    return replace(shell_of(name, Layup(tuple(plies), bottom)), area_mass=added_mass)


def _of_plies(name: str, layup: Layup) -> GeneralShell:
    plies, total = layup.plies, sum(p.thickness for p in layup.plies)
    z0 = -0.5 * total + layup.offset * total if layup.bottom is None else layup.bottom
    offset = z0 + 0.5 * total
    z = np.concatenate([[0.0], np.cumsum([p.thickness for p in plies])]) - 0.5 * total
    matrices = [sheet_matrices(p.material) for p in plies]
    Q = np.array([turned_sheet(q, p.angle) for (q, _), p in zip(matrices, plies, strict=True)])
    G = np.array([turned_shear(g, p.angle) for (_, g), p in zip(matrices, plies, strict=True)])
    density = np.array([p.material.density for p in plies])
    A, B, D = (np.einsum("k,kij->ij", (z[1:] ** n - z[:-1] ** n) / n, Q) for n in (1, 2, 3))
    mass, moment, inertia = (float(density @ (z[1:] ** n - z[:-1] ** n)) / n for n in (1, 2, 3))
    share = density * np.diff(z) / mass if mass > 0.0 else np.diff(z) / total
    alpha, beta = (float(share @ np.array([getattr(p.material, key) for p in plies])) for key in ("alpha", "beta"))
    middle = GeneralShell(
        name=name,
        A=A,
        B=B,
        D=D,
        S=_shear_stiffness(z, Q, G, A, B, D),
        mass=mass,
        first_moment=moment,
        rotary_inertia=inertia,
        thickness=total,
        offset=0.0,
        alpha=alpha,
        beta=beta,
    )
    middle = replace(middle, expansion=_expansion(plies, z))
    return replace(shifted(middle, offset), plies=plies, bottom=z0, made_of=layup)


def _of_moduli(name: str, m: Moduli) -> GeneralShell:
    t, base = m.thickness, m.base
    (a, membrane), (d, bending), (s, across) = m.membrane, m.bending, m.shear
    A = t * (a * sheet_matrices(membrane)[0])
    D = t**3 / 12.0 * (d * sheet_matrices(bending)[0])
    S = s * t * sheet_matrices(across)[1]
    B = np.zeros((3, 3)) if m.coupling is None else -t * t * sheet_matrices(m.coupling)[0]
    heat = sheet_expansion(membrane, t) if a == 1.0 else None
    if heat is not None and m.coupling is not None:
        heat = replace(heat, moment=-t * t * sheet_stress(m.coupling))
    mass, rotary = base.density * t, base.density * t**3 / 12.0 if m.turns else 0.0
    made = GeneralShell(
        name=name,
        A=A,
        B=B,
        D=D,
        S=S,
        mass=mass,
        first_moment=0.0,
        rotary_inertia=rotary,
        thickness=t,
        offset=0.0,
        alpha=base.alpha,
        beta=base.beta,
    )
    return replace(made, expansion=heat, made_of=m)


def _partial(shell: GeneralShell, left: str) -> GeneralShell:
    """Of a laminate: no coupling, and membrane (MEM), bending (BEND) or both of one mean modulus (SMEAR)."""
    even = shell.A * shell.thickness**2 / 12.0
    A, D, S = {
        "MEM": (shell.A, LOOSE * even, LOOSE * shell.S),
        "BEND": (LOOSE * shell.A, shell.D, STIFF * shell.S),
        "SMEAR": (shell.A, even, STIFF * shell.S),
    }[left]
    heat = shell.expansion
    if heat is not None:
        force = LOOSE * heat.force if left == "BEND" else heat.force
        heat = replace(heat, force=force, moment=heat.moment if left == "BEND" else np.zeros(3))
    return replace(shell, A=A, B=np.zeros((3, 3)), D=D, S=S, plies=(), expansion=heat)


def sheet_expansion(material: AnyMaterial, thickness: float) -> ShellExpansion | None:
    """Of one material through the thickness, its middle at the nodes; None: it does not expand."""
    heat = material.expansion
    if heat is None:
        return None
    return ShellExpansion(thickness * sheet_stress(material), np.zeros(3), heat.reference, heat.flaw)


def _expansion(plies: Sequence[Ply], z: FloatArray) -> ShellExpansion | None:
    """N, M = integral of Q alpha (1, z) dz about the middle (Jones, eq. 4.100-4.101); None: no ply expands."""
    if all(p.material.expansion is None for p in plies):
        return None
    stress = np.array([turned_stress(sheet_stress(p.material), p.angle) for p in plies])
    force, moment = (((z[1:] ** n - z[:-1] ** n) / n) @ stress for n in (1, 2))
    return ShellExpansion(force, moment, *joined([p.material.expansion for p in plies]))


def shifted(shell: GeneralShell, height: float) -> GeneralShell:
    """The section moved up by `height` along the normal: z becomes z + height.

    A, B + h A, D + 2 h B + h^2 A, and the same of the mass.
    """
    h, m, heat = height, shell.mass, shell.expansion
    return GeneralShell(
        name=shell.name,
        A=shell.A,
        B=shell.B + h * shell.A,
        D=shell.D + 2.0 * h * shell.B + h * h * shell.A,
        S=shell.S,
        mass=m,
        first_moment=shell.first_moment + h * m,
        rotary_inertia=shell.rotary_inertia + 2.0 * h * shell.first_moment + h * h * m,
        thickness=shell.thickness,
        offset=shell.offset + h,
        alpha=shell.alpha,
        beta=shell.beta,
        expansion=None if heat is None else replace(heat, moment=heat.moment + h * heat.force),
        area_mass=shell.area_mass,
    )


def _shear_stiffness(
    z: FloatArray, Q: FloatArray, G: FloatArray, A: FloatArray, B: FloatArray, D: FloatArray
) -> FloatArray:
    """(2, 2) from the complementary energy of the shear stresses that equilibrate bending in cylindrical form.

    In each direction i = 1, 2 the stress s_ii(z) = (Q (e + z k))_i of a unit moment M_i (N = 0) changes along x_i
    with Q_i; equilibrium gives s_i3(z) = -integral of s_ii dz, and 1/S_ii = integral of s_i3^2/G_i3 dz. The
    coupling 13-23 is taken from the mean of the plies' own, scaled alike. 5/6 for a homogeneous sheet. The choice
    of directions is an assumption: other material axes change S a little where plies differ.
    Source: Rohwer, Composite Structures 10 (1988) 285, without the mixed terms.
    """
    middle = np.concatenate([np.concatenate([A, B], axis=1), np.concatenate([B, D], axis=1)])
    compliance = np.linalg.inv(middle)
    factor = np.zeros(2)
    plain = np.einsum("k,kij->ij", np.diff(z), G)
    for i in range(2):
        load = compliance[:, 3 + i]
        energy, below = 0.0, 0.0
        for k in range(len(Q)):
            at, weight = np.polynomial.legendre.leggauss(3)
            half = 0.5 * (z[k + 1] - z[k])
            depth = half * (at + 1.0)
            s0, s1 = Q[k][i] @ (load[:3] + z[k] * load[3:]), Q[k][i] @ load[3:]
            stress = below + s0 * depth + 0.5 * s1 * depth**2
            energy += float(half * weight @ stress**2) / float(G[k][i, i])
            below += 2.0 * half * s0 + 0.5 * s1 * (2.0 * half) ** 2
        factor[i] = 1.0 / energy / plain[i, i]
    scale = np.sqrt(factor)
    return plain * np.outer(scale, scale)
