"""Temperatures of a deck: of nodes, before and after heating, and of constants that depend on them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from creak.errors import InputError
from creak.formats.abaqus.text.fields import Registry, floats, to_float
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, list_params
from creak.model.steps import NodeTemperatures


def initial_temperature(deck: Outline) -> float | None:
    """The temperature of *INITIAL CONDITIONS, TYPE=TEMPERATURE; None: none is given, which is 0 in Abaqus.

    Raises
    ------
    InputError : it is not one number.
    """
    found: set[float] = set()
    where = ""
    for _, block in deck.blocks("INITIAL CONDITIONS"):
        if block.option("TYPE") == "TEMPERATURE":
            for fields, where in block.rows():
                if len(fields) > 1:
                    found.add(to_float(fields[1], where, "temperature"))
    if len(found) > 1:
        raise InputError(
            f"the deck starts at temperatures from {min(found):g} to {max(found):g}, and materials depend on them",
            expected="one temperature",
            where=where,
            fix="Keep the constants of one temperature in each material.",
        )
    return found.pop() if found else None


def at_temperature(deck: Outline, option: Block, count: int) -> tuple[list[float], str] | None:
    """The constants at the initial temperature, linear between lines, constant beyond; None: one entry only.

    Parameters
    ----------
    count : constants of an entry; its temperature stands after them.

    Raises
    ------
    InputError : the temperatures do not rise, or depend on more.
    """
    rows = list(option.rows())
    lines = -(-(count + 1) // 8)
    if option.has("DEPENDENCIES") or len(rows) <= -(-count // 8) or len(rows) % lines:
        return None
    entries = []
    for k in range(0, len(rows), lines):
        fields = [f for line, _ in rows[k : k + lines - 1] for f in [*line, *[""] * 8][:8]] + rows[k + lines - 1][0]
        entries.append(floats(fields, rows[k][1], f"constant of *{option.name}", count + 1))
    table = np.array(entries)
    if len(table) < 2:
        return None
    if not (np.diff(table[:, -1]) > 0.0).all():
        raise InputError(
            f"the temperatures of *{option.name} do not rise",
            where=rows[-1][1],
            expected="one line for each temperature, rising",
            fix="Sort the lines, or keep one.",
        )
    stated = initial_temperature(deck)
    t = stated or 0.0
    from_where = "of *INITIAL CONDITIONS" if stated is not None else "that Abaqus takes where none is given"
    deck.note(option, f"it depends on temperature; creak takes it at {t:g}, the one {from_where}", changes=False)
    return [float(np.interp(t, table[:, -1], table[:, i])) for i in range(count)], rows[0][1]


def node_temperatures(deck: Outline, nodes: Registry) -> NodeTemperatures | None:
    """*INITIAL CONDITIONS, TYPE=TEMPERATURE; None where the deck has none.

    Raises
    ------
    InputError : unknown node or set, not a number, a gradient through a section.
    """
    found: dict[int, float] = {}
    for scope, block in deck.blocks("INITIAL CONDITIONS"):
        if block.option("TYPE") == "TEMPERATURE":
            _take(found, block, nodes, scope.name)
    return _arrays(found)


def heated(deck: Outline, blocks: Iterable[Block], nodes: Registry) -> NodeTemperatures | None:
    """*TEMPERATURE lines of steps, in order; later ones replace earlier ones on their nodes, OP=NEW on all.

    Raises
    ------
    InputError : as `node_temperatures`; temperatures from a file or subroutine.
    """
    found: dict[int, float] = {}
    for block in blocks:
        other = next((p for p in ("FILE", "USER", "INPUT") if block.has(p)), "")
        if other:
            raise block.error(
                f"*TEMPERATURE, {other} of a *STATIC step",
                expected="lines of node or set, temperature",
                fix="Write them out, or a study with [[static]] temperature.",
            )
        list_params(deck, block, "OP, AMPLITUDE")
        if block.option("OP", "MOD") == "NEW":
            found.clear()
        _take(found, block, nodes, "")
    return _arrays(found)


def _take(found: dict[int, float], block: Block, nodes: Registry, scope: str) -> None:
    for fields, where in block.rows():
        value, *others = [to_float(f, where, "temperature") for f in fields[1:] if f] or [0.0]
        if len(fields) < 2:
            raise InputError(
                f"*{block.name} line with {len(fields)} value(s)", expected="node or set, temperature", where=where
            )
        if any(v not in (0.0, value) for v in others):
            raise InputError(
                f"temperatures that vary through the section, {', '.join(fields)}",
                expected="one temperature of each node",
                where=where,
                fix="creak heats shells and beams evenly through the thickness: give the mean.",
            )
        found.update(dict.fromkeys(nodes.find(fields[0], scope, where).tolist(), value))


def _arrays(found: dict[int, float]) -> NodeTemperatures | None:
    if not found:
        return None
    return NodeTemperatures(np.array(list(found), dtype=np.int64), np.array(list(found.values()), dtype=np.float64))
