"""Frequency response functions of universal files (data sets 58, function type 4), with their coherence (type 6).

Source: Universal File Formats for Modal Analysis Testing (SDRC; University of Cincinnati).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.measured.modes import RECEPTANCE, MeasuredFrf, MeasuredFrfs
from creak.formats.measured.uff_functions import COMPLEX, FORCES, ORDERS, MeasuredFunction, functions, require_of_kind
from creak.formats.measured.uff_modes import MODE
from creak.formats.measured.uff_points import Points, read_points, require_ended
from creak.formats.measured.uff_sets import DataSet
from creak.formats.measured.unit_words import MOTIONS, NEWTONS, SAME, plain_unit

FREQUENCY = 18
FRF, COHERENCE = 4, 6
KINDS = {
    0: "a general function",
    1: "a time response",
    2: "an auto spectrum",
    3: "a cross spectrum",
    FRF: "a frequency response",
    5: "a transmissibility",
    COHERENCE: "a coherence",
    9: "a power spectral density",
    12: "a spectrum",
}
UNKNOWN = 0

Channel = tuple[int, int]
"""Node and direction of the file, with its sign."""


def uff_frfs(path: Path, sets: list[DataSet]) -> MeasuredFrfs | None:
    """The frequency response functions among the data sets of a universal file, motion over force.

    None where it has none and either no functions at all or modes.

    Units are those of data set 164, or of the labels of the ordinate. The channels are named by their nodes.

    Raises
    ------
    InputError : the file has functions but neither a frequency response nor modes, one is cut short or cannot be read,
        its units contradict each other, or it does not tell what was measured.
    """
    every = list(functions(sets))
    if not every:
        return None
    require_ended(sets)
    notes: list[str] = []
    points = read_points(sets, path, notes)
    wanted = [f for f in every if _is_wanted(f, notes)]
    if not wanted:
        if any(one.number == MODE for one in sets):
            return None
        raise InputError(
            f"none of its {len(every)} functions is a frequency response of motion over force: "
            + "; ".join(dict.fromkeys(notes)),
            where=every[0].where(),
            expected="data sets 58 of function type 4, displacement, velocity or acceleration over force",
            fix="Export frequency response functions.",
        )
    channels = {c: k for k, c in enumerate(dict.fromkeys(c for f in wanted for c in (f.response, f.reference)))}
    coherence = {_key(f): f for f in every if f.kind == COHERENCE}
    found = tuple(_frf(f, points, channels, coherence.get(_key(f))) for f in wanted)
    return MeasuredFrfs(
        path,
        found,
        tuple(str(node) for node, _ in channels),
        np.stack([points.place(node) for node, _ in channels]),
        np.stack([math.copysign(1.0, d) * points.axes(node)[abs(d) - 1] for node, d in channels]),
        None if points.units is None else points.units[0],
        tuple(dict.fromkeys(notes)),
    )


def _is_wanted(f: MeasuredFunction, notes: list[str]) -> bool:
    """Whether a function is motion over force; else a note says what it is, unless it is a coherence."""
    if f.kind == COHERENCE:
        return False
    why = next(_why_not(f), "")
    if why:
        notes.append(f"{why} is left out")
    return not why


def _why_not(f: MeasuredFunction) -> Iterator[str]:
    if f.kind != FRF or f.abscissa.kind not in (FREQUENCY, UNKNOWN):
        yield KINDS.get(f.kind, f"a function of type {f.kind}") + ("" if f.kind != FRF else " not over frequency")
    elif f.data not in COMPLEX:
        yield "a frequency response with real values"
    elif f.ordinate.kind not in (*ORDERS, UNKNOWN) or f.denominator.kind not in (*FORCES, UNKNOWN):
        yield f"a frequency response of kind {f.ordinate.kind} over kind {f.denominator.kind}"
    elif not all(1 <= abs(d) <= 3 for _, d in (f.response, f.reference)):
        yield "a frequency response without direction, or of rotations or moments,"


def _key(f: MeasuredFunction) -> tuple[int, int, int, int]:
    return f.response[0], abs(f.response[1]), f.reference[0], abs(f.reference[1])


def _frf(
    f: MeasuredFunction, points: Points, channels: dict[Channel, int], coherence: MeasuredFunction | None
) -> MeasuredFrf:
    order, factor = _units(f, points.units, points.notes)
    x, values = f.values()
    some = x > 0.0
    if not some.any():
        raise InputError("a frequency response without a frequency above 0", where=f.where())
    return MeasuredFrf(
        name=f.name,
        where=f.where(),
        response=channels[f.response],
        reference=channels[f.reference],
        order=order,
        freq=x[some],
        values=(1.0 if factor is None else factor) * values[some],
        has_units=factor is not None,
        coherence=None if coherence is None else _coherence(coherence, x)[some],
    )


def _coherence(f: MeasuredFunction, x: FloatArray) -> FloatArray:
    at, values = f.values()
    if at.size != x.size or np.abs(at - x).max() > SAME * x[-1]:
        raise InputError(
            "a coherence at other frequencies than its function", where=f.where(), fix="Export both from one test."
        )
    return np.asarray(values.real, dtype=np.float64)


def _units(f: MeasuredFunction, told: tuple[float, float] | None, notes: list[str]) -> tuple[int, float | None]:
    """What is measured, and the factor that brings it to m, s and N; None: the file tells no units."""
    words = _words(f)
    motion, force = MOTIONS.get(words[0]), NEWTONS.get(words[1])
    if f.ordinate.kind == UNKNOWN and motion is None:
        raise InputError(
            f"a frequency response that does not tell what was measured (its unit is {f.ordinate.unit!r})",
            where=f.of.where(8),
            expected="displacement (8), velocity (11) or acceleration (12) over force, or a unit as m/s^2",
            fix="Export it with the kind of its ordinate.",
        )
    order = ORDERS.get(f.ordinate.kind, RECEPTANCE if motion is None else motion[0])
    if motion is not None:
        require_of_kind(f, motion[0], "a frequency response")
    odd = [label for label, known in zip(_words(f), (motion, force), strict=True) if label and known is None]
    if told is None and (odd or (motion is None and force not in (None, 1.0))):
        raise InputError(
            f"a frequency response in {f.ordinate.unit or '?'} over {f.denominator.unit or '?'}",
            where=f.of.where(8),
            expected="units as m/s^2, mm/s, in or g over N, kN or lbf, both or none, or data set 164",
            fix="Correct the labels of its axes, or leave both out: its values are then in the units of the deck.",
        )
    if told is None:
        return order, None if motion is None else motion[1] / (1.0 if force is None else force)
    if odd:
        notes.append(f"units {', '.join(odd)} of functions are not known: those of data set 164 are taken")
    for label, value, factor, unit in (
        (f.ordinate.unit, None if motion is None else motion[1], told[0], "m"),
        (f.denominator.unit, force, told[1], "N"),
    ):
        if value is not None and abs(value * factor - 1.0) > SAME:
            raise InputError(
                f"a function in {label}, where data set 164 tells {factor:g} units in 1 {unit}",
                where=f.of.where(8),
                expected="one system of units in data set 164 and in the labels of the functions",
                fix="Correct the one that is wrong: values are divided by these factors to be in m and N.",
            )
    return order, told[1] / told[0]


def _words(f: MeasuredFunction) -> tuple[str, str]:
    """The units beside the axes, of a motion and of a force that may stand behind it."""
    motion, force = plain_unit(f.ordinate.unit), plain_unit(f.denominator.unit)
    for name in NEWTONS:
        if motion.endswith(f"/{name}"):
            motion, force = motion.removesuffix(f"/{name}"), force or name
    return motion, force
