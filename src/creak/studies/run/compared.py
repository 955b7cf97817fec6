"""Runs of a study side by side; of a result at hand, or as results.h5 keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Protocol, TypeVar

from creak.studies.prepare.excitation import time_axis
from creak.studies.prepare.output_steps import compared_end
from creak.studies.prepare.setup import Setup
from creak.verify.events import Event
from creak.verify.matching import EventMatch, match_events
from creak.verify.statistics import EventStatistics, compare_statistics

T = TypeVar("T")


class HasEvents(Protocol):
    """A run."""

    @property
    def events(self) -> list[Event]: ...


class HasRuns(Protocol):
    """A study with its runs by name and its verification window, s."""

    @property
    def runs(self) -> Mapping[str, HasEvents]: ...
    @property
    def window(self) -> tuple[float, float]: ...


def main_run(runs: Mapping[str, T]) -> T | None:
    """The run that a study speaks of: reduced where there is one."""
    return runs.get("reduced") or runs.get("reference")


def compare_events(runs: Mapping[str, HasEvents], tolerance: float, window: tuple[float, float]) -> EventMatch | None:
    """Events of the reduced run against those of the reference; None where one of them is missing."""
    if "reference" not in runs or "reduced" not in runs:
        return None
    return match_events(runs["reference"].events, runs["reduced"].events, tolerance, window)


def event_statistics(result: HasRuns) -> EventStatistics:
    """Statistics of the events of both runs in the verification window."""
    runs = result.runs
    return compare_statistics(runs["reference"].events, runs["reduced"].events, result.window)


def compared_setup(setup: Setup) -> Setup:
    """The setup up to where the unreduced model is run for comparison."""
    c, end = setup.study.config, float(setup.loads.time[-1])
    until = compared_end(setup.study.course, end)
    if until == end:
        return setup
    time = c.time.model_copy(update={"end": until, "periods": None})
    study = replace(setup.study, config=c.model_copy(update={"time": time}))
    n = time_axis(study.driving, study.course).size
    loads = replace(
        setup.loads, time=setup.loads.time[:n], support=setup.loads.support[:, :n], force=setup.loads.force[:n]
    )
    return replace(setup, study=study, loads=loads)
