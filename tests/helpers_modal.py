"""A clamped strip, and files of a modal test that measured its modes without error."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from creak.studies.models.deck_modes import DeckModes, deck_modes
from helpers_decks import STEEL, strip

COUNT = 6
SHELL = "*SHELL SECTION, ELSET=S, MATERIAL=STEEL\n1.0,\n*BOUNDARY\nROOT_S, 1, 6\n"
NODES = [4, 7, 10, 13, 20, 23, 26, 30, 33, 36, 39]
"""Labels of the nodes that are measured: three rows along the strip, none at a place where another is."""


def strip_deck(folder: Path) -> Path:
    """120 x 20 x 1 mm in mm-t-s, clamped at x = 0."""
    path = folder / "strip.inp"
    path.write_text(f"*HEADING\nstrip\n{strip(1, 1, 'S', 0.0)}{STEEL}{SHELL}", encoding="utf-8")
    return path


@dataclass
class Test:
    """What was measured: points (n, 3) with labels, translations (n_mode, n, 3) in global axes, Hz and damping."""

    __test__ = False
    labels: list[int]
    points: np.ndarray
    shapes: np.ndarray
    frequencies: np.ndarray
    damping: np.ndarray
    frames: dict[int, np.ndarray] = field(default_factory=dict)
    """Label -> (4, 3) rows of data set 2420."""
    kinds: dict[int, int] = field(default_factory=dict)


def measured_strip(deck: Path) -> tuple[DeckModes, Test]:
    """The modes of the strip, and a test that found them."""
    found = deck_modes(deck, count=COUNT)
    rows = [int(np.flatnonzero(found.model.nodes.ids == label)[0]) for label in NODES]
    shapes = np.stack([u[rows] for u in found.translations()])
    frequencies = np.array(found.frequencies)
    return found, Test([*NODES], found.model.nodes.coords[rows], shapes, frequencies, 0.01 + 1e-4 * frequencies / 100)


def e13(values) -> str:
    """Six to a line."""
    texts = [f"{v:13.5E}" for v in np.ravel(values)]
    return "\n".join("".join(texts[k : k + 6]) for k in range(0, len(texts), 6))


def data_set(number: int, *lines: str) -> str:
    return "\n".join(["    -1", f"{number:6d}", *lines, "    -1"]) + "\n"


def points_15(t: Test, defined: int = 0, moved: int = 0, points: np.ndarray | None = None) -> str:
    at = t.points if points is None else points
    rows = [f"{n:10d}{defined:10d}{moved:10d}{8:10d}{e13(x)}" for n, x in zip(t.labels, at, strict=True)]
    return data_set(15, *rows)


def points_2411(t: Test, moved: int = 0) -> str:
    rows = []
    for n, x in zip(t.labels, t.points, strict=True):
        rows += [f"{n:10d}{1:10d}{moved:10d}{8:10d}", "".join(f"{v:25.16E}" for v in x).replace("E", "D")]
    return data_set(2411, *rows)


def frames_2420(t: Test) -> str:
    rows = [f"{1:10d}", "PART"]
    for label, matrix in t.frames.items():
        rows += [f"{label:10d}{t.kinds.get(label, 0):10d}{8:10d}", f"CS{label}"]
        rows += ["".join(f"{v:25.16E}" for v in row) for row in matrix]
    return data_set(2420, *rows)


def units_164(factor: float) -> str:
    line = "".join(f"{v:25.17E}" for v in (factor, 1.0, 1.0)).replace("E", "D")
    return data_set(164, f"{9:10d}{'units':<20}{2:10d}", line, f"{273.15:25.17E}".replace("E", "D"))


def normal_mode(t: Test, k: int, values=None, kind: int = 8, hysteretic: bool = False) -> str:
    """A data set 55 of a normal mode; complex where the values are."""
    u = t.shapes[k] if values is None else values
    zeta = t.damping[k]
    ends = (0.0, 2.0 * zeta) if hysteretic else (zeta, 0.0)
    third = f"{2:10d}{4:10d}{1:10d}{k + 1:10d}\n" + e13([t.frequencies[k], 1.0, *ends])
    return _mode(t, u, 2, kind, third)


def complex_mode(t: Test, k: int, values=None, analysis: int = 3, sign: float = 1.0, counted: int = 1) -> str:
    """A data set 55 of a complex mode, eigenvalue in rad/s; `counted` 2: the head counts real and imaginary parts."""
    omega, zeta = 2.0 * math.pi * t.frequencies[k], t.damping[k]
    eigenvalue = [-zeta * omega, sign * omega * math.sqrt(1.0 - zeta**2)]
    third = f"{2:10d}{6:10d}{1:10d}{k + 1:10d}\n" + e13([*eigenvalue, 1.0, 0.0, 1.0, 0.0])
    return _mode(t, (t.shapes[k] if values is None else values) + 0j, analysis, 8, third, counted)


def _mode(t: Test, u, analysis: int, kind: int, third: str, counted: int = 1) -> str:
    is_complex, per_node = np.iscomplexobj(u), u.shape[1]
    head = (1, analysis, {3: 2, 6: 3}[per_node], kind, 5 if is_complex else 2, counted * per_node)
    lines = ["TEST", "NONE", "NONE", "NONE", "NONE", "".join(f"{v:10d}" for v in head), third]
    for n, row in zip(t.labels, u, strict=True):
        flat = np.column_stack([row.real, row.imag]).ravel() if is_complex else row
        lines += [f"{n:10d}", e13(flat)]
    return data_set(55, *lines)


def every_mode(t: Test, **options) -> str:
    return "".join(normal_mode(t, k, **options) for k in range(len(t.frequencies)))


def csv_text(t: Test, axes=("x", "y", "z"), head: str = "", separator: str = ",", damping: float = 1.0) -> str:
    """A row for each mode, point and axis; axes are x, -y, or vectors as `.6 0 .8`."""
    names = head or "frequency_hz,damping,sensor,x,y,z,direction,value"
    rows = [names.replace(",", separator)]
    for k, f in enumerate(t.frequencies):
        for n, x, u in zip(t.labels, t.points, t.shapes[k], strict=True):
            for axis in axes:
                value = u @ vector(axis)
                cells = [
                    f"{f:.9g}",
                    f"{damping * t.damping[k]:.9g}",
                    str(n),
                    *(f"{v:.9g}" for v in x),
                    axis,
                    f"{value:.9g}",
                ]
                rows.append(separator.join(cells))
    return "\n".join(rows) + "\n"


def vector(axis: str) -> np.ndarray:
    if axis.strip("+-") in "xyz":
        return (-1.0 if "-" in axis else 1.0) * np.eye(3)["xyz".index(axis.strip("+-"))]
    v = np.array([float(w) for w in axis.split()])
    return v / np.linalg.norm(v)
