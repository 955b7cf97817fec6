"""How far an answer can be trusted, in one word and the reasons for it; how far each event has settled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from creak.studies.converge.rubbing import faint_rubs, open_rubs, rub_words
from creak.studies.converge.settling import BASE, CHANCE, ENOUGH, UNREDUCED, Convergence, EventSettling, Settling
from creak.studies.converge.words import remedy_of
from creak.studies.file.case import Course
from creak.studies.run.one_run import Run
from creak.studies.run.steady import faded_in, may_still_close
from creak.verify.events import Event
from creak.verify.matching import FIGURES, OF_PLACE, TIMES
from creak.verify.reliability import UNRELIABLE, reasons_against
from creak.verify.rubbing import FIGURES as OF_RUB
from creak.verify.statistics import MANY, EventStatistics, is_crowded, rate_interval
from creak.words import percent

SETTLED, STATISTICS, UNSETTLED = "settled", "statistics", "unsettled"
UNCHECKED = "not checked: it was not repeated with other settings of the run"
"""Reason of a run that nothing judged."""
FAINT = 0.1
"""Force of the place over that of the hardest event, up to which an event that has not settled may be let be."""
KEYS = {
    "start": "t_start",
    "duration": "duration",
    "impulse": "impulse",
    "force": "force",
    "closing_speed": "closing_speed",
}
"""Figure -> key of `settled_to` in summary.json."""


@dataclass(frozen=True)
class Verdict:
    """Of one run."""

    word: str
    """settled, statistics (single events are not, rates and distributions hold), unsettled, unreliable."""
    reasons: tuple[str, ...]
    """Sentences; none where all is well."""


def verdict_of(
    run: Run, course: Course, unanswered: str | None, convergence: Convergence | None, unit: str, ended: str = ""
) -> Verdict | None:
    """What the energy balance and the repeated runs say of a run; None where it was not repeated.

    A run whose answer could not have been another one has not settled, however exact it is.

    Parameters
    ----------
    unanswered : why it says nothing of rattle. unit : of length. ended : why f_max = "auto" went no further.
    """
    table = course.time
    against = reasons_against(run.history, forced=not table.exact, unit=unit)
    if against:
        return Verdict(UNRELIABLE, tuple(against))
    if unanswered:
        return Verdict(UNSETTLED, (unanswered,))
    if not table.exact and run.gaps.presses and (convergence is None or convergence.model != run.name):
        return Verdict(
            UNSETTLED,
            (
                "a scheme and its step were forced, and what they change was not looked at: leave "
                "them out of [time], or run with --converge",
            ),
        )
    if why := faded_in(run.history, course.fade):
        return Verdict(UNSETTLED, (why,))
    if table.exact and (why := may_still_close(run.history, run.gaps, course.repeats, unit)):
        return Verdict(UNSETTLED, (why,))
    if table.exact and not run.gaps.presses:
        return Verdict(SETTLED, ())
    if convergence is None or convergence.model != run.name:
        return None
    verdict = verdict_of_runs(convergence)
    if verdict.word != SETTLED and ended:
        return Verdict(verdict.word, (*verdict.reasons, f'f_max = "auto" ended here: {ended}'))
    return verdict


def verdict_of_runs(c: Convergence) -> Verdict:
    """What the repeated runs say: of the events, of friction and of lasting contact."""
    return _with_friction(_of_convergence(c), c)


def _with_friction(verdict: Verdict, c: Convergence) -> Verdict:
    """The worse of two verdicts, that of the events and that of friction and lasting contact."""
    found = open_rubs(c)
    if found and faint_rubs(found, c):
        return Verdict(verdict.word, (*verdict.reasons, *map(rub_words, found)))
    chaos = [r for r in found if c.chaotic and not r.lasting]  # hits that part rub differently
    parted = [r for r in c.rubs if r.parted and r.settled]
    if not found and not parted:
        return verdict
    word = UNSETTLED if len(found) > len(chaos) or verdict.word == UNSETTLED else STATISTICS
    said = [rub_words(r) for r in found]
    said += [f"{rub_words(r)}: use their rate, share and energy" for r in parted]
    causes = [cause for r in found for cause in r.causes]
    return Verdict(word, tuple(dict.fromkeys((*verdict.reasons, *said, *_remedy(causes, c)))))


def _remedy(causes: list[str], c: Convergence) -> list[str]:
    """What moves most, and what it takes."""
    if not causes:
        return []
    what, remedy = remedy_of(_most(causes), c)
    return [f"most of it comes from {what}: what settles it is {remedy}"]


def _most(causes: list[str]) -> str:
    return max(dict.fromkeys(causes), key=causes.count)


def lacks_modes(c: Convergence) -> bool:
    """Have single events not settled, most of them for want of modes that there are?"""
    open_ones = [e for e in c.judged if not e.settled]
    causes = _causes(open_ones, _open_totals(c))
    unsettled = _of_convergence(c).word == UNSETTLED
    return unsettled and not c.complete and bool(causes) and _most(causes) in ("modes", UNREDUCED)


def _open_totals(c: Convergence) -> list[Settling]:
    """Figures of the whole run that have not settled; events are counted one by one."""
    return [t for name, t in c.totals.items() if name != "events" and not t.settled]


def is_chaotic(convergence: Convergence | None, count: int, length: float, highest: float) -> bool:
    """Do single events part in two exact solutions? As the repeated runs tell; without any, where there are very many.

    Parameters
    ----------
    count, length : events in a window, and its length, s. highest : of the excitation, Hz; 0: not known.
    """
    if convergence is not None and convergence.families:
        return convergence.chaotic
    return is_crowded(count, length, highest)


def _of_convergence(c: Convergence) -> Verdict:
    if not c.families:
        return Verdict(UNSETTLED, c.notes)
    unproven = _unproven(c)
    if unproven:
        return Verdict(UNSETTLED, (unproven, *_of_repeats(c).reasons))
    return _of_repeats(c)


def _unproven(c: Convergence) -> str:
    """Why a reduced run was not held against the unreduced model, in a sentence.

    Empty: it was, it has no events, or it has all modes that there are, and is the unreduced model.
    """
    if c.structure is None or c.structure.looked or not c.events or c.complete:
        return ""
    return f"not one event was held against the unreduced model: {c.structure.why_not}"


def _of_repeats(c: Convergence) -> Verdict:
    open_ones, going_on = [e for e in c.judged if not e.settled], _going_on(c)
    whole = _open_totals(c)
    if c.unlooked:
        return Verdict(UNSETTLED, c.unlooked)
    judged = (found for name, found in c.new.items() if c.outcomes[name].repeat.judged)
    new = max((len(found) for found in judged if found and not are_faint(found, c)), default=0)
    new = new if c.structure is None else max(new, c.structure.missed)
    few = (1.0 - ENOUGH) * len(c.judged)
    if not whole and new <= few and (len(open_ones) <= few or are_faint([e.event for e in open_ones], c)):
        return Verdict(SETTLED, (*_exceptions(open_ones, c), *going_on))
    reasons = (*_reasons(c, open_ones, whole, new), *going_on)
    if _statistics_hold(c, whole):
        return Verdict(
            STATISTICS,
            (
                "single events differ from run to run, their rate and the distributions of their forces and impulses "
                "do not: use those",
                _rate(c),
                *reasons,
            ),
        )
    return Verdict(UNSETTLED, reasons)


def _statistics_hold(c: Convergence, whole: list[Settling]) -> bool:
    """Whether many events are alike as samples in all runs that decide: of chaotic motion, or with settled totals."""
    judged = [s for family, s in c.statistics.items() if c.outcomes[c.families[family][1]].repeat.judged]
    if c.structure is not None and c.structure.samples is not None:
        judged.append(c.structure.samples)
    alike = bool(judged) and all(_alike(s) for s in judged)
    return alike and (c.chaotic or (not whole and len(c.events) >= MANY))


def are_faint(events: Sequence[Event], c: Convergence) -> bool:
    """Whether events decide nothing: each is far below the hardest one, or what presses for good, and together they
    carry next to nothing.

    A tap of a hundredth of the hardest hit moves by its own 5 % where the motion moves by next to nothing.
    """
    force, impulse = _shares(events, c)
    return force <= FAINT and impulse <= 1.0 - ENOUGH


def is_faint(some: Sequence[Event], events: Sequence[Event]) -> bool:
    """The same of events by themselves."""
    force, impulse = _over(some, max(e.force_place for e in events), sum(e.impulse for e in events))
    return force <= FAINT and impulse <= 1.0 - ENOUGH


def _shares(events: Sequence[Event], c: Convergence) -> tuple[float, float]:
    """Force of the place of the hardest of them over the largest of the run, and their part of the impulse."""
    base = c.outcomes[BASE]
    every = sum(e.event.impulse for e in c.events)
    return _over(events, base.force, max(every, base.impulse))


def _over(some: Sequence[Event], hardest: float, all_of_it: float) -> tuple[float, float]:
    force, impulse = max(e.force_place for e in some), sum(e.impulse for e in some)
    return force / hardest if hardest else 0.0, impulse / all_of_it if all_of_it else 0.0


def _going_on(c: Convergence) -> tuple[str, ...]:
    """The events that have not ended when the run does, in a sentence."""
    found = [e.event for e in c.events if not e.judged]
    if not found:
        return ()
    one = f"the event at {found[0].t_start:.4f} s goes on when the run ends and is"
    many = f"{len(found)} events go on when the run ends and are"
    return (f"{one if len(found) == 1 else many} left out: duration and impulse are only those up to there",)


def _exceptions(open_ones: list[EventSettling], c: Convergence) -> tuple[str, ...]:
    """The few events that have not settled, in a sentence: the hardest of them is told."""
    if not open_ones:
        return ()
    hardest = max(open_ones, key=lambda e: e.event.force_place)
    said = f"event at {hardest.event.t_start:.4f} s: {_open(hardest)}"
    if len(open_ones) == 1:
        return (said,)
    faint = ""
    events = [e.event for e in open_ones]
    if are_faint(events, c):
        force, impulse = _shares(events, c)
        faint = f" (none above {percent(force)} of the largest force, {percent(impulse)} of the impulse)"
    return (f"{len(open_ones)} of {len(c.judged)} events have not{faint}, the hardest of them the {said}",)


def _reasons(c: Convergence, open_ones: list[EventSettling], whole: list[Settling], new: int) -> tuple[str, ...]:
    said = []
    if open_ones:
        counts = {name: sum(not e.figures[name].settled for e in c.judged) for name in FIGURES}
        counts["two or one"] = sum(e.torn for e in c.judged)
        parts = ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in counts.items() if n)
        said.append(f"{len(open_ones)} of {len(c.judged)} events have not settled ({parts})")
    if new:
        said.append(f"up to {'1 event comes and goes' if new == 1 else f'{new} events come and go'} from run to run")
    said += [
        f"the {t.name} of the whole run {'may be off' if CHANCE in t.beside else 'changes'} by up to "
        f"{percent(t.settled_to)}"
        if np.isfinite(t.settled_to)
        else f"the {t.name} of the whole run is not known in all runs{f': {t.problem}' if t.problem else ''}"
        for t in whole
    ]
    return (*said, *_remedy(_causes(open_ones, whole), c))


def _causes(open_ones: list[EventSettling], whole: list[Settling]) -> list[str]:
    """What moves each figure most that has not settled."""
    causes = [f.worst for e in open_ones for f in e.figures.values() if not f.settled or (e.torn and f.name == "start")]
    return [cause for cause in (*causes, *(t.worst for t in whole)) if cause]


def _open(e: EventSettling) -> str:
    if e.torn:
        return "whether it is two, or one with the next: contact is lost for as long as decides"
    return e.problem or ", ".join(
        f"{name.replace('_', ' ')} to {1e3 * f.settled_to:.2g} ms"
        if name in TIMES
        else f"{name.replace('_', ' ')} to {_percent(f.settled_to)} %"
        for name, f in e.figures.items()
        if not f.settled
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g}" if abs(share) < 0.995 else f"{100.0 * share:.0f}"


def _alike(s: EventStatistics) -> bool:
    known = [d.alike for d in (s.force, s.impulse) if d is not None]
    return bool(s.rates_alike and all(known))


def _rate(c: Convergence) -> str:
    length = c.window[1] - c.window[0]
    low, high = rate_interval(len(c.events), length)
    over = "the window" if c.window[0] > 0.0 else "the whole run"
    return f"{len(c.events) / length:.3g} events per second over {over} (95 % confidence: {low:.3g} to {high:.3g})"


def settled_to(e: EventSettling) -> dict[str, float | None]:
    """Largest change of each figure of an event over all repeated runs: s for times, shares else; None: not known."""
    if e.problem:
        return dict.fromkeys(KEYS.values())
    return {key: _known(e.figures[name].settled_to) for name, key in KEYS.items()}


def place_settled_to(c: Convergence | None, number: int) -> dict[str, float | None]:
    """The same of each figure of a place, by its number in the ranking: shares; None: not known."""
    figures = c.places[number - 1] if c is not None and number <= len(c.places) else {}
    rub = next((r.figures for r in c.rubs if r.number == number), {}) if c is not None else {}
    every = figures | rub
    return {name: _known(every[name].settled_to) if name in every else None for name in (*OF_PLACE, *OF_RUB)}


def _known(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None
