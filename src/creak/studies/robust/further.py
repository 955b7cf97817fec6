"""Many more draws, of which the motion without contact tells how near they come; a few of them are marched."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.errors import InputError
from creak.formats.stored.record_log import log_path, read_records, record_log
from creak.studies.robust.draws import Design, Drawn
from creak.studies.robust.linear import FACTORS
from creak.studies.robust.shared_model import SharedModel, places_of, without_contact
from creak.verify.odds import Forecast

LOG = "further"
"""Stem of the file that keeps them."""
TIMES = 64
"""Of the draws themselves, as many at most: then what the forecast misses is most of the bounds."""
WORK = 50_000_000
"""Gaps that are looked at, at most: some seconds."""
NUMBERS = 5_000_000
"""Numbers that are kept of them, at most: 40 MB."""
BLOCK = 256
"""Draws of a record on file."""
NOW = FACTORS.index(1.0)


@dataclass(frozen=True)
class Further:
    """What is known of them."""

    design: Design
    can: BoolArray
    """(total,) whether anything can touch; where not it does not, for sure."""
    slack: FloatArray
    """(total, n_place, n_factor) as `Linear.slack`."""
    rows: IntArray
    """(k,) those of the design's n that are marched, beside the draws of the study."""
    events: FloatArray | None = None
    """(k, n_place) in them, once they were."""
    state: FloatArray | None = None
    """(k,) of them, as of the draws of the study."""

    def forecast(self, place: int | None) -> Forecast:
        """Whether each of the design's n closes a gap of a place; None: of any."""
        n = self.design.n
        return forecast(self.can[:n], self.slack[:n], place)


def forecast(can: BoolArray, slack: FloatArray, place: int | None) -> Forecast:
    """Of draws that can touch (n,), and their slack (n, n_place, n_factor)."""
    closes = slack[:, :, NOW] < 0.0
    return Forecast(np.asarray(closes.any(axis=1)) if place is None else closes[:, place], can)


def depth(slack: FloatArray) -> FloatArray:
    """(n,) how far gaps would close beyond contact, of all places together."""
    return np.asarray(np.maximum(-slack[:, :, NOW], 0.0).sum(axis=1))


def further_draws(
    design: Design, drawn: Drawn, channels: GapOperator, check: Callable[[Drawn], None]
) -> tuple[Drawn, Design] | None:
    """`drawn` and more behind it, and the design of these; None: they would tell little more, or reach what no study
    may say, which `check` refuses."""
    runs = design.total / design.n
    most = min(WORK // max(channels.m, 1), NUMBERS // _kept_of(len(places_of(channels))))
    most = min(TIMES * design.n, int(most / runs))
    n = 2 ** (most.bit_length() - 1) if most else 0
    if n < max(2 * BLOCK, 4 * design.n):
        return None
    more = design.further(n)
    found = Drawn.at(design.causes, np.concatenate([drawn.points, more.points()]))
    try:
        check(found)
    except InputError:
        return None
    return found, more


def _rows(can: BoolArray, n: int) -> IntArray:
    """Those to march beside a design of n draws, of which about as many can touch as of these.

    What the forecast misses is bounded by some 4 / m of what can touch, m draws that can; what is drawn is known to
    2 / sqrt(N) of N that can. With m = 2 sqrt(N) both are alike. No more than a quarter of the design's own are added.
    """
    those = np.flatnonzero(can)
    more = math.ceil(2.0 * math.sqrt(those.size) - n * those.size / can.size)
    return those[: max(min(more, n // 4), 0)]


def told_of(made: SharedModel, channels: GapOperator, design: Design, more: Design) -> Further | None:
    """Of the draws of a model behind those of the design; None: each has to be marched."""
    blocks = [(clear, slack) for _, clear, slack in without_contact(made, channels, design.total, None)]
    if not blocks:
        return None
    clear, slack = (np.concatenate(each) for each in zip(*blocks, strict=True))
    return Further(more, ~clear, slack, _rows(~clear[: more.n], design.n))


def keep(further: Further, folder: Path, made_from: Mapping[str, Any]) -> None:
    """Write them beside the draws, for `kept`."""
    n, places, _ = further.slack.shape
    table = np.concatenate([further.can[:, None], further.slack.reshape(n, -1)], axis=1)
    width = BLOCK * _kept_of(places)
    with record_log(log_path(folder, LOG, made_from, width), made_from, width, 0) as log:
        for k, rows in enumerate(table.reshape(-1, width)):
            log.add(k, rows)


def kept(folder: Path, made_from: Mapping[str, Any], places: int, design: Design, more: Design) -> Further | None:
    """Those of a design as they were written; None: they are not all there."""
    width, total = BLOCK * _kept_of(places), more.total
    found, _ = read_records(log_path(folder, LOG, made_from, width), made_from, width)
    if sorted(found) != list(range(total // BLOCK)):
        return None
    table = np.stack([found[k] for k in sorted(found)]).reshape(total, -1)
    can = table[:, 0] > 0.0
    slack = table[:, 1:].reshape(total, places, len(FACTORS))
    return Further(more, can, slack, _rows(can[: more.n], design.n))


def _kept_of(places: int) -> int:
    """Numbers of a draw."""
    return 1 + places * len(FACTORS)
