"""The gap that a place needs: the shift of all its gaps, and what the numbers of the study are with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.studies.robust.changes import drawn_setup
from creak.studies.robust.draws import Cause, Draw
from creak.studies.robust.job import Draws
from creak.verify.odds import shift_needed

OF_GAPS = ("contact.", "connector.", "clip.")
"""What the gaps of channels depend on."""
EVEN = 1e-9
"""Spread of the gaps of a place up to which they are one number."""
QUARTERS = (0.25, 0.75)
"""Of what is drawn of a number: gaps that differ between them move with it."""


@dataclass(frozen=True)
class Need:
    """What the gap of a place has to be for a probability at most."""

    target: float
    shift: float
    """Added to every gap that is drawn: each distribution moves as a whole."""
    low: float
    high: float
    """Bounds of 95 %; infinite where the draws are too few."""
    gap: float | None
    """That of the study's own number (the mean of a distribution that gives one) with the shift. None: the place has
    more than one gap, or the number does more than move its distribution: uniform, lognormal, relative."""
    numbers: Mapping[str, float] = field(default_factory=dict)
    """Key -> number that the study has to say: its own (or `mean`) and `low` and `high` of a truncated or uniform
    distribution. The shift is taken off where a gap grows as the number falls: `lower` of a stop."""


@dataclass(frozen=True)
class OwnGaps:
    """Gaps of all channels by the numbers about which they scatter, and what moves them."""

    gaps: FloatArray
    """(m,)"""
    moved: tuple[tuple[Cause, IntArray], ...]
    """Causes, and (m,) 1 or -1 where the gap of a channel grows or shrinks as the cause does, else 0."""

    def need(self, own: BoolArray, slack: FloatArray, target: float) -> Need:
        """That of a place with the channels `own` (m,), from its slack (n,) without contact.

        Its gaps all grow by the shift s with P(slack + s < 0) = target (`verify.odds.shift_needed`).
        """
        shift, low, high = shift_needed(slack, target)
        gaps, causes = self.gaps[own], [(cause, signs[own]) for cause, signs in self.moved if signs[own].any()]
        one = gaps.size and np.ptp(gaps) <= EVEN * abs(float(gaps.max())) and all(c.moves_whole for c, _ in causes)
        numbers = dict[str, float]()
        for cause, signs in causes if np.isfinite(shift) else ():
            if np.unique(signs[signs != 0]).size == 1:
                numbers |= _shifted(cause, float(signs[signs != 0][0]) * shift)
        return Need(target, shift, low, high, float(gaps.mean()) + shift if one else None, numbers)


def _shifted(cause: Cause, by: float) -> dict[str, float]:
    """Key -> number of a distribution that is moved as a whole, as the study has it."""
    of = cause.of
    if of.relative:
        return {}
    own = {f"{cause.key}.mean": of.mean} if of.mean is not None else {cause.key: cause.nominal}
    told = {**(own if cause.moves_whole else {}), f"{cause.key}.low": of.low, f"{cause.key}.high": of.high}
    return {key: x + by for key, x in told.items() if x is not None and np.isfinite(x)}


def own_gaps(draws: Draws) -> OwnGaps:
    """Of the study that was drawn."""
    values, fields, of_numbers = dict[str, Any](), dict[str, FloatArray](), list[Cause]()
    moved = list[tuple[Cause, IntArray]]()
    for cause in draws.design.causes:
        if cause.mean is not None:
            fields[cause.contact] = cause.mean
            moved.append((cause, draws.channels.of_groups({cause.contact}).astype(np.int64)))
        elif cause.key.startswith(OF_GAPS) and cause.key not in draws.reduced_again and not cause.is_factor:
            values[cause.key] = cause.number(cause.about)
            of_numbers.append(cause)
    for cause in of_numbers:
        low, high = (_gaps(draws, {**values, cause.key: cause.number(cause.at(q))}, fields) for q in QUARTERS)
        moved.append((cause, np.sign(high - low).astype(np.int64)))
    return OwnGaps(_gaps(draws, values, fields), tuple(moved))


def _gaps(draws: Draws, values: dict[str, Any], fields: dict[str, FloatArray]) -> FloatArray:
    setup = drawn_setup(draws.setup, Draw(0, values, fields))
    return np.concatenate([setup.contacts.gap0, setup.connectors.gap0])
