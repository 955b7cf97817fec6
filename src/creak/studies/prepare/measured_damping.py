"""Measured modes and those of a linear structure: which belong together, and the damping taken from them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray
from creak.assembly.part import Rayleigh, loose_system
from creak.assembly.system import System
from creak.errors import InputError
from creak.formats.measured.mode_files import read_measured_modes
from creak.formats.measured.modes import Measured, MeasuredModes, high_damping
from creak.model.dofs import TRANSLATIONS, dofs_of, node_dofs
from creak.reduction.modal import ModalShares
from creak.studies.prepare.sensors import Sensors, locate
from creak.studies.prepare.structure import Structure, modes_up_to
from creak.studies.warned import Warned
from creak.verify.mac import mac_matrix, pair_measured, phase_collinearity, real_shapes, turned_twins
from creak.verify.mode_fit import GOOD_HZ, GOOD_MAC, does_fit
from creak.verify.nrmse import AXES
from creak.verify.turned_sensors import FEW, Channels, TurnedSensors, find_turned
from creak.words import first_few, listed

ABOVE = 1.3
"""Modes of the model are sought up to this multiple of the highest measured frequency."""
COMPLEX = 0.5
"""Phase collinearity below which no real mode stands for one: points move on ellipses, as where a wave travels."""
STILL = 1e-6
"""Share of the largest displacement of a mode: where its motion at all sensors is less, it is round-off."""
UNDAMPED = Rayleigh(0.0, 0.0)
UNITS = (("rad/s", 0.5 / np.pi), ("1/min", 1.0 / 60.0), ("kHz", 1e3), ("Hz divided by 2 pi", 2.0 * np.pi))
"""In which frequencies may be, and what makes Hz of them."""
SOME, MOST_OF = 0.2, 0.6
"""Shares of the measured modes that fit: up to the one those in Hz do not, from the other on those in a unit do."""
STRAIGHT = 0.999
"""Cosine from which a direction is told as an axis."""
ONE = 1e-3
"""Of the largest motion at any sensor in a mode: what two nodes that move as one may differ by."""
NAMED = 6
"""Channels and sensors that are named."""


@dataclass(frozen=True)
class PairedShapes:
    """Measured shapes and those of the model at the channels of the test."""

    test: FloatArray
    """(n_channel, n_test) real"""
    model: FloatArray
    """(n_channel, n_model) along the directions of the channels."""
    mac: FloatArray
    """(n_test, n_model)"""
    partner: IntArray
    """(n_test,) column of the partner, -1 for none."""
    collinearity: FloatArray
    """(n_test,) modal phase collinearity, 1: real."""
    turn: FloatArray
    """(n_model, n_model) how modes of one frequency were combined (`turned_twins`)."""
    doubts: tuple[str, ...] = ()
    """What about the sensors or the frequencies looks wrong."""


def pair_shapes(
    measured: MeasuredModes, sensors: Sensors, system: System, shapes: FloatArray, freq: FloatArray
) -> PairedShapes:
    """Which measured mode belongs to which of a System.

    Parameters
    ----------
    shapes : (n, n_mode) in the coordinates of the System. freq : (n_mode,) Hz, 0 for rigid ones.

    Raises
    ------
    InputError : the modes are complex through and through, none of the model moves the sensors, or none has a partner.
    """
    collinearity = phase_collinearity(measured.shapes)
    _require_real(measured, collinearity)
    test, model = real_shapes(measured.shapes), shapes_at(system, measured, sensors, shapes)
    _require_motion(measured, model[:, freq > 0.0])
    turn = turned_twins(test, model, measured.frequencies, freq)
    model = model @ turn
    matrix = mac_matrix(test, model)
    partner = pair_measured(matrix, measured.frequencies, freq)
    motion = _motion_at(system, measured, sensors, shapes) @ turn
    found = Channels(test, motion, measured.directions, measured.sensors, measured.frequencies, freq)
    doubts = tuple(sensor_doubts(found))
    has_twin = sensors.twins_idx >= 0
    if has_twin.any():
        other = replace(sensors, nodes_idx=np.where(has_twin, sensors.twins_idx, sensors.nodes_idx))
        doubts += tuple(twin_doubts(found, _motion_at(system, measured, other, shapes) @ turn, sensors.choices))
    _require_pairs(measured, matrix[:, freq > 0.0], freq[freq > 0.0], partner, doubts)
    return PairedShapes(test, model, matrix, partner, collinearity, turn, doubts)


def _motion_at(system: System, measured: MeasuredModes, sensors: Sensors, shapes: FloatArray) -> FloatArray:
    """(n_channel, 3, n_mode) motion at the nodes of all channels along x, y and z."""
    axes = (replace(measured, directions=np.tile(axis, (len(measured.sensors), 1))) for axis in np.eye(3))
    found, largest = (channel_rows(system, along, sensors) @ shapes for along in axes), _largest(system, shapes)
    return np.stack([_moving(np.asarray(one), largest) for one in found], axis=1)


def shapes_at(system: System, measured: MeasuredModes, sensors: Sensors, shapes: FloatArray) -> FloatArray:
    """(n_channel, n_mode) motion of every channel in modes of a System, 0 of a mode that is `STILL` at all of them."""
    return _moving(np.asarray(channel_rows(system, measured, sensors) @ shapes), _largest(system, shapes))


def _largest(system: System, shapes: FloatArray) -> FloatArray:
    """(n_mode,) largest displacement of each mode."""
    moves = (system.coordinates >= 0) & np.isin(dofs_of(system.coordinates), TRANSLATIONS)
    return np.asarray(np.abs(shapes[moves]).max(axis=0, initial=0.0))


def _moving(found: FloatArray, largest: FloatArray) -> FloatArray:
    return np.where(np.abs(found).max(axis=0, initial=0.0) < STILL * largest, 0.0, found)


def channel_rows(system: System, measured: Measured, sensors: Sensors) -> Any:
    """(n_channel, n) sparse: motion of every channel by the coordinates of a System, 0 where supports hold it."""
    labels, count = node_dofs(sensors.nodes_idx, TRANSLATIONS), len(measured.sensors)
    moves = np.isin(labels, system.labels)
    rows, columns = np.repeat(np.arange(count), len(TRANSLATIONS))[moves], np.arange(int(moves.sum()))
    along = sp.csr_array((measured.directions.ravel()[moves], (rows, columns)), shape=(count, columns.size))
    return sp.csr_array(along @ system.rows(labels[moves])[0])


def damping_shares(measured: MeasuredModes, partner: IntArray, freq: FloatArray) -> ModalShares | None:
    """The damping of measured modes as that of their partners, of others the mean of these; None: no partner has any.

    Parameters
    ----------
    partner : (n_test,) mode of the model of each, -1 for none. freq : (n_mode,) Hz of the model.
    """
    known = sorted(
        (float(freq[j]), zeta)
        for j, zeta in zip(partner.tolist(), measured.damping.tolist(), strict=True)
        if j >= 0 and math.isfinite(zeta)
    )
    if not known:
        return None
    at, zeta = np.array(known).T
    return ModalShares(at, zeta, float(zeta.mean()))


def damping_notes(shares: ModalShares, measured: MeasuredModes, fits: Sequence[bool]) -> list[str]:
    """What was taken, what of it does not fit, and what the file says of it.

    Parameters
    ----------
    fits : of each pair, whether shape and frequency do.
    """
    told = (
        f"damping is measured: {shares.freq.size} modes of the model have that of their partners in "
        f"{measured.path.name}, all others its mean, {100.0 * shares.other:.3g} % of critical"
    )
    count, alone, off = measured.frequencies.size, measured.frequencies.size - len(fits), len(fits) - sum(fits)
    if alone or off:
        told = Warned(
            f"{told}: of its {count} modes {alone} have no partner, and {off} have one that does not fit (MAC below "
            f"{GOOD_MAC:g}, or frequency more than {100.0 * GOOD_HZ:g} % off); creak modes --test shows which"
        )
    odd = high_damping(measured.damping)
    return [told, *(Warned(note) if note in odd else note for note in measured.notes)]


def measured_damping(structure: Structure, path: Path, units: str, where: str) -> tuple[ModalShares, list[str]]:
    """The damping that a structure takes from the modes of a test, and notes about it.

    Modes of the structure, contact left out, are paired with the measured ones by MAC.

    Parameters
    ----------
    units : of the model. where : what names the file, for messages.

    Raises
    ------
    InputError : the file is wrong or holds no damping, or as `sensors.locate` and `pair_shapes`.
    NumericalError : the modes of the structure could not be found.
    """
    measured = read_measured_modes(path)
    known = measured.damping[np.isfinite(measured.damping)]
    if not known.size:
        raise _no_damping(path, where, "no mode in it has damping")
    if known.max() >= 1.0:
        raise InputError(
            f"{path.name} has a mode with damping of {known.max():g} of critical", where=where, expected="below 1"
        )
    sensors = locate(structure.model, measured, units)
    loose = loose_system(structure.model, UNDAMPED)
    system = structure.joined([structure.part(k) for k in range(len(structure.model.parts))], loose)
    found = modes_up_to(system, ABOVE * float(measured.frequencies.max()))
    freq = np.array(found.frequencies)
    both = pair_shapes(measured, sensors, system, found.shapes, freq)
    shares = damping_shares(measured, both.partner, freq)
    if shares is None:
        raise _no_damping(path, where, "no mode in it that has a partner in the model has damping")
    paired = [(k, j) for k, j in enumerate(both.partner.tolist()) if j >= 0]
    fits = [does_fit(float(both.mac[k, j]), float(measured.frequencies[k]), float(freq[j])) for k, j in paired]
    return shares, [*damping_notes(shares, measured, fits), *both.doubts]


def _no_damping(path: Path, where: str, what: str) -> InputError:
    return InputError(
        f"from_test = {path.name!r}: {what}",
        where=where,
        expected="measured modes with damping: data sets 55, or a table with the column damping",
        fix="Export the modes with their damping, or say modal = 0.02 for 2 % of critical in every mode.",
    )


def _require_real(measured: MeasuredModes, collinearity: FloatArray) -> None:
    turning = np.flatnonzero(collinearity < COMPLEX)
    if 2 * turning.size > collinearity.size:
        k = int(turning[0])
        raise InputError(
            f"{turning.size} of {collinearity.size} modes are complex: at {measured.frequencies[k]:g} Hz the phase "
            f"collinearity is {collinearity[k]:.2f}, where 1 is a real mode",
            where=measured.path,
            expected="modes of a structure at rest, whose points move in phase or against it",
            fix="Modes of a rotating frame, or travelling waves, have no real partner. Else look at the phases.",
        )


def _require_motion(measured: MeasuredModes, elastic: FloatArray) -> None:
    if not elastic.size:
        raise InputError(
            "no mode of the model but rigid ones lies in the range in which modes were sought; the highest measured "
            f"one is at {measured.frequencies.max():.4g} Hz",
            where=measured.path,
            expected="modes of the same structure, in Hz",
            fix="Are its frequencies in Hz? Is it the test of this structure? Else ask for more modes.",
        )
    if elastic.any():
        return
    count = len(measured.sensors)
    raise InputError(
        f"no mode of the model moves {'its sensor' if count == 1 else f'any of its {count} channels'}: the node of "
        f"sensor {measured.sensors[0]} cannot move along the direction {_direction(measured)}",
        where=measured.path,
        expected="directions in which the model moves",
        fix="Are the directions in the axes of the deck? Correct them, or the places of the sensors.",
    )


def _direction(measured: MeasuredModes) -> str:
    return " ".join(f"{x:.3g}" for x in measured.directions[0].tolist())


def _require_pairs(
    measured: MeasuredModes, matrix: FloatArray, freq: FloatArray, partner: IntArray, doubts: tuple[str, ...]
) -> None:
    if (partner >= 0).any():
        return
    k, j = np.unravel_index(matrix.argmax(), matrix.shape)
    asked = "Is it the test of this structure, with the same supports? Are the directions in the axes of the deck?"
    raise InputError(
        f"none of the {partner.size} measured modes has a partner among the model's: the highest MAC is "
        f"{matrix.max():.2f}, of {measured.frequencies[k]:.4g} Hz with the model's {freq[j]:.4g} Hz",
        where=measured.path,
        expected="modes of the same structure, within an octave of the model's",
        fix=" ".join(f"{doubt[0].upper()}{doubt[1:]}." for doubt in doubts) or asked,
    )


def sensor_doubts(found: Channels) -> Iterator[Warned]:
    """Sentences that ask about what would make the test one of the model; nothing is put right."""
    factor = _unit(found)
    if factor is not None:
        unit, hz = factor
        count, before = found.freq_test.size, found.fits
        found = replace(found, freq_test=found.freq_test * hz)
        yield Warned(
            f"the frequencies of the test look as if they were in {unit}: times {hz:.4g}, {found.fits} of its {count} "
            f"modes fit, and {before or 'none'} as Hz: write them in Hz"
        )
    turned = find_turned(found)
    if turned is not None:
        yield Warned(
            f"{'; '.join(_ways(turned, found))}: so the mean MAC of the modes would be {turned.after:.2f}, as the file "
            f"says it is {turned.before:.2f}: check how the sensors were mounted and numbered; nothing was changed"
        )


def twin_doubts(found: Channels, other: FloatArray, choices: Sequence[str]) -> Iterator[Warned]:
    """A sentence about sensors that may be on another part than they were put on, where the two move otherwise.

    Parameters
    ----------
    other : (n_channel, 3, n_model) as `found.motion`, at the other node. choices : (n_channel,) words for both nodes.
    """
    size, apart = np.abs(found.motion).max(axis=(0, 1)), np.abs(other - found.motion).max(axis=1)
    moves_otherwise = (apart > ONE * size).any(axis=1)
    rows = {sensor: here for sensor, here in found.rows.items() if moves_otherwise[here].any()}
    if not rows:
        return
    best, as_it_is = found.motion, found.mean_mac
    highest = as_it_is
    for here in rows.values():
        tried = best.copy()
        tried[here] = other[here]
        if (mac := replace(found, motion=tried).mean_mac) > highest:
            best, highest = tried, mac
    named = [f"{sensor} ({choices[here[0]]})" for sensor, here in rows.items()]
    yield Warned(
        f"sensors that lie at nodes of two parts, of which the first was taken: {first_few(named, NAMED)}: "
        f"the mean MAC is {as_it_is:.2f}, and {highest:.2f} with the better choices: name their nodes in a table "
        "sensor,node (--sensors)"
    )


def _unit(found: Channels) -> tuple[str, float] | None:
    """The unit in which the frequencies would be those of the model, where in Hz they are of none."""
    count = found.freq_test.size
    if count < FEW or found.fits > SOME * count:
        return None
    fits = [replace(found, freq_test=found.freq_test * hz).fits for _, hz in UNITS]
    best = int(np.argmax(fits))
    return UNITS[best] if fits[best] >= max(FEW, MOST_OF * count) else None


def _ways(turned: TurnedSensors, found: Channels) -> Iterator[str]:
    """What would have to be otherwise, a clause each."""
    if turned.axes is not None:
        yield f"the axes of all sensors look turned, {_axes(turned.axes)}"
    if turned.reversed:
        named = [f"{found.sensors[c]} ({_axis_name(found.directions[c])})" for c in turned.reversed]
        yield f"sensors that look reversed: {first_few(named, NAMED)}"
    if turned.turned:
        named = [f"{sensor} ({_axes(turn)})" for sensor, turn in turned.turned.items()]
        yield f"sensors that look turned: {first_few(named, NAMED)}"
    if turned.exchanged:
        named = [f"{a} with {b}" for a, b in turned.exchanged]
        yield f"sensors that look exchanged: {first_few(named, NAMED)}"


def _axes(turn: IntArray) -> str:
    """`its x being -y of the model`, of every axis that is another."""
    said = [f"{AXES[i]} being {_axis_name(turn[:, i])}" for i in range(3) if turn[i, i] != 1]
    return listed(said)


def _axis_name(axis: FloatArray | IntArray) -> str:
    """`-x`, or the numbers of a skew one."""
    k = int(np.abs(axis).argmax())
    if abs(axis[k]) > STRAIGHT:
        return f"{'-' if axis[k] < 0 else ''}{AXES[k]}"
    return " ".join(f"{x:.2g}" for x in axis.tolist())
