"""Tables of a convergence study, for the report and the terminal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.model.units import Units
from creak.report.tables.run import Table
from creak.report.words.text import NONE, fixed, number, percent, share, tidy
from creak.studies.converge.settling import (
    BASE,
    GOES_ON,
    OF_DURATION,
    SETTLED,
    Convergence,
    EventSettling,
    Outcome,
    Settling,
)
from creak.studies.converge.words import TOTALS, WORDS
from creak.verify.matching import FIGURES, TIMES
from creak.words import listed

MOST_EVENTS = 400
"""Lines of the event table; convergence.csv holds all events with the values of every run."""
ON_TERMINAL = 30
"""Lines of the event table on the terminal."""


@dataclass(frozen=True)
class ConvergenceParts:
    """What the report's section shows."""

    findings: list[str]
    runs: Table
    totals: Table
    events: Table
    marks: list[list[str]]
    """Style of each cell of `events`: settled, open or nothing."""
    procedure: str


def convergence_parts(c: Convergence, findings: list[str], units: Units) -> ConvergenceParts:
    """Tables and words of the section.

    Parameters
    ----------
    findings : sentences, from `creak.studies.converge.words.findings`.
    """
    shown = c.events[:MOST_EVENTS]
    return ConvergenceParts(
        findings, run_table(c, units), total_table(c), event_table(c, units), [_marks(e) for e in shown], procedure(c)
    )


def procedure(c: Convergence) -> str:
    """What was repeated with what, and when a figure has settled, in sentences: of the runs that were made."""
    made = [
        f"{_difference(o, c.outcomes[BASE])} ({name})" for name, o in c.outcomes.items() if name != BASE and o.steps
    ]
    if not made:
        return "The run was not repeated."
    said = [f"The run was repeated {listed(made)}."]
    deciding: list[str] = []
    others: list[str] = []
    for a, b in c.families.values():
        (deciding if c.outcomes[b].repeat.judged else others).append(f"from {a} to {b}")
    if deciding:
        apart = c.finest in c.outcomes and (BASE, c.finest) not in c.families.values()
        less = f", and {c.finest} differs from the base run by no more" if apart else ""
        said.append(f"A figure has settled when none of the changes {listed(deciding)} is larger than this{less}:")
        said.append(f"{_limits()}.")
    if others:
        said.append(f"What changes {listed(others)} is told and decides nothing.")
    return " ".join([*said, '"Settled to" is the largest of all these changes.' if c.families else ""]).strip()


def _difference(outcome: Outcome, of: Outcome) -> str:
    """What a repeated run took differently."""
    v, base, said = outcome.repeat, of.repeat, list[str]()
    if v.refined != base.refined:
        said.append(f"contact resolved {tidy(v.refined / base.refined)} times as finely in time")
    elif v.step != base.step:
        said.append(f"steps of {tidy(1e3 * v.step)} ms for {tidy(1e3 * base.step)} ms")
    if v.stiffness != base.stiffness:
        said.append(f"{tidy(v.stiffness / base.stiffness)} times the contact stiffness")
    if v.harder != base.harder:
        said.append(f"{tidy(v.harder / base.harder)} times the spring that stands for hard contact")
    if v.family == "modes":
        said.append(f"{number(outcome.modes)} modes for {number(of.modes)}")
    return f"with {' and '.join(said) or 'the same settings'}"


def run_table(c: Convergence, units: Units) -> Table:
    """What each run took differently, and the figures of the whole run."""
    head = [
        "run",
        "step, ms",
        "contact stiffness",
        "modes",
        "events",
        f"total impulse, {units.impulse}",
        f"largest force, low-passed, {units.force}",
        "energy created",
        "dissipated by the scheme",
        "wall time, s",
        "ended",
    ]
    rows = []
    for name, o in c.outcomes.items():
        v = o.repeat
        rows.append(
            [
                name,
                tidy(1e3 * v.step),
                f"x {tidy(v.stiffness * v.harder)}",
                NONE if v.f_max is None else number(o.modes),
                number(len(o.events)),
                number(o.impulse, 4),
                number(o.force, 4),
                share(o.energy_created),
                share(o.dissipated),
                number(o.wall_s, 3),
                f"stopped at {number(o.end, 4)} s" if o.stopped else "",
            ]
        )
    return Table(head, rows)


PARTED = (
    "Single events of this run part from repeat to repeat: `within` is how far the repeats came, and no bound. "
    "What holds are the sums and distributions."
)


def total_table(c: Convergence) -> Table:
    """Figures of the whole run: change by each family, and within what it has settled."""
    pairs = [f"{a} to {b}" for a, b in c.families.values()]
    head = ["whole run", *pairs, f"{BASE} against {c.finest}", "within", ""]
    rows = [
        [
            TOTALS[key],
            *(_change(t, x) for x in t.changes.values()),
            _change(t, t.base_error),
            _change(t, t.settled_to),
            t.problem or ("settled" if t.settled else "not settled"),
        ]
        for key, t in c.totals.items()
    ]
    return Table(head, rows)


def event_table(c: Convergence, units: Units) -> Table:
    """Each event of the base run: figures with the base step and the shortest one, and how far they have settled."""
    unit = {
        "start": "s",
        "duration": "ms",
        "force": units.force,
        "impulse": units.impulse,
        "closing_speed": units.speed,
    }
    groups = [("", 1), *((f"{WORDS[name]}, {unit[name]}", 3) for name in FIGURES), ("", 1)]
    head = ["where", *([BASE, c.finest, "within"] * len(FIGURES)), ""]
    rows = [
        [e.event.group, *(x for f in e.figures.values() for x in _cells(f, c.finest)), _verdict(e)]
        for e in c.events[:MOST_EVENTS]
    ]
    cut = (
        f"The first {MOST_EVENTS} of {len(c.events)} events; convergence.csv holds all."
        if len(c.events) > MOST_EVENTS
        else ""
    )
    note = " ".join(filter(None, (PARTED if c.chaotic else "", cut)))
    return Table(head, rows, 1, note, groups=groups)


def run_rows(c: Convergence, units: Units) -> list[list[str]]:
    """`run_table` for narrow pages: header and one line per figure, a column for each run."""
    table = run_table(c, units)
    rows = [list(column) for column in zip(table.head, *table.rows, strict=True)]
    return [row for row in rows if any(row[1:])]


def settled_rows(c: Convergence) -> list[list[str]]:
    """Header and one line per event: when, and within what each figure has settled."""
    head = ["time, s", *(WORDS[name] for name in FIGURES), ""]
    shown = c.events[:ON_TERMINAL]
    return [
        head,
        *(
            [fixed(e.event.t_start, 4), *(_change(f, f.settled_to) for f in e.figures.values()), _short(e)]
            for e in shown
        ),
    ]


def _short(e: EventSettling) -> str:
    if not e.judged:
        return GOES_ON
    return e.problem or ("settled" if e.settled else f"{sum(not f.settled for f in e.figures.values())} open")


def _cells(f: Settling, finest: str) -> list[str]:
    return [_value(f, BASE), _value(f, finest), _change(f, f.settled_to)]


def _value(f: Settling, run: str) -> str:
    value = f.values.get(run)
    if value is None:
        return NONE
    return fixed(value, 4) if f.name == "start" else number(1e3 * value if f.name == "duration" else value, 3)


def _change(f: Settling, value: float) -> str:
    if np.isnan(value):
        return NONE
    if f.name in TIMES:
        return f"{number(1e3 * value, 2)} ms"
    return percent(1.0 + value) if value < 0.0 else share(value)


def _marks(e: EventSettling) -> list[str]:
    each = (["", "", "settled" if f.settled else "open"] for f in e.figures.values())
    return ["", *(x for three in each for x in three), "settled" if e.settled else "open" if e.judged else ""]


def _verdict(e: EventSettling) -> str:
    if e.settled or not e.judged:
        return "settled" if e.settled else GOES_ON
    return f"not settled: {e.problem or ', '.join(WORDS[f.name] for f in e.figures.values() if not f.settled)}"


def _limits() -> str:
    said = f"forces, impulses and closing speeds within {share(SETTLED)}"
    brief = "or a fiftieth of the period of the low-pass"
    return f"start and duration within {share(OF_DURATION)} of the event's duration {brief}, {said}"
