"""Mode shapes and time histories -> Nastran punch files.

Source: the formats of NASTRAN's punch routine (OFPPUN), real output of grid points: head lines of 72 columns with `$`
first; I10,7X,A1,1P3E18.6 for a point, 1PE16.6,1X,A1,1P3E18.6 for an instant, -CONT-,12X,1P3E18.6 for its rotations; the
number of the line, I8, in columns 73 to 80.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from creak.arrays import FloatArray
from creak.formats.complete_file import complete_file
from creak.formats.measured.csv_rows import holdable, plain_text, unique_labels
from creak.model.mesh import Model

EIGENVECTOR, DISPLACEMENTS, MPCF = "$EIGENVECTOR", "$DISPLACEMENTS", "$MPCF"
"""Kinds of output; the last one is of forces between points."""
WIDTH, COUNTED = 72, 10**8
"""Columns before the number of a line, and where that starts anew."""
TITLE = WIDTH - 12
"""Characters of a title."""
BY_CREAK = "written by creak"
"""Start of the subtitle, by which an earlier file of creak is known."""


@dataclass(frozen=True)
class PointHistory:
    """Six components of one point over time."""

    kind: str
    """`DISPLACEMENTS` or `MPCF`."""
    subcase: int
    point: int
    label: str
    """What the point is."""
    time: FloatArray
    """(n_time,) s"""
    values: FloatArray
    """(n_time, 6) T1 T2 T3 R1 R2 R3"""


def write_mode_punch(
    path: Path, model: Model, frequencies: Sequence[float], motions: Iterable[FloatArray], *, title: str = ""
) -> None:
    """Write each mode as real eigenvectors, SORT1: a line with the translations of each node, one with its rotations.

    Labels are the deck's; where instances repeat them, nodes are numbered 1, 2, ... in the order of the model.
    Numbers have seven digits. `$EIGENVALUE` is (2 pi f)^2, in (rad/s)^2.

    Parameters
    ----------
    frequencies : (n_mode,) Hz. motions : (n_node, 6) for each mode in turn, mass-normalised; taken one at a time.
    """
    labels = unique_labels(model.nodes.ids).tolist()

    def lines() -> Iterator[str]:
        for mode, (f, motion) in enumerate(zip(frequencies, motions, strict=True), start=1):
            words = f"{BY_CREAK}: mass-normalised modes"
            yield from _head(title or model.source, words, f"mode {mode}, {f:.6g} Hz", EIGENVECTOR, 1)
            yield f"$EIGENVALUE ={(2.0 * math.pi * f) ** 2:15.7E}  MODE ={mode:6d}"
            yield from _rows([f"{label:10d}{'':7}G" for label in labels], motion)

    _write(path, lines())


def write_history_punch(path: Path, histories: Iterable[PointHistory], *, title: str, units: str) -> None:
    """Write the points over time, SORT2: a head with `$POINT ID` for each, then two lines for each instant.

    Numbers have seven digits, times too.

    Parameters
    ----------
    units : named in the subtitle, for a punch file has no place for them.
    """

    def lines() -> Iterator[str]:
        for h in histories:
            yield from _head(title, f"{BY_CREAK}: {units}", h.label, h.kind, h.subcase)
            yield f"$POINT ID ={h.point:12d}  IDENTIFIED BY TIME"
            yield from _rows([f"{t:16.6E} G" for t in h.time.tolist()], h.values)

    _write(path, lines())


def _head(title: str, subtitle: str, label: str, kind: str, subcase: int) -> Iterator[str]:
    for name, words in (("$TITLE   =", title), ("$SUBTITLE=", subtitle), ("$LABEL   =", label)):
        yield f"{name}{plain_text(words, TITLE)}"
    yield from (kind, "$REAL OUTPUT", f"$SUBCASE ID ={subcase:12d}")


def _rows(first: list[str], values: FloatArray) -> Iterator[str]:
    """Two lines a row of (n, 6) values: `first` with the translations, then the rotations."""
    for start, (a, b, c, d, e, f) in zip(first, holdable(values).tolist(), strict=True):
        yield f"{start}{a:18.6E}{b:18.6E}{c:18.6E}"
        yield f"-CONT-{'':12}{d:18.6E}{e:18.6E}{f:18.6E}"


def _write(path: Path, lines: Iterator[str]) -> None:
    with complete_file(path) as partial, partial.open("w", encoding="ascii", newline="\n") as file:
        file.writelines(f"{line:<{WIDTH}}{k % COUNTED:8d}\n" for k, line in enumerate(lines, start=1))
