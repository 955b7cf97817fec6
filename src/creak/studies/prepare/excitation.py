"""The excitations of a study: driven dofs, and their samples at the steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Literal

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.coupling import Driven, labels_of
from creak.digest import digest, file_stem
from creak.dynamics.loads import Loads
from creak.errors import InputError
from creak.linalg.memory import require
from creak.model.dofs import node_and_dof
from creak.model.mesh import Model
from creak.model.units import GRAVITY, UNITS
from creak.signals import sources
from creak.signals.between_samples import FEWEST, JITTER, even_step, evened
from creak.signals.signal import Signal
from creak.signals.vibration import RandomVibration
from creak.studies.design.supports import loads_taken
from creak.studies.file.case import Course, Driving
from creak.studies.file.excitation_tables import ExcitationTable
from creak.studies.file.signals.course import columns
from creak.studies.file.signals.tables import RecordTable, TableTable
from creak.studies.file.signals.vibration import PsdTable, check_density
from creak.studies.file.table import DOFS
from creak.studies.file.tables import KEPT, Samples, read_header, read_signal, read_table
from creak.studies.prepare.spread import resolved
from creak.studies.solved import solved

DERIVATIVES = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""Of the motion that an excitation of this kind prescribes."""
POWER = 0.99
"""Share of a sampled load's power below its highest frequency."""
START = 11.0
"""f_max that "auto" begins with over the highest frequency of the excitation (docs/guidelines.md)."""


def driven_dofs(model: Model, driving: Driving) -> Driven:
    """Dofs with prescribed motion, one coordinate per excitation.

    Raises
    ------
    InputError : unknown node set; a dof driven twice.
    """
    labels = {}
    seen: dict[int, str] = {}
    for name, table in driving.moving.items():
        nodes = model.node_set(table.node_set, where=driving.places.where("excitation", name, "node_set"))
        labels[name] = labels_of(nodes, DOFS.index(table.dof) + 1)
        for label in labels[name].tolist():
            if label in seen and seen[label] != name:
                node = model.nodes.label(node_and_dof(label)[0])
                raise InputError(
                    f"node {node} {table.dof} is driven by {seen[label]!r} and {name!r}",
                    where=driving.places.where("excitation", name),
                    fix="Drive each dof once.",
                )
            seen[label] = name
    for moved in moved_before(model, driving):
        by = {seen.get(label) for label in moved.labels.tolist()}
        whole = next(
            (name for name in by if name is not None and np.array_equal(np.sort(labels[name]), np.sort(moved.labels))),
            "",
        )
        if len(by) == 1 and whole:
            continue
        if by != {None}:
            raise InputError(
                f"the nodes of this displacement are moved in part by {' and '.join(sorted(filter(None, by)))}",
                where=moved.where,
                expected="nodes that nothing else moves, or all those of one excitation",
                fix="Divide the node set.",
            )
        labels[moved.name] = moved.labels
        seen |= dict.fromkeys(moved.labels.tolist(), moved.name)
    return Driven(labels)


@dataclass(frozen=True, eq=False)
class StaticMotion:
    """Dofs that are moved before the run and held there."""

    name: str
    """Of their coordinate, where no excitation moves them."""
    labels: IntArray
    value: float
    where: str
    node_set: str = ""
    """Of the study's table; "": the deck's loads name the nodes."""


def moved_before(model: Model, driving: Driving) -> list[StaticMotion]:
    """The static displacements, of tables and of the deck's loads that they name."""
    found = []
    for k, table in enumerate(driving.statics):
        if table.displacement is not None:
            nodes = model.node_set(table.node_set or "", where=driving.places.where("static", k, "node_set"))
            labels = labels_of(nodes, DOFS.index(table.dof or "x") + 1)
            where, moved = driving.places.where("static", k), table.displacement
            found.append(StaticMotion(f"static.{k + 1}", labels, moved, where, table.node_set or ""))
    for k, loads in loads_taken(model, driving):
        found += [
            StaticMotion(f"static.{k + 1}.{j + 1}", m.labels, m.value, m.where) for j, m in enumerate(loads.moved)
        ]
    return found


WORTH_KEEPING = 10_000
"""Samples from which on a signal is kept for the next run."""
COURSES = 3
"""Of each excitation at each instant: displacement, velocity, acceleration."""
MOST_STEPS = 100_000_000
"""Steps of a run, substeps counted; the loads of more do not fit into memory."""


def count_steps(course: Course, parts: int) -> int:
    """Steps of a run, each of so many parts.

    Raises
    ------
    InputError : neither end nor a periodic excitation; fewer than two steps, or more than `MOST_STEPS`.
    """
    table, end = course.time, course.end
    steps = end / table.step
    if table.exact and parts * steps > MOST_STEPS:
        raise InputError(
            f"a run of {end:g} s takes {steps:.3g} flight steps of {table.step:.3g} s, by the highest frequency that "
            "its excitations, [verification] f_max or [output] interval ask for",
            where=course.places.where("time"),
            expected=f"at most {MOST_STEPS // parts:,}",
            fix="Are frequencies in Hz and times in s? Lower what is too high, or end the run earlier.",
        )
    if not steps > 1.5 or parts * steps > MOST_STEPS:
        raise InputError(
            f"a run of {end:g} s has {steps:.6g} step(s) of {table.step:g} s",
            where=course.places.where("time", "step"),
            expected=f"two to {MOST_STEPS // parts:,}",
            fix="Change the step or move the end.",
        )
    return round(steps)


def time_axis(driving: Driving, course: Course, parts: int | None = None) -> FloatArray:
    """(parts n_step + 1,) instants of the run: `parts` of them a step, by default as many as there are substeps.

    Raises
    ------
    InputError : as `count_steps`. OutOfMemory : memory does not hold the loads.
    """
    parts = course.time.substeps if parts is None else parts
    n = count_steps(course, parts)
    require(
        8.0 * parts * n * (1 + COURSES * len(driving.excitations)),
        f"the loads of {parts * n:,} instants",
        "Move the end of the run, or write fewer outputs.",
    )
    return np.asarray(course.time.step / parts * np.arange(parts * n + 1), dtype=np.float64)


def highest_frequency(driving: Driving, *, stated: bool = False) -> float:
    """Highest frequency that the excitations (`stated`: those which hold no other) are known to hold, Hz (0 for steps
    and tables)."""
    highest = 0.0
    for name, table in driving.excitations.items():
        s = table.signal
        if stated and not s.stated:
            continue
        if isinstance(s, PsdTable) and s.values is None:
            highest = max(highest, _density_points(driving, s, name)[-1][0])
        highest = max(highest, s.highest)
    return highest


@dataclass(frozen=True)
class Excitation:
    """How high the load reaches."""

    frequency: float
    """Hz"""
    source: str
    """"stated", "sampled" (99 % of the power lies below) or "assumed"."""


def first_f_max(given: float | Literal["auto"], reach: Callable[[], Excitation], end: float) -> float:
    """[reduction] f_max, Hz; of "auto" the one that it begins with. A run is no shorter than a period of its load.

    Parameters
    ----------
    reach : how high the load reaches. end : of the run, s.
    """
    return START * max(reach().frequency, 1.0 / end) if given == "auto" else given


def excitation_of(driving: Driving, loads: Loads, otherwise: float) -> Excitation:
    """The highest frequency of the load: stated, found in its samples, or assumed.

    Samples of records, tables and steps: the frequency below which 99 % of the power of the force, of the acceleration
    (where that is given) or of the velocity lies, the mean left out. The acceleration of a displacement given by points
    would show the points themselves.

    Parameters
    ----------
    otherwise : Hz, assumed where nothing is stated or found.
    """
    stated = highest_frequency(driving)
    if all(t.signal.stated for t in driving.excitations.values()) and stated > 0.0:
        return Excitation(stated, "stated")
    sampled = max((_reach(x, loads.step) for x in _loads_of(driving, loads)), default=0.0)
    if max(stated, sampled) > 0.0:
        return Excitation(max(stated, sampled), "stated" if stated >= sampled else "sampled")
    return Excitation(otherwise, "assumed")


def _loads_of(driving: Driving, loads: Loads) -> Iterator[FloatArray]:
    """(n_time,) of each excitation that moves something, then of each force."""
    for j, table in enumerate(driving.moving.values()):
        yield loads.support[2 if table.values_of == "acceleration" else 1, :, j]
    yield from loads.force.T


def _reach(x: FloatArray, step: float) -> float:
    power = np.abs(np.fft.rfft(x - x.mean())) ** 2
    total = np.cumsum(power)
    if total[-1] <= 1e-20 * x.size * float(x @ x):
        return 0.0
    return float(np.fft.rfftfreq(x.size, step)[np.searchsorted(total, POWER * total[-1])])


def sample_loads(
    model: Model, driving: Driving, time: FloatArray, store: Path | None = None, *, exact: bool = False
) -> Loads:
    """All excitations at the steps.

    Parameters
    ----------
    exact : of a march without scheme, which knows no more of them: what changes faster is spread (`spread`).
    store : folder of saved superelements, beside which sampled signals are kept.

    Raises
    ------
    InputError : unknown node set, or a table or record that cannot be used.
    """
    moving, forced = driving.moving, driving.forcing
    support = np.zeros((3, time.size, len(driven_dofs(model, driving).names)))
    for j, (name, table) in enumerate(moving.items()):
        support[:, :, j] = _sampled(driving, name, table, time, store, exact)
    force = np.zeros((time.size, len(forced)))
    labels = []
    for j, (name, table) in enumerate(forced.items()):
        nodes = model.node_set(table.node_set, where=driving.places.where("excitation", name, "node_set"))
        force[:, j] = _sampled(driving, name, table, time, store, exact)[0]
        labels.append(labels_of(nodes, DOFS.index(table.dof) + 1))
    return Loads(time, support, force, tuple(labels))


def loads_over(model: Model, driving: Driving, course: Course, parts: int | None = None) -> Loads:
    """The excitations over a run, `sample_loads` on its `time_axis`."""
    return sample_loads(model, driving, time_axis(driving, course, parts), exact=course.time.exact)


def _sampled(
    driving: Driving, name: str, table: ExcitationTable, time: FloatArray, store: Path | None, exact: bool
) -> FloatArray:
    """(3, n_time) prescribed motion and its derivatives, or (1, n_time) force."""
    signal = _signal(driving, name, table)
    exact = exact and signal.sudden

    def make() -> dict[str, FloatArray]:
        if table.kind == "force":
            by_impulse = partial(signal.motion, order=2)
            return {"rows": (resolved(by_impulse, time).acceleration if exact else signal.values(time))[None]}
        motion_of = partial(signal.motion, order=DERIVATIVES[table.kind])
        motion = resolved(motion_of, time) if exact else motion_of(time)
        return {"rows": np.stack([motion.displacement, motion.velocity, motion.acceleration])}

    if store is None or time.size < WORTH_KEEPING:
        return make()["rows"]
    made_from = [digest([signal, table.kind, time, exact])]
    return solved(store, f"signal_{file_stem(name)}", made_from, make)["rows"]


def records_of(driving: Driving, tables: Mapping[str, ExcitationTable]) -> dict[str, sources.Record]:
    """The records among some excitations, by their names."""
    made = {name: _signal(driving, name, t) for name, t in tables.items() if isinstance(t.signal, RecordTable)}
    return {name: signal for name, signal in made.items() if isinstance(signal, sources.Record)}


def _signal(driving: Driving, name: str, table: ExcitationTable) -> Signal:
    s = table.signal
    if isinstance(s, PsdTable):
        frequency, density = columns(s.values or _density_points(driving, s, name))
        return RandomVibration(frequency, density * _squared(s.unit, driving.units), s.duration, s.seed)
    if (made := s.made()) is not None:
        return made
    assert isinstance(s, TableTable | RecordTable)
    assert s.file is not None
    where = driving.places.where("excitation", name, "signal")
    path = driving.places.sibling(s.file)
    read = read_signal(path, s.channel, where)
    if not isinstance(s, RecordTable):
        return sources.Table(read.time, s.factor * read.value, s.rounding)
    if read.time.size < 2:
        raise InputError(f"{s.file}: a record of {read.time.size} sample(s)", where=where, expected="two or more")
    step, off = even_step(read.time), 0.0
    if step is None:
        made_even = _on_even_times(read)
        if made_even is None:
            raise _uneven(path, read.time, where)
        read, off = made_even
        step = float(read.time[1] - read.time[0])
    nyquist = 0.5 / step
    if s.high_pass >= nyquist:
        raise InputError(
            f"high_pass = {s.high_pass:g} Hz",
            where=where,
            expected=f"below {nyquist:.6g} Hz, which samples {step:.6g} s apart can hold",
            fix=f"Are the times of {s.file} in s? The head time [ms] of their column tells another unit.",
        )
    return _record(read, s.factor, s.high_pass, off)


@lru_cache(maxsize=KEPT)
def _on_even_times(read: Samples) -> tuple[Samples, float] | None:
    found = evened(read.time, read.value)
    return None if found is None else (Samples(found[0], found[1], read.unit), found[2])


@lru_cache(maxsize=KEPT)
def _record(read: Samples, factor: float, high_pass: float, off: float) -> sources.Record:
    """The record, whose integrals are made once."""
    return sources.Record(read.time, factor * read.value, high_pass, off)


def _uneven(path: Path, time: FloatArray, where: str) -> InputError:
    """Of a record in a table; those of other files are even."""
    between = np.diff(time)
    usual = float(np.median(between))
    row = int(np.abs(between - usual).argmax()) + 1
    line = read_header(path, where, "table")[1][row][0]
    return InputError(
        f"the time {time[row]:.9g} s comes {between[row - 1]:.6g} s after that before it, others {usual:.6g} s",
        where=f"{path}:{line}",
        expected=f"even sampling; steps from {1.0 - JITTER:g} to {1.0 + JITTER:g} times the usual one, of {FEWEST} "
        "samples or more, are put on even times",
        fix="Samples are missing there: take a piece without the gap, or export the record again at a fixed rate."
        if between[row - 1] > usual
        else "Two samples are of almost one time: drop one of them, or export the record again at a fixed rate.",
    )


def _squared(unit: str, units: str) -> float:
    """What a density in `unit` is multiplied by to be one in the units of the model."""
    length = UNITS[units].per_metre
    return float({"g2/Hz": (GRAVITY * length) ** 2, "(m/s2)2/Hz": length**2, "unit2/Hz": 1.0}[unit])


def _density_points(driving: Driving, s: PsdTable, name: str) -> list[tuple[float, float]]:
    """Points of a density's file.

    Raises
    ------
    InputError : no such file, wrong header, numbers that are none or that make no density.
    """
    assert s.file is not None
    where = driving.places.where("excitation", name, "signal")
    x, y = read_table(driving.places.sibling(s.file), where, ("frequency", "density"))
    points = list(zip(x.tolist(), y.tolist(), strict=True))
    try:
        check_density(points, s.duration)
    except ValueError as error:
        raise InputError(str(error), where=driving.places.sibling(s.file), fix="Correct the table.") from error
    return points
