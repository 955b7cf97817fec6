"""SOL 109, 112 and 129: the transient analysis of the deck itself."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from creak.errors import InputError
from creak.formats.deck.refusals import referred
from creak.formats.nastran.joints.gaps import read_gaps
from creak.formats.nastran.loads.modal_damping import CARD as DAMPING
from creak.formats.nastran.loads.modal_damping import damping_table, points_of
from creak.formats.nastran.loads.sets import READ, LoadSet, load_set
from creak.formats.nastran.loads.static_loads import CARDS as OF_STATIC
from creak.formats.nastran.loads.static_loads import by_value, subcase_loads
from creak.formats.nastran.loads.time_functions import TABLES, amplitude_of
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import BY_FREQUENCY, Deck, unique_cards
from creak.model.constraints import Fixed, without
from creak.model.mesh import Unread
from creak.model.steps import Amplitude, DeckRun, DynamicStep, InModes, PointLoad, Prescribed

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
        fix = "Write a study that names the deck in [model]."
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
    _check_motion_once(moved, found)


def _check_motion_once(moved: Sequence[Prescribed], found: LoadSet) -> None:
    dofs = [(int(n), m.dof) for m in moved for n in m.nodes_idx]
    if len(set(dofs)) < len(dofs):
        raise InputError(
            "two loads move the same dof",
            where=found.where,
            expected="one motion for each dof",
            fix="Add the motions up in one table.",
        )
