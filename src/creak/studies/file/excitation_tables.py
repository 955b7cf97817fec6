"""Tables of what drives the model: excitations and their signals."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from creak.studies.file.design.node_tables import Label
from creak.studies.file.table import Dof, Finite, NonNegative, Positive, Table


class MultisineTable(Table):
    """Random-phase multisine: every line between f_min and f_max with the same amplitude."""

    type: Literal["multisine"]
    f_min: NonNegative = 1.0
    """Hz"""
    f_max: Positive
    """Hz"""
    amplitude: Finite
    """Of each line."""
    period: Positive = 1.0
    """s"""
    seed: Annotated[int, Field(ge=0)] = 1
    """Of the random phases."""

    @model_validator(mode="after")
    def _has_lines(self) -> MultisineTable:
        if self.f_min > self.f_max:
            raise ValueError(f"f_min = {self.f_min:g} Hz is above f_max = {self.f_max:g} Hz")
        if int(self.f_max * self.period + 1e-9) < max(1.0, self.f_min * self.period - 1e-9):
            raise ValueError(
                f"period = {self.period:g} s gives lines at whole multiples of {1.0 / self.period:g} Hz, none of them "
                f"between f_min = {self.f_min:g} and f_max = {self.f_max:g} Hz"
            )
        return self


class SineTable(Table):
    """A sin(2 pi f t)."""

    type: Literal["sine"]
    frequency: Positive
    """Hz"""
    amplitude: Finite
    """A, in the unit of the excitation's kind."""


class StepTable(Table):
    """Constant from t = 0."""

    type: Literal["step"]
    amplitude: Finite
    """In the unit of the excitation's kind."""


Points = Annotated[list[tuple[Finite, Finite]], Field(min_length=1)]
"""[[time, value], ...], s, times that increase."""
CLOSEST = 1e-12
"""s between two points of a signal."""


def _increase(points: list[tuple[float, float]]) -> None:
    for before, after in pairwise(points):
        if after[0] < before[0] + CLOSEST:
            raise ValueError(f"the time {after[0]:g} s does not come {CLOSEST:g} s or more after {before[0]:g} s")


class TableTable(Table):
    """A CSV file with the header time,value, a channel of a measured file, or the points themselves."""

    type: Literal["table"]
    file: str | None = None
    """Path relative to the study file: .csv; .rsp, .drv, .rpc (RPC III); .uff, .unv (data set 58)."""
    channel: Label | None = None
    """Name or number of a channel; of a CSV file the name of a column."""
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


class SmoothStepTable(Table):
    """From point to point by a polynomial of degree five that starts and ends with zero slope and curvature."""

    type: Literal["smooth-step"]
    values: Annotated[Points, Field(min_length=2)]
    """[[time, value], ...], s and the unit of the excitation's kind."""

    @model_validator(mode="after")
    def _rises(self) -> SmoothStepTable:
        _increase(self.values)
        return self


class PeriodicTable(Table):
    """mean + sum_n cosine_n cos(2 pi n f (t - start)) + sine_n sin(2 pi n f (t - start)); the mean before start."""

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


class RecordTable(Table):
    """A measured acceleration, integrated by omega arithmetic."""

    type: Literal["record"]
    file: str
    """Path relative to the study file: CSV with the header time,value; .rsp, .drv, .rpc (RPC III); .uff, .unv."""
    channel: Label | None = None
    """Name or number of a channel; of a CSV file the name of a column."""
    factor: Finite = 1.0
    """The values of the file are taken so many times, 9810 for g in mm/s2."""
    high_pass: Positive
    """Hz; below it the record counts as drift."""


class PsdTable(Table):
    """Random vibration with a power spectral density, one-sided; a power of the frequency between its points."""

    type: Literal["psd"]
    unit: Literal["g2/Hz", "(m/s2)2/Hz", "unit2/Hz"]
    """Of the density; the first two for accelerations, the last: the unit of the excitation's kind, squared, per Hz."""
    values: Annotated[Points, Field(min_length=2)] | None = None
    """[[frequency, density], ...], Hz and `unit`."""
    file: str | None = None
    """CSV file with the header frequency,density; path relative to the study file."""
    duration: Positive = 10.0
    """s after which the signal repeats; its lines are 1 / duration Hz apart."""
    seed: Annotated[int, Field(ge=0)] = 1
    """Of the random phases."""

    @model_validator(mode="after")
    def _one_of(self) -> PsdTable:
        if (self.file is None) == (self.values is None):
            raise ValueError("give either file or values")
        check_density(self.values or [], self.duration)
        return self


def check_density(points: list[tuple[float, float]], duration: float) -> None:
    """Raise ValueError for points of a density that cannot be used; no points are none to check."""
    for before, after in pairwise(points):
        if after[0] <= before[0]:
            raise ValueError(f"the frequency {after[0]:g} Hz does not come after {before[0]:g} Hz")
    for frequency, density in points:
        if frequency <= 0.0 or density < 0.0:
            raise ValueError(f"a density of {density:g} at {frequency:g} Hz: frequencies above 0, densities 0 or more")
    if points and points[-1][0] * duration < max(1.0, points[0][0] * duration):
        raise ValueError(f"a duration of {duration:g} s has no line between {points[0][0]:g} and {points[-1][0]:g} Hz")
    if points and not any(density for _, density in points):
        raise ValueError("the density is zero everywhere")


class SweepTable(Table):
    """A sin of a frequency that goes from f_start to f_end, and stays there."""

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


class HalfSineTable(Table):
    """A shock: half a sine, zero before and after; for accelerations, velocities and forces."""

    type: Literal["half-sine"]
    amplitude: Finite
    """In the unit of the excitation's kind."""
    duration: Positive
    """s"""
    start: NonNegative = 0.0
    """s"""


class TrapezoidTable(Table):
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


class ExcitationTable(Table):
    """[excitation.NAME]"""

    node_set: str
    """All nodes of this set get the same signal."""
    dof: Dof
    """Direction of the motion or force."""
    kind: Literal["displacement", "velocity", "acceleration", "force"] = "displacement"
    """length, length/time, length/time^2, or force on each node."""
    signal: SignalTable
    """The course in time."""

    @model_validator(mode="after")
    def _fits(self) -> ExcitationTable:
        s = self.signal
        if isinstance(s, HalfSineTable | TrapezoidTable) and self.kind == "displacement":
            raise ValueError(f'a {s.type} displacement has kinks: give kind = "acceleration", or a smooth-step')
        if isinstance(s, PsdTable) and s.unit != "unit2/Hz" and self.kind != "acceleration":
            raise ValueError(f'a density in {s.unit} is one of an acceleration: give kind = "acceleration"')
        if isinstance(s, PsdTable) and s.unit != "unit2/Hz" and self.dof.startswith("r"):
            raise ValueError(f'a density in {s.unit} is one of a translation: give unit = "unit2/Hz"')
        return self


class StaticTable(Table):
    """[[static]]: a load that acts before the run and goes on through it; give one of gravity, force, displacement and
    press_fit. The run starts from the equilibrium under all of them, with contact."""

    gravity: tuple[Finite, Finite, Finite] | None = None
    """length/time^2: acceleration of gravity on all mass, [0, 0, -9810] in mm and s where z is up."""
    force: Finite | None = None
    """force (moment for rx, ry, rz) on each node of node_set along dof."""
    displacement: Finite | None = None
    """length or rad: the nodes of node_set are moved by so much along dof and held there; nodes that an excitation
    moves move about this place."""
    press_fit: Literal[True] | None = None
    """true: surfaces that overlap (in the deck, or by a negative clearance) press each other apart; without it their
    gap is set to 0 without strain."""
    node_set: str | None = None
    """Nodes of a force or displacement."""
    dof: Dof | None = None
    """Its direction."""

    @model_validator(mode="after")
    def _one_load(self) -> StaticTable:
        given = [k for k in ("gravity", "force", "displacement", "press_fit") if getattr(self, k) is not None]
        if len(given) != 1:
            raise ValueError(
                f"gives {' and '.join(given) or 'no load'}: give one of gravity, force, displacement and "
                "press_fit, the others in [[static]] tables of their own"
            )
        at_nodes = given[0] in ("force", "displacement")
        if at_nodes and (self.node_set is None or self.dof is None):
            raise ValueError(f"{given[0]} needs node_set and dof")
        if not at_nodes and (self.node_set is not None or self.dof is not None):
            raise ValueError(f"{given[0]} acts on the whole model: leave out node_set and dof")
        zero = self.force == 0.0 or (self.gravity is not None and not any(self.gravity))
        if zero:
            raise ValueError(f"{given[0]} is zero: it loads nothing")
        return self
