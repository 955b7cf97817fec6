"""*MATERIAL with *ELASTIC, *DENSITY and *DAMPING."""

from __future__ import annotations

from dataclasses import dataclass

from creak.errors import InputError, suggest
from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.numbers import positive, to_float
from creak.formats.abaqus.outline import Outline
from creak.model.materials import Material


@dataclass(frozen=True)
class RawMaterial:
    """What the deck says of a material; a section that uses it decides what must be there."""

    name: str
    where: str
    elastic: tuple[float, float] | None
    """Young's modulus, Poisson's ratio."""
    density: float | None
    alpha: float
    beta: float


def read_materials(deck: Outline) -> dict[str, RawMaterial]:
    """Materials by name, upper case.

    Raises
    ------
    InputError : not isotropic, depends on temperature, a value out of range, a name used twice.
    """
    result: dict[str, RawMaterial] = {}
    seen: set[int] = set()
    for _, block in deck.blocks("MATERIAL"):
        if id(block) in seen:
            continue
        seen.add(id(block))
        name = block.need("NAME")
        if name.upper() in result:
            raise InputError(
                f"material {name!r} is defined twice, first at {result[name.upper()].where}",
                where=block.where,
                fix="Rename one of them.",
            )
        result[name.upper()] = _material(deck, name, block)
    return result


def find_material(name: str, materials: dict[str, RawMaterial], where: str) -> Material:
    """The material of a structural section.

    Raises
    ------
    InputError : no such material, or it lacks *ELASTIC or *DENSITY.
    """
    raw = materials.get(name.upper())
    if raw is None:
        raise InputError(f"unknown material {name!r}", where=where, fix=suggest(name, materials))
    if raw.elastic is None or raw.density is None:
        lacks = "*ELASTIC" if raw.elastic is None else "*DENSITY"
        raise InputError(
            f"material {raw.name!r} (defined at {raw.where}) has no {lacks}",
            expected="*ELASTIC and *DENSITY in every material of a structure",
            where=where,
            fix=f"Add {lacks} after its *MATERIAL line.",
        )
    return Material(raw.name, *raw.elastic, raw.density, raw.alpha, raw.beta)


def _material(deck: Outline, name: str, block: Block) -> RawMaterial:
    elastic: tuple[float, float] | None = None
    density: float | None = None
    alpha = beta = 0.0
    for option in block.options:
        if option.name == "ELASTIC":
            elastic = _elastic(name, option)
        elif option.name == "DENSITY":
            fields, where = _single_row(name, option, 1)
            density = positive(fields[0], where, f"density of material {name!r}")
        elif option.name == "DAMPING":
            alpha, beta = _damping(name, option)
    return RawMaterial(name, block.where, elastic, density, alpha, beta)


def _elastic(name: str, option: Block) -> tuple[float, float]:
    kind = option.option("TYPE", "ISOTROPIC")
    if kind not in ("ISOTROPIC", "ISO"):
        raise InputError(
            f"*ELASTIC, TYPE={kind} in material {name!r}",
            expected="TYPE=ISOTROPIC",
            where=option.where,
            fix="creak reads isotropic elasticity only; give E and nu.",
        )
    fields, where = _single_row(name, option, 2)
    youngs = positive(fields[0], where, f"Young's modulus of material {name!r}")
    nu = to_float(fields[1] if len(fields) > 1 else "", where, f"Poisson's ratio of material {name!r}")
    check_poisson(nu, name, where)
    return youngs, nu


def check_poisson(nu: float, name: str, where: str) -> None:
    """Raise InputError unless -1 < nu < 0.5."""
    if not -1.0 < nu < 0.5:
        raise InputError(
            f"Poisson's ratio of material {name!r} is {nu:g}",
            expected="more than -1 and less than 0.5",
            where=where,
            fix="Correct nu.",
        )


def _single_row(name: str, option: Block, n_values: int) -> tuple[list[str], str]:
    """The only data line; a temperature after the values is left out, further lines are refused."""
    rows = list(option.rows())
    if not rows:
        raise InputError(
            f"*{option.name} of material {name!r} has no data line", where=option.where, fix="Add its values."
        )
    if len(rows) > 1 or option.has("DEPENDENCIES"):
        raise InputError(
            f"*{option.name} of material {name!r} depends on temperature or fields",
            expected="one line of values",
            where=rows[-1][1],
            fix="Keep the line of the temperature to be analysed.",
        )
    fields, where = rows[0]
    if len(fields) > n_values + 1:
        raise InputError(
            f"*{option.name} of material {name!r} has {len(fields)} values",
            expected=f"{n_values}",
            where=where,
            fix="Remove the others.",
        )
    return fields, where


def _damping(name: str, option: Block) -> tuple[float, float]:
    values = []
    for param in ("ALPHA", "BETA"):
        value = to_float(option.get(param), option.where, f"{param} of material {name!r}")
        if value < 0.0:
            raise InputError(
                f"damping {param} of material {name!r} is {value:g}",
                expected="zero or more",
                where=option.where,
                fix="Correct it.",
            )
        values.append(value)
    return values[0], values[1]
