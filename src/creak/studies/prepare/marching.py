"""How a study is marched: through which loads, how finely, and what is looked at on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.dynamics.flow.resolution import Resolution
from creak.dynamics.loads import Loads
from creak.dynamics.record.watch import Watched
from creak.dynamics.scheme import Scheme
from creak.model.mesh import Model
from creak.studies.file.case import Course
from creak.studies.file.config import TimeTable, VerificationTable
from creak.studies.prepare.elines import NO_ELINES, Elines
from creak.studies.prepare.excitation import count_steps
from creak.studies.prepare.output_steps import compared_end, shown_window
from creak.studies.prepare.static_loads import StaticStart


@dataclass(frozen=True)
class Marching:
    """Through which loads a run goes, and how."""

    course: Course
    loads: Loads
    """At the ends of all steps and substeps."""
    sampled: Callable[[Course, int], Loads]
    """The same over another course, with so many samples a step."""
    excited: float
    """Highest frequency that the excitations are known to hold, Hz; 0: none is known."""
    resolution: Resolution
    """How finely contact is resolved."""
    solver: bool
    """Whether channels rub or have dampers, which takes the solver of contact."""

    @property
    def table(self) -> TimeTable:
        """[time]"""
        return self.course.time

    @property
    def scheme(self) -> Scheme:
        """Of a forced step."""
        return self.table.scheme

    @property
    def ends(self) -> FloatArray:
        """(n_step + 1,) of the whole steps, s."""
        return np.asarray(self.loads.time[:: self.table.substeps])

    @property
    def window(self) -> tuple[float, float]:
        """s, stretch that is compared and shown."""
        return shown_window(self.course, self.ends)

    def divided(self, parts: int) -> Loads:
        """The loads with `parts` samples a step."""
        return self.loads if parts == self.table.substeps else self.sampled(self.course, parts)

    @property
    def compared(self) -> Marching:
        """The same up to where the unreduced model is run for comparison."""
        loads, end = self.loads, float(self.loads.time[-1])
        until = compared_end(self.course, end)
        if until == end:
            return self
        course = replace(self.course, time=self.table.model_copy(update={"end": until, "periods": None}))
        n = self.table.substeps * count_steps(course, self.table.substeps) + 1
        loads = replace(loads, time=loads.time[:n], support=loads.support[:, :n], force=loads.force[:n])
        return replace(self, course=course, loads=loads)


@dataclass(frozen=True)
class Scope:
    """What is told of a run: of which model, by which events, over what time."""

    model: Model
    verification: VerificationTable
    window: tuple[float, float]
    """s"""


@dataclass(frozen=True)
class Observed:
    """What is looked at in a run besides its channels."""

    verification: VerificationTable
    """By which events are told."""
    static: StaticStart | None
    """Whose share the kept displacements hold."""
    nodes: IntArray
    """Node rows whose motion is kept."""
    seen: Watched | None = None
    """At every whole step, whatever is kept."""
    lines: Elines = NO_ELINES
    """At whose points relative motion is measured."""
    record: bool = False
    """Whether the motion around the hardest events is kept."""
