"""Signals of the test laboratory in a study: power spectral density, sweeps, shocks."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from creak.signals.signal import RAMP, Signal
from creak.signals.sources import Table
from creak.signals.vibration import HalfSine, SineSweep, trapezoid
from creak.studies.file.signals.course import PER_FLANK, Course, Points, Shown, check_lines
from creak.studies.file.table import Finite, NonNegative, Positive

LOBE = 1.5
"""Times one over the duration of a shock: where the first lobe of its spectrum ends."""
PER_SHOCK = 20.0
"""Flight steps in half a sine."""


MOST_RANDOM_LINES = 10_000_000
"""Of random vibration, which is summed by FFT."""


class PsdTable(Course):
    """Random vibration with a power spectral density, one-sided; a power of the frequency between its points."""

    stated: ClassVar[bool] = True
    type: Literal["psd"]
    unit: Literal["g2/Hz", "(m/s2)2/Hz", "unit2/Hz"]
    """Of the density; the first two for accelerations, the last: the unit of the excitation's kind, squared, per Hz."""
    values: Annotated[Points, Field(min_length=2)] | None = None
    """[[frequency, density], ...], Hz and `unit`."""
    file: str | None = None
    """CSV file with the header frequency,density; path relative to the study file."""
    duration: Positive = 10.0
    """s after which the signal repeats; its lines are 1 / duration Hz apart, 10 million at most."""
    seed: Annotated[int, Field(ge=0)] = 1
    """Of the random phases."""

    @model_validator(mode="after")
    def _one_of(self) -> PsdTable:
        if (self.file is None) == (self.values is None):
            raise ValueError("give either file or values")
        check_density(self.values or [], self.duration)
        return self

    def check(self, kind: str, dof: str) -> None:
        if self.unit != "unit2/Hz" and kind != "acceleration":
            raise ValueError(f'a density in {self.unit} is one of an acceleration: give kind = "acceleration"')
        if self.unit != "unit2/Hz" and dof.startswith("r"):
            raise ValueError(f'a density in {self.unit} is one of a translation: give unit = "unit2/Hz"')

    @property
    def highest(self) -> float:
        return self.values[-1][0] if self.values else 0.0

    @property
    def repeats(self) -> float:
        return self.duration

    @property
    def fade(self) -> float:
        return RAMP * self.repeats

    @property
    def random(self) -> int:
        return self.seed

    def words(self, unit: str, shown: Shown) -> str:
        points = f"table {self.file}" if self.values is None else f"{len(self.values)} points"
        times = f"repeated after {shown(self.duration)} s, seed {self.seed}"
        return f"random vibration, density of {points} in {self.unit}, {times}"


def check_density(points: list[tuple[float, float]], duration: float) -> None:
    """Raise ValueError for points of a density that cannot be used; no points are none to check."""
    for before, after in pairwise(points):
        if after[0] <= before[0]:
            raise ValueError(f"the frequency {after[0]:g} Hz does not come after {before[0]:g} Hz")
    for frequency, density in points:
        if frequency <= 0.0 or density < 0.0:
            raise ValueError(f"a density of {density:g} at {frequency:g} Hz: frequencies above 0, densities 0 or more")
    if points:
        check_lines(points[0][0], points[-1][0], duration, MOST_RANDOM_LINES)
    if points and not any(density for _, density in points):
        raise ValueError("the density is zero everywhere")


class SweepTable(Course):
    """A sin of a frequency that goes from f_start to f_end, and stays there."""

    stated: ClassVar[bool] = True
    type: Literal["sweep"]
    f_start: Positive
    """Hz"""
    f_end: Positive
    """Hz"""
    amplitude: Finite
    """A, in the unit of the excitation's kind."""
    duration: Positive
    """s from f_start to f_end."""
    law: Literal["linear", "log"] = "linear"
    """Hz per second, or octaves per second, are constant."""

    @property
    def highest(self) -> float:
        return max(self.f_start, self.f_end)

    def made(self) -> Signal:
        return SineSweep(self.f_start, self.f_end, self.amplitude, self.duration, self.law == "log")

    def words(self, unit: str, shown: Shown) -> str:
        ends = f"{shown(self.f_start)} to {shown(self.f_end)} Hz in {shown(self.duration)} s"
        return f"{self.law} sine sweep, {ends}, {shown(self.amplitude)} {unit}"


class _Shock(Course):
    """Zero before and after."""

    type: str

    def check(self, kind: str, dof: str) -> None:
        if kind == "displacement":
            raise ValueError(f'a {self.type} displacement has kinks: give kind = "acceleration", or a smooth-step')


class HalfSineTable(_Shock):
    """A shock: half a sine, zero before and after; for accelerations, velocities and forces."""

    type: Literal["half-sine"]
    amplitude: Finite
    """In the unit of the excitation's kind."""
    duration: Positive
    """s"""
    start: NonNegative = 0.0
    """s"""

    @property
    def highest(self) -> float:
        return LOBE / self.duration

    @property
    def resolving(self) -> float:
        return self.duration / PER_SHOCK

    def made(self) -> Signal:
        return HalfSine(self.amplitude, self.duration, self.start)

    def words(self, unit: str, shown: Shown) -> str:
        return f"half-sine shock of {shown(self.duration)} s, {shown(self.amplitude)} {unit}"


class TrapezoidTable(_Shock):
    """A shock with straight flanks, zero before and after; for accelerations, velocities and forces."""

    type: Literal["trapezoid"]
    amplitude: Finite
    """In the unit of the excitation's kind."""
    rise: Positive
    """s"""
    hold: Positive
    """s"""
    fall: Positive
    """s"""
    start: NonNegative = 0.0
    """s"""

    @property
    def highest(self) -> float:
        return LOBE / (self.rise + self.hold + self.fall)

    @property
    def resolving(self) -> float:
        return min(self.rise, self.hold, self.fall) / PER_FLANK

    def made(self) -> Signal:
        return Table(*trapezoid(self.amplitude, self.rise, self.hold, self.fall, self.start))

    def words(self, unit: str, shown: Shown) -> str:
        times = f"{shown(self.rise)}, {shown(self.hold)} and {shown(self.fall)} s"
        return f"trapezoidal shock of {times}, {shown(self.amplitude)} {unit}"
