"""Convergence: the run once more with shorter steps, stiffer contact and more modes, compared event by event."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.errors import CreakError
from creak.studies.models.reduced import ReducedModel, reduce_model, with_more_modes
from creak.studies.models.superelements import MODES_FACTOR
from creak.studies.prepare.excitation import sample_loads, time_axis
from creak.studies.prepare.setup import Setup
from creak.studies.run.job import Run, StudyResult, events_in, march_run
from creak.verify.events import Event
from creak.verify.matching import EventMatch, match_events
from creak.verify.statistics import EventStatistics, compare_statistics, is_chaotic

SETTLED = 0.05
"""Low-passed force, impulse and closing speed are settled when the last refinement of every family changes them by no
more than this share: the 5 % within which the thesis calls an amplitude right (3.7.3)."""
TIME_LIMIT = 1e-4
"""s by which the resolution of contact in time may move start and duration; stiffness and modes, which the model sets,
by `TIME_SHARE`: the last of several micro-contacts of an event is theirs."""
TIME_SHARE = 0.1
"""Start and duration are settled when the last refinement of every family moves them by no more than this share of the
verification's `event_tolerance`, so that what is left cannot decide whether two events are the same one."""

BASE, HALF, QUARTER = "base", "h/2", "h/4"
TWICE, TENFOLD, MORE_MODES = "2 x stiffness", "10 x stiffness", "1.5 x f_max"
FINER, SOFTER, STIFFER = "half the tolerance", "half the stiffness", "twice the stiffness"
LAST_TWO = {
    "step": (HALF, QUARTER),
    "stiffness": (TWICE, TENFOLD),
    "tolerance": (BASE, FINER),
    "softer": (BASE, SOFTER),
    "stiffer": (BASE, STIFFER),
    "modes": (BASE, MORE_MODES),
}
"""Family -> the two runs whose difference tells how far it has settled; the first two are those of a forced step."""
HALVED = 2.0
"""How much finer the contact is resolved with half the tolerance."""

FIGURES: dict[str, Callable[[Event], float]] = {
    "start": lambda e: e.t_start,
    "duration": lambda e: e.t_end - e.t_start,
    "force": lambda e: e.force_place,
    "impulse": lambda e: e.impulse,
    "closing_speed": lambda e: e.closing_speed,
}
"""What is followed of every event: s, s, low-passed peak force of its place, force s, length/s."""
TIMES = ("start", "duration")
"""Figures whose changes are absolute, s; those of the others are shares."""

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Variant:
    """What one run takes differently."""

    name: str
    family: str
    """step, stiffness, modes; empty for the base run."""
    step: float
    """s"""
    refined: float = 1.0
    """How much finer than the accuracy says contact is resolved."""
    stiffness: float = 1.0
    """Factor on the stiffness of the contacts."""
    f_max: float | None = None
    """Hz, of the reduction; None: the model is not reduced."""


@dataclass(frozen=True)
class Outcome:
    """What a run found: its events and the figures of the whole run."""

    variant: Variant
    events: tuple[Event, ...]
    impulse: float
    """Of all channels over the whole run, force s."""
    energy_created: float
    """By the scheme, share of the external work."""
    dissipated: float
    """By the scheme, share of the external work."""
    steps: int
    end: float
    """Where the run ended, s."""
    wall_s: float
    stopped: str | None = None
    """Why it ended early; None: it did not."""

    @property
    def force(self) -> float:
        """Largest low-passed force of all events."""
        return max((e.force_place for e in self.events), default=0.0)


@dataclass(frozen=True)
class Settling:
    """One figure in every run, and how far it has settled."""

    name: str
    values: dict[str, float]
    """Run -> value, of those that have it."""
    changes: dict[str, float]
    """Family -> change by its last refinement: s for times, share of the last value for all others; nan where one of
    the two runs does not have the figure."""
    limit: float
    problem: str = ""
    """Why it cannot be settled; empty: the changes decide."""

    @property
    def settled_to(self) -> float:
        """Largest change of all families; nan where one of them is not known, or where there is none."""
        return float(np.max(np.abs(list(self.changes.values())))) if self.changes else np.nan

    @property
    def worst(self) -> str:
        """The family that moves the figure most; empty where that is not known."""
        known = {k: abs(v) for k, v in self.changes.items() if not np.isnan(v)}
        return max(known, key=known.__getitem__) if known else ""

    @property
    def settled(self) -> bool:
        """The last refinements agree, and so do the base run and the finest one."""
        changes = all(abs(x) <= self.limit_of(family) for family, x in self.changes.items())
        return not self.problem and bool(self.changes) and changes and not abs(self.base_error) > self.limit

    def limit_of(self, family: str) -> float:
        """What a family may move the figure by."""
        return min(self.limit, TIME_LIMIT) if self.name in TIMES and family == "tolerance" else self.limit

    @property
    def base_error(self) -> float:
        """Base run less the finest in time, as `changes`; nan where one of them does not have the figure."""
        return -change(self.name, self.values.get(BASE), self.values.get(FINER, self.values.get(QUARTER)))


@dataclass(frozen=True)
class EventSettling:
    """One event of the base run."""

    event: Event
    problem: str
    """Which runs do not have it; empty: all have."""
    figures: dict[str, Settling]

    @property
    def settled(self) -> bool:
        return all(f.settled for f in self.figures.values())


@dataclass(frozen=True)
class Convergence:
    """What the repeated runs tell of the base run."""

    model: str
    """The run that was repeated: reduced, or reference."""
    outcomes: dict[str, Outcome]
    """By name, the base run first."""
    families: dict[str, tuple[str, str]]
    """Those of `LAST_TWO` that were run."""
    window: tuple[float, float]
    """Events that start in it are compared, s."""
    events: tuple[EventSettling, ...]
    new: dict[str, int]
    """Run -> events of it in the window that the base run does not have."""
    totals: dict[str, Settling]
    """Number of events, impulse and largest low-passed force of the whole run."""
    statistics: dict[str, EventStatistics]
    """Family -> events of its last two runs in the window as samples."""
    exact: bool
    """No scheme was forced: the runs differ from the base run, each in one thing."""
    chaotic: bool
    """So many events that single ones need not be the same in two exact solutions."""
    notes: tuple[str, ...]

    @property
    def finest(self) -> str:
        """The run that is finest in time."""
        return FINER if self.exact else QUARTER

    def settled_events(self, name: str) -> int:
        """How many events have a figure settled."""
        return sum(e.figures[name].settled for e in self.events)


def converge(result: StudyResult, progress: Progress) -> Convergence:
    """Repeat the study's run and tell which of its figures have settled.

    Repeated is the run of the reduced model, or of the unreduced one where the study reduces nothing: with half and a
    quarter of the step h (and of its substeps near contact) at the base run's contact stiffness; with 2 and 10 times
    that stiffness at h/4, which resolves it; with 1.5 times the f_max of the reduction at h. All cover the same time
    at the same output interval, with the same channels. A run that stops early, or cannot be made, is reported and the
    others go on. A figure that has settled is free of the step, of the penalty and of the cut-off: it may still be off
    by what the mesh, the contact normals (found once), the damping and the pre-check (made with the base step, not
    repeated) say. Figures of single events that differ from run to run without trend are chaotic, not unconverged:
    `Convergence.statistics` compares the samples then.
    """
    base = result.runs.get("reduced") or result.runs["reference"]
    notes: list[str] = []
    outcomes = {BASE: _outcome(_base_variant(result), base)}
    if base.stopped is not None:
        notes.append(f"convergence was not looked at: the {base.stopped}")
    elif not result.gaps.presses:
        notes.append("convergence was not looked at: there is no channel that can press")
    else:
        variants, notes = plan(result)
        for variant in variants:
            outcomes[variant.name] = _repeat(result, base, variant, progress)
    notes += [o.stopped for o in outcomes.values() if o.stopped and o.variant.family]
    v, exact = result.setup.study.config.verification, result.setup.study.config.time.exact
    window = (0.0, float(base.history.time[-1])) if exact else result.window
    return assess(outcomes, base.name, window, v.event_tolerance, tuple(notes))


def assess(
    outcomes: dict[str, Outcome], model: str, window: tuple[float, float], tolerance: float, notes: tuple[str, ...] = ()
) -> Convergence:
    """Compare runs, the base run first among them.

    Parameters
    ----------
    tolerance : events that start this close are the same, s.
    """
    families = {name: pair for name, pair in LAST_TWO.items() if set(pair) <= outcomes.keys()}
    samples = {
        name: compare_statistics(outcomes[a].events, outcomes[b].events, window) for name, (a, b) in families.items()
    }
    matches = {
        name: match_events(outcomes[BASE].events, o.events, tolerance, window)
        for name, o in outcomes.items()
        if name != BASE
    }
    events = _events(outcomes, matches, families, window, tolerance)
    new = {name: len(match.extra) for name, match in matches.items()}
    return Convergence(
        model,
        outcomes,
        families,
        window,
        events,
        new,
        _totals(outcomes, families),
        samples,
        FINER in outcomes,
        is_chaotic(len(events), window[1] - window[0]),
        notes,
    )


def change(name: str, before: float | None, after: float | None) -> float:
    """after - before (times, s) or that over |after|; inf where something becomes nothing; nan where one is unknown."""
    if before is None or after is None:
        return np.nan
    if name in TIMES or after == before:
        return after - before
    return (after - before) / abs(after) if after else np.inf


# --- the runs -------------------------------------------------------------------------------------------------------


def plan(result: StudyResult) -> tuple[list[Variant], list[str]]:
    """The runs to make, and what is to be said of those that are not."""
    if result.setup.study.config.time.exact:
        return _exact_plan(result)
    base, notes = _base_variant(result), []
    h, quarter = base.step, 0.25 * base.step
    variants = [replace(base, name=name, family="step", step=x) for name, x in ((HALF, 0.5 * h), (QUARTER, quarter))]
    softer = _scaled(result)
    hard = int(np.isinf(result.gaps.stiffness).sum())
    if softer.size:
        variants += [
            replace(base, name=name, family="stiffness", step=quarter, stiffness=factor)
            for name, factor in ((TWICE, 2.0), (TENFOLD, 10.0))
        ]
    if hard:
        notes.append(f"{hard} hard channels have no stiffness to vary and stay hard in all runs")
    if result.setup.connectors.m:
        notes.append("the stiffness of connectors is a figure of the study, no penalty: it stays in all runs")
    if not softer.size:
        notes.append("no contact has a stiffness to vary: settling with it was not looked at")
    if base.f_max is not None and result.setup.study.config.reduction.method != "guyan":
        variants.append(replace(base, name=MORE_MODES, family="modes", f_max=MODES_FACTOR * base.f_max))
    elif base.f_max is not None:
        notes.append("a Guyan reduction keeps no modes: settling with f_max was not looked at")
    return variants, notes


def _exact_plan(result: StudyResult) -> tuple[list[Variant], list[str]]:
    """One run for each thing that the answer must not hang on."""
    base, notes = _base_variant(result), []
    variants = [replace(base, name=FINER, family="tolerance", step=base.step / HALVED, refined=HALVED)]
    if _scaled(result).size:
        variants += [
            replace(base, name=SOFTER, family="softer", stiffness=0.5),
            replace(base, name=STIFFER, family="stiffer", stiffness=2.0),
        ]
    if base.f_max is not None and result.setup.study.config.reduction.method != "guyan":
        variants.append(replace(base, name=MORE_MODES, family="modes", f_max=MODES_FACTOR * base.f_max))
    elif base.f_max is not None:
        notes.append("a Guyan reduction keeps no modes: settling with f_max was not looked at")
    return variants, notes


def scaled_contact(gaps: GapOperator, channels: IntArray, factor: float) -> GapOperator:
    """The same with stiffness and pressure curves of `channels` times a factor; hard ones stay hard."""
    by = np.ones(gaps.m)
    by[channels] = factor
    curves = None if gaps.curves is None else replace(gaps.curves, scale=gaps.curves.scale * by)
    return replace(gaps.with_stiffness(gaps.stiffness * by), curves=curves)


def _scaled(result: StudyResult) -> IntArray:
    """Channels of contact pairs with a finite stiffness or a curve."""
    contacts = set(result.setup.contacts.group)
    mine = np.array([g in contacts for g in result.gaps.group], dtype=bool)
    return np.flatnonzero(mine & np.isfinite(result.gaps.stiffness))


def _base_variant(result: StudyResult) -> Variant:
    c = result.setup.study.config
    return Variant(BASE, "", c.time.step, f_max=None if result.reduced is None else c.reduction.f_max)


def _repeat(result: StudyResult, base: Run, variant: Variant, progress: Progress) -> Outcome:
    """One run; one that cannot be made has no events and says why."""

    def report(stage: str, done: int, total: int) -> None:
        progress(stage if stage.startswith(variant.name) else f"{variant.name}: {stage}", done, total)

    try:
        setup = repeated_setup(result.setup, variant, _substeps(result.setup, base))
        system, reduced = _model(result, variant, setup, report)
        gaps = scaled_contact(result.gaps, _scaled(result), variant.stiffness)
        quiet = replace(setup, watched=np.zeros(0, dtype=np.int64))
        return _outcome(variant, march_run(variant.name, quiet, system, gaps, report, reduced))
    except CreakError as error:
        return Outcome(variant, (), 0.0, 0.0, 0.0, 0, 0.0, 0.0, f"{variant.name} was not run: {error}")


def _model(
    result: StudyResult, variant: Variant, setup: Setup, progress: Progress
) -> tuple[System, ReducedModel | None]:
    """The base run's model, reduced anew where more modes are asked for."""
    if result.reduced is None:
        return result.reference.system, None
    reduced = result.reduced
    if variant.family == "modes" and setup.study.config.time.exact and reduced.superelements:
        reduced = with_more_modes(setup, result.reference, result.gaps, reduced, progress)
    elif variant.family == "modes":
        reduced = reduce_model(setup, result.reference, result.gaps, progress)
    return reduced.system, reduced


def repeated_setup(setup: Setup, variant: Variant, substeps: int) -> Setup:
    """The setup over the same time with another step and f_max, its loads sampled anew; no fields are kept."""
    c, study = setup.study.config, setup.study
    end = float(setup.loads.time[-1])
    tables = {
        "time": c.time.model_copy(update={"step": variant.step, "end": end, "periods": None, "substeps": substeps}),
        "output": c.output.model_copy(update={"interval": c.output.interval or c.time.step, "field_interval": None}),
        "reduction": c.reduction.model_copy(update={"f_max": variant.f_max or c.reduction.f_max}),
    }
    study = replace(study, config=c.model_copy(update=tables))
    loads = sample_loads(setup.model, study, time_axis(study))
    return replace(setup, study=study, refined=variant.refined, loads=loads)


def _substeps(setup: Setup, base: Run) -> int:
    """Parts into which the base run divided a step near contact: shorter steps are divided into as many."""
    table, steps = setup.study.config.time, np.diff(base.history.time)
    if table.exact:
        return table.substeps
    return max(table.substeps, round(table.step / float(steps.min())) if steps.size else 1)


def _outcome(variant: Variant, run: Run) -> Outcome:
    h = run.history
    return Outcome(
        variant,
        tuple(run.events),
        float((h.weights @ h.force).sum()),
        h.energy_created,
        h.energy_dissipated_by_scheme,
        h.time.size - 1,
        float(h.time[-1]),
        run.cost.wall_s,
        run.stopped,
    )


# --- what has settled -----------------------------------------------------------------------------------------------


def _events(
    outcomes: dict[str, Outcome],
    matches: dict[str, EventMatch],
    families: dict[str, tuple[str, str]],
    window: tuple[float, float],
    tolerance: float,
) -> tuple[EventSettling, ...]:
    own = events_in(outcomes[BASE].events, window)
    partners = {name: {id(a): b for a, b in match.pairs} for name, match in matches.items()}
    limits = {name: TIME_SHARE * tolerance if name in TIMES else SETTLED for name in FIGURES}
    found = []
    for event in own:
        same = {BASE: event} | {name: p[id(event)] for name, p in partners.items() if id(event) in p}
        problem = _problem(event, same, outcomes, tolerance)
        figures = {
            name: _settling(name, {run: of(e) for run, e in same.items()}, families, limits[name], problem)
            for name, of in FIGURES.items()
        }
        found.append(EventSettling(event, problem, figures))
    return tuple(found)


def _problem(event: Event, same: dict[str, Event], outcomes: dict[str, Outcome], tolerance: float) -> str:
    """Runs without a partner of the event, and those that ended before it was over."""
    early = [name for name, o in outcomes.items() if o.stopped and o.end < event.t_end + tolerance]
    absent = [name for name in outcomes if name not in same and name not in early]
    said = [f"absent with {', '.join(absent)}"] if absent else []
    said += [f"{', '.join(early)} stopped before"] if early else []
    return "; ".join(said)


def _settling(
    name: str, values: dict[str, float], families: dict[str, tuple[str, str]], limit: float, problem: str = ""
) -> Settling:
    changes = {family: change(name, values.get(a), values.get(b)) for family, (a, b) in families.items()}
    return Settling(name, values, changes, limit, problem)


def _totals(outcomes: dict[str, Outcome], families: dict[str, tuple[str, str]]) -> dict[str, Settling]:
    """Figures of the whole run, of the runs that reached its end."""
    whole = {name: o for name, o in outcomes.items() if not o.stopped}
    columns: dict[str, Callable[[Outcome], float]] = {
        "events": lambda o: float(len(o.events)),
        "impulse": lambda o: o.impulse,
        "force": lambda o: o.force,
    }
    short = ", ".join(name for name in outcomes if name not in whole)
    problem = f"{short} stopped early" if short else ""
    return {
        key: _settling(key, {name: of(o) for name, o in whole.items()}, families, SETTLED, problem)
        for key, of in columns.items()
    }
