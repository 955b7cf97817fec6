"""*BOUNDARY and *INITIAL CONDITIONS."""

from __future__ import annotations

from collections.abc import Sequence

from creak.errors import InputError, suggest
from creak.formats.abaqus.joints.couplings import note_rotated
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.names import Registry
from creak.formats.abaqus.text.numbers import dof_range, to_dof, to_float
from creak.formats.abaqus.text.outline import Outline
from creak.model.constraints import Fixed

_NAMED = {
    "ENCASTRE": (1, 2, 3, 4, 5, 6),
    "PINNED": (1, 2, 3),
    "XSYMM": (1, 5, 6),
    "YSYMM": (2, 4, 6),
    "ZSYMM": (3, 4, 5),
    "XASYMM": (2, 3, 4),
    "YASYMM": (1, 3, 5),
    "ZASYMM": (1, 2, 6),
}


def read_boundaries(deck: Outline, nodes: Registry, held: Sequence[Block] = ()) -> list[Fixed]:
    """Dofs held at zero, in the model data and in the steps in force, whose OP=NEW takes those of the model data away.

    Non-zero values in the step are left to the study's [excitation], but for the blocks `held`, which fix their dofs.

    Raises
    ------
    InputError : unknown node or set, dof outside 1..6, non-zero value in the model data.
    """
    result: list[Fixed] = []
    for scope, block in deck.blocks("BOUNDARY"):
        note_rotated(deck, scope, block)
        result += _fixed(block, scope.name, nodes, in_step=False)
    if any(block.option("OP", "MOD") == "NEW" for block in deck.step_boundaries):
        result = []
    for block in deck.step_boundaries:
        result += _fixed(block, "", nodes, in_step=True, held=any(block is b for b in held))
    return result


def model_boundaries(deck: Outline, nodes: Registry) -> list[Fixed]:
    """Dofs that the model data alone hold at zero.

    Raises
    ------
    InputError : as `read_boundaries`.
    """
    return [f for scope, block in deck.blocks("BOUNDARY") for f in _fixed(block, scope.name, nodes, in_step=False)]


def boundary_dofs(fields: Sequence[str], where: str) -> tuple[tuple[int, ...], float | None]:
    """Dofs of a *BOUNDARY line and their value; None for a named condition (ENCASTRE, PINNED, ...).

    Raises
    ------
    InputError : no dof, an unknown name, a dof outside 1..6, a value that is no number.
    """
    if len(fields) < 2:
        raise InputError(
            f"*BOUNDARY on {fields[0]} names no degree of freedom",
            expected="node or set, first dof, last dof; or ENCASTRE, PINNED, XSYMM, ...",
            where=where,
            fix="Complete the line.",
        )
    dofs = _NAMED.get(fields[1].upper())
    if dofs is not None:
        return dofs, None
    if fields[1][:1].isalpha():
        raise InputError(
            f"*BOUNDARY on {fields[0]} is of unknown type {fields[1]!r}",
            expected=", ".join(_NAMED),
            where=where,
            fix=suggest(fields[1], _NAMED),
        )
    dofs = dof_range(fields[1:3], where)
    return dofs, to_float(fields[3] if len(fields) > 3 else "", where, "boundary value")


def _fixed(block: Block, scope: str, nodes: Registry, *, in_step: bool, held: bool = False) -> list[Fixed]:
    result: list[Fixed] = []
    for fields, where in block.rows():
        rows = nodes.find(fields[0], scope, where)
        dofs, value = boundary_dofs(fields, where)
        if value and in_step and not held:
            continue
        if value and not in_step:
            raise InputError(
                f"*BOUNDARY on {fields[0]} prescribes {value:g}",
                expected="0 in the model data",
                where=where,
                fix="Prescribe motion in the study's [excitation].",
            )
        result.append(Fixed(rows, dofs, where))
    return result


def read_initial_velocity(deck: Outline, nodes: Registry) -> list[tuple[int, int, float]]:
    """*INITIAL CONDITIONS, TYPE=VELOCITY; other types are listed as unread.

    Raises
    ------
    InputError : TYPE missing, unknown node or set, dof outside 1..6, not a number.
    """
    result: list[tuple[int, int, float]] = []
    for scope, block in deck.blocks("INITIAL CONDITIONS"):
        kind = block.need("TYPE").upper()
        if kind != "VELOCITY":
            harmless = kind in ("TEMPERATURE", "CONTACT")
            why = "creak reads TYPE=VELOCITY"
            if kind == "TEMPERATURE":
                why = "it acts only together with temperatures: *TEMPERATURE of a *STATIC step, a study's [[static]]"
            deck.note(block, why, changes=not harmless, what=f"*INITIAL CONDITIONS, TYPE={kind}")
            continue
        for fields, where in block.rows():
            if len(fields) != 3:
                raise InputError(
                    f"*INITIAL CONDITIONS line with {len(fields)} values",
                    expected="node or set, dof, velocity",
                    where=where,
                    fix="Correct the line.",
                )
            dof, value = to_dof(fields[1], where), to_float(fields[2], where, "velocity")
            result += [(int(row), dof, value) for row in nodes.find(fields[0], scope.name, where)]
    return result
