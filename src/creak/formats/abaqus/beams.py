"""*BEAM SECTION and *BEAM GENERAL SECTION."""

from __future__ import annotations

import math

import numpy as np

from creak.errors import InputError, suggest
from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.materials import RawMaterial, check_poisson, find_material
from creak.formats.abaqus.numbers import positive, to_float
from creak.formats.abaqus.outline import Scope
from creak.model.materials import BeamSection, Material

_SHAPES = {"RECT": 2, "CIRC": 1, "PIPE": 2}


def read_beam_section(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> BeamSection:
    """*BEAM SECTION, SECTION=RECT (a, b), CIRC (r) or PIPE (r, t); second line: direction of axis 1.

    Raises
    ------
    InputError : unknown shape, bad dimensions, zero axis.
    """
    material = find_material(block.need("MATERIAL"), materials, block.where)
    shape = block.need("SECTION").upper()
    rows = list(block.rows(blanks=True))
    return _section(scope, block, material, _shape(block, shape, rows), rows, _radius(shape, rows))


def read_beam_general_section(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> BeamSection:
    """*BEAM GENERAL SECTION: dimensions or A, I11, I12, I22, J; axis 1; E, G. Density on the keyword line.

    Raises
    ------
    InputError : unknown shape, missing density or moduli, I12 not zero, bad values.
    """
    shape = block.option("SECTION", "GENERAL")
    rows = list(block.rows(blanks=True))
    values = _general(block, rows) if shape == "GENERAL" else _shape(block, shape, rows)
    name = f"{block.get('ELSET')}-E-G"
    density = positive(block.get("DENSITY"), block.where, "DENSITY of the beam section")
    if len(rows) < 3:
        raise InputError(
            f"*BEAM GENERAL SECTION has {len(rows)} data lines",
            expected="three: properties; axis 1; E, G",
            where=block.where,
            fix="Add the missing lines; the axis line may be blank.",
        )
    fields, where = rows[2]
    young, shear = (
        positive(f, where, what)
        for f, what in zip([*fields, "", ""][:2], ("Young's modulus", "shear modulus"), strict=True)
    )
    nu = young / (2.0 * shear) - 1.0
    check_poisson(nu, name, where)
    return _section(scope, block, Material(name, young, nu, density), values, rows, _radius(shape, rows))


def _section(
    scope: Scope,
    block: Block,
    material: Material,
    values: tuple[float, float, float, float],
    rows: list[tuple[list[str], str]],
    radius: float,
) -> BeamSection:
    if not all(0.0 < v < math.inf for v in values):
        raise InputError(
            "the beam section has an area or second moment that is zero, negative or too large",
            where=block.where,
            fix="Correct its dimensions.",
        )
    return BeamSection(block.get("ELSET"), material, *values, axis1=_axis1(scope, rows), radius=radius)


def _radius(shape: str, rows: list[tuple[list[str], str]]) -> float:
    """From the axis to the surface: outer radius, half the smaller side of a rectangle, 0 for general sections."""
    fields, where = rows[0]
    sizes = [to_float(f, where, "dimension of the section") for f in fields[: _SHAPES.get(shape, 0)]]
    if shape == "RECT":
        return 0.5 * min(sizes)
    return sizes[0] if sizes else 0.0


def _axis1(scope: Scope, rows: list[tuple[list[str], str]]) -> tuple[float, float, float]:
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


def _shape(block: Block, shape: str, rows: list[tuple[list[str], str]]) -> tuple[float, float, float, float]:
    """Area, I11, I22 and torsion constant of a standard shape; a lies along axis 1, b along axis 2."""
    if shape not in _SHAPES:
        raise InputError(
            f"beam section {shape!r} is not supported",
            expected="RECT, CIRC, PIPE or GENERAL",
            where=block.where,
            fix=suggest(shape, [*_SHAPES, "GENERAL"]),
        )
    fields, where = rows[0] if rows else ([], block.where)
    size = [positive(f, where, f"dimension of the {shape} section") for f in [*fields, ""][: _SHAPES[shape]]]
    if len(size) < _SHAPES[shape]:
        raise InputError(f"{shape} needs {_SHAPES[shape]} dimensions", where=where, fix="Complete the line.")
    if shape == "RECT":
        a, b = size
        return a * b, a * b * b * b / 12.0, b * a * a * a / 12.0, rectangle_torsion(a, b)
    outer = size[0]
    inner = outer - size[1] if shape == "PIPE" else 0.0
    if inner < 0.0:
        raise InputError(
            f"PIPE with wall {size[1]:g} thicker than its radius {outer:g}",
            expected="radius, wall thickness",
            where=where,
            fix="Correct the line.",
        )
    area = math.pi * (outer * outer - inner * inner)
    second = math.pi * (outer * outer * outer * outer - inner * inner * inner * inner) / 4.0
    return area, second, second, 2.0 * second


def rectangle_torsion(a: float, b: float) -> float:
    """St Venant torsion constant of an a x b rectangle.

    J = l s^3 (1/3 - (64/pi^5) (s/l) sum_{n odd} tanh(n pi l / 2 s) / n^5), l the long and s the short side
    (Timoshenko and Goodier, Theory of Elasticity, art. 109).
    """
    long, short = max(a, b), min(a, b)
    ratio = long / short
    series = sum(math.tanh(n * math.pi * ratio / 2.0) / n**5 for n in range(1, 60, 2))
    return long * short * short * short * (1.0 / 3.0 - 64.0 / math.pi**5 / ratio * series)


def _general(block: Block, rows: list[tuple[list[str], str]]) -> tuple[float, float, float, float]:
    fields, where = rows[0] if rows else ([], block.where)
    names = ("area", "I11", "I12", "I22", "J")
    values = [to_float(f, where, n) for f, n in zip([*fields, *[""] * 5], names, strict=False)]
    if values[2] != 0.0:
        raise InputError(
            f"I12 of the beam section is {values[2]:g}",
            expected="0",
            where=where,
            fix="Give principal axes: I12 = 0 and axis 1 along a principal direction.",
        )
    for name, value in zip(names, values, strict=True):
        if name != "I12" and value <= 0.0:
            raise InputError(
                f"{name} of the beam section is {value:g}",
                expected="a number greater than zero",
                where=where,
                fix=f"Give {names}.",
            )
    return values[0], values[1], values[3], values[4]
