"""Runs compared event by event with the base run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.studies.converge.rubbing import settled_rubs
from creak.studies.converge.settling import (
    BAND,
    BASE,
    CHANCE,
    ENOUGH,
    FINER,
    GOES_ON,
    LAST_TWO,
    OF_CONTACT,
    ROUND_OFF,
    SCATTER,
    SETTLED,
    UNREDUCED,
    WAYS,
    Convergence,
    EventSettling,
    Followed,
    Outcome,
    Settling,
    limit,
)
from creak.verify.events import events_in
from creak.verify.matching import FIGURES, OF_PLACE, TIMES, UNTIL_THE_END, EventMatch, change, match_events
from creak.verify.statistics import MANY, chance, chance_between, compare_statistics
from creak.verify.unreduced import Structure

NOTHING = Followed()
PERTURBED = (*OF_CONTACT, "modes")
"""Families whose runs change the impulses themselves: what becomes of that later shows how sensitive an event is."""
FARTHEST = 10.0
"""Errors of impulses over what a run changes of them, up to which what follows is drawn out in proportion."""
WHOLE_RUN: dict[str, Callable[[Outcome], float]] = {
    "events": lambda o: float(len(o.events)),
    "impulse": lambda o: o.impulse,
    "force": lambda o: o.force,
}
"""Figures of a whole run."""


def assess(
    outcomes: dict[str, Outcome],
    model: str,
    window: tuple[float, float],
    tolerance: float,
    notes: tuple[str, ...] = (),
    structure: Structure | None = None,
    places: Followed = NOTHING,
) -> Convergence:
    """Compare runs, the base run first among them.

    Parameters
    ----------
    tolerance : events that start this close are the same, s. structure : what the unreduced model says.
    places : what is known of those of the base run beside their figures.
    """
    families = {name: pair for name, pair in LAST_TWO.items() if set(pair) <= outcomes.keys()}
    told = tuple(name for name, pair in families.items() if not outcomes[pair[1]].repeat.judged)
    samples = {
        name: compare_statistics(outcomes[a].events, outcomes[b].events, window) for name, (a, b) in families.items()
    }
    matches = {
        name: match_events(outcomes[BASE].events, o.events, tolerance, window)
        for name, o in outcomes.items()
        if name != BASE
    }
    events = _events(outcomes, matches, families, told, window, tolerance)
    chaotic = _parted(events)
    whole, hits = _by_chance(outcomes, places.impulses) if chaotic else (0.0, [])
    by_chance = {"impulse": {CHANCE: whole}} if chaotic else {}
    if structure is not None and structure.counts:
        events = _beside(events, structure)
    new = {name: tuple(match.extra) for name, match in matches.items()}
    of_all = {name: {UNREDUCED: x} for name, x in _of_all(structure).items()}
    return Convergence(
        model=model,
        outcomes=outcomes,
        families=families,
        window=window,
        events=events,
        new=new,
        totals=_totals(
            outcomes, families, told, {name: of_all.get(name, {}) | by_chance.get(name, {}) for name in WHOLE_RUN}
        ),
        statistics=samples,
        exact=FINER in outcomes,
        chaotic=chaotic,
        notes=notes,
        places=_places(outcomes, families, told, of_all, places, hits),
        structure=structure,
        band_ends=places.band_ends,
        rubs=settled_rubs(outcomes, families, told, places.rub_names, hits, structure),
    )


def _by_chance(outcomes: dict[str, Outcome], places: Sequence[Sequence[float]]) -> tuple[float, list[float]]:
    """How far the sum of impulses of a chaotic run may be off, and that of each place, whose impulses are given.

    All of it by what the runs that were made part; a copy, of no steps, is no run. Each place by as much more as a
    compound Poisson process of its hits would be.
    """
    base = outcomes[BASE]
    own = chance([e.impulse for e in base.events])
    runs = [o.events for o in outcomes.values() if o.repeat.judged and not o.stopped and o.steps]
    whole = chance_between(runs, (0.0, base.end)) if len(runs) > 1 else own
    return whole, [whole / own * chance(impulses) for impulses in places] if own else []


def _beside(events: Sequence[EventSettling], structure: Structure) -> tuple[EventSettling, ...]:
    """The events with what the unreduced model makes of them, and what errors of those before pass on to them.

    How sensitive an event is show the runs that change contact or the structure (`PERTURBED`): where they move the
    impulses before by c at most and a figure of the event by the share x, an error e of those impulses moves it by
    e x / c, e being the largest that a spot check found. What is more than `Structure.inherited` is added. A hard blow
    that is off by 1 % may so leave a faint one after it off by a fifth, or take it away; a faint one that is off by a
    half does nothing to a hard one. Where c is below a tenth of e (`FARTHEST`) x is what the run changes by itself, and
    no more than tenfold of it is told. Durations hang on the last of many touches, in those runs as well, and tell
    nothing of this.
    """
    ended = sorted(events, key=lambda e: e.event.t_end)
    ends = np.array([e.event.t_end for e in ended])
    moved = {family: _most_moved(ended, family) for family in PERTURBED}
    found = []
    for e in events:
        count = int(np.searchsorted(ends, e.event.t_start, side="right"))
        before = {family: float(most[count - 1]) for family, most in moved.items()} if count else {}
        found.append(_with_problem(_passed_on(e, before, structure), structure))
    return tuple(found)


def _most_moved(ended: Sequence[EventSettling], family: str) -> FloatArray:
    """(n,) by how much a family changes an impulse at most, of the first 1, 2, ... n events; impulses that its run
    lacks are no measure of what was changed."""
    by = np.array([abs(e.figures["impulse"].changes.get(family, 0.0)) * e.event.impulse for e in ended])
    return np.maximum.accumulate(np.where(np.isfinite(by), by, 0.0))


def _passed_on(e: EventSettling, before: dict[str, float], structure: Structure) -> EventSettling:
    """The event with what the unreduced model makes of it, and with what errors of impulses before do to it.

    Parameters
    ----------
    before : family -> how much it changes an impulse before at most; empty: there is none.
    """
    figures, lasts, error = {}, e.event.t_end - e.event.t_start, structure.impulse_error
    least = max(error / FARTHEST, ROUND_OFF * e.event.impulse)
    for name, f in e.figures.items():
        by, unit = structure.change(name, e.event), lasts if name in TIMES else 1.0
        if before and name != "duration" and not structure.begins_anew(e.event):
            passed = max(
                (error * _moved(f, family, unit) / max(most, least) for family, most in before.items()), default=0.0
            )
            if passed > (known := structure.inherited(e.event)):
                by += (passed - known) * unit
        figures[name] = replace(f, beside={UNREDUCED: by})
    return replace(e, figures=figures)


def _with_problem(e: EventSettling, structure: Structure) -> EventSettling:
    """An event that the unreduced run does not have is told."""
    if not any(e.event is x for x in structure.extra):
        return e
    problem = "; ".join(text for text in (e.problem, "absent in the unreduced run") if text)
    figures = {name: replace(f, problem=problem) for name, f in e.figures.items()}
    return replace(e, problem=problem, figures=figures)


def _moved(f: Settling, family: str, unit: float) -> float:
    """Share by which a family changes a figure; 1 where its run has no such event, 0 where there is no such run."""
    by = f.changes.get(family, 0.0)
    return abs(by) / unit if np.isfinite(by) and unit > 0.0 else 1.0


def _events(
    outcomes: dict[str, Outcome],
    matches: dict[str, EventMatch],
    families: dict[str, tuple[str, str]],
    told: tuple[str, ...],
    window: tuple[float, float],
    tolerance: float,
) -> tuple[EventSettling, ...]:
    own = events_in(outcomes[BASE].events, window)
    partners = {name: {id(a): b for a, b in match.pairs} for name, match in matches.items()}
    found = []
    for event in own:
        same = {BASE: event} | {name: p[id(event)] for name, p in partners.items() if id(event) in p}
        # Runs without a partner of the event, and those that ended before it was over; of those that decide.
        early = [n for n, o in outcomes.items() if o.repeat.judged and o.stopped and o.end < event.t_end + tolerance]
        absent = [n for n, o in outcomes.items() if o.repeat.judged and n not in same and n not in early]
        said = [f"absent with {', '.join(absent)}"] if absent else []
        said += [f"{', '.join(early)} stopped before"] if early else []
        problem = "; ".join(said)
        lasts = max(e.t_end - e.t_start for e in same.values())
        cut = dict.fromkeys(UNTIL_THE_END, GOES_ON) if event.unfinished else {}
        figures = {
            name: _settling(
                name,
                {run: of(e) for run, e in same.items()},
                families,
                told,
                limit(name, lasts, tolerance),
                cut.get(name, problem),
            )
            for name, of in FIGURES.items()
        }
        found.append(EventSettling(event, problem, figures))
    return tuple(found)


def _parted(events: tuple[EventSettling, ...]) -> bool:
    """A good part of many events has no partner in some run, or is another one by the resolution in time alone.

    That changes nothing of the model, and in motion that can be followed next to nothing of the answer.
    """
    judged = [e for e in events if e.judged]
    parted = sum(bool(e.problem) or e.moved_in_time for e in judged)
    return len(judged) >= MANY and parted > (1.0 - ENOUGH) * len(judged)


def _settling(
    name: str,
    values: dict[str, float],
    families: dict[str, tuple[str, str]],
    told: tuple[str, ...],
    limit: float,
    problem: str = "",
    beside: dict[str, float] | None = None,
) -> Settling:
    changes = {family: change(name, values.get(a), values.get(b)) for family, (a, b) in families.items()}
    return Settling(name, values, changes, limit, problem, told, beside or {})


def _totals(
    outcomes: dict[str, Outcome],
    families: dict[str, tuple[str, str]],
    told: tuple[str, ...],
    of_all: dict[str, dict[str, float]],
) -> dict[str, Settling]:
    """Figures of the whole run, of the runs that reached its end."""
    whole = {name: o for name, o in outcomes.items() if not o.stopped}
    short = ", ".join(name for name, o in outcomes.items() if name not in whole and o.repeat.judged)
    problem = f"{short} stopped early" if short else ""
    return {
        key: _settling(
            key, {name: of(o) for name, o in whole.items()}, families, told, SETTLED, problem, of_all.get(key)
        )
        for key, of in WHOLE_RUN.items()
    }


def _of_all(structure: Structure | None) -> dict[str, float]:
    """What the unreduced model changes of figures of many events: shares."""
    if structure is None or not structure.counts:
        return {}
    seen = [s for s in (structure.run or structure.spots) if not s.problem]
    lost = sum(s.unreduced is None for s in seen) + max(structure.missed, len(structure.extra))
    count = len(seen) + (len(structure.extra) if structure.run else 0)
    hardest = max(seen, key=lambda s: s.event.force_place, default=None)
    of_hardest = {} if hardest is None else {name: structure.change(name, hardest.event) for name in FIGURES}
    return {
        "events": lost / max(count, 1),
        "impulse": structure.of_sum("impulse"),
        "force": of_hardest.get("force", float("nan")),
        "closing_speed": of_hardest.get("closing_speed", float("nan")),
    }


def _places(
    outcomes: dict[str, Outcome],
    families: dict[str, tuple[str, str]],
    told: tuple[str, ...],
    of_all: dict[str, dict[str, float]],
    followed: Followed,
    by_chance: Sequence[float],
) -> tuple[dict[str, Settling], ...]:
    """How far each figure of each place has settled, by the runs that reached their end.

    Parameters
    ----------
    by_chance : how far the impulse of each may be off by chance; empty where the motion is not chaotic.
    """
    whole = {name: o for name, o in outcomes.items() if not o.stopped}
    of_sound = {BAND: followed.band, WAYS: followed.ways, SCATTER: followed.scatter}
    out = []
    for k in range(len(outcomes[BASE].places)):
        values = {
            figure: {name: o.places[k][figure] for name, o in whole.items() if figure in o.places[k]}
            for figure in OF_PLACE
        }
        of_n5 = {name: x[k] for name, x in of_sound.items() if k < len(x)}
        beside = {**of_all, "n5": of_n5} if of_n5 else of_all
        if k < len(by_chance):
            beside = {**beside, "impulse": beside.get("impulse", {}) | {CHANCE: by_chance[k]}}
        problem = {f: "" if len(runs) == len(outcomes) else "not known in all runs" for f, runs in values.items()}
        out.append(
            {
                f: _settling(f, known, families, told, SETTLED, problem[f], beside.get(f))
                for f, known in values.items()
                if known
            }
        )
    return tuple(out)
