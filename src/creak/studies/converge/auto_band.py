"""[reduction] f_max = "auto": modes until neither more of them nor the unreduced model change anything."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from creak.linalg.memory import OutOfMemory, fits
from creak.linalg.modes import BAND, HALF_AGAIN
from creak.progress import Progress, Sentence
from creak.studies.converge.compared import assess
from creak.studies.converge.repeats import outcome_of
from creak.studies.converge.rubbing import FLOOR
from creak.studies.converge.settled import is_faint
from creak.studies.converge.settling import (
    BASE,
    ENOUGH,
    MORE_MODES,
    SETTLED,
    UNREDUCED,
    Convergence,
    EventSettling,
    Repeat,
    Settling,
    is_moved,
)
from creak.studies.file.config import VerificationTable
from creak.studies.models.reduced import (
    BLOCKED,
    DENSE,
    DIAGONAL_LIMIT,
    ReducedModel,
    Stage,
    raised_model,
    with_more_modes,
)
from creak.studies.models.reference import ReferenceModel
from creak.studies.models.saved import NO_STORE, Store
from creak.studies.prepare.reduction import Reduction
from creak.studies.run.job import March, ReducedRun
from creak.studies.run.one_run import Run
from creak.verify.events import Event
from creak.verify.rubbing import pressing
from creak.verify.slips import SlipEvent
from creak.verify.statistics import MANY
from creak.verify.unreduced import Structure
from creak.words import duration

BUDGET = 4.0
"""What all stages together may cost over the first one, its reduction and its two runs."""
PATIENCE = 40.0
"""s that all stages together may take in any case. Both are reckoned from counts (`_reckoned`), not from a clock: the
same study ends at the same f_max, however busy the machine is."""
SOLVE_S, DIAGONAL_S, INSTANT_S, PRODUCT_S, RUB_S, STEP_S = 1.4e-7, 5e-10, 5e-6, 1e-9, 1.5e-6, 3e-4
"""s for a dof of a back-substitution, for a cube of the dense eigenproblem, for a kept instant, for a mode of a channel
in it, for a channel that may rub in one with contact, and for what a contact step of the unreduced model takes beside
its solution: one core (door at 40 mm; strips that lie on each other)."""
SMALL = 10.0
"""s (`_reckoned`) that all modes of a small model may take."""
WORTH = 1.0
"""Times what the stages have taken, that all modes may take from then on."""
SOLUTIONS, SHORTER = 10.0, 4.0
"""Eigenproblems until all modes are there, and times as many instants with them."""
ROOM = 0.4
"""Of what a figure may be moved by that is for the modes (`settling.REST`): the rest is for the other sources."""
PROOF = 0.35
"""Of the same, that is for the unreduced model."""
GROWTH = BAND**2
"""What a stage costs over the one before it: there are more modes, and they are faster."""


Prove = Callable[[ReducedRun, ReferenceModel, Progress], Structure]


def settle(
    first: ReducedRun,
    reference: ReferenceModel,
    march: March,
    progress: Progress,
    *,
    prove: Prove | None = None,
    store: Store = NO_STORE,
    least: int = 0,
) -> ReducedRun:
    """Raise f_max by half until the run with more modes, and the unreduced model, find what the run found.

    Modes that change nothing at all are no answer before some have changed something: nothing excites them.

    The run with more modes of one stage is the run of the next: each model is run once. Modes that are known stay. The
    unreduced model is asked where more modes change nothing any more: it knows of all that are left out. Of a model
    that is small (`SMALL`) all modes are taken at once: nothing is left out then. So they are once the stages have
    taken as long as all modes would.

    Parameters
    ----------
    first : of the first f_max.
    march : makes the run of a model.
    prove : lets the unreduced model march through events of a run; None: it is not asked. Nor is it where the study
        thins interfaces: what these lack no mode brings back.
    store : as `reduce_model`.
    least : stages that are known not to be enough.
    """
    v, at = first.scope.verification, first
    prove = None if first.reduced.thinned else prove
    stages = [_stage(first.reduction.band.f_max, first.reduced, first.run, first.reduced.wall_s)]
    reckoned, moved, tried = [_reckoned(reference, first.reduced, first.run)], False, False
    while not at.reduced.every_mode and at.run.stopped is None:
        spent = sum(reckoned) if len(stages) > 1 else 0.0
        if not tried and _of_all_modes(reference, at.run) <= max(SMALL, WORTH * spent):
            tried, before = True, at
            at = _with_all_modes(at, reference, march, progress, store)
            if at is not before:
                same = at.run.stopped is None and tell_the_same(v, at.scope.window, before.run, at.run)
                making = at.reduced.wall_s - before.reduced.wall_s
                last = _stage(at.reduction.band.f_max, at.reduced, at.run, making)
                stages[-1:] = [replace(stages[-1], same=same), last]
                continue
        try:
            more = _more_modes(at.reduction, reference, at, at.reduced, progress, store)
        except OutOfMemory as error:
            return replace(at, stages=tuple(stages), why=f"more modes do not fit: {error}")
        following = _raised(at.reduction)
        f_max = following.band.f_max
        upto = "all modes that there are" if more.every_mode else f"modes up to {f_max:,.0f} Hz"
        said = f'f_max = "auto", stage {len(stages) + 1}: the run again with {upto}, until more change nothing'
        progress(Sentence(said), 1, 1)
        again = march(more)
        agree = again.stopped is None and tell_the_same(v, at.scope.window, at.run, again)
        stage = _stage(f_max, more, again, more.wall_s - at.reduced.wall_s)
        moved = moved or more.every_mode or is_moved(stages[-1].impulse, stage.impulse)
        structure = None
        if agree and moved and prove is not None and len(stages) > least:
            structure = prove(at, reference, progress)
            reckoned[-1] += structure.solves * (SOLVE_S * reference.free_dof + STEP_S)
        proven = None
        if structure is not None and structure.counts:
            proven = is_proven(_compared(v, at.scope.window, at.run, again, structure))
        stages[-1:] = [replace(stages[-1], same=agree, proven=proven), stage]
        reckoned.append(_reckoned(reference, more, again, at.reduced))
        takes = GROWTH * _reckoned(reference, more, again, at.reduced, BLOCKED)
        enough = agree and moved and proven is not False and len(stages) > least
        why = "" if enough else _too_much(f_max, more, reckoned, takes)
        if not (enough or why) and again.stopped is None:
            try:
                reduced = more
                if not more.every_mode:
                    reduced = raised_model(following, reference, at.gaps, more, progress, store)
            except OutOfMemory as error:
                why = f"f_max {BAND * f_max:,.0f} Hz does not fit: {error}"
        if enough or why or again.stopped is not None:
            return replace(at, more=(more, again), stages=tuple(stages), why=why, structure=structure)
        stages[-1] = replace(stages[-1], wall_s=stages[-1].wall_s + reduced.wall_s - more.wall_s)
        at = replace(at, reduction=following, reduced=reduced, run=again)
    return replace(at, stages=tuple(stages))


def _of_all_modes(reference: ReferenceModel, run: Run) -> float:
    """s that all modes take, and the run with them, which has shorter steps near contact where that does not rub."""
    modes = SOLUTIONS * DIAGONAL_S * float(reference.free_dof) ** 3
    return modes + SHORTER * _flown(run, reference.free_dof) + _rubbed(run)


def _with_all_modes(
    first: ReducedRun, reference: ReferenceModel, march: March, progress: Progress, store: Store
) -> ReducedRun:
    """The run with all modes, f_max raised past the highest of them; the first one where they cannot be had."""
    how, reduced = first.reduction, first.reduced
    while not reduced.every_mode:
        more = _more_modes(how, reference, first, reduced, progress, store)
        if more.modes == reduced.modes and not more.every_mode:
            return first
        how = _raised(how)
        reduced = more if more.every_mode else raised_model(how, reference, first.gaps, more, progress, store)
    return first if reduced is first.reduced else replace(first, reduction=how, reduced=reduced, run=march(reduced))


def _raised(reduction: Reduction) -> Reduction:
    """With f_max half as high again."""
    return replace(reduction, band=reduction.band.raised_to(reduction.band.raised + 1))


def _more_modes(
    reduction: Reduction,
    reference: ReferenceModel,
    run: ReducedRun,
    reduced: ReducedModel,
    progress: Progress,
    store: Store,
) -> ReducedModel:
    """A model of the run's channels with its further modes; its times hold those of the model itself."""
    more = with_more_modes(reduction, reference, run.gaps, reduced, progress, store.folder)
    return replace(more, wall_s=reduced.wall_s + more.wall_s, cpu_s=reduced.cpu_s + more.cpu_s)


def _stage(f_max: float, reduced: ReducedModel, run: Run, making: float) -> Stage:
    h = run.history
    impulse = float((h.weights @ h.force).sum())
    return Stage(f_max, reduced.modes, len(run.events), impulse, making + run.cost.wall_s)


def _reckoned(
    reference: ReferenceModel, reduced: ReducedModel, run: Run, known: ReducedModel | None = None, share: float = 1.0
) -> float:
    """s that a stage takes by its counts: back-substitutions, the eigenproblem of what is coupled, instants of the run.

    Parameters
    ----------
    known : the model whose modes were there before; None: it is the first one.
    share : what a back-substitution takes of one by itself: all of it in the budgets, `BLOCKED` by the clock.
    """
    solves = share * (reduced.solves - (0 if known is None else known.solves))
    n = float(reduced.system.n)
    return SOLVE_S * solves * reference.free_dof + DIAGONAL_S * n**3 + _flown(run, n) + _rubbed(run)


def _flown(run: Run, n: float) -> float:
    """s that the run of n modes takes for its motion and its contact."""
    return run.history.time.size * (INSTANT_S + PRODUCT_S * n * run.history.gap.shape[1])


def _rubbed(run: Run) -> float:
    """s that it takes for friction."""
    return RUB_S * run.history.contact_steps * run.gaps.rubbing


def _too_much(f_max: float, more: ReducedModel, reckoned: list[float], takes: float) -> str:
    """Why no further stage is made, and the seconds that it would take; empty: it is."""
    if more.every_mode:
        return ""
    to = f"f_max {BAND * f_max:,.0f} Hz"
    n = more.system.n + int(HALF_AGAIN * more.modes)
    if n > DIAGONAL_LIMIT or not fits(DENSE * 8.0 * float(n) ** 2):
        return f"{to} would take {n:,} unknowns, more than memory or {DIAGONAL_LIMIT:,}"
    if sum(reckoned) + GROWTH * reckoned[-1] > max(BUDGET * (reckoned[0] + reckoned[1]), PATIENCE):
        return f"{to} would take some {duration(takes)} more"
    return ""


def tell_the_same(v: VerificationTable, window: tuple[float, float], run: Run, again: Run) -> bool:
    """The question of f_max = "auto", for two runs of a study: does the second, with more modes, tell the same?

    Events that carry 95 % of the impulse, and 95 % of all events but faint ones, move by a part (`ROOM`) of what the
    verdict lets all sources together move their figures by; so do impulse and force of the whole run, and the force of
    contact that lasts. Number and work of slips are the same; and blows last as long as before, to 5 % in the mean that
    the impulse weighs. Many events of which more than 5 % have no partner may be alike as samples instead.

    Parameters
    ----------
    window : of the runs that is told, s.
    """
    c = _compared(v, window, run, again)
    if not all(_fits(t) for name, t in c.totals.items() if name != "events") or not _slip_alike(run, again):
        return False
    if not _press_alike(run, again, window, v.f_max):
        return False
    still = [not e.problem and all(map(_fits, e.figures.values())) for e in c.judged]
    total = sum(e.event.impulse for e in c.judged)
    if _enough([e.event for e in c.judged], still) and sum(map(_moved, c.judged)) <= SETTLED * total:
        return True
    if sum(bool(e.problem) for e in c.judged) <= (1.0 - ENOUGH) * len(c.judged):
        return False  # single events can be followed, and more modes will tell them
    s = c.statistics["modes"]
    known = [d.alike for d in (s.force, s.impulse) if d is not None]
    return len(c.events) >= MANY and s.rates_alike and all(known)


def _compared(
    v: VerificationTable, window: tuple[float, float], run: Run, again: Run, structure: Structure | None = None
) -> Convergence:
    """A run beside that with more modes and, where it was asked, the unreduced model."""
    of = {name: Repeat(name, family, 0.0) for name, family in ((BASE, ""), (MORE_MODES, "modes"))}
    outcomes = {BASE: outcome_of(of[BASE], run, ()), MORE_MODES: outcome_of(of[MORE_MODES], again, ())}
    return assess(outcomes, run.name, window, v.event_tolerance, structure=structure)


def is_proven(c: Convergence) -> bool:
    """Does the unreduced model change little (`PROOF`) in the events that carry 95 % of the impulse, and in 95 % of all
    but faint ones? What errors of events before pass on is part of it, as the verdict has it."""
    still = [all(f.beside[UNREDUCED] <= PROOF * f.limit for f in e.figures.values()) for e in c.judged]
    return _enough([e.event for e in c.judged], still)


def _enough(events: Sequence[Event], still: Sequence[bool]) -> bool:
    """Do those that stay carry 95 % of the impulse, and are they as many as the verdict asks for?"""
    moving = [e for e, stays in zip(events, still, strict=True) if not stays]
    total, gone = (sum(e.impulse for e in some) for some in (events, moving))
    few = len(moving) <= (1.0 - ENOUGH) * len(events)
    return gone <= (1.0 - ENOUGH) * total and (few or is_faint(moving, events))


def _fits(figure: Settling) -> bool:
    return not figure.problem and figure.settled_to <= ROOM * figure.limit


def _moved(e: EventSettling) -> float:
    """Change of an event's duration as a share of it, times the impulse."""
    return abs(e.figures["duration"].changes["modes"]) * e.event.impulse / (e.event.t_end - e.event.t_start)


def _press_alike(run: Run, again: Run, window: tuple[float, float], f_max: float) -> bool:
    """Mean and fluctuation of the force of contact that lasts for the whole window, all channels together."""
    every = np.arange(run.history.force.shape[1])
    one, other = (pressing(r.history, every, window, f_max) for r in (run, again))
    if one is None or other is None:
        return one is other
    most = ROOM * SETTLED * np.array([other.mean, max(other.rms, FLOOR * other.mean)])
    return bool((np.abs([one.mean - other.mean, one.rms - other.rms]) <= most).all())


def _slip_alike(run: Run, again: Run) -> bool:
    """Number of slips and the work of friction in all of them, within 5 % or one slip."""

    def figures(slips: tuple[SlipEvent, ...]) -> tuple[int, float]:
        return sum(len(s.slips) for s in slips), sum(s.friction_work for s in slips)

    (n, work), (m, other) = figures(run.slips), figures(again.slips)
    return abs(n - m) <= max(1.0, SETTLED * m) and (max(n, m) <= 1 or abs(work - other) <= SETTLED * abs(other))
