"""Words made of numbers for the thesis page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from creak.report_tools import NONE, fixed, number, percent
from creak_thesis.plan import LOADS, RATTLING
from creak_thesis.report.blocks import Block, absent
from creak_thesis.report.facts import Agreement, Facts, flange_events

FOUND = 0.9
"""Share of the events that must be found for the prediction in time to hold."""
CLOSE = 0.02
"""Difference of NRMSE fits that counts as none."""


def listed(items: Iterable[str]) -> str:
    """`a, b and c`."""
    words = list(items)
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}" if words else "none"


def seconds(value: float | None) -> str:
    """CPU seconds with three digits."""
    return NONE if value is None else number(value, 3)


def against_reference(value: float | None, reference: float | None) -> str:
    """Cost as a share of the reference's."""
    if value is None or not reference:
        return NONE
    return f"{number(value / reference, 3)}"


def fit(value: float | None) -> str:
    return fixed(value, 4)


def bias(agreement: Agreement | None) -> str:
    """Mean force of the common events against the reference."""
    return NONE if agreement is None else percent(agreement.force_ratio)


def by_load(values: Mapping[str, str]) -> str:
    """`+2.0 % (A2), +1.0 % (A3)`."""
    return listed(f"{v} ({load})" for load, v in values.items())


def biases(facts: Facts, name: str) -> str:
    """Mean force of a case against its reference, load by load."""
    return by_load({load: bias(a) for load, a in facts.agreements(name).items()})


def counted(agreement: Agreement) -> str:
    """`7 of 8 events found, 1 missed, none extra`."""
    missed, extra = agreement.missed or "none", agreement.extra or "none"
    return f"{len(agreement.common)} of {agreement.reference} events found, {missed} missed, {extra} extra"


def events_words(facts: Facts, name: str) -> str:
    """Events of a case under each load with contact."""
    found = facts.agreements(name)
    if not found:
        return f"{name}: {facts.why_not(name) or 'no run with contact'}"
    return "; ".join(f"{load}: {counted(a)}" for load, a in found.items())


def captured(facts: Facts, name: str) -> tuple[int, int, int]:
    """Events of the reference, those found, and the extra ones, over the loads with contact."""
    found = facts.agreements(name).values()
    return sum(a.reference for a in found), sum(len(a.common) for a in found), sum(a.extra for a in found)


def predicts(facts: Facts, name: str) -> bool | None:
    """Whether a case finds at least `FOUND` of the events and adds few; None without events to compare."""
    reference, common, extra = captured(facts, name)
    if not reference:
        return None
    return common >= FOUND * reference and extra <= (1.0 - FOUND) * reference + 1.0


def fits(facts: Facts) -> str:
    """Fit of D8 under each load."""
    values = {load: facts.fit("D8", load) for load in LOADS}
    return by_load({load: fit(v) for load, v in values.items() if v is not None})


def worst_fit_change(facts: Facts, names: Sequence[str]) -> float | None:
    """Largest difference of the fits of some cases from those of D8, over all loads."""
    found = [
        abs(a - b)
        for n in names
        for load in LOADS
        if (a := facts.fit(n, load)) is not None and (b := facts.fit("D8", load)) is not None
    ]
    return max(found, default=None)


def not_run(facts: Facts, names: Sequence[str]) -> list[Block]:
    """A line for cases that have no outcome."""
    missing = facts.missing(names)
    return [absent(f"Without a result: {'; '.join(missing)}.")] if missing else []


def same_events(facts: Facts, name: str) -> bool | None:
    """Whether a case finds the same number of common, missed and extra events as D8 under every load."""
    mine, theirs = facts.agreements(name), facts.agreements("D8")
    if mine.keys() != theirs.keys() or not mine:
        return None
    return all(
        (len(mine[k].common), mine[k].missed, mine[k].extra)
        == (len(theirs[k].common), theirs[k].missed, theirs[k].extra)
        for k in mine
    )


def event_rates(facts: Facts, name: str) -> dict[str, int | None]:
    """Contact events in the last second, by load."""
    runs = {load: facts.load(name, load) for load in ("A1", *RATTLING)}
    return {load: None if run is None else len(flange_events(run)) for load, run in runs.items()}
