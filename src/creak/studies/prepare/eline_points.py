"""The points of a drawn E-line: places along it, or pairs of nodes, from the study or from a file."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.node_to_surface import nodes_of
from creak.errors import InputError
from creak.formats.measured.csv_rows import number
from creak.model.mesh import Model
from creak.model.units import UNITS
from creak.studies.design.named_nodes import node_labels, nodes_at
from creak.studies.file.case import Lines
from creak.studies.file.eline_tables import ElineTable
from creak.studies.file.named_columns import ColumnTable, Wanted, read_columns

AXIS = re.compile(r"([+-]?)([xyz])", re.IGNORECASE)
FIX_POINT = (
    "Correct the coordinates, or name their unit in the head, as x1 [mm].",
    "Give main and secondary, the sets that the points lie on, or labels of nodes.",
)
SIDES = {"main": ("1", "a", "main", "master", "start"), "secondary": ("2", "b", "secondary", "slave", "end")}
"""Sides of a pair, and what files add to `node` or `x` for them."""
ENDS = {side: tuple(f"{axis}{k}" for axis in "xyz") for k, side in ((1, "main"), (2, "secondary"))}
PLACE, NORMAL = ("x", "y", "z"), ("normal_x", "normal_y", "normal_z")
FORMS = (("main", "secondary"), (*ENDS["main"], *ENDS["secondary"]), PLACE)
"""Columns that a file has to have: labels of both nodes, coordinates of both points, or of one; the first that fits."""
HEADERS = " or ".join(",".join(form) for form in (FORMS[2], *FORMS[:2]))


@dataclass(frozen=True)
class Pairs:
    """Pairs of nodes, one of each side."""

    main: IntArray
    """(p,) rows"""
    secondary: IntArray
    """(p,) rows"""
    names: tuple[str, ...]
    """(p,) of the points."""
    normals: FloatArray
    """(p, 3) unit direction from main to secondary; nan: along the line between the nodes."""
    axes: BoolArray
    """(p,) the direction is an axis without a sign: either way."""
    where: tuple[str, ...]
    """(p,) what messages name."""


def pairs_of(model: Model, t: ElineTable, main: IntArray, secondary: IntArray, where: str) -> Pairs:
    """Pairs of nodes with the direction that the study gives.

    Raises
    ------
    InputError : a normal of no length.
    """
    normals = np.full((main.size, 3), math.nan)
    if t.normal is not None:
        length = float(np.linalg.norm(t.normal))
        if not length > 0.0:
            raise InputError(f"normal = {list(t.normal)} has no direction", where=where)
        normals[:] = np.array(t.normal) / length
    names = tuple(model.nodes.label(int(i)) for i in secondary)
    return Pairs(main, secondary, names, normals, np.zeros(main.size, dtype=bool), (where,) * main.size)


def places_or_pairs(model: Model, t: ElineTable, name: str, given: Lines) -> FloatArray | Pairs:
    """Coordinates (k, 3) of the points that a line lists, or pairs of nodes.

    Raises
    ------
    InputError : a file that cannot be used (`read_points`), that names nodes beside the sides of the line, or places
        without them; unknown nodes, points off the mesh, directions that cannot be read or stand beside `normal`.
    """
    where = given.places.where("eline", name, "points")
    if not isinstance(t.points, str):
        return np.array(t.points, dtype=np.float64)
    path = given.places.sibling(t.points)
    table = read_points(path, where, {str(column): name for column, name in t.columns.items()}, given.units)
    directed = {"direction", *NORMAL} & table.cells.keys()
    if table.form == PLACE:
        if t.main is None:
            raise InputError(
                f"{t.points} has coordinates, and the line no sides that they lie between",
                where=where,
                expected="main and secondary",
                fix="Name both sets.",
            )
        if directed:
            raise InputError(
                f"{t.points} has places along the line and the directions {', '.join(sorted(directed))}",
                where=where,
                expected="directions of pairs of points alone",
                fix="Take the column out, and give normal where the main side has no facets.",
            )
        return np.array([table.numbers(k, PLACE) for k in range(len(table.lines))])
    if table.form == ("main", "secondary"):
        main, secondary = _labelled(model, table)
        if t.main is not None:
            raise InputError(
                "the file of points names nodes, and the line has main and secondary too",
                where=where,
                fix="Leave out main and secondary, or give x,y,z.",
            )
    else:
        main, secondary = (
            _nearest(model, t, table, side, given.places.where("eline", name), UNITS[given.units].length)
            for side in ENDS
        )
    if directed and t.normal is not None:
        raise InputError(
            f"{t.points} has the directions {', '.join(sorted(directed))}, and the line a normal",
            where=where,
            expected="one of them",
            fix="Leave out normal.",
        )
    plain = pairs_of(model, t, main, secondary, given.places.where("eline", name, "normal"))
    axes, normals = plain.axes.copy(), plain.normals
    if directed:
        for k in range(main.size):
            normals[k], axes[k] = _direction(table, k)
    at = tuple(table.where(k) for k in range(main.size))
    return Pairs(main, secondary, _names(table, plain.names), normals, axes, at)


def _labelled(model: Model, table: ColumnTable) -> tuple[IntArray, IntArray]:
    known = node_labels(model, np.arange(model.nodes.count))
    rows: dict[str, IntArray] = {}
    for side in ("main", "secondary"):
        for k, label in enumerate(table.cells[side]):
            if label.upper() not in known:
                raise InputError(
                    f"unknown node {label!r}",
                    where=table.where(k),
                    expected="labels of nodes of the deck: main,secondary",
                    fix="Correct the label.",
                )
        rows[side] = np.array([known[label.upper()] for label in table.cells[side]], dtype=np.int64)
    return rows["main"], rows["secondary"]


def _nearest(model: Model, t: ElineTable, table: ColumnTable, side: str, where: str, unit: str) -> IntArray:
    """Rows of the nodes at the points of one side: of its set where the line names it, else of the model."""
    points = np.array([table.numbers(k, ENDS[side]) for k in range(len(table.lines))])
    name = t.main if side == "main" else t.secondary
    among = np.arange(model.nodes.count) if name is None else nodes_of(model, name, where=f"{where} {side}").rows
    return nodes_at(model, among, points, None, table.where, FIX_POINT, unit)[0]


def _direction(table: ColumnTable, k: int) -> tuple[FloatArray, bool]:
    """Unit direction of a row, nan where it has none; whether it is an axis without a sign.

    Three columns, or one with an axis (x, +x, -x) or three numbers.
    """
    columns = [name for name in (*NORMAL, "direction") if name in table.cells]
    text = " ".join(filter(None, (table.cells[name][k] for name in columns)))
    if not text:
        return np.full(3, math.nan), False
    axis = AXIS.fullmatch(text)
    if axis is not None:
        sign = -1.0 if axis[1] == "-" else 1.0
        return sign * np.eye(3)["xyz".index(axis[2].lower())], not axis[1]
    bare = text.strip("()[]{} ")
    words = bare.split() if len(bare.split()) == 3 else bare.split(",")
    vector = np.array([number(word.strip(", ")) for word in words])
    if vector.size != 3 or not np.isfinite(vector).all() or not np.linalg.norm(vector) > 0.0:
        raise InputError(
            f"got the direction {text!r}",
            where=table.where(k),
            expected="an axis, as x or -z, or three numbers that are not all 0",
            fix="Repair the row.",
        )
    return vector / np.linalg.norm(vector), False


def _names(table: ColumnTable, labels: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the points: their ids, with the label of the node where an id repeats; the label where there is none."""
    ids = table.cells.get("id", ("",) * len(labels))
    count = Counter(ids)
    return tuple(
        label if not text else text if count[text] == 1 else f"{text}:{label}"
        for text, label in zip(ids, labels, strict=True)
    )


def _synonyms() -> dict[str, str]:
    """A name in a file, in small letters and digits alone -> the column that it means."""
    found = {axis: axis for axis in PLACE} | dict.fromkeys(("direction", "dir", "normal"), "direction")
    found |= dict.fromkeys(("id", "name", "no", "nr", "point", "pointid", "elineid", "pairid", "eline"), "id")
    for side, ends in SIDES.items():
        found |= dict.fromkeys((end for end in ends if len(end) > 3 and end != "start"), side)
        for end in ends:
            nodes = ("node{}", "nodeid{}", "node{}id", "n{}", "nid{}", "grid{}", "gid{}", "{}node", "{}nodeid")
            found |= dict.fromkeys((word.format(end) for word in nodes), side)
            for axis, column in zip(PLACE, ENDS[side], strict=True):
                places = ("{1}{0}", "{0}{1}", "node{0}{1}", "point{0}{1}", "p{0}{1}")
                found |= dict.fromkeys((word.format(end, axis) for word in places), column)
    for axis, column in zip(PLACE, NORMAL, strict=True):
        normals = ("n{}", "normal{}", "{}normal", "dir{}", "direction{}")
        found |= dict.fromkeys((word.format(axis) for word in normals), column)
    return found


WANTED = Wanted("file of points", FORMS, _synonyms(), frozenset((*FORMS[1], *PLACE)), HEADERS)


def read_points(path: Path, where: str, named: Mapping[str, str], units: str) -> ColumnTable:
    """The points of a CSV file, its `form` one of `FORMS` (`named_columns.read_columns` says the rest)."""
    return read_columns(path, where, WANTED, named, units)
