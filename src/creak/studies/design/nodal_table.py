"""CSV files with a number for each of some nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from creak.arrays import IntArray
from creak.errors import InputError, suggest
from creak.model.mesh import Model
from creak.studies.design.named_nodes import node_labels
from creak.studies.file.tables import read_rows


@dataclass(frozen=True)
class Column:
    """What the numbers are, in words."""

    name: str
    """Header of the column after `node`."""
    among: str
    """Where the nodes are: "on 'FLANGE'"."""
    expected: str
    """"a node of ..."."""
    else_kept: str
    """What a node without a row keeps."""


def nodal_values(path: Path, model: Model, nodes: IntArray, column: Column, where: str) -> dict[int, float]:
    """Numbers by node row, from a CSV file with the header node,NAME (further columns are not used).

    Parameters
    ----------
    nodes : rows that may be named; in decks with instances the label alone will do where it is unique among them.

    Raises
    ------
    InputError : no such file, wrong header, no rows; a row without node, with an unknown node, with one that is not
        among the nodes or was there before, or with a value that is no finite number.
    """
    rows = read_rows(path, where, f"table of {column.name}s", ["node", column.name])
    known = node_labels(model, nodes)
    result: dict[int, float] = {}
    for line, row in rows:
        node, value = _node(row, f"{path}:{line}", known, model, column), _number(row, f"{path}:{line}", column)
        if node in result:
            raise InputError(
                f"node {row[0].strip()} has a second row",
                where=f"{path}:{line}",
                expected="one row for each node",
                fix="Remove one of them.",
            )
        result[node] = value
    if not result:
        raise InputError("the table has no rows", where=path, expected=f"node,{column.name} lines", fix="Add them.")
    return result


def _node(row: list[str], where: str, known: dict[str, int], model: Model, column: Column) -> int:
    label = row[0].strip().upper()
    if not label:
        raise InputError("a row without a node", where=where, expected=f"node,{column.name}", fix="Name the node.")
    if label not in known:
        exists = label in {str(i) for i in model.nodes.ids.tolist()} or "." in label
        what = f"node {row[0].strip()} is not {column.among}" if exists else f"unknown node {row[0].strip()}"
        raise InputError(
            what,
            where=where,
            expected=column.expected,
            fix=suggest(label, known) if len(known) < 10_000 else "Correct the label.",
        )
    return known[label]


def _number(row: list[str], where: str, column: Column) -> float:
    text = row[1].strip() if len(row) > 1 else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(
            f"the {column.name} of node {row[0].strip()} is {text!r}",
            where=where,
            expected="a finite number",
            fix=f"Repair the row, or remove it to keep {column.else_kept}.",
        )
    return value
