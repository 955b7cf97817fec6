"""SOL 109, 112 and 129: the transient analysis of the deck itself; TLOAD1 with TABLED1 to 3, and TLOAD2 -> functions of
time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.refusals import referred
from creak.formats.nastran.joints.gaps import read_gaps
from creak.formats.nastran.loads.modal_damping import CARD as DAMPING
from creak.formats.nastran.loads.modal_damping import damping_table, points_of
from creak.formats.nastran.loads.sets import CARDS as OF_STATIC
from creak.formats.nastran.loads.sets import READ, by_value, load_set, subcase_loads
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import BY_FREQUENCY, Deck, unique_cards
from creak.given import LARGEST
from creak.model.constraints import Fixed, without
from creak.model.mesh import Unread
from creak.model.steps import Amplitude, DeckRun, DynamicStep, InModes, PointLoad, Prescribed

TABLES = ("TABLED1", "TABLED2", "TABLED3")
CLOSEST = 1e-9
"""Share of a step over which a jump of a table is drawn out, half of it to either side: on it the mean holds."""
FLAT = {"TABLED1": 3, "TABLED2": 2, "TABLED3": 3}
"""Field of a table that says how it goes on beyond its ends (FLAT in OptiStruct, EXTRAP in MSC Nastran)."""


def amplitude_of(deck: Deck, card: Card, dt: float, count: int, kind: str) -> Amplitude:
    """The function of a TLOAD card over a run of `count` steps of `dt`.

    TLOAD1: F(t - delay) by a table, linear between its points; beyond its ends as its first and last line, or flat
    where it says so; at a jump the mean; or a constant, where a number stands for the table. TLOAD2:
    s^B exp(C s) cos(2 pi F s + P), s = t - T1 - delay, from T1 to T2; a plain cosine (or constant) over the whole run
    as such, others of forces by their values at the steps.

    Raises
    ------
    InputError : delays by card, tables with logarithmic axes, initial values, motions by a TLOAD2 that starts or ends
        within the run.
    """
    if card.is_integer(2) and card.integer(2):
        raise card.error(f"{card.title} has a DELAY card", expected="a time in its field DELAY", fix="Shift its table.")
    delay = 0.0 if card.is_integer(2) else card.real(2, 0.0)
    if any(card.real(i, 0.0) for i in ((5, 6) if card.name == "TLOAD1" else (10, 11))):
        raise card.error(
            f"{card.title} has initial values US0, VS0",
            expected="blank or 0",
            fix="creak starts from the undeformed place.",
        )
    if card.name == "TLOAD1":
        if card.text(4) and not card.is_integer(4):
            return _tabular(card, np.array([[0.0, card.real(4)], [dt * count, card.real(4)]]))
        tables = unique_cards(deck.cards(*TABLES, "TABLED4"), "table")
        table = referred(tables, card.integer(4), card, "table", ", ".join(TABLES))
        if table.name not in TABLES:
            raise InputError(
                f"{table.name} {table.text(0)} gives its function by a power series",
                where=table.where,
                expected=f"points: {', '.join(TABLES)}",
                fix="Write its values at some times into a TABLED1.",
            )
        points, end, flat = _points(table), dt * count, _is_flat(table)
        points[:, 0] += delay
        (a, b), (c, d) = points[:2, 0], points[-2:, 0]
        if not flat and ((a == b and a > 0.0) or (c == d and d < end)):
            raise InputError(
                f"{table.name} {table.text(0)} jumps at an end, beyond which it would go on along a line",
                where=table.where,
                expected="two points of the line, or 1 in the field FLAT",
                fix="Add a point.",
            )
        return _tabular(card, _over_run(points, dt, end, flat))
    return _analytic(card, delay, dt, count, kind)


def _name(card: Card) -> str:
    return f"{card.name} {card.integer(0)}"


def _tabular(card: Card, points: FloatArray) -> Amplitude:
    return Amplitude(_name(card), "tabular", points, rounding=0.0, where=card.where)


def _points(table: Card) -> FloatArray:
    """(k, 2) times, which do not fall, and values."""
    axes = [table.text(i).upper() for i in (1, 2)] if table.name == "TABLED1" else ["", ""]
    if "LOG" in axes:
        raise InputError(f"TABLED1 {table.text(0)} has logarithmic axes", where=table.where, expected="LINEAR")
    pairs: list[tuple[float, float]] = []
    for i in range(8, len(table.fields) - 1, 2):
        texts = (table.text(i).upper(), table.text(i + 1).upper())
        if "ENDT" in texts:
            break
        if "SKIP" not in texts and any(texts):
            pairs.append((table.real(i), table.real(i + 1)))
    points = np.array(pairs, dtype=np.float64).reshape(-1, 2)
    if table.name == "TABLED2":
        points[:, 0] += table.real(1, 0.0)
    elif table.name == "TABLED3":
        points[:, 0] = table.real(2, 0.0) * points[:, 0] + table.real(1, 0.0)
    if points.size and points[0, 0] > points[-1, 0]:
        points = points[::-1].copy()
    if len(points) < 2 or (np.diff(points[:, 0]) < 0.0).any() or points[0, 0] == points[-1, 0]:
        raise InputError(
            f"{table.name} {table.text(0)} has {len(points)} points, or times that rise and fall or stand still",
            where=table.where,
            expected="two points or more, in the order of time or against it",
        )
    return points


def _is_flat(table: Card) -> bool:
    """Whether the values at the ends of a table go on beyond them."""
    word = table.text(FLAT[table.name]).upper()
    if word not in ("", "0", "1", "FLAT"):
        raise InputError(
            f"{table.name} {table.text(0)} has {word} for what lies beyond its ends",
            where=table.where,
            expected="blank or 0 (its first and last line), 1 or FLAT (the values at its ends)",
        )
    return word in ("1", "FLAT")


def _over_run(points: FloatArray, dt: float, end: float, flat: bool) -> FloatArray:
    """The table from 0 to `end`, lengthened along its first and last line or flat; jumps take a billionth of a step,
    half of it to either side."""
    t = points[:, 0].copy()
    apart = np.maximum(max(CLOSEST * dt, 2e-12), 4e-16 * np.abs(t))
    _, first, which, count = np.unique(t, return_index=True, return_inverse=True, return_counts=True)
    t += apart * (np.arange(t.size) - first[which] - 0.5 * (count[which] - 1))
    for k in range(1, t.size):
        t[k] = max(t[k], t[k - 1] + apart[k])
    points = np.column_stack([t, points[:, 1]])
    if t[0] > 0.0:
        points = np.concatenate([[_beyond(points[0], points[1], 0.0, flat)], points])
    if t[-1] < end:
        points = np.concatenate([points, [_beyond(points[-1], points[-2], end, flat)]])
    return points


def _beyond(end: FloatArray, inner: FloatArray, time: float, flat: bool) -> tuple[float, float]:
    slope = 0.0 if flat else float((end[1] - inner[1]) / (end[0] - inner[0]))
    return time, float(end[1]) + slope * (time - float(end[0]))


def _analytic(card: Card, delay: float, dt: float, count: int, kind: str) -> Amplitude:
    start, stop = (card.real(i, 0.0) + delay for i in (4, 5))
    frequency, phase, growth, power = (card.real(i, 0.0) for i in (6, 7, 8, 9))
    phase = math.radians(phase)
    end = dt * count
    if start <= 0.0 and stop >= end and not growth and not power:
        shifted = phase - 2.0 * math.pi * frequency * start
        if not frequency:
            return _tabular(card, np.array([[0.0, math.cos(phase)], [end, math.cos(phase)]]))
        cosine, sine = (math.cos(shifted),), (-math.sin(shifted),)
        return Amplitude(_name(card), "periodic", frequency=frequency, cosine=cosine, sine=sine, where=card.where)
    if kind != "force":
        raise card.error(
            f"TLOAD2 {card.text(0)} moves grids by a function that starts, ends or grows within the run",
            expected="T1 = 0, T2 at or after the end, B = C = 0",
            fix="Give the motion by TLOAD1 and a table.",
        )
    t = dt * np.arange(count + 1)
    s = np.maximum(t - start, 0.0)
    on = (t >= start - 1e-9 * dt) & (t <= stop + 1e-9 * dt)
    with np.errstate(over="ignore", invalid="ignore"):
        values = np.where(on, s**power * np.exp(growth * s) * np.cos(2.0 * math.pi * frequency * s + phase), 0.0)
    if not (np.abs(values) <= LARGEST).all():
        raise card.error(f"TLOAD2 {card.text(0)} grows beyond all numbers", fix="Check B and C.")
    return _tabular(card, np.column_stack([t, values]))


SOLUTIONS = {"109": "", "SEDTRAN": "", "112": "modal", "SEMTRAN": "modal", "129": "nonlinear"}
KINDS = {
    "": "force",
    "0": "force",
    "LOAD": "force",
    "L": "force",
    "1": "displacement",
    "DISP": "displacement",
    "D": "displacement",
    "2": "velocity",
    "VELO": "velocity",
    "V": "velocity",
    "3": "acceleration",
    "ACCE": "acceleration",
    "A": "acceleration",
}
"""TYPE of TLOAD1 and TLOAD2."""
CARDS = {"TSTEP", "TSTEPNL", "TLOAD1", "TLOAD2", "DLOAD", "CGAP", "PGAP", *READ, *TABLES}
"""Read for the deck's own run."""


def cards_of(run: DeckRun) -> set[str]:
    """What is read for a run."""
    in_modes = {DAMPING} if run.step.modes is not None else set()
    return CARDS | in_modes | (OF_STATIC if run.static is not None else set())


WITH_STOPS = -0.05
"""Alpha of HHT where gaps close; without gaps it is 0, the mean acceleration."""
MOST = 1e7
"""Steps."""


@dataclass(frozen=True)
class _Term:
    """A TLOAD card and the factor of DLOAD."""

    card: Card
    factor: float


def read_transient(deck: Deck, fixed: Sequence[Fixed]) -> DeckRun:
    """The run: TSTEP of one length, TLOAD1 and TLOAD2 with DLOAD, gaps as stops; what SPCD moves is not held.
    It starts from the loads of a static subcase before it.

    SOL 112 is run in all dofs instead of modes, but with damping of the modes (SDAMPING), which makes it a step in
    modes; SOL 129, with TSTEPNL, linear but for its gaps. creak integrates by HHT
    with alpha = 0 (with gaps -0.05) where Nastran has Newmark's method with beta = 1/3; both are of second order in the
    step.

    Raises
    ------
    InputError : another solution, no TSTEP, steps of several lengths, loads or functions that creak does not read.
    """
    case = deck.case
    if case.solution not in SOLUTIONS:
        what = f"SOL {case.solution}" if case.solution else "no SOL line"
        fix = "`creak new DECK` writes a study that names the deck."
        if case.solution in BY_FREQUENCY:
            fix = f"creak computes in time: `creak modes` finds the modes of a frequency response. {fix}"
        raise InputError(
            f"the deck has {what}; creak runs SOL 109, SOL 112 and SOL 129 by themselves",
            where=case.where,
            expected="SOL 109, 112 or 129, or a study file (.toml)",
            fix=fix,
        )
    if SOLUTIONS[case.solution] == "nonlinear":
        why = "the run is linear but for its gaps: small motion, elastic materials"
        deck.unread.append(Unread(f"SOL {case.solution}", case.where, False, why))
    count, dt, where = _steps(deck)
    amplitudes: dict[str, Amplitude] = {}
    moved: list[Prescribed] = []
    loads: list[PointLoad] = []
    for term in _terms(deck):
        amplitude = amplitude_of(deck, term.card, dt, count, _kind(term.card))
        amplitudes[amplitude.name] = amplitude
        _excite(deck, term, amplitude.name, moved, loads)
    stops, table = read_gaps(deck), damping_table(deck)
    damped = points_of(table) if table is not None and SOLUTIONS[case.solution] == "modal" else ()
    static = None if case.static is None else subcase_loads(deck, case.static)
    held = moved if static is None else [*moved, *static.moved]
    step = DynamicStep(
        f"SOL {case.solution}",
        case.where,
        dt,
        count * dt,
        True,
        WITH_STOPS if stops else 0.0,
        "",
        fixed=without(fixed, np.concatenate([np.zeros(0, dtype=np.int64), *(m.labels for m in held)])),
        moved=tuple(moved),
        loads=tuple(loads),
        output_sets=case.output,
        places={"time": where, "dynamic": where},
        modes=InModes(by_frequency=damped) if damped else None,
    )
    return DeckRun(step, amplitudes, {}, (), stops=stops, static=static)


def _steps(deck: Deck) -> tuple[int, float, str]:
    """Number, length and place of the steps, those of subcases that follow each other added up."""
    cards = unique_cards(deck.cards("TSTEP", "TSTEPNL"), "TSTEP")
    if not deck.case.tsteps:
        raise InputError(
            "the case control has no TSTEP",
            where=deck.case.where,
            expected="TSTEP = n",
            fix="Name the TSTEP card of the run.",
        )
    count, lengths = 0, set[float]()
    for number in deck.case.tsteps:
        if number not in cards:
            raise InputError(
                f"TSTEP = {number} in the case control, but no card has this number",
                where=deck.case.where,
                expected=f"one of {sorted(cards)}",
            )
        card = cards[number]
        rows = [1] if card.name == "TSTEPNL" else [i for i in range(1, len(card.fields), 8) if card.text(i)]
        lengths |= {card.real(i + 1) for i in rows}
        count += sum(card.integer(i) for i in rows)
    name, where = f"TSTEP {', '.join(map(str, dict.fromkeys(deck.case.tsteps)))}", card.where
    if len(lengths) != 1 or not min(lengths) > 0.0:
        raise InputError(
            f"{name} has steps of {', '.join(f'{x:g}' for x in sorted(lengths))} s",
            where=where,
            expected="one length, above 0",
            fix="creak's step is constant: give the shortest for the whole run.",
        )
    if not 2 <= count <= MOST:
        raise InputError(f"{name} has {count} steps", where=where, expected=f"2 to {MOST:g}")
    return count, lengths.pop(), where


def _terms(deck: Deck) -> Iterator[_Term]:
    """TLOAD cards that the case control takes, by themselves or through DLOAD."""
    chosen = deck.case.dload
    if not chosen:
        return
    loads = unique_cards(deck.cards("TLOAD1", "TLOAD2"), "dynamic load")
    sums = unique_cards(deck.cards("DLOAD"), "DLOAD")
    if chosen not in sums:
        user = Card("DLOAD", (str(chosen),), deck.case.where)
        yield _Term(referred(loads, chosen, user, "dynamic load", "TLOAD1, TLOAD2 or DLOAD"), 1.0)
        return
    card = sums[chosen]
    for i in range(2, len(card.fields), 2):
        if card.text(i + 1):
            load = referred(loads, card.integer(i + 1), card, "dynamic load", "TLOAD1 or TLOAD2")
            yield _Term(load, card.real(1, 1.0) * card.real(i, 1.0))


def _kind(card: Card) -> str:
    text = card.text(3).upper()
    if text not in KINDS:
        raise card.wrong(3, "LOAD, DISP, VELO or ACCE, or 0 to 3")
    return KINDS[text]


def _excite(deck: Deck, term: _Term, amplitude: str, moved: list[Prescribed], loads: list[PointLoad]) -> None:
    kind, card = _kind(term.card), term.card
    found = load_set(deck, card.integer(1), card)
    if kind != "force" and found.forces:
        raise card.error(
            f"{card.title} moves grids (TYPE {card.text(3)}), but its set has forces",
            expected="SPCD cards",
            fix="Give TYPE LOAD for forces.",
        )
    if kind == "force" and found.motion:
        raise card.error(
            f"{card.title} is a load, but its set has SPCD cards",
            expected="TYPE DISP, VELO or ACCE",
            fix="Give the type of the motion.",
        )
    for (dof, value), rows in by_value(found.motion if kind != "force" else found.forces).items():
        name = f"GRID {deck.grids.ids[rows[0]]}" if len(rows) == 1 else f"SET {card.integer(1)}"
        nodes, scaled = np.array(rows, dtype=np.int64), term.factor * value
        if kind == "force":
            loads.append(PointLoad(nodes, dof, scaled, amplitude, name, card.where))
        else:
            moved.append(Prescribed(nodes, dof, kind, scaled, amplitude, name, card.where))
    dofs = [(int(n), m.dof) for m in moved for n in m.nodes_idx]
    if len(set(dofs)) < len(dofs):
        raise InputError(
            "two loads move the same dof",
            where=found.where,
            expected="one motion for each dof",
            fix="Add the motions up in one table.",
        )
