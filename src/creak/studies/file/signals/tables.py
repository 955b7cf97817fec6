"""Signals of a study file."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from creak.signals import sources
from creak.signals.curves import Periodic, SmoothStep
from creak.signals.signal import RAMP, Signal
from creak.studies.file.model_tables import Label
from creak.studies.file.signals.course import PER_FLANK, Course, Points, Shown, check_lines, columns
from creak.studies.file.signals.vibration import HalfSineTable, PsdTable, SweepTable, TrapezoidTable
from creak.studies.file.table import Finite, NonNegative, Positive

MOST_LINES = 100_000
"""Of a multisine, which is summed line by line at each instant."""


class MultisineTable(Course):
    """Random-phase multisine: every line between f_min and f_max with the same amplitude."""

    stated: ClassVar[bool] = True
    type: Literal["multisine"]
    f_min: NonNegative = 1.0
    """Hz"""
    f_max: Positive
    """Hz"""
    amplitude: Finite
    """Of each line."""
    period: Positive = 1.0
    """s; the lines are 1 / period Hz apart, 100,000 at most."""
    seed: Annotated[int, Field(ge=0)] = 1
    """Of the random phases."""

    @model_validator(mode="after")
    def _has_lines(self) -> MultisineTable:
        if self.f_min > self.f_max:
            raise ValueError(f"f_min = {self.f_min:g} Hz is above f_max = {self.f_max:g} Hz")
        check_lines(self.f_min, self.f_max, self.period, MOST_LINES)
        return self

    @property
    def highest(self) -> float:
        return self.f_max

    @property
    def repeats(self) -> float:
        return self.period

    @property
    def fade(self) -> float:
        return RAMP * self.period

    @property
    def random(self) -> int:
        return self.seed

    def made(self) -> Signal:
        return sources.Multisine(self.f_min, self.f_max, self.amplitude, self.period, self.seed)

    def words(self, unit: str, shown: Shown) -> str:
        return (
            f"multisine {shown(self.f_min)} to {shown(self.f_max)} Hz, {shown(self.amplitude)} {unit} a line, period "
            f"{shown(self.period)} s, seed {self.seed}"
        )


class SineTable(Course):
    """A sin(2 pi f t)."""

    stated: ClassVar[bool] = True
    type: Literal["sine"]
    frequency: Positive
    """Hz"""
    amplitude: Finite
    """A, in the unit of the excitation's kind."""

    @property
    def highest(self) -> float:
        return self.frequency

    @property
    def repeats(self) -> float:
        return 1.0 / self.frequency

    def made(self) -> Signal:
        return sources.Sine(self.frequency, self.amplitude)

    def words(self, unit: str, shown: Shown) -> str:
        return f"sine, {shown(self.frequency)} Hz, {shown(self.amplitude)} {unit}"


class StepTable(Course):
    """Constant from t = 0."""

    type: Literal["step"]
    amplitude: Finite
    """In the unit of the excitation's kind."""

    def made(self) -> Signal:
        return sources.Step(self.amplitude)

    def words(self, unit: str, shown: Shown) -> str:
        return f"step of {shown(self.amplitude)} {unit}"


CLOSEST = 1e-12
"""s between two points of a signal."""


def _increase(points: list[tuple[float, float]]) -> None:
    for before, after in pairwise(points):
        if after[0] < before[0] + CLOSEST:
            raise ValueError(f"the time {after[0]:g} s does not come {CLOSEST:g} s or more after {before[0]:g} s")


class TableTable(Course):
    """A CSV file with the header time,value, a channel of a measured file, or the points themselves."""

    type: Literal["table"]
    file: str | None = None
    """Path relative to the study file: .csv; .rsp, .drv, .rpc (RPC III); .uff, .unv (data set 58)."""
    channel: Label | None = None
    """Name or number of a channel; of a CSV file the name of a column, where there are several."""
    factor: Finite = 1.0
    """The values of the file are taken so many times, 9810 for g in mm/s2."""
    values: Points | None = None
    """[[time, value], ...], s and the unit of the excitation's kind."""
    rounding: Annotated[float, Field(ge=0.0, le=0.5, allow_inf_nan=False)] | None = None
    """For displacement and velocity: straight lines whose corners are rounded over this share of the shorter interval
    beside them; default: displacement follows splines, velocity straight lines."""

    @model_validator(mode="after")
    def _one_of(self) -> TableTable:
        if (self.file is None) == (self.values is None):
            raise ValueError("give either file or values")
        if self.file is None and (self.channel is not None or self.factor != 1.0):
            raise ValueError("channel and factor belong to a file")
        _increase(self.values or [])
        return self

    def made(self) -> Signal | None:
        return None if self.values is None else sources.Table(*columns(self.values), self.rounding)

    def words(self, unit: str, shown: Shown) -> str:
        return f"table {self.file}" if self.values is None else f"table of {len(self.values)} point(s), {unit}"


class SmoothStepTable(Course):
    """From point to point by a polynomial of degree five that starts and ends with zero slope and curvature."""

    type: Literal["smooth-step"]
    values: Annotated[Points, Field(min_length=2)]
    """[[time, value], ...], s and the unit of the excitation's kind."""

    @model_validator(mode="after")
    def _rises(self) -> SmoothStepTable:
        _increase(self.values)
        return self

    @property
    def resolving(self) -> float | None:
        moves = [b[0] - a[0] for a, b in pairwise(self.values) if a[1] != b[1]]
        return min(moves) / PER_FLANK if moves else None

    def made(self) -> Signal:
        return SmoothStep(*columns(self.values))

    def words(self, unit: str, shown: Shown) -> str:
        return f"smooth step through {len(self.values)} points, {unit}"


class PeriodicTable(Course):
    """mean + sum_n cosine_n cos(2 pi n f (t - start)) + sine_n sin(2 pi n f (t - start)); the mean before start."""

    stated: ClassVar[bool] = True
    type: Literal["periodic"]
    frequency: Positive
    """Hz"""
    cosine: list[Finite] = []
    """Coefficients of the cosines, n = 1, 2, ..."""
    sine: list[Finite] = []
    """Coefficients of the sines, n = 1, 2, ..."""
    mean: Finite = 0.0
    """In the unit of the excitation's kind."""
    start: Finite = 0.0
    """s"""

    @property
    def terms(self) -> int:
        return max(len(self.cosine), len(self.sine))

    @property
    def highest(self) -> float:
        return self.terms * self.frequency

    @property
    def repeats(self) -> float:
        return 1.0 / self.frequency

    def made(self) -> Signal:
        each = ([*c, *[0.0] * (self.terms - len(c))] for c in (self.cosine, self.sine))
        cosine, sine = (np.array(c, dtype=np.float64) for c in each)
        return Periodic(self.frequency, cosine, sine, self.mean, self.start)

    def words(self, unit: str, shown: Shown) -> str:
        return f"periodic, {shown(self.frequency)} Hz, {self.terms} term(s), {unit}"


class RecordTable(Course):
    """A measured acceleration, integrated by omega arithmetic."""

    type: Literal["record"]
    file: str
    """Path relative to the study file: CSV with the header time,value; .rsp, .drv, .rpc (RPC III); .uff, .unv."""
    channel: Label | None = None
    """Name or number of a channel; of a CSV file the name of a column, where there are several."""
    factor: Finite = 1.0
    """The values of the file are taken so many times, 9810 for g in mm/s2."""
    high_pass: Positive
    """Hz; below it the record counts as drift."""

    @property
    def fade(self) -> float:
        return 1.0 / self.high_pass

    def words(self, unit: str, shown: Shown) -> str:
        return f"record {self.file}, above {shown(self.high_pass)} Hz"


SignalTable = Annotated[
    MultisineTable
    | SineTable
    | StepTable
    | TableTable
    | RecordTable
    | SmoothStepTable
    | PeriodicTable
    | PsdTable
    | SweepTable
    | HalfSineTable
    | TrapezoidTable,
    Field(discriminator="type"),
]
"""Any of them, by its `type`."""
