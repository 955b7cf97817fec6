"""Data set 55 of universal files: measured modes, real or complex, with their points, frames and units.

Source: Universal File Formats for Modal Analysis Testing (SDRC; University of Cincinnati).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from creak.arrays import ComplexArray
from creak.errors import InputError
from creak.formats.measured.modes import MeasuredModes, high_damping
from creak.formats.measured.uff_points import read_points, require_ended
from creak.formats.measured.uff_sets import DataSet, data_sets

MODE = "55"
NORMAL, COMPLEX = (2,), (3, 7)
"""Analysis types: normal modes; complex ones of first and second order."""
VALUES = {2: 3, 3: 6}
"""Data characteristic -> values at a node: translations, and with rotations."""
MOTION = {0: "unknown", 8: "displacement", 11: "velocity", 12: "acceleration"}
REAL, COMPLEX_DATA = (2, 4), (5, 6)
"""Types of data, in single and double precision."""
HEAD = 8
"""Lines before the values."""
PER_LINE = 6
SAME, ALIKE = 1e-3, 0.99
"""A mode and its conjugate: relative difference of their frequencies and difference of their damping at most, and MAC
of one with the conjugate of the other at least."""
AXES = "xyz"


@dataclass(frozen=True)
class _Mode:
    frequency: float
    damping: float
    rising: bool
    """Of a pair of complex modes, the one whose eigenvalue has a positive imaginary part."""
    values: dict[int, ComplexArray]
    """Node -> its three translations."""


def read_uff_modes(path: Path) -> MeasuredModes:
    """The modes of a universal file, as `uff_modes`."""
    return uff_modes(path, data_sets(path))


def uff_modes(path: Path, sets: list[DataSet]) -> MeasuredModes:
    """The modes among the data sets of a universal file, at every axis in which a node moves in any of them.

    Eigenvalues of complex modes are in rad/s. An axis that is zero in every mode was not measured.

    Raises
    ------
    InputError : no modes in it; a data set is cut short or cannot be read; other frames than Cartesian and cylindrical.
    """
    require_ended(sets, MODE)
    notes: list[str] = []
    modes = [m for one in sets if one.number == MODE if (m := _mode(one, notes)) is not None]
    if not modes:
        other = "; ".join(dict.fromkeys(notes))
        raise InputError(
            f"no modes in it{f': {other}' if other else ''}",
            where=path,
            expected="data sets 55 of normal or complex modes",
            fix="Export the mode shapes, not the measured functions.",
        )
    modes = _once(modes, notes)
    nodes = _common_nodes(modes, notes, path)
    frequencies, order = np.array([m.frequency for m in modes]), np.argsort([m.frequency for m in modes], kind="stable")
    values = np.stack([[m.values[node] for node in nodes] for m in modes])
    moved = (values != 0.0).any(axis=0)
    notes += _unmeasured(nodes, moved)
    rows, axes = np.nonzero(moved)
    if not rows.size:
        raise InputError("nothing moves in any mode", where=path, fix="Export the mode shapes again.")
    notes += high_damping(np.array([m.damping for m in modes]))
    at = read_points(sets, path, notes)
    places, turned = (np.stack([f(node) for node in nodes]) for f in (at.place, at.axes))
    return MeasuredModes(
        path=path,
        frequencies=frequencies[order],
        damping=np.array([m.damping for m in modes])[order],
        shapes=values[order][:, rows, axes].T,
        sensors=tuple(str(nodes[r]) for r in rows),
        points=places[rows],
        directions=turned[rows, axes],
        per_metre=None if at.units is None else at.units[0],
        lines=at.lines,
        notes=tuple(dict.fromkeys(notes)),
    )


def _mode(one: DataSet, notes: list[str]) -> _Mode | None:
    """A data set 55; None where it holds no mode."""
    _, analysis, characteristic, kind, data, per_node = one.integers(5, 6)
    if analysis not in (*NORMAL, *COMPLEX):
        notes.append(f"data of analysis type {analysis} are no modes and are left out")
        return None
    count = VALUES.get(characteristic, 0)
    twice = data in COMPLEX_DATA and per_node == 2 * count  # some programs count real and imaginary parts
    if not count or (per_node != count and not twice) or kind not in MOTION:
        notes.append(f"data of type {kind} with {per_node} values at a node are no motion and are left out")
        return None
    if data not in (*REAL, *COMPLEX_DATA):
        raise InputError(f"data type {data}", where=one.where(5), expected="2 (real) or 5 (complex)")
    given = one.numbers(7)
    if analysis in NORMAL:
        if len(given) < 4:
            raise InputError("a normal mode without frequency, modal mass and damping", where=one.where(7))
        frequency, viscous, hysteretic = given[0], given[2], given[3]
        damping, rising = viscous or 0.5 * hysteretic or math.nan, True
    else:
        if len(given) < 2:
            raise InputError("a complex mode without its eigenvalue", where=one.where(7))
        size = math.hypot(given[0], given[1])
        frequency, damping, rising = size / (2.0 * math.pi), -given[0] / size if size else math.nan, given[1] >= 0.0
        if damping < 0.0:
            notes.append("eigenvalues with a positive real part: their damping is taken without its sign")
            damping = -damping
    if frequency < 0.0:
        raise InputError(f"a frequency of {frequency:g} Hz", where=one.where(7), expected="a positive one")
    return _Mode(frequency, damping, rising, _values(one, count, data in COMPLEX_DATA))


def _values(one: DataSet, per_node: int, is_complex: bool) -> dict[int, ComplexArray]:
    count = per_node * (2 if is_complex else 1)
    found: dict[int, ComplexArray] = {}
    row = HEAD
    while row < len(one.lines) and one.lines[row].strip():
        node, values = one.integers(row, 1)[0], list[float]()
        row += 1
        while len(values) < count:
            values += one.numbers(row)[: min(PER_LINE, count - len(values))]
            row += 1
        parts = np.array(values).reshape(per_node, -1)[:3]
        found[node] = parts[:, 0] + 1j * (parts[:, 1] if is_complex else 0.0)
    if not found:
        raise one.short()
    return found


def _once(modes: list[_Mode], notes: list[str]) -> list[_Mode]:
    """Modes of eigenvalues with a positive imaginary part; a lower one stands for its conjugate, once."""
    upper = [m for m in modes if m.rising]
    kept = [m for m in modes if m.rising or not any(_are_conjugate(m, u) for u in upper)]
    if len(kept) < len(modes):
        notes.append(f"{len(modes) - len(kept)} conjugate modes are left out")
    if alone := len(kept) - len(upper):
        notes.append(f"{alone} modes stand with their lower eigenvalue alone: their conjugates are taken")
    return [m if m.rising else replace(m, values={n: np.conj(u) for n, u in m.values.items()}) for m in kept]


def _are_conjugate(lower: _Mode, upper: _Mode) -> bool:
    apart = abs(lower.frequency - upper.frequency) > SAME * upper.frequency
    if apart or abs(lower.damping - upper.damping) > SAME:
        return False
    nodes = sorted(lower.values.keys() & upper.values.keys())
    if not nodes:
        return False
    a, b = (np.concatenate([m.values[n] for n in nodes]) for m in (lower, upper))
    return bool(abs(a @ b) ** 2 >= ALIKE * np.vdot(a, a).real * np.vdot(b, b).real)


def _common_nodes(modes: list[_Mode], notes: list[str], path: Path) -> list[int]:
    every = {node for m in modes for node in m.values}
    common = set.intersection(*(set(m.values) for m in modes))
    if not common:
        raise InputError("no node has a value in every mode", where=path, fix="Export all modes of one test together.")
    if len(common) < len(every):
        notes.append(f"{len(every) - len(common)} points without a value in every mode are left out")
    return sorted(common)


def _unmeasured(nodes: list[int], moved: np.ndarray) -> Iterator[str]:
    """What is zero in every mode."""
    still = int((~moved.any(axis=1)).sum())
    if still:
        yield f"{still} of {len(nodes)} points are zero in every mode and are left out"
    seen = moved[moved.any(axis=1)]
    for axis, name in enumerate(AXES):
        without = int((~seen[:, axis]).sum())
        if without and len(seen):
            who = "no point has" if without == len(seen) else f"{without} of {len(seen)} points have no"
            yield f"{who} values in {name}, which count{'s' if without == len(seen) else ''} as not measured"
