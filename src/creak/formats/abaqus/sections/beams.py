"""*BEAM SECTION and *BEAM GENERAL SECTION."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from creak.errors import InputError, suggest
from creak.formats.abaqus.sections.beam_shapes import OF_NODE, SHAPES, WALL, WIDTHS, arbitrary, ellipse
from creak.formats.abaqus.sections.materials import RawMaterial, check_poisson, find_material
from creak.formats.abaqus.text.fields import floats, positive, to_float
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Scope
from creak.formats.deck.cross_section import CrossSection, principal
from creak.model.materials import BeamSection, Material

Rows = list[tuple[list[str], str]]
Given = tuple[str, tuple[float, ...]]
"""Shape and dimensions."""


def read_beam_section(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> BeamSection:
    """*BEAM SECTION, SECTION=RECT, CIRC, PIPE, THICK PIPE, BOX, I, HEX, L, TRAPEZOID or ARBITRARY; second line (of
    ARBITRARY that after its walls): direction of axis 1.

    *BEAM SECTION OFFSET after it, and CalculiX's OFFSET1 and OFFSET2 (in widths of the section), move it off the nodes.

    Raises
    ------
    InputError : unknown shape, bad dimensions, zero axis.
    """
    material = find_material(block.need("MATERIAL"), materials, block.where)
    rows = list(block.rows(blanks=True))
    name = block.need("SECTION").upper()
    name = {"RECTANGULAR": "RECT", "CIRCULAR": "CIRC"}.get(name, name)
    shape, rows, given = _shape(block, name, rows)
    return _section(scope, block, material, _moved(block, shape, given), rows, given)


def read_beam_general_section(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> BeamSection:
    """*BEAM GENERAL SECTION: dimensions or A, I11, I12, I22, J; axis 1; E, G. Density on the keyword line.

    *CENTROID and *SHEAR CENTER after it move these points off the nodes. With MATERIAL it is CalculiX's form, which is
    that of *BEAM SECTION.

    Raises
    ------
    InputError : unknown shape, missing density or moduli, second moments of no section, bad values.
    """
    shape = block.option("SECTION", "GENERAL")
    if block.has("MATERIAL") and shape != "GENERAL":
        return read_beam_section(scope, block, materials)
    rows = list(block.rows(blanks=True))
    found, rows, given = _general(block, rows) if shape == "GENERAL" else _shape(block, shape, rows)
    found = replace(
        found,
        centroid=_point(block, "CENTROID", found.centroid),
        shear_centre=_point(block, "SHEAR CENTER", found.shear_centre),
    )
    name = f"{block.get('ELSET')}-E-G"
    density = positive(block.get("DENSITY"), block.where, "DENSITY of the beam section")
    if len(rows) < 3:
        raise block.error(
            f"*BEAM GENERAL SECTION has {len(rows)} data lines",
            expected="three: properties; axis 1; E, G",
            fix="Add the missing lines; the axis line may be blank.",
        )
    fields, where = rows[2]
    young, shear = (
        positive(f, where, what)
        for f, what in zip([*fields, "", ""][:2], ("Young's modulus", "shear modulus"), strict=True)
    )
    nu = young / (2.0 * shear) - 1.0
    check_poisson(nu, name, where)
    return _section(scope, block, Material(name, young, nu, density), _moved(block, found, given), rows, given)


def _section(
    scope: Scope,
    block: Block,
    material: Material,
    shape: CrossSection,
    rows: Rows,
    given: Given,
) -> BeamSection:
    """The section with shear areas k A; the second moments turned to principal axes."""
    if not shape.sound or shape.i12**2 >= shape.i11 * shape.i22:
        raise block.error(
            "the beam section has an area or second moment that is zero, negative or too large",
            fix="Correct its dimensions.",
        )
    i1, i2, angle = principal(shape.i11, shape.i22, shape.i12)
    along1, along2 = _shear_areas(block, shape, material)
    if angle:
        along1 = along2 = 0.5 * (along1 + along2)
    return BeamSection(
        name=block.get("ELSET"),
        material=material,
        area=shape.area,
        i11=i1,
        i22=i2,
        torsion=shape.torsion,
        axis1=_axis1(scope, rows),
        radius=shape.radius,
        shear_area1=along1,
        shear_area2=along2,
        angle=angle,
        centroid=shape.centroid,
        shear_centre=shape.shear_centre,
        profile=given[0],
        dimensions=given[1],
    )


def _shear_areas(block: Block, shape: CrossSection, material: Material) -> tuple[float, float]:
    """k A along axes 1 and 2, or K13/G and K23/G of *TRANSVERSE SHEAR STIFFNESS (K23, K13)."""
    for option in block.options:
        if option.name == "TRANSVERSE SHEAR STIFFNESS":
            rows = list(option.rows())
            fields, where = rows[0] if rows else ([], option.where)
            k23 = positive(fields[0] if fields else "", where, "shear stiffness K23")
            k13 = positive(fields[1], where, "shear stiffness K13") if len(fields) > 1 and fields[1] else k23
            return k13 / material.shear_modulus, k23 / material.shear_modulus
    return shape.shear_factors[0] * shape.area, shape.shear_factors[1] * shape.area


def _point(block: Block, keyword: str, default: tuple[float, float]) -> tuple[float, float]:
    for option in block.options:
        if option.name == keyword:
            rows = list(option.rows())
            if rows:
                x, y = floats(*rows[0], f"coordinate of *{keyword}", 2)
                return x, y
    return default


def _axis1(scope: Scope, rows: Rows) -> tuple[float, float, float]:
    """Direction of axis 1 in global axes; (0, 0, -1) when not given."""
    axis = np.array([0.0, 0.0, -1.0])
    if len(rows) > 1 and rows[1][0]:
        fields, where = rows[1]
        axis = np.array([to_float(f, where, "direction of beam axis 1") for f in [*fields, "", ""][:3]])
        if not 0.0 < float(np.linalg.norm(axis)) < math.inf:
            raise InputError(
                "the direction of beam axis 1 is zero",
                expected="a direction x, y, z",
                where=where,
                fix="Give a direction across the beam.",
            )
    x, y, z = (float(v) for v in scope.rotation @ axis)
    return x, y, z


def _moved(block: Block, shape: CrossSection, given: Given) -> CrossSection:
    """Centroid and shear centre after *BEAM SECTION OFFSET, or OFFSET1 and OFFSET2 in widths of the section."""
    x, y = _point(block, "BEAM SECTION OFFSET", (0.0, 0.0))
    shares = [to_float(block.get(p), block.where, p) if block.has(p) else 0.0 for p in ("OFFSET1", "OFFSET2")]
    if any(shares):
        name, size = given
        if name not in WIDTHS:
            raise block.error(
                f"OFFSET1 and OFFSET2 of a beam section {name}",
                expected=f"them with {', '.join(WIDTHS)}, as in CalculiX",
                fix="Give *BEAM SECTION OFFSET after the section, as lengths.",
            )
        x, y = (o + share * width for o, share, width in zip((x, y), shares, WIDTHS[name](size), strict=True))
    (c1, c2), (s1, s2) = shape.centroid, shape.shear_centre
    return replace(shape, centroid=(c1 + x, c2 + y), shear_centre=(s1 + x, s2 + y))


def _shape(block: Block, name: str, rows: Rows) -> tuple[CrossSection, Rows, Given]:
    """Properties of a standard shape, its first dimension along axis 1; the lines with one for all dimensions."""
    if name == "ARBITRARY":
        return _arbitrary(block, rows)
    if name not in SHAPES:
        raise block.error(
            f"beam section {name!r} is not supported",
            expected=f"{', '.join(SHAPES)}, ARBITRARY or GENERAL",
            fix=suggest(name, [*SHAPES, "ARBITRARY", "GENERAL"]),
        )
    count, made = SHAPES[name]
    fields, where = rows[0] if rows else ([], block.where)
    if name == "CIRC" and any(fields[1:2]):  # of CalculiX
        a, b = (positive(field, where, "diameter of the CIRC section") for field in fields[:2])
        found = ellipse(a, b)
        general = ("GENERAL", (found.area, found.i11, 0.0, found.i22, found.torsion))
        return found, rows, ("CIRC", (0.5 * a,)) if a == b else general
    size = []
    for i, field in enumerate([*fields, *[""] * count][:count]):
        if i == OF_NODE.get(name):
            size.append(to_float(field, where, f"height of the node in the {name} section"))
        else:
            size.append(positive(field, where, f"dimension of the {name} section"))
    try:
        return made(size), rows, (name, tuple(size))
    except ValueError as error:
        raise InputError(
            str(error), expected="dimensions that leave a section", where=where, fix="Correct the line."
        ) from None


def _arbitrary(block: Block, rows: Rows) -> tuple[CrossSection, Rows, Given]:
    """Walls from point to point: their number, two points, thickness; point and thickness of each further one."""
    fields, where = rows[0] if rows else ([], block.where)
    count, *first = floats(fields, where, "number of the ARBITRARY section", 6)
    if count != int(count) or not 1 <= count <= len(rows):
        raise InputError(
            f"the ARBITRARY beam section has {count:g} walls and {len(rows)} data lines",
            expected="a line for each wall, then axis 1",
            where=where,
            fix="Give the number of walls on the first line.",
        )
    size = [count, *first]
    for line, at in rows[1 : int(count)]:
        size += floats(line, at, "number of the ARBITRARY section", WALL)
    try:
        found = arbitrary(size)
    except ValueError as error:
        raise InputError(
            str(error),
            expected="walls with a length and a thickness, not all on a line",
            where=where,
            fix="Correct them.",
        ) from None
    return found, [rows[0], *rows[int(count) :]], ("ARBITRARY", tuple(size))


def _general(block: Block, rows: Rows) -> tuple[CrossSection, Rows, Given]:
    fields, where = rows[0] if rows else ([], block.where)
    names = ("area", "I11", "I12", "I22", "J")
    area, i11, i12, i22, torsion = floats(fields, where, "property of the beam section", 5)
    for name, value in (("area", area), ("I11", i11), ("I22", i22), ("J", torsion)):
        if value <= 0.0:
            raise InputError(
                f"{name} of the beam section is {value:g}",
                expected="a number greater than zero",
                where=where,
                fix=f"Give {names}.",
            )
    size = (area, i11, i12, i22, torsion)
    return CrossSection(area, i11, i22, i12, torsion, shear_factors=(1.0, 1.0)), rows, ("GENERAL", size)
