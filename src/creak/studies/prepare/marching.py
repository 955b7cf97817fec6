"""How a study is marched: through which loads, how finely, and what is looked at on the way.

What is kept of it at which nodes and steps, which stretch is compared, and settings that leave nothing of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.coupling import Driven
from creak.assembly.system import System
from creak.dynamics.flow.resolution import Resolution
from creak.dynamics.loads import Loads
from creak.dynamics.record.watch import Watched
from creak.dynamics.scheme import Scheme
from creak.errors import InputError
from creak.model.constraints import held_labels, tied_nodes
from creak.model.dofs import nodes_of
from creak.model.mesh import Model
from creak.studies.file.case import Course
from creak.studies.file.config import TimeTable, VerificationTable
from creak.studies.file.places import Places
from creak.studies.prepare.elines import NO_ELINES, Elines
from creak.studies.prepare.excitation import count_steps
from creak.studies.prepare.static_loads import StaticStart
from creak.studies.warned import Warned

FEW = 10
"""Periods up to which the last one alone counts."""
SAME_END = 1e-6
"""Share of its length by which a run may end beside the time that the study gives."""


def check_outputs(course: Course, time: FloatArray, pairs: int) -> list[str]:
    """Refuse outputs that a run cannot have, before it is made; warnings of what they cannot show.

    Parameters
    ----------
    time : ends of the whole steps. pairs : how many the study compares.

    Raises
    ------
    InputError : an interval that is no multiple of the step or longer than the run, a field that starts after it; with
        pairs, fewer than two outputs in the verification window, or no line of their spectra up to f_max.
    """
    table, f_max, step = course.output, course.f_max, course.time.step
    field_steps(course, time)
    interval, end = output_every(course) * step, float(time[-1])
    for key, value in (("interval", table.interval), ("field_interval", table.field_interval)):
        if value is not None and value > end * (1.0 + 1e-9):
            raise InputError(
                f"{key} = {value:g} s is longer than the run, which ends at {end:g} s",
                where=course.places.where("output", key),
                expected="several intervals in a run",
                fix="Shorten it.",
            )
    notes = _other_end(course, end)
    start, end = excitation_window(course, time)
    if not pairs:
        return notes
    if (end - start) / interval < 2.0 - 1e-6:
        raise InputError(
            f"interval = {interval:g} s leaves fewer than two outputs in the {end - start:g} s that are compared",
            where=course.places.where("output", "interval"),
            expected=f"at most {0.5 * (end - start):g} s",
            fix="Shorten it.",
        )
    if f_max * (end - start) < 1.0 - 1e-6:
        raise InputError(
            f"f_max = {f_max:g} Hz lies below the first line of the spectra of the {end - start:g} s that are compared",
            where=course.places.where("verification", "f_max"),
            expected=f"{1.0 / (end - start):g} Hz or more",
            fix="Raise it, or make the run longer.",
        )
    if table.interval is not None and interval > step and f_max > 0.5 / interval * (1.0 + 1e-9):
        said = (
            f"[output] interval = {interval:g} s holds frequencies up to {0.5 / interval:g} Hz: the spectra and "
            f"their fit end there, below [verification] f_max = {f_max:g} Hz"
        )
        return [*notes, Warned(said)]
    return notes


def _other_end(course: Course, end: float) -> list[str]:
    """Where the run ends, if not where the study says."""
    over = end - course.end
    if abs(over) <= SAME_END * course.end:
        return []
    return [
        f"the run ends at {end:.7g} s, {abs(over):.2g} s {'after' if over > 0.0 else 'before'} [time] end: "
        f"it is made of whole steps of {course.time.step:.4g} s"
    ]


def output_every(course: Course) -> int:
    """Steps between outputs.

    Raises
    ------
    InputError : an interval shorter than the step, or no multiple of it.
    """
    interval = course.output.interval
    return 1 if interval is None else _steps(course, "interval", interval)


def field_steps(course: Course, time: FloatArray) -> IntArray:
    """Whole steps, of those that end at `time`, at which the motion of all nodes is written.

    Raises
    ------
    InputError : an interval shorter than the step, or no multiple of it; a start after the end of the run.
    """
    table = course.output
    if table.field_interval is None:
        return np.zeros(0, dtype=np.int64)
    every = _steps(course, "field_interval", table.field_interval)
    first = int(np.searchsorted(time, table.field_start - 1e-9 * course.time.step))
    if first >= time.size:
        raise InputError(
            f"field_start = {table.field_start:g} s",
            where=course.places.where("output", "field_start"),
            expected=f"a time within the run, which ends at {time[-1]:g} s",
            fix="Start earlier.",
        )
    return np.arange(first, time.size, every, dtype=np.int64)


def _steps(course: Course, key: str, interval: float) -> int:
    step = course.time.step
    every = round(interval / step)
    if every < 1 or abs(every * step - interval) > 1e-6 * interval:
        raise InputError(
            f"{key} = {interval:g} s",
            where=course.places.where("output", key),
            expected=f"a multiple of the step, {step:g} s",
            fix=f"Use {max(every, 1) * step:g}.",
        )
    return every


def excitation_window(course: Course, time: FloatArray) -> tuple[float, float]:
    """The time span that verification looks at: all of a run in which nothing repeats, else its last period.

    Of more than `FEW` periods it is the second half, in whole periods: contact may come back in every third alone.
    """
    period, end = course.repeats, float(time[-1])
    if period is None or period >= end:
        return 0.0, end
    whole = math.floor(end / period * (1.0 + 1e-9))
    return end - (whole // 2 if whole > FEW else 1) * period, end


def compared_end(course: Course, end: float) -> float:
    """s up to which the unreduced model is run beside the reduced one; the whole run unless the study says less."""
    until = course.until
    return end if until is None or until >= end * (1.0 - 1e-9) else until


def shown_window(course: Course, time: FloatArray) -> tuple[float, float]:
    """`excitation_window` up to `compared_end`: what the page shows event by event."""
    end = compared_end(course, float(time[-1]))
    return excitation_window(course, time[: max(2, int(np.searchsorted(time, end * (1.0 + 1e-9), side="right")))])


def output_nodes(
    model: Model, node_sets: Sequence[str], pairs: IntArray, measured: Sequence[IntArray], places: Places
) -> IntArray:
    """Rows of the nodes of pairs, of the node sets in [output] nodes and of tests, each once, in that order."""
    where = places.where("output", "nodes")
    sets = [model.node_set(name, where=where) for name in node_sets]
    return np.array(list(dict.fromkeys(np.concatenate([pairs.ravel(), *sets, *measured]).tolist())), dtype=np.int64)


def unmoved_warnings(model: Model, nodes: IntArray, driven: Driven, superelements: Sequence[System]) -> list[str]:
    """Nodes of the output without an element, a link, a support or a drive: their motion is written as zero."""
    moved = tied_nodes(model.constraints, model.nodes.count)
    for block in model.blocks:
        moved[block.nodes_idx] = True
    moved[driven.nodes_idx] = moved[nodes_of(held_labels(model.fixed))] = True
    for system in superelements:
        moved[nodes_of(system.labels)] = True
    bare = nodes[~moved[nodes]]
    if not bare.size:
        return []
    others, verb = (f" and {bare.size - 1} more", "have") if bare.size > 1 else ("", "has")
    return [
        Warned(
            f"node {model.nodes.label(int(bare[0]))}{others} of the output {verb} no element, link or support: nothing "
            "moves there, and zero is written; look at [output] nodes"
        )
    ]


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
