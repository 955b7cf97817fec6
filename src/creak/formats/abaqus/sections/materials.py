"""*MATERIAL with *ELASTIC (or *HYPERELASTIC, *HYPERFOAM), *DENSITY and *DAMPING."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.loads.temperatures import at_temperature
from creak.formats.abaqus.sections.rubber import small_strain
from creak.formats.abaqus.text.fields import floats, positive, to_float
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline
from creak.model.elasticity import lamina, orthotropic, require_stable, symmetric
from creak.model.expansion import Expansion, isotropic_expansion
from creak.model.materials import AnisotropicMaterial, AnyMaterial, Material, SheetMaterial

COEFFICIENTS = {"ISO": 1, "ISOTROPIC": 1, "ORTHO": 3, "ORTHOTROPIC": 3, "ANISO": 6, "ANISOTROPIC": 6}
"""TYPE -> coefficients of an entry: a11, a22, a33, a12, a13, a23; a temperature may follow."""


@dataclass(frozen=True)
class Elastic:
    """*ELASTIC: which kind, and its numbers as the deck lists them."""

    kind: str
    """ISOTROPIC, LAMINA, ENGINEERING CONSTANTS, ORTHOTROPIC or ANISOTROPIC."""
    values: tuple[float, ...]
    where: str


@dataclass(frozen=True)
class RawMaterial:
    """What the deck says of a material; a section that uses it decides what must be there."""

    name: str
    where: str
    elastic: Elastic | None
    density: float | None
    alpha: float
    beta: float
    expansion: Expansion | None = None


def read_materials(deck: Outline) -> dict[str, RawMaterial]:
    """Materials by name, upper case.

    Raises
    ------
    InputError : unknown kind of elasticity, depends on fields, a value out of range, a name used twice.
    """
    result: dict[str, RawMaterial] = {}
    seen: set[int] = set()
    for _, block in deck.blocks("MATERIAL"):
        if id(block) in seen:
            continue
        seen.add(id(block))
        name = block.need("NAME")
        if name.upper() in result:
            raise block.twice(f"material {name!r}", result[name.upper()].where, "Rename one of them.")
        result[name.upper()] = _material(deck, name, block)
    return result


def find_material(name: str, materials: dict[str, RawMaterial], where: str) -> Material:
    """The material of a section that must be isotropic.

    Raises
    ------
    InputError : no such material, it lacks *ELASTIC or *DENSITY, or it is not isotropic.
    """
    material = find_any_material(name, materials, where)
    if isinstance(material, Material):
        return material
    raise InputError(
        f"material {name!r} of this section is not isotropic",
        expected="*ELASTIC, TYPE=ISOTROPIC",
        where=where,
        fix="Give E and nu.",
    )


def find_solid_material(name: str, materials: dict[str, RawMaterial], where: str) -> Material | AnisotropicMaterial:
    """The material of solids.

    Raises
    ------
    InputError : as `find_any_material`, or it is TYPE=LAMINA.
    """
    material = find_any_material(name, materials, where)
    if isinstance(material, SheetMaterial):
        raise InputError(
            f"material {name!r} is TYPE=LAMINA, plane stress only",
            expected="TYPE=ISOTROPIC, ENGINEERING CONSTANTS, ORTHOTROPIC or ANISOTROPIC",
            where=where,
            fix="Give all nine constants.",
        )
    return material


def find_traction_material(
    name: str, materials: dict[str, RawMaterial], where: str
) -> tuple[tuple[float, float, float], float, float, float]:
    """Enn, Ess, Ett of *ELASTIC, TYPE=TRACTION (and UNCOUPLED TRACTION), density, alpha and beta of a cohesive layer.

    Raises
    ------
    InputError : no such material, or it is of another type; no *DENSITY is a density of zero.
    """
    raw = materials.get(name.upper())
    if raw is None:
        raise InputError(f"unknown material {name!r}", where=where, fix=suggest(name, materials))
    if raw.elastic is None or raw.elastic.kind != TRACTION:
        raise InputError(
            f"material {raw.name!r} of a cohesive section has no *ELASTIC, TYPE=TRACTION",
            expected="Enn, Ess, Ett",
            where=raw.where,
            fix="Give the stiffness of the layer in traction over separation.",
        )
    n, s, t = raw.elastic.values
    return (n, s, t), raw.density or 0.0, raw.alpha, raw.beta


def find_any_material(name: str, materials: dict[str, RawMaterial], where: str) -> AnyMaterial:
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
    common = (raw.density, raw.alpha, raw.beta)
    values, at, heat = raw.elastic.values, raw.elastic.where, raw.expansion
    if raw.elastic.kind == TRACTION:
        raise InputError(
            f"material {raw.name!r} is *ELASTIC, TYPE=TRACTION, which cohesive elements alone have",
            expected="*COHESIVE SECTION with COH3D8 or COH3D6",
            where=where,
            fix="Give E and nu.",
        )
    if raw.elastic.kind == "ISOTROPIC":
        return Material(raw.name, values[0], values[1], *common, heat)
    if raw.elastic.kind == "LAMINA":
        E1, E2, nu12, G12, G13, G23 = values
        return SheetMaterial(raw.name, *lamina(E1, E2, nu12, G12, G13, G23, where=at), *common, values, heat)
    if raw.elastic.kind == "ENGINEERING CONSTANTS":
        E, nu, G = values[:3], values[3:6], values[6:9]
        matrix = orthotropic((E[0], E[1], E[2]), (nu[0], nu[1], nu[2]), (G[0], G[1], G[2]), where=at)
        return AnisotropicMaterial(raw.name, matrix, *common, heat)
    return AnisotropicMaterial(raw.name, _stiffness(raw.elastic), *common, heat)


def _stiffness(elastic: Elastic) -> FloatArray:
    """(6, 6) in the order xx, yy, zz, xy, yz, zx from Abaqus's xx, yy, zz, xy, xz, yz, listed column by column."""
    if elastic.kind == "ANISOTROPIC":
        D = symmetric(elastic.values, 6)
    else:
        D = np.diag([0.0, 0.0, 0.0, *elastic.values[6:]])
        D[:3, :3] = symmetric(elastic.values[:6], 3)
    order = np.array([0, 1, 2, 3, 5, 4])
    D = D[np.ix_(order, order)]
    require_stable(D, elastic.where)
    return D


def _material(deck: Outline, name: str, block: Block) -> RawMaterial:
    elastic: Elastic | None = None
    density: float | None = None
    alpha = beta = 0.0
    heat: Expansion | None = None
    for option in block.options:
        if option.name == "ELASTIC":
            elastic = _elastic(deck, name, option)
        elif option.name in ("HYPERELASTIC", "HYPERFOAM"):
            elastic = Elastic("ISOTROPIC", small_strain(name, option), option.where)
            E, nu = elastic.values
            why = f"creak takes it at zero strain: E = {E:.6g}, nu = {nu:.4g}"
            deck.note(option, why, changes=False, what=f"*{option.name} of {name}")
        elif option.name == "DENSITY":
            fields, where = _row(deck, name, option, 1)
            density = positive(fields[0], where, f"density of material {name!r}")
        elif option.name == "DAMPING":
            alpha, beta = _damping(deck, name, option)
        elif option.name == "EXPANSION":
            heat = read_expansion(name, option)
    return RawMaterial(name, block.where, elastic, density, alpha, beta, heat)


TRACTION = "TRACTION"
_COUNTS = {"TRACTION": 3, "ISOTROPIC": 2, "LAMINA": 6, "ENGINEERING CONSTANTS": 9, "ORTHOTROPIC": 9, "ANISOTROPIC": 21}
"""Number of constants of each kind of *ELASTIC."""
_MODULI = {"TRACTION": (0, 1, 2), "LAMINA": (0, 1, 3, 4, 5), "ENGINEERING CONSTANTS": (0, 1, 2, 6, 7, 8)}
"""Which of them must be positive."""


def _elastic(deck: Outline, name: str, option: Block) -> Elastic:
    kind = option.option("TYPE", "ISOTROPIC")
    kind = f"{kind}TROPIC" if kind in ("ISO", "ORTHO", "ANISO") else kind.removeprefix("UNCOUPLED ")
    if kind not in _COUNTS:
        raise option.error(
            f"*ELASTIC, TYPE={kind} in material {name!r}",
            expected=f"TYPE={', '.join(_COUNTS)}",
            fix="Give one of these kinds of elasticity.",
        )
    fields, where = _row(deck, name, option, _COUNTS[kind])
    if kind == "ISOTROPIC":
        youngs = positive(fields[0], where, f"Young's modulus of material {name!r}")
        nu = to_float(fields[1] if len(fields) > 1 else "", where, f"Poisson's ratio of material {name!r}")
        check_poisson(nu, name, where)
        return Elastic(kind, (youngs, nu), where)
    values = floats(fields, where, f"constant of material {name!r}", _COUNTS[kind])
    for k in _MODULI.get(kind, ()):
        positive(fields[k] if k < len(fields) else "", where, f"constant {k + 1} of material {name!r}")
    return Elastic(kind, tuple(values), where)


def check_poisson(nu: float, name: str, where: str) -> None:
    """Raise InputError unless -1 < nu < 0.5."""
    if not -1.0 < nu < 0.5:
        raise InputError(
            f"Poisson's ratio of material {name!r} is {nu:g}",
            expected="more than -1 and less than 0.5",
            where=where,
            fix="Correct nu.",
        )


def _row(deck: Outline, name: str, option: Block, n_values: int) -> tuple[list[str], str]:
    """The values of the only entry, or of all entries at the initial temperature."""
    found = at_temperature(deck, option, n_values)
    return _single_row(name, option, n_values) if found is None else ([repr(v) for v in found[0]], found[1])


def _single_row(name: str, option: Block, n_values: int) -> tuple[list[str], str]:
    """The values of the only entry, over as many lines as they need (8 each); a temperature at the end is left out."""
    rows = list(option.rows())
    if not rows:
        raise option.error(f"*{option.name} of material {name!r} has no data line", fix="Add its values.")
    n_lines = -(-n_values // 8)
    if len(rows) > n_lines or option.has("DEPENDENCIES"):
        raise InputError(
            f"*{option.name} of material {name!r} depends on fields, or its lines are not one for each temperature",
            expected="one line of values" if n_lines == 1 else f"{n_values} values on {n_lines} lines",
            where=rows[-1][1],
            fix="Keep the line of the temperature to be analysed.",
        )
    where = rows[0][1]
    fields = [f for line, _ in rows[:-1] for f in [*line, *[""] * 8][:8]] + rows[-1][0]
    if len(fields) > n_values + 1:
        raise InputError(
            f"*{option.name} of material {name!r} has {len(fields)} values",
            expected=f"{n_values}",
            where=where,
            fix="Remove the others.",
        )
    return fields, where


def _damping(deck: Outline, name: str, option: Block) -> tuple[float, float]:
    """Of Rayleigh; structural damping is no part of Abaqus's direct integration either."""
    values = []
    for param in ("ALPHA", "BETA", "STRUCTURAL"):
        value = to_float(option.get(param), option.where, f"{param} of material {name!r}")
        if value < 0.0:
            raise option.error(
                f"damping {param} of material {name!r} is {value:g}", expected="zero or more", fix="Correct it."
            )
        values.append(value)
    alpha, beta, structural = values
    if structural:
        why = (
            "it acts over frequency alone, in Abaqus too: in time give [damping] in the study "
            f"(modal = {structural / 2.0:g} does the same at resonance)"
        )
        what, share = "*DAMPING, STRUCTURAL", 0.5 * structural
        deck.note(option, why, changes=False, what=what, damps=True, share=share, share_of=name)
    return alpha, beta


def read_expansion(material: str, option: Block) -> Expansion | None:
    """The coefficients; ones that creak cannot use stop only a run that heats them (`Expansion.flaw`).

    ZERO matters to coefficients that depend on temperature alone: the strain of constant ones counts from the initial
    temperature. None: those of a pore fluid.

    Raises
    ------
    InputError : not a number.
    """
    what = f"*EXPANSION of {material} ({option.where})"
    kind = option.option("TYPE", "ISO")
    if option.has("PORE FLUID"):
        return None
    if option.has("USER") or option.has("DEPENDENCIES") or option.has("FIELD") or kind not in COEFFICIENTS:
        return isotropic_expansion(0.0, flaw=f"{what} is none by constants, TYPE=ISO or ORTHO")
    count = COEFFICIENTS[kind]
    short = next((where for fields, where in option.rows() if len([f for f in fields if f]) < count), "")
    if short:
        raise InputError(
            f"*EXPANSION of {material} has fewer than {count} coefficients",
            expected=f"{count} for TYPE={kind}",
            where=short,
            fix="Complete the line.",
        )
    rows = [floats(fields, where, f"coefficient of {what}", count) for fields, where in option.rows()]
    if not rows:
        return isotropic_expansion(0.0, flaw=f"{what} has no data line")
    if any(row != rows[0] for row in rows):
        return isotropic_expansion(0.0, flaw=f"{what} depends on temperature")
    if any(rows[0][3:]):
        return isotropic_expansion(0.0, flaw=f"{what} shears")
    if count == 1:
        return isotropic_expansion(rows[0][0])
    a, b, c = rows[0][:3]
    return Expansion((a, b, c, 0.0, 0.0, 0.0))
