"""Stretches of a record and chains of stretches that follow each other closely."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, TypeVar

import numpy as np

from creak.arrays import BoolArray, FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.errors import InputError
from creak.given import number, of_kind, positive


class Stretch(Protocol):
    """Something that lasts for a while, s."""

    @property
    def start(self) -> float: ...

    @property
    def end(self) -> float: ...


Piece = TypeVar("Piece", bound=Stretch)


def stretches(flags: BoolArray) -> list[tuple[int, int]]:
    """First and last row of each run of true flags."""
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8))
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    return list(zip(starts.tolist(), stops.tolist(), strict=True))


def in_window(time: FloatArray, window: tuple[float, float]) -> BoolArray:
    """(n,) instants of a window, its edges included, s."""
    return np.asarray((time >= window[0]) & (time <= window[1]))


def overlap(start: float, end: float, window: tuple[float, float]) -> bool:
    """Whether something that lasts from `start` to `end` does so at any time of a window, its edges included, s."""
    return start <= window[1] and end >= window[0]


def chains(pieces: Iterable[Piece], merge: float) -> list[list[Piece]]:
    """Stretches by their start, grouped where one begins less than `merge` seconds after all before it have ended."""
    found: list[list[Piece]] = []
    end = -np.inf
    for piece in sorted(pieces, key=lambda p: p.start):
        if found and piece.start - end < merge:
            found[-1].append(piece)
        else:
            found.append([piece])
        end = max(end, piece.end)
    return found


def check_merging(history: History, gaps: GapOperator, merge: float | None, f_max: float) -> None:
    """Raise InputError for channels of another run, or where events cannot be merged by these: `find_events`,
    `find_slips`."""
    of_kind(history, History, "history", "what creak.simulate gives")
    of_kind(gaps, GapOperator, "gaps", "the channels of the run, as creak.gap_channels gives them")
    if history.force.shape[1] != gaps.m:
        raise InputError(
            f"a history of {history.force.shape[1]} channels and gaps with {gaps.m}", expected="the channels of the run"
        )
    positive(f_max, "f_max")
    if merge is not None and not number(merge, "merge") >= 0.0:
        raise InputError(f"merge = {merge}", expected="seconds, zero or more")
