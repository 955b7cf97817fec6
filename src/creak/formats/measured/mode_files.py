"""Files of modal tests by their ending, and measured modes in CSV: a row for each mode, sensor and direction."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.deck.command_files import plain_file
from creak.formats.measured.csv_rows import csv_rows, separator_of
from creak.formats.measured.csv_rows import number as number_of
from creak.formats.measured.modes import PER_METRE, Channel, MeasuredFrfs, MeasuredModes, high_damping
from creak.formats.measured.uff_frfs import uff_frfs
from creak.formats.measured.uff_functions import histories_among
from creak.formats.measured.uff_modes import MODE, read_uff_modes, uff_modes
from creak.formats.measured.uff_sets import DataSet, data_sets

PLACE = ("x", "y", "z")
NEEDED = ("frequency_hz", "sensor", "direction")
HEADER = "frequency_hz,damping,sensor,x,y,z,direction,value (or real,imag instead of value)"
UNIT = re.compile(r"\s*[\[(]\s*([^\[(]*?)\s*[\])]\s*$")
UNITS = {
    **dict.fromkeys(PLACE, tuple(PER_METRE)),
    "frequency_hz": ("hz",),
    "damping": ("-", "1"),
    "damping_percent": ("%",),
}
"""Column -> units that its head may tell."""
SHAPES = ("value", "real", "imag")
"""Columns whose unit does not matter."""
AXIS = re.compile(r"([+-]?)([xyz])([+-]?)", re.IGNORECASE)


@dataclass(frozen=True)
class _Row:
    mode: str
    frequency: float
    damping: float
    sensor: str
    place: tuple[float, ...]
    direction: FloatArray
    value: complex
    where: str


def read_csv_modes(path: Path) -> MeasuredModes:
    """The modes of a table with the columns of `HEADER`, in any order.

    `damping` is a share of critical damping, `damping_percent` is in per cent. A direction is x, -y, +z, or a vector as
    0.6 0 0.8. Rows with one frequency are one mode; `mode` tells modes with equal frequencies apart. Lengths may name
    their unit, as x [mm].

    Raises
    ------
    InputError : a column is missing or a cell wrong; a sensor without a value in a mode, or with two.
    """
    rows = _rows(path)
    modes = list(dict.fromkeys(r.mode for r in rows[0]))
    channels: dict[tuple[str, tuple[float, ...]], int] = {}
    for r in rows[0]:
        channels.setdefault(_channel(r), len(channels))
    shapes = np.full((len(channels), len(modes)), np.nan, dtype=np.complex128)
    of, first = {m: k for k, m in enumerate(modes)}, {_channel(r): r for r in reversed(rows[0])}
    frequencies, damping = np.full(len(modes), np.nan), np.full(len(modes), np.nan)
    for r in rows[0]:
        k, mode = channels[_channel(r)], of[r.mode]
        if not np.isnan(shapes[k, mode]):
            raise InputError(f"sensor {r.sensor} has a second value in this direction and mode", where=r.where)
        _same(frequencies, mode, r.frequency, "frequency", r)
        _same(damping, mode, r.damping, "damping", r)
        if not np.array_equal(r.place, first[_channel(r)].place, equal_nan=True):
            raise InputError(f"sensor {r.sensor} has two places", where=r.where, expected="one for all its rows")
        shapes[k, mode] = r.value
    _complete(path, shapes, list(channels), modes)
    order = np.argsort(frequencies, kind="stable")
    kept = [first[c] for c in channels]
    return MeasuredModes(
        path,
        frequencies[order],
        damping[order],
        shapes[:, order],
        tuple(r.sensor for r in kept),
        np.array([r.place for r in kept]),
        np.array([r.direction for r in kept]),
        rows[1],
        notes=tuple(high_damping(damping)),
    )


def _channel(r: _Row) -> tuple[str, tuple[float, ...]]:
    return r.sensor, tuple(np.round(r.direction, 9).tolist())


def _same(values: FloatArray, mode: int, value: float, name: str, r: _Row) -> None:
    """One figure of a mode, which all its rows share."""
    if np.isnan(values[mode]):
        values[mode] = value
    elif not math.isnan(value) and value != values[mode]:
        raise InputError(
            f"mode {r.mode} has the {name} {value:g} here and {values[mode]:g} before",
            where=r.where,
            expected="one for all its rows",
        )


def _complete(path: Path, shapes: np.ndarray, channels: list[tuple[str, tuple[float, ...]]], modes: list[str]) -> None:
    missing = np.argwhere(np.isnan(shapes))
    if missing.size:
        k, mode = missing[0].tolist()
        sensor, direction = channels[k]
        raise InputError(
            f"sensor {sensor} has no value along ({', '.join(f'{x:g}' for x in direction)}) in mode {modes[mode]}",
            where=path,
            expected="a value of every sensor in every mode",
            fix="Add the row, or remove the others of that sensor and direction.",
        )


def is_of_modes(lines: Sequence[str]) -> bool:
    """Whether a table is one of modes, by its head."""
    at = _head(lines)
    return at is not None and NEEDED[0] in lines[at].lower()


def _head(lines: Sequence[str]) -> int | None:
    """Row of the head: the first with something in it that is no comment."""
    return next((k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")), None)


def _rows(path: Path) -> tuple[list[_Row], float | None]:
    """The rows of the table, and the units of length in 1 m where its head tells."""
    lines = plain_file(path).read_text(encoding="utf-8-sig").splitlines()
    at = _head(lines)
    if at is None:
        raise InputError("the table is empty", where=path, expected=HEADER)
    separator = separator_of(lines[at])
    (_, head), *body = csv_rows(lines[at:], path, separator, start=at)
    columns, per_metre = _columns(head, f"{path}:{at + 1}")
    rows = []
    for line, cells in body:
        if any(cell.strip() for cell in cells) and not cells[0].lstrip().startswith("#"):
            rows.append(_row(columns, [c.strip() for c in cells], f"{path}:{line}"))
    if not rows:
        raise InputError("the table has no rows", where=path, expected=HEADER)
    return rows, per_metre


def _columns(head: Sequence[str], where: str) -> tuple[dict[str, int], float | None]:
    columns: dict[str, int] = {}
    units = set()
    for k, cell in enumerate(head):
        unit, whole = UNIT.search(cell), cell.strip().lower()
        name = UNIT.sub("", whole).strip()
        name = name if name in UNITS or name in SHAPES else whole
        if unit and name in UNITS and unit[1].lower() not in UNITS[name]:
            raise InputError(
                f"the column {name} is in {unit[1] or '?'}",
                where=where,
                expected=f"one of {', '.join(UNITS[name])}" if len(UNITS[name]) > 1 else UNITS[name][0],
                fix="Call it damping_percent." if unit[1] == "%" else "Convert its numbers, or correct its head.",
            )
        if name in PLACE and unit:
            units.add(unit[1].lower())
        if name in columns:
            raise InputError(f"two columns are called {name!r}", where=where, fix="Rename one.")
        columns[name] = k
    missing = [name for name in NEEDED if name not in columns]
    if missing:
        close = suggest(missing[0], columns)
        raise InputError(
            f"no column {missing[0]!r}", where=where, expected=HEADER, fix=close if close.startswith("Did") else ""
        )
    if ("value" in columns) == ("real" in columns or "imag" in columns) or ("real" in columns) != ("imag" in columns):
        raise InputError("the shapes are not told", where=where, expected="a column value, or real and imag")
    if "damping" in columns and "damping_percent" in columns:
        raise InputError("both damping and damping_percent", where=where, expected="one of them")
    if 0 < sum(axis in columns for axis in PLACE) < 3:
        raise InputError("not all of x, y, z are there", where=where, expected="all three, or none")
    if len(units) > 1:
        raise InputError(f"x, y, z are in {' and '.join(sorted(units))}", where=where, expected="one unit")
    return columns, PER_METRE[units.pop()] if units else None


def _row(columns: dict[str, int], cells: list[str], where: str) -> _Row:
    def text(name: str) -> str:
        k = columns.get(name, len(cells))
        return cells[k] if k < len(cells) else ""

    def number(name: str, *, optional: bool = False) -> float:
        cell = text(name)
        if optional and not cell:
            return math.nan
        value = number_of(cell)
        if not math.isfinite(value):
            raise InputError(f"{name} is {cell!r}", where=where, expected="a finite number", fix="Repair the row.")
        return value

    frequency = number("frequency_hz")
    if not frequency > 0.0:
        raise InputError(f"frequency_hz is {frequency:g}", where=where, expected="a positive number")
    percent = "damping_percent" in columns
    damping = number("damping_percent", optional=True) / 100.0 if percent else number("damping", optional=True)
    if not (math.isnan(damping) or 0.0 <= damping < 1.0):
        fix = "" if percent else "Call the column damping_percent where it is in per cent."
        raise InputError(f"damping is {damping:g}", where=where, expected="a share of critical, 0 to 1", fix=fix)
    value = complex(number("value")) if "value" in columns else complex(number("real"), number("imag"))
    sensor = text("sensor")
    if not sensor:
        raise InputError("a row without a sensor", where=where, fix="Name it.")
    place = tuple(number(axis) if axis in columns else math.nan for axis in PLACE)
    mode = text("mode") or f"{frequency:.12g} Hz"
    return _Row(mode, frequency, damping, sensor, place, _direction(text("direction"), where), value, where)


def _direction(text: str, where: str) -> FloatArray:
    """(3,) unit vector of x, -y, z+ or of three numbers."""
    named = AXIS.fullmatch(text)
    if named and not (named[1] and named[3]):
        sign = -1.0 if "-" in (named[1], named[3]) else 1.0
        return sign * np.eye(3)["xyz".index(named[2].lower())]
    try:
        vector = np.array([float(word) for word in re.split(r"[\s;/]+", text)])
    except ValueError:
        vector = np.zeros(0)
    size = float(np.linalg.norm(vector))
    if vector.size != 3 or not math.isfinite(size) or not size > 0.0:
        raise InputError(
            f"direction is {text!r}", where=where, expected="x, y, z with or without a sign, or a vector as 0.6 0 0.8"
        )
    return np.asarray(vector / size)


READERS: dict[str, Callable[[Path], MeasuredModes]] = {
    **dict.fromkeys((".unv", ".uff", ".u55"), read_uff_modes),
    **dict.fromkeys((".csv", ".txt"), read_csv_modes),
}
"""Ending of a file -> its reader."""


@dataclass(frozen=True)
class ModalTest:
    """What a file of a test holds, at least one of the three."""

    path: Path
    modes: MeasuredModes | None = None
    frfs: MeasuredFrfs | None = None
    channels: tuple[Channel, ...] = ()
    """Time histories, where they were asked for."""


def read_measured_modes(path: Path) -> MeasuredModes:
    """The modes of a universal file (.unv, .uff) or a table (.csv, .txt).

    Raises
    ------
    InputError : no such file; it is cut short, holds no modes, or is not of its kind.
    """
    with _reading(path):
        return _reader(path)(path)


def read_test(path: Path) -> ModalTest:
    """The modes and the frequency response functions of a file; functions are in universal files alone.

    Raises
    ------
    InputError : as `read_measured_modes`, or it holds neither modes nor such functions.
    """
    with _reading(path):
        if (read_modes := _reader(path)) is not read_uff_modes:
            return ModalTest(path, read_modes(path))
        return _of_sets(path, data_sets(path), [])


def read_universal(path: Path) -> ModalTest:
    """All that a universal file holds of a test: time histories besides.

    Raises
    ------
    InputError : as `read_test`, or it holds none of the three.
    """
    with _reading(path):
        channels, rest = histories_among(data_sets(path))
        return _of_sets(path, rest, channels)


def _of_sets(path: Path, sets: list[DataSet], channels: list[Channel]) -> ModalTest:
    frfs = uff_frfs(path, sets)
    has_modes = any(one.number == MODE for one in sets) or (frfs is None and not channels)
    return ModalTest(path, uff_modes(path, sets) if has_modes else None, frfs, tuple(channels))


def _reader(path: Path) -> Callable[[Path], MeasuredModes]:
    reader = READERS.get(plain_file(path).suffix.lower())
    if reader is None:
        raise InputError(f"measured modes in {path.name}", expected=f"a file that ends in {', '.join(READERS)}")
    return reader


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """What the system says about a file, as an InputError."""
    try:
        yield
    except FileNotFoundError as error:
        raise InputError(f"no such file: {path}", fix="Check the path.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8", fix="Save it as UTF-8.") from error
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
