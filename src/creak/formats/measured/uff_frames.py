"""Data set 2420 of universal files: the frames in which points are given and moved."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.measured.uff_sets import DataSet

CARTESIAN, CYLINDRICAL, SPHERICAL = 0, 1, 2
RECORDS = 6
"""Lines of a frame."""
SQUARE = 1e-4
"""How far the axes may be from unit length and right angles: frames are also written with six digits."""


@dataclass(frozen=True)
class Frame:
    """A frame: x_global = origin + x_local @ axes, x_local of a cylindrical one (r cos t, r sin t, z)."""

    kind: int
    axes: FloatArray
    """(3, 3) a row for each local axis, in global components."""
    origin: FloatArray
    """(3,)"""

    def place(self, x: FloatArray) -> FloatArray:
        """(3,) in global axes of a point of this frame: x, y, z, or radius, angle in degrees, z."""
        if self.kind == CYLINDRICAL:
            angle = np.radians(x[1])
            x = np.array([x[0] * np.cos(angle), x[0] * np.sin(angle), x[2]])
        return np.asarray(self.origin + x @ self.axes)

    def directions(self, place: FloatArray) -> FloatArray:
        """(3, 3) unit vectors of the motion at a global point: x, y, z, or radial, tangential, axial, a row each."""
        if self.kind == CARTESIAN:
            return self.axes
        local = (place - self.origin) @ self.axes.T
        radius = float(np.hypot(local[0], local[1]))
        if not radius > 0.0:
            return self.axes
        c, s = local[0] / radius, local[1] / radius
        return np.asarray(np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ self.axes)


def read_frames(one: DataSet) -> dict[int, Frame]:
    """The frames of a data set 2420 by their label.

    Three rows are the local axes in global components, the fourth is the origin.

    Raises
    ------
    InputError : the set is cut short, a frame is spherical, or its axes are no right-handed frame of unit vectors.
    """
    found: dict[int, Frame] = {}
    for row in range(2, len(one.lines), RECORDS):
        if not one.lines[row].strip():
            continue
        label, kind = one.integers(row, 2)
        if kind not in (CARTESIAN, CYLINDRICAL):
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
        found[label] = Frame(kind, axes, np.array(rows[3]))
    return found


def frame_axes(frames: dict[int, Frame], label: int, place: FloatArray, path: Path, notes: list[str]) -> FloatArray:
    """(3, 3) directions of the motion at a point; global axes where the file does not tell its frame."""
    if frame := _frame(frames, label, "motion is", path, notes):
        if frame.kind == CYLINDRICAL and not np.isfinite(place).all():
            raise InputError("a point in a cylindrical frame without coordinates", where=path)
        return frame.directions(place)
    return np.eye(3)


def frame_place(frames: dict[int, Frame], label: int, x: FloatArray, path: Path, notes: list[str]) -> FloatArray:
    """(3,) where a point of a frame is in global axes; they are those of its frame where the file does not tell it."""
    frame = _frame(frames, label, "points are", path, notes)
    if frame is not None and frame.kind == CYLINDRICAL:
        notes.append("angles of points in cylindrical frames are taken in degrees")
    return x if frame is None else frame.place(x)


def _frame(frames: dict[int, Frame], label: int, what: str, path: Path, notes: list[str]) -> Frame | None:
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
