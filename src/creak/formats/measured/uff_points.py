"""Points of a universal file: data sets 15 and 2411, their frames (2420), lines (82) and units (164).

Source: Universal File Formats for Modal Analysis Testing (SDRC; University of Cincinnati).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.coordinate_systems import CoordinateSystem, axes_at, point_in_basic
from creak.formats.measured.uff_sets import DataSet

SAME = 1e-5
"""Share by which two tellings of a place or unit may differ, which formats of few digits make."""
Frames = dict[int, CoordinateSystem]
"""By their label."""
KINDS = {0: "R", 1: "C"}
"""Cartesian and cylindrical frames, as `CoordinateSystem` has them."""
SPHERICAL = 2
RECORDS = 6
"""Lines of a frame."""
SQUARE = 1e-4
"""How far the axes may be from unit length and right angles: frames are also written with six digits."""


@dataclass(frozen=True)
class _Point:
    coords: FloatArray
    """In the frame that defines it."""
    defined: int
    """Label of that frame, and of the one in which it moves."""
    moved: int


NOWHERE = _Point(np.full(3, np.nan), 0, 0)


@dataclass(frozen=True)
class Points:
    """Where the nodes of a file are, and along what they move."""

    path: Path
    points: dict[int, _Point]
    frames: Frames
    units: tuple[float, float] | None
    """Units of length in 1 m and of force in 1 N, where the file tells."""
    lines: tuple[tuple[str, str], ...]
    """Nodes joined in drawings."""
    notes: list[str]

    def place(self, node: int) -> FloatArray:
        """(3,) in global axes; nan where the file does not tell.

        Raises
        ------
        InputError : the frame that defines it is not in the file.
        """
        p = self.points.get(node, NOWHERE)
        # (3,) where a point of a frame is in global axes; they are those of its frame where the file does not tell it.
        frame = _frame(self.frames, p.defined, "points are", self.path, self.notes)
        if frame is not None and frame.kind == "C":
            self.notes.append("angles of points in cylindrical frames are taken in degrees")
        return p.coords if frame is None else point_in_basic(frame, p.coords)

    def axes(self, node: int) -> FloatArray:
        """(3, 3) unit vectors of its motion, a row each.

        Raises
        ------
        InputError : its frame is not in the file, or needs a place.
        """
        p = self.points.get(node, NOWHERE)
        return frame_axes(self.frames, p.moved, self.place(node), self.path, self.notes)


def require_ended(sets: list[DataSet], *more: str) -> None:
    """Raise InputError where a data set of points, or one of `more`, is cut short."""
    for one in sets:
        if one.number in ("15", "82", "164", "2411", "2420", *more) and not one.ended:
            raise one.short()


def read_points(sets: list[DataSet], path: Path, notes: list[str]) -> Points:
    """The points of a file; what was taken for granted is added to the notes when places and axes are asked for.

    Raises
    ------
    InputError : a data set cannot be read, or a frame is none that creak knows.
    """
    frames = {label: f for one in sets if one.number == "2420" for label, f in read_frames(one).items()}
    every = [(one, label, p) for one in sets for label, p in _points(one)]
    points = {label: p for _, label, p in every}
    _require_one_place(every, points)
    lines = tuple((str(a), str(b)) for one in sets for a, b in _lines(one))
    return Points(path, points, frames, units_told(sets), lines, notes)


def _require_one_place(every: list[tuple[DataSet, int, _Point]], last: dict[int, _Point]) -> None:
    """Raise InputError for a node at two places; places in two frames are not compared.

    Parameters
    ----------
    every : nodes of all data sets. last : of each node its last telling.
    """
    if len(every) == len(last):
        return
    size = max(float(np.abs(p.coords).max()) for p in last.values())
    for one, label, p in every:
        now = last[label]
        if p.defined == now.defined and np.abs(now.coords - p.coords).max() > SAME * size:
            raise InputError(
                f"node {label} is at {p.coords.tolist()}, and again at {now.coords.tolist()}",
                where=one.where(0),
                expected="each node at one place",
                fix="Keep one of the data sets of nodes (15, 2411).",
            )


def _points(one: DataSet) -> Iterator[tuple[int, _Point]]:
    """Nodes: those of data set 15 in the frame that defines them, those of 2411 in the axes of the whole."""
    if one.number == "15":
        for row, line in enumerate(one.lines):
            if line.strip():
                label, defined, moved, _ = one.integers(row, 4)
                yield label, _Point(_three(one, row, 40, 13), defined, moved)
    if one.number == "2411":
        for row in range(0, len(one.lines) - 1, 2):
            label, _, moved, _ = one.integers(row, 4)
            yield label, _Point(_three(one, row + 1, 0, 25), 0, moved)


def _three(one: DataSet, row: int, start: int, width: int) -> FloatArray:
    values = one.numbers(row, start, width)
    if len(values) != 3:
        raise InputError("a node without three coordinates", where=one.where(row), fix="Export the file again.")
    return np.array(values)


def _lines(one: DataSet) -> Iterator[tuple[int, int]]:
    """Ends of trace lines; node 0 lifts the pen."""
    row = 0
    while one.number == "82" and row < len(one.lines) and one.lines[row].strip():
        count = one.integers(row, 2)[1]
        nodes: list[int] = []
        row += 2
        while len(nodes) < count:
            nodes += one.integers(row)
            row += 1
        yield from ((a, b) for a, b in pairwise(nodes) if a and b)


def units_told(sets: list[DataSet]) -> tuple[float, float] | None:
    """What the values of a file are divided by to be in m and N (data set 164); None where it does not tell.

    Raises
    ------
    InputError : a factor is none, or two data sets tell two systems of units.
    """
    told: tuple[float, float] | None = None
    for one in sets:
        if one.number == "164":
            factors = one.numbers(1, 0, 25)
            for name, factor in zip(("length", "force"), factors, strict=False):
                if not factor > 0.0:
                    raise InputError(f"a {name} factor of {factor:g}", where=one.where(1), expected="a positive number")
            here = factors[0], factors[1] if len(factors) > 1 else 1.0
            if told is not None and not np.allclose(here, told, rtol=SAME, atol=0.0):
                raise InputError(
                    f"factors {here[0]:g} and {here[1]:g} for length and force, after {told[0]:g} and {told[1]:g}",
                    where=one.where(1),
                    expected="one system of units in a file (data set 164)",
                    fix="Export the file in one go, or keep its parts in files of their own.",
                )
            told = here
    return told


def read_frames(one: DataSet) -> Frames:
    """The frames of a data set 2420 by their label.

    Three rows are the local axes in global components, the fourth is the origin.

    Raises
    ------
    InputError : the set is cut short, a frame is spherical, or its axes are no right-handed frame of unit vectors.
    """
    found: Frames = {}
    for row in range(2, len(one.lines), RECORDS):
        if not one.lines[row].strip():
            continue
        label, kind = one.integers(row, 2)
        if kind not in KINDS:
            raise InputError(
                f"frame {label} is of type {kind}{' (spherical)' * (kind == SPHERICAL)}",
                where=one.where(row),
                expected="0 (Cartesian) or 1 (cylindrical)",
            )
        rows = [one.numbers(row + 2 + k, 0, 25) for k in range(4)]
        if any(len(r) != 3 for r in rows):
            raise InputError(f"frame {label} has a row without three numbers", where=one.where(row + 2))
        axes = np.array(rows[:3])
        if np.abs(axes @ axes.T - np.eye(3)).max() > SQUARE or np.linalg.det(axes) < 0.0:
            raise InputError(
                f"the axes of frame {label} are no right-handed frame of unit vectors",
                where=one.where(row + 2),
                expected="three rows at right angles, x cross y along z",
                fix="Correct the frame, or export the shapes in global axes.",
            )
        found[label] = CoordinateSystem(KINDS[kind], np.array(rows[3]), axes.T)
    return found


def frame_axes(frames: Frames, label: int, place: FloatArray, path: Path, notes: list[str]) -> FloatArray:
    """(3, 3) directions of the motion at a point; global axes where the file does not tell its frame."""
    if frame := _frame(frames, label, "motion is", path, notes):
        if frame.kind == "C" and not np.isfinite(place).all():
            raise InputError("a point in a cylindrical frame without coordinates", where=path)
        return axes_at(frame, place).T
    return np.eye(3)


def _frame(frames: Frames, label: int, what: str, path: Path, notes: list[str]) -> CoordinateSystem | None:
    """A frame by its label; None for the global one, and where the file has no frames."""
    if label in frames:
        return frames[label]
    if frames and label > 1:
        raise InputError(
            f"frame {label} is not in the file",
            where=path,
            expected=f"data set 2420 with it (there are {', '.join(map(str, frames))})",
            fix="Export the frames too, or points and shapes in global axes.",
        )
    if label > 1:
        notes.append(f"the file has no frames: {what} taken in global axes")
    return None
