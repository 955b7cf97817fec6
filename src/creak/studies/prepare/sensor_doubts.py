"""What in a test looks wrong beside a model: directions, signs and order of sensors, the unit of frequencies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.studies.warned import Warned
from creak.verify.nrmse import AXES
from creak.verify.turned_sensors import FEW, Channels, TurnedSensors, find_turned
from creak.words import first_few, listed

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


def sensor_doubts(found: Channels) -> Iterator[Warned]:
    """Sentences that ask about what would make the test one of the model; nothing is put right."""
    factor = _unit(found)
    if factor is not None:
        unit, hz = factor
        count, before = found.freq_test.size, found.fits
        found = replace(found, freq_test=found.freq_test * hz)
        yield Warned(
            f"the frequencies of the test look as if they were in {unit}: times {hz:.4g}, {found.fits} of its {count} "
            f"modes fit, as Hz {before}: write them in Hz"
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
    named = (f"{sensor} ({choices[here[0]]})" for sensor, here in rows.items())
    yield Warned(
        f"sensors that lie at nodes of two parts, of which the first was taken: {first_few(named, len(rows), NAMED)}: "
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
        named = (f"{found.sensors[c]} ({_direction(found.directions[c])})" for c in turned.reversed)
        yield f"sensors that look reversed: {first_few(named, len(turned.reversed), NAMED)}"
    if turned.turned:
        named = (f"{sensor} ({_axes(turn)})" for sensor, turn in turned.turned.items())
        yield f"sensors that look turned: {first_few(named, len(turned.turned), NAMED)}"
    if turned.exchanged:
        named = (f"{a} with {b}" for a, b in turned.exchanged)
        yield f"sensors that look exchanged: {first_few(named, len(turned.exchanged), NAMED)}"


def _axes(turn: IntArray) -> str:
    """`its x being -y of the model`, of every axis that is another."""
    said = [f"{AXES[i]} being {_direction(turn[:, i])}" for i in range(3) if turn[i, i] != 1]
    return listed(said)


def _direction(axis: FloatArray | IntArray) -> str:
    """`-x`, or the numbers of a skew one."""
    k = int(np.abs(axis).argmax())
    if abs(axis[k]) > STRAIGHT:
        return f"{'-' if axis[k] < 0 else ''}{AXES[k]}"
    return " ".join(f"{x:.2g}" for x in axis.tolist())
