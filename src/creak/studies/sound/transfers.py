"""Measured ways from a part to an ear: transfer functions of files, in place of the open air.

A volume source in a wall sends rho / (2 pi r) e^(-i omega r / c) of its volume acceleration to a point in the open. A
transfer function H, measured in the vehicle from the middle of the part to the ear, tells what it sends there. What the
faces of the part send is multiplied by the ratio of both.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.errors import InputError
from creak.formats.measured.files import chosen
from creak.formats.measured.uff_frfs import FREQUENCY, FRF, UNKNOWN
from creak.formats.measured.uff_functions import COMPLEX, MeasuredFunction, functions
from creak.formats.measured.uff_points import units_told
from creak.formats.measured.uff_sets import data_sets
from creak.formats.measured.unit_words import HERTZ, SAME, plain_unit
from creak.formats.wav import read_wav
from creak.sound.between_lines import Lines
from creak.sound.forced import smooth
from creak.sound.rayleigh import AIR
from creak.sound.third_octave import across_third
from creak.studies.file.sound_tables import TransferTable
from creak.studies.file.tables import head_of_axis, read_header, row_numbers
from creak.studies.warned import Warned

COLUMNS = (("real", "imag"), ("amplitude", "phase"), ("amplitude",))
"""Of a table, behind frequency; phase in degrees."""
EXPECTED = "frequency,real,imag or frequency,amplitude,phase (degrees) or frequency,amplitude"
ORDER = {"volume acceleration": 0, "volume velocity": 1}
"""Times that what the response is per was integrated."""
SOURCES = {"m^3/s^2": "volume acceleration", "m3/s^2": "volume acceleration"}
SOURCES |= {"m^3/s": "volume velocity", "m3/s": "volume velocity"}
PASCAL = "pa"
THIRD = 2.0 ** (1.0 / 3.0)
"""Frequencies beyond those that were measured over these, at which a part is heard as in the open again."""
PADDED = 4
"""Lengths of an impulse response that its transform is made of: its frequencies are as close."""
PER_THIRD = 16
"""Frequencies of a third octave by which its mean square is taken."""


@dataclass(frozen=True)
class Transfer:
    """What was measured from a part to an ear, over what a small source in a wall sends there in the open."""

    part: int
    """Row into `Model.parts`."""
    file: str
    freq: FloatArray
    """(n,) Hz"""
    ratio: ComplexArray
    """(n,); above 0 where only amplitudes were measured, and late then as in the open."""

    @cached_property
    def lines(self) -> Lines:
        """What lies between the frequencies."""
        return Lines(self.freq, self.ratio)

    def gain(self, freq: FloatArray) -> ComplexArray:
        """At frequencies, Hz; 1 from a third octave outside those that were measured on. Between measured ones it is as
        `Lines` has it."""
        low, high = float(self.freq[0]), float(self.freq[-1])
        known = self.lines.at(np.clip(freq, low, high))
        off = np.maximum(low / np.maximum(freq, 1e-300), freq / high)
        return np.asarray(1.0 + smooth((THIRD - off) / (THIRD - 1.0)) * (known - 1.0))

    def square(self, freq: float) -> float:
        """Mean of its square in the third octave around a frequency, Hz."""
        return float(np.mean(np.abs(self.gain(freq * across_third(PER_THIRD))) ** 2))


def transfer_of(table: TransferTable, path: Path, part: int, away: float, where: str) -> Transfer:
    """What a study's table tells of the way from a part.

    Parameters
    ----------
    path : the file. away : m from the middle of the part's faces to the listener. where : of the table.

    Raises
    ------
    InputError : no such file or function, none of its kind; a response that is not pressure in Pa over a volume
        acceleration or velocity; numbers that are not finite, or not above 0 where they must be.
    """
    name = Path(table.file).name
    ending = Path(name).suffix.lower()
    reader = next((read for endings, read in READERS.items() if ending in endings), None)
    if reader is None:
        raise InputError(
            f"a transfer function in {name}",
            where=where,
            expected="a file that ends in .csv, .wav, .uff, .unv or .u58",
            fix="Export it as one of these.",
        )
    if reader is not _impulse and table.full_scale is not None:
        raise InputError(f"full_scale of {name}", where=where, expected="it with a WAV file", fix="Leave it out.")
    found = reader(table, path, where)
    if None not in (found.per, table.per) and found.per != table.per:
        raise InputError(
            f"per = {table.per!r}, where {name} tells {found.per}",
            where=where,
            fix="Leave per out, or correct it.",
        )
    _check(found, path)
    omega, order = 2.0 * np.pi * found.freq, ORDER[found.per or table.per or "volume acceleration"]
    if found.phase:
        ratio = found.response / (1j * omega) ** order * np.exp(1j * omega * away / AIR.speed)
    else:
        ratio = np.abs(found.response) / omega**order + 0j
    return Transfer(part, name, found.freq, ratio * (2.0 * np.pi * away / AIR.density))


def words_of(
    transfers: Sequence[Transfer], names: Sequence[str], listener: str, band: tuple[float, float]
) -> list[str]:
    """Notes on what a listener hears by what was measured; they warn of lines too far apart for their phase."""
    said = []
    for one in transfers:
        low, high = float(one.freq[0]), float(one.freq[-1])
        beyond = "" if low <= band[0] and high >= band[1] else ", outside as in the open"
        said.append(f"{names[one.part]} by {one.file} ({low:.0f} to {high:.0f} Hz{beyond})")
    heard = f"sound: {listener} hears {', '.join(said)}: measured, in place of the open air"
    return [heard, *(text for one in transfers for text in _too_far(one, band))]


def _too_far(one: Transfer, band: tuple[float, float]) -> list[str]:
    """A warning, where the phase of a way turns too far between two lines in the band."""
    steps, lines = one.lines.unknown, one.lines
    steps = steps[(one.freq[steps + 1] > band[0]) & (one.freq[steps] < band[1])]
    if not steps.size:
        return []
    low, high = one.freq[steps[0]], one.freq[steps[-1] + 1]
    most = np.degrees(np.abs(lines.turns[steps]).max())
    told = (
        f"sound: the phase of {one.file} turns by up to {most:.0f} degrees from a line to the next, without the "
        f"{1e3 * lines.delay:.3g} ms by which all of it is later than in the open, {steps.size} time(s) from "
        f"{low:.0f} to {high:.0f} Hz: what lies between is not known but for its level. Measure lines "
        f"{lines.fine(steps):.2g} Hz apart there, or closer"
    )
    return [Warned(told)]


@dataclass(frozen=True)
class _Response:
    """As a file has it."""

    freq: FloatArray
    response: ComplexArray
    phase: bool
    """Whether its phase is known."""
    per: str | None = None
    """What the file says that it is per."""


def _check(found: _Response, path: Path) -> None:
    freq, response = found.freq, found.response
    if freq.size < 2 or not (np.diff(freq) > 0.0).all() or freq[0] <= 0.0:
        raise InputError(
            f"a transfer function of {freq.size} frequencies",
            where=path,
            expected="two or more above 0, upwards",
            fix="Sort its rows, drop doubles.",
        )
    if not np.isfinite(response).all() or not np.abs(response).any():
        raise InputError("a transfer function that is zero, or no number", where=path, fix="Export it again.")


def _tabulated(_: TransferTable, path: Path, where: str) -> _Response:
    header, rows = read_header(path, where, "table")
    axis, hertz = head_of_axis(path, header[0], HERTZ, "the frequencies") if header else ("", 1.0)
    columns = next((c for c in COLUMNS if header[1:] == [*c]), None)
    if axis != "frequency" or columns is None:
        raise InputError(
            f"the table starts with {','.join(header) or 'nothing'}",
            where=f"{path}:1",
            expected=f"the header {EXPECTED}",
            fix="Put it into the first line.",
        )
    values = np.array([row_numbers(path, *row, header) for row in rows]).reshape(-1, len(header))
    rows = [row for row, f in zip(rows, values[:, 0], strict=True) if f != 0.0]
    values = values[values[:, 0] != 0.0]  # a source that does not move tells nothing
    freq, first, second = hertz * values[:, 0], values[:, 1], values[:, -1]
    if columns == ("real", "imag"):
        return _Response(freq, first + 1j * second, phase=True)
    if (first < 0.0).any():
        line = rows[int(np.argmax(first < 0.0))][0]
        raise InputError(
            f"an amplitude of {first.min():g}",
            where=f"{path}:{line}",
            expected="0 or more: Pa over its source, no level",
        )
    known = len(columns) == 2
    return _Response(freq, first * np.exp(1j * np.radians(second if known else 0.0 * second)), known)


def _universal(table: TransferTable, path: Path, where: str) -> _Response:
    try:
        sets = data_sets(path)
        every = [f for f in functions(sets) if _is_response(f)]
    except OSError as error:
        raise InputError(f"cannot read {path}: {(error.strerror or str(error)).lower()}", where=where) from error
    if not every:
        raise InputError(
            f"{path.name} has no frequency response function",
            where=where,
            expected="data set 58 of function type 4 with complex values over frequency",
            fix="Export frequency response functions.",
        )
    f = chosen(every, [f.name for f in every], "function", table.function, path, where)
    found: tuple[FloatArray, Any] = f.values()
    above = found[0] > 0.0
    told, over = (plain_unit(axis.unit) for axis in (f.ordinate, f.denominator))
    told, _, behind = told.partition("/") if not over else (told, "", over)
    if told not in ("", PASCAL) or (behind and behind not in SOURCES):
        raise InputError(
            f"a transfer function in {f.ordinate.unit or '?'} over {f.denominator.unit or '?'}",
            where=f.of.where(8),
            expected="Pa over m^3/s^2 (volume acceleration) or m^3/s (volume velocity)",
            fix="Export it in these units.",
        )
    factors = (1.0, 1.0) if told and behind else units_told(sets) or (1.0, 1.0)
    if max(abs(factor - 1.0) for factor in factors) > SAME:
        raise InputError(
            f"a transfer function in {f.ordinate.unit or '?'} over {f.denominator.unit or '?'}, where data set 164 "
            f"tells {factors[0]:g} units in 1 m and {factors[1]:g} in 1 N",
            where=f.of.where(8),
            expected="units beside both axes, Pa and m^3/s^2 or m^3/s, or data set 164 in m and N",
            fix="Export it in m and N, or with its units.",
        )
    return _Response(found[0][above], found[1][above], phase=True, per=SOURCES.get(behind))


def _is_response(f: MeasuredFunction) -> bool:
    return f.kind == FRF and f.data in COMPLEX and f.abscissa.kind in (FREQUENCY, UNKNOWN)


def _impulse(table: TransferTable, path: Path, where: str) -> _Response:
    """Of an impulse response, whose samples add up."""
    sound = read_wav(path)
    if table.full_scale is None:
        raise InputError(
            f"{path.name} has no calibration: nothing says what its samples are",
            where=where,
            expected="full_scale, Pa per m^3/s^2 (or per m^3/s) that a sample of 1 stands for",
            fix="Give full_scale; 1 where samples are floats in these units.",
        )
    channels = sound.samples.reshape(sound.samples.shape[0], -1).T / (sound.full_scale or 1.0)
    names = [f"channel {k + 1}" for k in range(len(channels))]
    x = chosen(list(channels), names, "function", table.function, path, where)
    size = PADDED * x.size
    freq = np.arange(1, size // 2 + 1) * (sound.rate / size)
    return _Response(freq, table.full_scale * np.fft.rfft(x, size)[1:], phase=True)


READERS: dict[tuple[str, ...], Callable[[TransferTable, Path, str], _Response]] = {
    (".csv",): _tabulated,
    (".wav",): _impulse,
    (".uff", ".unv", ".u58"): _universal,
}
"""Endings of a file -> its reader."""
