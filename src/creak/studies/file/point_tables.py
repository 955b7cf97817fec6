"""Files of points as pre-processors and spreadsheets write them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from creak.studies.file.named_columns import ColumnTable, Wanted, read_columns

SIDES = {"main": ("1", "a", "main", "master", "start"), "secondary": ("2", "b", "secondary", "slave", "end")}
"""Sides of a pair, and what files add to `node` or `x` for them."""
ENDS = {side: tuple(f"{axis}{k}" for axis in "xyz") for k, side in ((1, "main"), (2, "secondary"))}
PLACE, NORMAL = ("x", "y", "z"), ("normal_x", "normal_y", "normal_z")
FORMS = (("main", "secondary"), (*ENDS["main"], *ENDS["secondary"]), PLACE)
"""Columns that a file has to have: labels of both nodes, coordinates of both points, or of one; the first that fits."""
HEADERS = " or ".join(",".join(form) for form in (FORMS[2], *FORMS[:2]))


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
