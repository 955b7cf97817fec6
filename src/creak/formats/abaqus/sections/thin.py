"""Sections of elements read as shells or solids of other kinds: membranes, rigid, continuum shells, cohesive."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.formats.abaqus.sections.materials import (
    RawMaterial,
    find_any_material,
    find_solid_material,
    find_traction_material,
)
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.numbers import positive
from creak.formats.abaqus.text.outline import Scope
from creak.model.elasticity import plane_stress
from creak.model.laminates import LOOSE, Moduli, shell_of
from creak.model.materials import AnisotropicMaterial, GeneralShell, Material, SolidSection

Materials = dict[str, RawMaterial]
RIGID_THICKNESS = 1e-6
"""Thickness of rigid elements for contact, in lengths of their edges."""
RIGID_STRENGTH = 0.05
"""Thickness in lengths of their edges of the shell that is as stiff against contact as rigid elements."""


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
