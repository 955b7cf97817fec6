"""*SHELL SECTION and its kin: general, membranes, rigid, continuum shells, cohesive."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.abaqus.sections.materials import (
    RawMaterial,
    find_any_material,
    find_solid_material,
    find_traction_material,
)
from creak.formats.abaqus.text.fields import floats, positive, to_float
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Scope
from creak.model.elasticity import plane_stress, require_stable, symmetric
from creak.model.laminates import LOOSE, Layup, Moduli, Ply, homogeneous_shell, shell_of, shifted
from creak.model.materials import AnisotropicMaterial, GeneralShell, Material, ShellSection, SolidSection

Materials = dict[str, RawMaterial]

_OFFSETS = {"SPOS": 0.5, "SNEG": -0.5, "MID": 0.0, "MIDDLE": 0.0}
"""Height of the nodes above the middle surface over the thickness."""
RIGID_THICKNESS = 1e-6
"""Thickness of rigid elements for contact, in lengths of their edges."""
RIGID_STRENGTH = 0.05
"""Thickness in lengths of their edges of the shell that is as stiff against contact as rigid elements."""


def read_shell_section(scope: Scope, block: Block, materials: Materials) -> ShellSection | GeneralShell:
    """*SHELL SECTION: one material and a thickness, or COMPOSITE with a line for each ply.

    Raises
    ------
    InputError : unknown material, no thickness, an offset or a ply that creak cannot read.
    """
    section = _plies(block, materials) if block.has("COMPOSITE") else _homogeneous(block, materials)
    return _with_shear(block, section)


def read_shell_general_section(scope: Scope, block: Block, materials: Materials) -> ShellSection | GeneralShell:
    """*SHELL GENERAL SECTION: MATERIAL= or COMPOSITE as *SHELL SECTION, or the 21 terms of the section's stiffness.

    The terms are the columns of the upper triangle of [A B; B D] for N11, N22, N12, M11, M22, M12; DENSITY is the
    mass per area, and the rotary inertia that of a sheet as thick as bending and membrane stiffness say.

    Raises
    ------
    InputError : as `read_shell_section`; a matrix that is not positive definite, without *TRANSVERSE SHEAR STIFFNESS.
    """
    if block.has("MATERIAL") or block.has("COMPOSITE"):
        return read_shell_section(scope, block, materials)
    rows = list(block.rows())
    values = [v for fields, where in rows[:3] for v in floats(fields, where, "term of the section stiffness", 8)][:21]
    if len(values) < 21:
        raise block.error(
            "*SHELL GENERAL SECTION without MATERIAL= has not the 21 terms of its stiffness",
            expected="three lines of 8, 8 and 5 numbers",
            fix="Complete the lines.",
        )
    full = symmetric(values, 6)
    require_stable(full, block.where)
    thickness = math.sqrt(12.0 * float(np.trace(full[3:5, 3:5])) / float(np.trace(full[:2, :2])))
    mass = positive(block.get("DENSITY"), block.where, "DENSITY (mass per area) of the shell")
    plain = GeneralShell(
        name=block.get("ELSET"),
        A=full[:3, :3],
        B=full[:3, 3:],
        D=full[3:, 3:],
        S=np.zeros((2, 2)),
        mass=mass,
        first_moment=0.0,
        rotary_inertia=mass * thickness**2 / 12.0,
        thickness=thickness,
    )
    section = _with_shear(block, plain)
    if isinstance(section, ShellSection) or not section.S.any():
        raise block.error(
            "*SHELL GENERAL SECTION by its stiffness has no transverse shear stiffness",
            expected="*TRANSVERSE SHEAR STIFFNESS after it",
            fix="Add K11, K22, K12.",
        )
    return shifted(section, -_offset(block) * thickness)


def _homogeneous(block: Block, materials: Materials) -> ShellSection | GeneralShell:
    material = find_any_material(block.need("MATERIAL"), materials, block.where)
    rows = list(block.rows())
    if not rows and (block.has("NODAL THICKNESS") or block.has("SHELL THICKNESS")):
        thickness = 1.0
    elif not rows:
        raise block.error(f"*{block.name} has no data line", expected="a line with the thickness", fix="Add it.")
    else:
        thickness = positive(rows[0][0][0], rows[0][1], "shell thickness")
    offset = _offset(block)
    if isinstance(material, Material) and not offset:
        return ShellSection(block.get("ELSET"), material, thickness)
    return shell_of(block.get("ELSET"), Layup((Ply(material, thickness),), offset=-offset))


def _plies(block: Block, materials: Materials) -> GeneralShell:
    """Lines: thickness, number of integration points, material, angle in degrees (from the section's axis 1)."""
    plies: list[Ply] = []
    for fields, where in block.rows():
        _, _, name, angle = [*fields, "", "", ""][:4]
        if angle[:1].isalpha() or angle.startswith("<"):
            raise InputError(
                f"ply {len(plies) + 1} has an orientation of its own, {angle!r}",
                where=where,
                expected="an angle in degrees from the section's ORIENTATION",
                fix="Give the angle.",
            )
        material = find_any_material(name, materials, where)
        turn = math.radians(to_float(angle, where, "angle of the ply"))
        plies.append(Ply(material, positive(fields[0], where, "thickness of the ply"), turn))
    if not plies:
        raise block.error(
            f"*{block.name}, COMPOSITE has no plies",
            fix="Add a data line for each ply.",
            expected="thickness, integration points, material, angle",
        )
    if block.has("SYMMETRIC"):
        plies += plies[::-1]
    return shell_of(block.get("ELSET"), Layup(tuple(plies), offset=-_offset(block)))


def _offset(block: Block) -> float:
    """Height of the nodes above the middle surface, over the thickness."""
    word = block.option("OFFSET", "0")
    if word in _OFFSETS:
        return _OFFSETS[word]
    return to_float(word, block.where, "OFFSET of the shell section")


def _with_shear(block: Block, section: ShellSection | GeneralShell) -> ShellSection | GeneralShell:
    for option in block.options:
        if option.name != "TRANSVERSE SHEAR STIFFNESS":
            continue
        rows = list(option.rows())
        k11, k22, k12 = floats(*(rows[0] if rows else ([], option.where)), "transverse shear stiffness", 3)
        S = np.array([[k11, k12], [k12, k22]])
        require_stable(S, option.where)
        if isinstance(section, ShellSection):
            section = homogeneous_shell(section.name, section.material, section.thickness)
        section = replace(section, S=S, own_shear=True)
    return section


def read_membrane_section(scope: Scope, block: Block, materials: Materials) -> GeneralShell:
    """*MEMBRANE SECTION: N = A e, and a millionth of a shell's bending and shear stiffness.

    Raises
    ------
    InputError : unknown material, no thickness.
    """
    material = find_any_material(block.need("MATERIAL"), materials, block.where)
    rows = list(block.rows())
    if not rows and not block.has("NODAL THICKNESS"):
        raise block.error(f"*{block.name} has no data line", expected="a line with the thickness", fix="Add it.")
    t = positive(rows[0][0][0], rows[0][1], "membrane thickness") if rows else 1.0
    weak = (LOOSE, material)
    return shell_of(block.get("ELSET"), Moduli(t, material, (1.0, material), weak, weak, turns=False))


def rigid_section(block: Block, corners: FloatArray, materials: Materials) -> GeneralShell:
    """Section of the rigid elements (n, k, 3) of a *RIGID BODY: without mass, and strained by nothing.

    What stiffness it has shows in contact alone: that of a shell of the deck's stiffest material.
    """
    edge = float(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean())
    known = [m.elastic.values[0] for m in materials.values() if m.elastic is not None and m.elastic.values]
    t = RIGID_STRENGTH * edge
    steel = Material("rigid", max(known, default=1.0), 0.3, 0.0)
    sheet = plane_stress(steel)
    return GeneralShell(
        block.get("ELSET"),
        t * sheet,
        np.zeros((3, 3)),
        t**3 / 12.0 * sheet,
        5.0 / 6.0 * steel.shear_modulus * t * np.eye(2),
        0.0,
        thickness=RIGID_THICKNESS * edge,
        rigid=True,
    )


def read_continuum_shell(scope: Scope, block: Block, materials: Materials) -> SolidSection:
    """*SHELL SECTION of SC8R and SC6R: the solid of its one material; the thickness is that of the nodes.

    Raises
    ------
    InputError : plies, a material by sheet constants.
    """
    if block.has("COMPOSITE"):
        raise block.error(
            f"*{block.name}, COMPOSITE of continuum shells",
            expected="one material",
            fix="Give each ply its own layer of elements, or use S4R.",
        )
    return SolidSection(block.get("ELSET"), find_solid_material(block.need("MATERIAL"), materials, block.where))


def read_cohesive_section(scope: Scope, block: Block, materials: Materials) -> SolidSection:
    """*COHESIVE SECTION, RESPONSE=TRACTION SEPARATION: tractions K = E / T0 and mass rho T0 per area.

    First data line: T0, 1 where it is blank or missing; with THICKNESS=GEOMETRY that of the nodes, which is refused.

    Raises
    ------
    InputError : another response, a material that is not *ELASTIC, TYPE=TRACTION.
    """
    response = block.option("RESPONSE")
    if response != "TRACTION SEPARATION" or block.option("THICKNESS", "SPECIFIED") == "GEOMETRY":
        raise block.error(
            f"*{block.name}, RESPONSE={response or '(none)'}, THICKNESS={block.option('THICKNESS', 'SPECIFIED')}",
            expected="RESPONSE=TRACTION SEPARATION, and the thickness on the data line",
            fix="Model a thick adhesive with C3D8 elements.",
        )
    rows = list(block.rows())
    fields, where = rows[0] if rows else ([""], block.where)
    T0 = positive(fields[0], where, "thickness of the cohesive layer") if fields and fields[0] else 1.0
    stiffness, density, alpha, beta = find_traction_material(block.need("MATERIAL"), materials, block.where)
    D = np.zeros((6, 6))
    D[[2, 5, 4], [2, 5, 4]] = np.array(stiffness) / T0
    return SolidSection(block.get("ELSET"), AnisotropicMaterial(block.get("MATERIAL"), D, density * T0, alpha, beta))
