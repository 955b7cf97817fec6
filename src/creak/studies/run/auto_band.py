"""[reduction] f_max = "auto": the run again with more modes until they change nothing, or cost too much."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from creak.contact.gap_operator import GapOperator
from creak.linalg.memory import OutOfMemory, fits
from creak.linalg.modes import BAND, HALF_AGAIN
from creak.progress import Progress
from creak.studies.models.reduced import DENSE, DIAGONAL_LIMIT, ReducedModel, raised_model, with_more_modes
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.setup import Setup
from creak.words import duration

if TYPE_CHECKING:
    from creak.studies.run.job import Run

BUDGET = 4.0
"""What all stages together may cost over the first one, its reduction and its two runs."""
GROWTH = BAND**2
"""What a stage costs over the one before it: there are more modes, and they are faster."""

March = Callable[[Setup, ReducedModel], "Run"]
Same = Callable[["Run", "Run"], bool]


@dataclass(frozen=True)
class Stage:
    """One model of the stages: what it is, and what its run found."""

    f_max: float
    """Hz, up to which each part has all its modes."""
    modes: int
    events: int
    impulse: float
    """Of all channels over the whole run, force s."""
    wall_s: float
    """What making it and its run took, beyond the stage before."""
    same: bool | None = None
    """Whether the next one, with more modes, finds the same; None: there was no next one to tell."""


@dataclass(frozen=True)
class Settled:
    """Where the stages ended."""

    setup: Setup
    """Raised as often as it took."""
    reduced: ReducedModel
    run: Run
    more: tuple[ReducedModel, Run] | None = None
    """The run with more modes that the last stage was compared with; None: there is none yet, or it has all modes."""
    stages: tuple[Stage, ...] = ()
    """All models that were run; none where f_max was given."""
    why: str = ""
    """Why no further stage was made although more modes change the answer, and what it would cost."""


def settle(
    first: Settled,
    reference: ReferenceModel,
    gaps: GapOperator,
    march: March,
    same: Same,
    progress: Progress,
) -> Settled:
    """Raise f_max by half until the run with more modes finds what the one before it found.

    The run with more modes of one stage is the run of the next: each model is run once. Modes that are known stay.

    Parameters
    ----------
    first : of the first f_max.
    march : makes the run of a model. same : whether two runs tell the same, the second with more modes.
    """
    setup, reduced, run = first.setup, first.reduced, first.run
    stages = [_stage(setup, reduced, run, reduced.wall_s)]
    while not reduced.complete and run.stopped is None:
        before = reduced.wall_s
        try:
            more = with_more_modes(setup, reference, gaps, reduced, progress)
        except OutOfMemory as error:
            return Settled(setup, reduced, run, None, tuple(stages), f"more modes do not fit: {error}")
        more = replace(more, wall_s=before + more.wall_s, cpu_s=reduced.cpu_s + more.cpu_s)
        following = replace(setup, raised=setup.raised + 1)
        again = march(following, more)
        agree = again.stopped is None and same(run, again)
        stages[-1] = replace(stages[-1], same=agree)
        stages.append(_stage(following, more, again, more.wall_s - before))
        why = "" if agree else _too_much(following, more, stages)
        if agree or why or again.stopped is not None:
            return Settled(setup, reduced, run, (more, again), tuple(stages), why)
        try:
            reduced = more if more.complete else raised_model(following, reference, more, progress)
        except OutOfMemory as error:
            why = f"f_max {BAND * following.f_max:,.0f} Hz does not fit: {error}"
            return Settled(setup, reduced, run, (more, again), tuple(stages), why)
        stages[-1] = replace(stages[-1], wall_s=stages[-1].wall_s + reduced.wall_s - more.wall_s)
        setup, run = following, again
    return Settled(setup, reduced, run, None, tuple(stages))


def _stage(setup: Setup, reduced: ReducedModel, run: Run, making: float) -> Stage:
    h = run.history
    impulse = float((h.weights @ h.force).sum())
    return Stage(setup.f_max, reduced.modes, len(run.events), impulse, making + run.cost.wall_s)


def _too_much(setup: Setup, more: ReducedModel, stages: list[Stage]) -> str:
    """Why no further stage is made, and what it would cost; empty: it is."""
    if more.complete:
        return ""
    to = f"f_max {BAND * setup.f_max:,.0f} Hz"
    n = more.system.n + int(HALF_AGAIN * more.modes)
    if n > DIAGONAL_LIMIT or not fits(DENSE * 8.0 * float(n) ** 2):
        return f"{to} would take {n:,} unknowns, more than memory or {DIAGONAL_LIMIT:,}"
    spent, following = sum(s.wall_s for s in stages), GROWTH * stages[-1].wall_s
    if spent + following > BUDGET * (stages[0].wall_s + stages[1].wall_s):
        return f"{to} would take some {duration(following)} more"
    return ""
