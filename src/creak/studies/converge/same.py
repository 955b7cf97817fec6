"""Whether a run with more modes tells the same as the run before it."""

from __future__ import annotations

from collections.abc import Callable

from creak.studies.converge.compared import assess
from creak.studies.converge.settling import BASE, ENOUGH, MORE_MODES, SETTLED, EventSettling, Variant
from creak.studies.converge.variants import outcome_of
from creak.studies.prepare.output_steps import shown_window
from creak.studies.prepare.setup import Setup
from creak.studies.run.integrate import output_times
from creak.studies.run.job import Run
from creak.verify.slips import SlipEvent
from creak.verify.statistics import MANY


def same_with_more_modes(setup: Setup) -> Callable[[Run, Run], bool]:
    """The question of f_max = "auto", for two runs of a setup: does the second, with more modes, tell the same?

    Events that carry 95 % of the impulse have settled in all their figures, as the verdict has it; so have impulse and
    force of the whole run, and number and work of slips; and blows last as long as before, to 5 % in the mean that the
    impulse weighs. Many events may be alike as samples instead.
    """
    v, window = setup.study.config.verification, shown_window(setup.study, output_times(setup))

    def same(run: Run, again: Run) -> bool:
        of = {name: Variant(name, family, 0.0) for name, family in ((BASE, ""), (MORE_MODES, "modes"))}
        outcomes = {BASE: outcome_of(of[BASE], run, ()), MORE_MODES: outcome_of(of[MORE_MODES], again, ())}
        c = assess(outcomes, run.name, window, v.event_tolerance)
        if not all(t.settled for name, t in c.totals.items() if name != "events") or not _slip_alike(run, again):
            return False
        total, held = (sum(e.event.impulse for e in some) for some in (c.events, [e for e in c.events if e.settled]))
        if held >= ENOUGH * total and sum(map(_moved, c.events)) <= SETTLED * total:
            return True
        s = c.statistics["modes"]
        known = [d.alike for d in (s.force, s.impulse) if d is not None]
        return len(c.events) >= MANY and s.rates_alike and all(known)

    return same


def _moved(e: EventSettling) -> float:
    """Change of an event's duration as a share of it, times the impulse."""
    return abs(e.figures["duration"].changes["modes"]) * e.event.impulse / (e.event.t_end - e.event.t_start)


def _slip_alike(run: Run, again: Run) -> bool:
    """Number of slips and the work of friction in all of them, within 5 % or one slip."""

    def figures(slips: tuple[SlipEvent, ...]) -> tuple[int, float]:
        return sum(len(s.slips) for s in slips), sum(s.friction_work for s in slips)

    (n, work), (m, other) = figures(run.slips), figures(again.slips)
    return abs(n - m) <= max(1.0, SETTLED * m) and (max(n, m) <= 1 or abs(work - other) <= SETTLED * abs(other))
