"""*MASS, *ROTARY INERTIA, *SPRING and *DASHPOT."""

from __future__ import annotations

import numpy as np

from creak.errors import InputError
from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.materials import RawMaterial
from creak.formats.abaqus.numbers import floats, to_dof, to_float
from creak.formats.abaqus.outline import Scope
from creak.model.materials import PointMass, Spring


def read_mass(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> PointMass:
    """*MASS: one isotropic mass.

    Raises
    ------
    InputError : negative, missing or anisotropic mass.
    """
    if block.option("TYPE", "ISOTROPIC") != "ISOTROPIC":
        raise InputError(
            f"*MASS, TYPE={block.option('TYPE')}",
            expected="TYPE=ISOTROPIC",
            where=block.where,
            fix="Give one mass for all directions.",
        )
    fields, where = _row(block, 0, "the mass")
    mass = _not_negative(fields[0], where, "mass")
    return PointMass(block.get("ELSET"), mass=mass, alpha=_alpha(block))


def read_rotary_inertia(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> PointMass:
    """*ROTARY INERTIA: I11, I22, I33, I12, I13, I23, the entries of the inertia tensor.

    In a rotated instance the tensor turns with the instance: I = R I_part R'.

    Raises
    ------
    InputError : a tensor that is not positive semidefinite.
    """
    fields, where = _row(block, 0, "I11, I22, I33, I12, I13, I23")
    i11, i22, i33, i12, i13, i23 = floats(fields, where, "rotary inertia", 6)
    tensor = np.array([[i11, i12, i13], [i12, i22, i23], [i13, i23, i33]])
    turned = scope.rotation @ tensor @ scope.rotation.T
    size = float(np.abs(turned).max())
    if not np.isfinite(turned).all() or (size > 0.0 and np.linalg.eigvalsh(turned / size)[0] < -1e-9):
        raise InputError(
            "the rotary inertia is not that of any body (it has a negative principal value)",
            expected="I11, I22, I33, I12, I13, I23 of a positive tensor",
            where=where,
            fix="Correct the values.",
        )
    t = [[float(v) for v in row] for row in turned]
    inertia = (t[0][0], t[1][1], t[2][2], t[0][1], t[0][2], t[1][2])
    return PointMass(block.get("ELSET"), inertia=inertia, alpha=_alpha(block))


def read_spring(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> Spring:
    """*SPRING: a line with dof 1 (and dof 2), then a line with the stiffness."""
    dof1, dof2, value = _dofs_and_value(block, "stiffness")
    return Spring(block.get("ELSET"), dof1, dof2, stiffness=value)


def read_dashpot(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> Spring:
    """*DASHPOT: a line with dof 1 (and dof 2), then a line with the damping coefficient."""
    dof1, dof2, value = _dofs_and_value(block, "damping coefficient")
    return Spring(block.get("ELSET"), dof1, dof2, damping=value)


def _dofs_and_value(block: Block, what: str) -> tuple[int, int, float]:
    for param in ("NONLINEAR", "COMPLEX STIFFNESS"):
        if block.has(param):
            raise InputError(
                f"*{block.name} with {param}",
                expected=f"a constant {what}",
                where=block.where,
                fix="Describe it as a [[connector]] in the study.",
            )
    fields, where = _row(block, 0, "the degree of freedom")
    dof1 = to_dof(fields[0], where)
    dof2 = to_dof(fields[1], where) if len(fields) > 1 else dof1
    fields, where = _row(block, 1, f"the {what}")
    if len(list(block.rows())) > 2:
        raise InputError(
            f"*{block.name} has more than one {what}",
            expected=f"a line with dofs and a line with the {what}",
            where=list(block.rows())[2][1],
            fix="Keep the one to be analysed.",
        )
    return dof1, dof2, to_float(fields[0], where, what)


def _row(block: Block, number: int, what: str) -> tuple[list[str], str]:
    rows = list(block.rows())
    if len(rows) <= number:
        raise InputError(
            f"*{block.name} has no line with {what}",
            expected=f"{number + 1} data line(s)",
            where=block.where,
            fix="Add it.",
        )
    return rows[number]


def _not_negative(field: str, where: str, what: str) -> float:
    value = to_float(field, where, what)
    if value < 0.0 or not field:
        raise InputError(
            f"{what} is {field or 'missing'}", expected="zero or more", where=where, fix="Correct it."
        )
    return value


def _alpha(block: Block) -> float:
    return _not_negative(block.get("ALPHA", "0"), block.where, "ALPHA")
