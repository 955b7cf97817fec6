"""Runs of a study side by side; of a result at hand, or as results.h5 keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, TypeVar

from creak.verify.events import Event
from creak.verify.matching import EventMatch, match_events
from creak.verify.statistics import EventStatistics, compare_statistics

T = TypeVar("T")


class HasEvents(Protocol):
    """A run."""

    @property
    def events(self) -> list[Event]: ...


def main_run(runs: Mapping[str, T]) -> T | None:
    """The run that a study speaks of: reduced where there is one."""
    return runs.get("reduced") or runs.get("reference")


def compare_events(runs: Mapping[str, HasEvents], tolerance: float, window: tuple[float, float]) -> EventMatch | None:
    """Events of the reduced run against those of the reference; None where one of them is missing."""
    if "reference" not in runs or "reduced" not in runs:
        return None
    return match_events(runs["reference"].events, runs["reduced"].events, tolerance, window)


def event_statistics(runs: Mapping[str, HasEvents], window: tuple[float, float]) -> EventStatistics:
    """Statistics of the events of both runs in the verification window."""
    return compare_statistics(runs["reference"].events, runs["reduced"].events, window)
