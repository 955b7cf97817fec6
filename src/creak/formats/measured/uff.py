"""Mode shapes and time histories -> universal files (UFF), read by modal test software."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.complete_file import complete_file
from creak.formats.measured.csv_rows import holdable, plain_text, unique_labels
from creak.model.faces import HEX20
from creak.model.mesh import Model
from creak.model.units import UNITS, UnitsName

DESCRIPTORS = {
    "quad4": 94,
    "tri3": 91,
    "quad8": 95,
    "tri6": 92,
    "hex8": 115,
    "wedge6": 112,
    "tet4": 111,
    "tet10": 118,
    **dict.fromkeys(HEX20, 116),
    "wedge15": 113,
    "pyramid5": 115,
    "coh8": 115,
    "coh6": 112,
}
"""Finite element descriptors: thin shells and solids. Glue is drawn as a solid; a pyramid is a brick whose upper four
nodes are one, as none has five."""
ORDER = {
    "quad8": [0, 4, 1, 5, 2, 6, 3, 7],
    "tri6": [0, 3, 1, 4, 2, 5],
    "tet10": [0, 4, 1, 5, 2, 6, 7, 8, 9, 3],
    **{kind: [0, 8, 1, 9, 2, 10, 3, 11, 16, 17, 18, 19, 4, 12, 5, 13, 6, 14, 7, 15] for kind in HEX20},
    "wedge15": [0, 6, 1, 7, 2, 8, 12, 13, 14, 3, 9, 4, 10, 5, 11],
    "pyramid5": [0, 1, 2, 3, 4, 4, 4, 4],
}
"""Parabolic elements go round: corner, mid-side, corner, ...; solids so below, mid-sides between, then the top."""
CODES = {"mm-t-s": (10, "mm (newton)"), "m-kg-s": (1, "Meter (newton)"), "in-lbf-s": (7, "Inch (pound f)")}
"""Units code and its name."""
SEGMENTS = 80
"""Two-node elements in one trace line."""

TIME_RESPONSE, TIME = 1, 17
"""Type of function, kind of abscissa."""
DOUBLE, EVEN = 4, 1
DISPLACEMENT, REACTION_FORCE = 8, 9
"""Kinds of ordinate."""
EXPONENTS = {DISPLACEMENT: (1, 0, 0), REACTION_FORCE: (0, 1, 0)}
"""Of length, force and temperature."""


def write_uff(
    path: Path,
    model: Model,
    frequencies: Sequence[float],
    shapes: Iterable[FloatArray],
    units: UnitsName = "mm-t-s",
    *,
    title: str = "",
) -> None:
    """Write nodes, elements and one data set 55 per mode: real translations in global axes, modal mass 1, no damping.

    Shells and solids are data set 2412; beams, trusses and springs are trace lines (82). Labels are the deck's;
    where instances repeat them, nodes (or elements) are numbered 1, 2, ... in the order of the model.

    Parameters
    ----------
    frequencies : (n_mode,) Hz. shapes : (n_node, 3) for each mode in turn, mass-normalised; taken one at a time.
    units : of the deck; they name the units of the file (164).

    Source: Universal File Formats for Modal Analysis Testing (SDRC; University of Cincinnati): widths 6I10, 8I10,
    4I10 with 1P3E13.5, 6E13.5.
    """
    labels = unique_labels(model.nodes.ids)
    with complete_file(path) as partial, partial.open("w", encoding="ascii", newline="\r\n") as file:
        _data_set(file, 164, _units(units))
        _data_set(file, 15, _nodes(labels, model.nodes.coords))
        if any(b.kind in DESCRIPTORS for b in model.blocks):
            _data_set(file, 2412, _elements(model, labels))
        for lines in _trace_lines(model, labels):
            _data_set(file, 82, lines)
        for mode, (frequency, shape) in enumerate(zip(frequencies, shapes, strict=True), start=1):
            _data_set(file, 55, _mode(title or model.source, labels, mode, frequency, shape))


@dataclass(frozen=True)
class Function:
    """One quantity over time, (n_time,) values."""

    title: str
    node: int
    direction: int
    """1, 2, 3: X, Y, Z; 0: none."""
    kind: int
    """`DISPLACEMENT` or `REACTION_FORCE`."""
    label: str
    unit: str
    time: FloatArray
    """(n_time,) s, evenly spaced."""
    values: FloatArray
    entity: str = "NONE"
    """Name of what the node belongs to, of which ten characters are written."""


def write_functions(path: Path, functions: Iterable[Function], units: UnitsName = "mm-t-s") -> None:
    """Write one data set 58 per function: a time response, real, double precision, evenly spaced.

    Parameters
    ----------
    units : of the values; they name the units of the file (164).

    Source: Universal File Formats for Modal Analysis Testing (SDRC; University of Cincinnati), data set 58: five
    lines of text, 2(I5,I10),2(1X,10A1,I10,I4), 3I10,3E13.5, four of I10,3I5,2(1X,20A1), then 4E20.12.
    """
    with complete_file(path) as partial, partial.open("w", encoding="ascii", newline="\r\n") as file:
        _data_set(file, 164, _units(units))
        for number, function in enumerate(functions, start=1):
            _data_set(file, 58, _history(number, function))


def _history(number: int, f: Function) -> Iterator[str]:
    start, step = f.time[0], (f.time[-1] - f.time[0]) / max(f.time.size - 1, 1)
    yield plain_text(f.title, 80)
    yield from ["NONE"] * 4
    of, against = f" {plain_text(f.entity[:10], 10):<10}{f.node:10d}{f.direction:4d}", f" {'NONE':<10}{0:10d}{0:4d}"
    yield f"{TIME_RESPONSE:5d}{number:10d}{0:5d}{0:10d}{of}{against}"
    yield f"{DOUBLE:10d}{f.values.size:10d}{EVEN:10d}{_e13(np.array([start, step, 0.0]))}"
    yield _axis(TIME, (0, 0, 0), "Time", "s")
    yield _axis(f.kind, EXPONENTS[f.kind], f.label, f.unit)
    yield from [_axis(0, (0, 0, 0), "NONE", "NONE")] * 2
    values = holdable(f.values).tolist()
    for k in range(0, len(values), 4):
        yield "".join(f"{v:20.12E}" for v in values[k : k + 4])


def _axis(kind: int, exponents: tuple[int, int, int], label: str, unit: str) -> str:
    return f"{kind:10d}{''.join(f'{e:5d}' for e in exponents)} {label:<20.20} {unit:<20.20}"


def _data_set(file: TextIO, number: int, lines: Iterable[str]) -> None:
    file.write(f"    -1\n{number:6d}\n")
    file.writelines(f"{line}\n" for line in lines)
    file.write("    -1\n")


def _units(units: UnitsName) -> Iterator[str]:
    code, name = CODES[units]
    yield f"{code:10d}{name:<20}{2:10d}"
    yield "".join(_d25(v) for v in (UNITS[units].per_metre, 1.0 / UNITS[units].newton, 1.0))
    yield _d25(273.15)


def _d25(value: float) -> str:
    return f"{value:25.17E}".replace("E", "D")


def _nodes(labels: IntArray, coords: FloatArray) -> Iterator[str]:
    for label, x in zip(labels.tolist(), coords, strict=True):
        yield f"{label:10d}{1:10d}{1:10d}{11:10d}{_e13(x)}"


def _elements(model: Model, labels: IntArray) -> Iterator[str]:
    """Two records an element: label, descriptor, property and material tables, colour, number of nodes; nodes."""
    blocks = [b for b in model.blocks if b.kind in DESCRIPTORS]
    numbers = unique_labels(np.concatenate([b.ids for b in blocks]))
    start = 0
    for block in blocks:
        nodes = labels[block.nodes_idx[:, ORDER[block.kind]] if block.kind in ORDER else block.nodes_idx]
        for number, row in zip(numbers[start : start + block.ids.size].tolist(), nodes.tolist(), strict=True):
            yield f"{number:10d}{DESCRIPTORS[block.kind]:10d}{block.part + 1:10d}{1:10d}{7:10d}{len(row):10d}"
            yield from _i10(row)
        start += block.ids.size


def _trace_lines(model: Model, labels: IntArray) -> Iterator[Iterator[str]]:
    """Elements along lines, `SEGMENTS` to a trace line; node 0 lifts the pen."""
    pairs = [b.nodes_idx for b in model.blocks if b.nodes_idx.shape[1] == 2]
    pairs += [b.nodes_idx[:, ends] for b in model.blocks if b.kind == "beam3" for ends in ([0, 1], [1, 2])]
    ends = labels[np.concatenate(pairs)] if pairs else np.zeros((0, 2), dtype=np.int64)
    drawn = np.column_stack([ends, np.zeros(len(ends), dtype=np.int64)])
    for number, start in enumerate(range(0, len(drawn), SEGMENTS), start=1):
        yield _trace_line(number, drawn[start : start + SEGMENTS].ravel()[:-1].tolist())


def _trace_line(number: int, nodes: list[int]) -> Iterator[str]:
    yield f"{number:10d}{len(nodes):10d}{7:10d}"
    yield f"LINES {number}"
    yield from _i10(nodes)


def _mode(title: str, labels: IntArray, mode: int, frequency: float, shape: FloatArray) -> Iterator[str]:
    yield plain_text(title, 80)
    yield f"Mode {mode}, {frequency:.6g} Hz"
    yield from ["NONE", "mass-normalised", "NONE"]
    yield "".join(f"{v:10d}" for v in (1, 2, 2, 8, 2, 3))  # structural, normal mode, translations, real, 3 values
    yield "".join(f"{v:10d}" for v in (2, 4, 1, mode))
    yield _e13(np.array([frequency, 1.0, 0.0, 0.0]))
    for label, u in zip(labels.tolist(), holdable(shape), strict=True):
        yield f"{label:10d}"
        yield _e13(u)


def _e13(values: FloatArray) -> str:
    return "".join(f"{v:13.5E}" for v in values)


def _i10(values: list[int]) -> Iterator[str]:
    """8I10"""
    for start in range(0, len(values), 8):
        yield "".join(f"{v:10d}" for v in values[start : start + 8])
