"""[nodes.NAME] tables: labels and coordinates as node sets of the model, which every key of a study can name; CSV files
with a number for each of some nodes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.model.mesh import Model
from creak.studies.file.model_tables import NodesTable
from creak.studies.file.places import Places
from creak.studies.file.tables import read_rows

REACH = 0.01
"""Of the model's size: how far a node may lie from its point where the study does not say."""
SAME = 1e-9
"""Of the model's size: two nodes nearer to each other than this are at one place."""


def with_named_nodes(
    model: Model, tables: Mapping[str, NodesTable], places: Places, unit: str
) -> tuple[Model, list[str]]:
    """The model with the node sets of the study beside its own, and how far nodes lie from their points.

    Raises
    ------
    InputError : a set of the deck has the name; an unknown label or part; no node near enough, or two at one place.
    """
    sets, notes = dict(model.node_sets), []
    for name, table in tables.items():
        where = places.where("nodes", name)
        if name.upper() in sets:
            raise InputError(
                f"the deck has a node set {name!r} of its own",
                where=where,
                expected="a name that no other set has",
                fix="Rename the table.",
            )
        if table.labels is not None:
            sets[name.upper()] = _by_label(model, table.labels, where)
            continue
        assert table.near is not None
        rows, off = nearest_nodes(model, table.near, table.within, table.part, where, unit)
        sets[name.upper()] = rows
        notes.append(
            f"[nodes.{name}]: node {model.nodes.first_few(rows)}, {off:.3g} {unit} from the given place"
            + " at most" * (rows.size > 1)
        )
    return (replace(model, node_sets=sets), notes) if tables else (model, notes)


def _by_label(model: Model, labels: list[str], where: str) -> IntArray:
    known = node_labels(model, np.arange(model.nodes.count))
    for label in labels:
        if label.upper() not in known:
            several = label.isdigit() and int(label) in model.nodes.ids
            raise InputError(
                f"several instances have a node {label}" if several else f"unknown node {label}",
                where=where,
                expected="the label of one node" + (", as INSTANCE.17" if model.nodes.instance else ""),
                fix="Name the instance too." if several else suggest(label, known) if len(known) < 10_000 else "",
            )
    rows = [known[label.upper()] for label in labels]
    twice = next((label for label, row in zip(labels, rows, strict=True) if rows.count(row) > 1), None)
    if twice is not None:
        raise InputError(f"node {twice} is named twice", where=where, fix="Name it once.")
    return np.array(rows, dtype=np.int64)


def nearest_nodes(
    model: Model,
    near: Sequence[tuple[float, float, float]],
    within: float | None,
    part: str | None,
    where: str,
    unit: str,
) -> tuple[IntArray, float]:
    """Rows of the nodes nearest to some places, of one part or of all, and the largest distance. unit : of length.

    Raises
    ------
    InputError : an unknown part; no node within the distance; two nodes at one place, or one nearest to two.
    """
    among, points = nodes_of_part(model, part, where), np.array(near, dtype=np.float64).reshape(-1, 3)
    fix = ("Correct the place, or raise within.", "Give part, or labels instead of near.")
    rows, off = nodes_at(model, among, points, within, lambda _: where, fix, unit)
    if np.unique(rows).size < rows.size:
        raise InputError("two of the places have the same nearest node", where=where, fix="Give each node one place.")
    return rows, float(off.max())


def nodes_at(
    model: Model,
    among: IntArray,
    points: FloatArray,
    within: float | None,
    where: Callable[[int], str],
    fix: tuple[str, str],
    unit: str,
) -> tuple[IntArray, FloatArray]:
    """Rows of those nodes that lie nearest to each of (n, 3) points, and how far off.

    Parameters
    ----------
    within : how far they may lie off; None: `REACH` of the model's size. where : of each point. fix : what to do where
        no node is near enough, and where two lie at one place. unit : of length.

    Raises
    ------
    InputError : no node within the distance; two nodes at one place.
    """
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    coords, size = model.nodes.coords[among], float(np.linalg.norm(np.ptp(model.nodes.coords, axis=0)))
    reach = within if within is not None else REACH * size
    off, at = (a.reshape(points.shape[0], -1) for a in cKDTree(coords).query(points, k=min(2, among.size)))
    for k, point in enumerate(points):
        nearest = model.nodes.label(int(among[at[k, 0]]))
        place = _words(point)
        if off[k, 0] > reach:
            raise InputError(
                f"no node within {reach:.6g} {unit} of {place}: the nearest, {nearest} at "
                f"{_words(coords[at[k, 0]])}, is {off[k, 0]:.6g} {unit} away",
                where=where(k),
                expected="a place on the mesh, in the deck's axes and units",
                fix=fix[0],
            )
        if among.size > 1 and np.linalg.norm(coords[at[k, 0]] - coords[at[k, 1]]) <= SAME * size:
            other = model.nodes.label(int(among[at[k, 1]]))
            raise InputError(
                f"nodes {nearest} and {other} both lie at {place}",
                where=where(k),
                expected="one node at the place",
                fix=fix[1],
            )
    return among[at[:, 0]].astype(np.int64), off[:, 0]


def nodes_of_part(model: Model, part: str | None, where: str) -> IntArray:
    """Node rows of a part by its name; of the model where none is named."""
    if part is None:
        return np.arange(model.nodes.count)
    for p in model.parts:
        if part.upper() in (p.name.upper(), *(a.upper() for a in p.aliases)):
            return p.nodes_idx
    raise InputError(f"unknown part {part!r}", where=where, fix=suggest(part, [p.name for p in model.parts]))


def _words(place: FloatArray) -> str:
    return f"({', '.join(f'{x:g}' for x in place)})"


def node_labels(model: Model, nodes: IntArray) -> dict[str, int]:
    """Label -> row of `nodes`, upper case; with the instance, and without where that is unique."""
    ids, first, count = np.unique(model.nodes.ids[nodes], return_index=True, return_counts=True)
    short = {str(i): int(nodes[k]) for i, k, n in zip(ids.tolist(), first, count, strict=True) if n == 1}
    return {**short, **{model.nodes.label(int(row)).upper(): int(row) for row in nodes}}


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
