"""*EXPANSION of a material."""

from __future__ import annotations

from creak.errors import InputError
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.numbers import floats
from creak.model.expansion import Expansion, isotropic_expansion

_COUNTS = {"ISO": 1, "ISOTROPIC": 1, "ORTHO": 3, "ORTHOTROPIC": 3, "ANISO": 6, "ANISOTROPIC": 6}
"""TYPE -> coefficients of an entry: a11, a22, a33, a12, a13, a23; a temperature may follow."""


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
    if option.has("USER") or option.has("DEPENDENCIES") or option.has("FIELD") or kind not in _COUNTS:
        return isotropic_expansion(0.0, flaw=f"{what} is none by constants, TYPE=ISO or ORTHO")
    count = _COUNTS[kind]
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
