"""How far friction and lasting contact have settled: does each place stick, slip by turns or slide in every run?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.studies.converge.settling import (
    BASE,
    CHANCE,
    ENOUGH,
    SETTLED,
    UNREDUCED,
    Convergence,
    Outcome,
    RubSettling,
    Settling,
)
from creak.verify.matching import change
from creak.verify.rubbing import FIGURES, STICK, STICK_SLIP, Rub, Rubbing
from creak.verify.statistics import MANY
from creak.verify.unreduced import Structure
from creak.words import percent

FLOOR = 0.1
"""Of the time in contact, and of the mean force: what is less changes by shares of this."""
MOVED = 0.1
"""Share of the time between slips by which one may begin earlier or later to be the same one."""
HELD = ("slip_share", "friction_energy", "force_mean")
"""What pieces of both models are held against each other in: number and rate of some slips are left to chance."""
SUMS = ("slip_time", "slip_path", "friction_energy")
"""What adds up hit by hit."""
WORDS = {
    "slips": "number of slips",
    "slip_rate": "slips per second",
    "slip_time": "slip time",
    "slip_share": "share of slip",
    "slip_path": "slip path",
    "slip_speed_rms": "rms slip speed",
    "friction_energy": "energy by friction",
    "force_mean": "mean force",
    "force_rms": "fluctuation of the force",
}


def settled_rubs(
    outcomes: dict[str, Outcome],
    families: dict[str, tuple[str, str]],
    told: tuple[str, ...],
    names: Sequence[tuple[str, int]],
    by_chance: Sequence[float] = (),
    structure: Structure | None = None,
) -> tuple[RubSettling, ...]:
    """Each place of the base run that rubs, or that something presses on for the whole time, in the other runs.

    Parameters
    ----------
    by_chance : how far what adds up over the hits at each may be off by chance, of chaotic motion. structure : what the
    unreduced model says of pieces of it.
    """
    whole = {name: o for name, o in outcomes.items() if not o.stopped}
    found = []
    for k, (contact, number) in enumerate(names):
        rubs = {name: o.rubs[k] for name, o in whole.items()}
        if BASE in rubs and rubs[BASE].figures:
            problem = "" if len(rubs) == len(outcomes) else "not known in all runs"
            r = _settled(contact, number, rubs, families, told, problem)
            r = r if structure is None else _beside(r, structure)
            found.append(_of_hits(r, by_chance[k]) if k < len(by_chance) and not r.lasting else r)
    return tuple(found)


def _of_hits(r: RubSettling, by: float) -> RubSettling:
    """With chance in what friction adds up to over hits of chaotic motion: as in the sum of their impulses."""
    sums = {n: replace(f, beside={**f.beside, CHANCE: by}) for n, f in r.figures.items() if n in SUMS}
    return replace(r, figures=r.figures | sums)


def _beside(r: RubSettling, structure: Structure) -> RubSettling:
    """With what the unreduced model makes of pieces of it, where it went through some."""

    def beside(f: Settling) -> Settling:
        by = structure.of_rub(f.name, r.contact, r.number, f.floor)
        return f if by is None else replace(f, beside={UNREDUCED: by})

    return replace(r, figures={name: beside(f) if name in HELD else f for name, f in r.figures.items()})


def _settled(
    contact: str,
    number: int,
    rubs: dict[str, Rub],
    families: dict[str, tuple[str, str]],
    told: tuple[str, ...],
    problem: str,
) -> RubSettling:
    known = {name: rub.figures for name, rub in rubs.items()}
    base = known[BASE]
    deciding = {f: pair for f, pair in families.items() if f not in told}
    friction = {name: rub.friction for name, rub in rubs.items() if rub.friction is not None}
    pairs = {f: (friction[a], friction[b]) for f, (a, b) in deciding.items() if a in friction and b in friction}
    parted = {f: pair for f, pair in pairs.items() if _parted(*pair)}
    figures = {}
    for name in FIGURES:
        values = {run: x[name] for run, x in known.items() if name in x}
        if name not in base or (name == "slip_rate" and len(values) < len(known)):
            continue  # of two slips or less there is no rate: their number decides
        floor, limit = _floor(name, rubs), SETTLED
        if name == "slips":  # one more or less, which an edge of the window makes, is none
            floor = max(1.0, *values.values())
            limit = max(SETTLED, 1.0 / floor)
        if name in ("slips", "slip_rate"):
            limit = max(limit, *(_by_chance(*pair) for pair in parted.values()), 0.0)
        changes = {f: change(name, values.get(a), values.get(b), floor) for f, (a, b) in families.items()}
        figures[name] = Settling(name, values, changes, limit, problem, told, floor=floor)
    runs = {BASE, *(name for pair in deciding.values() for name in pair)}
    states = {friction[name].state for name in runs if name in friction}
    squeaks = any(friction[name].shares[1] > SETTLED for name in runs if name in friction)
    lasting = rubs[BASE].force is not None
    return RubSettling(
        contact=contact,
        number=number,
        states={name: r.state for name, r in friction.items()},
        figures=figures,
        deciding=tuple(name for name in figures if _decides(name, states, squeaks, lasting)),
        turned=tuple(f for f, (a, b) in pairs.items() if _turned(a, b, lasting and f not in parted)),
        parted=tuple(parted),
        lasting=lasting,
        energy=max((r.energy for r in friction.values()), default=0.0),
    )


def _floor(name: str, rubs: dict[str, Rub]) -> float:
    """What changes of a figure are shares of at least."""
    friction, force = rubs[BASE].friction, rubs[BASE].force
    if name == "slip_share":
        return FLOOR
    if name == "slip_time" and friction is not None:
        return FLOOR * friction.contact_time
    return FLOOR * force.mean if name == "force_rms" and force is not None else 0.0


def _decides(name: str, states: set[str], squeaks: bool, lasting: bool) -> bool:
    """Whether a figure must settle: not that of slips where no run slips by turns for long, none where all stick."""
    if name in ("slips", "slip_rate"):
        return squeaks
    if name in ("slip_path", "slip_speed_rms"):
        return lasting and states != {STICK}
    if name == "friction_energy":
        return states != {STICK}
    return name != "slip_time"  # its share says it


def _turned(a: Rubbing, b: Rubbing, lasting: bool) -> bool:
    """Another state, and not by a hair's breadth; or, in lasting contact, for another part of the time."""
    moved = max(abs(x - y) for x, y in zip(a.shares, b.shares, strict=True))
    return moved > SETTLED and (lasting or a.state != b.state)


def _parted(a: Rubbing, b: Rubbing) -> bool:
    """Both slip by turns, and not at the same times; of slips as regular as a clock one is as good as the other."""
    known = [r.irregularity for r in (a, b) if r.state == STICK_SLIP and r.irregularity is not None]
    if len(known) < 2 or max(known) <= SETTLED:
        return False
    starts, others = (np.array([start for start, _ in r.slips]) for r in (a, b))
    return _same(starts, others, MOVED * float(a.between.mean())) < ENOUGH * max(starts.size, others.size)


def _by_chance(a: Rubbing, b: Rubbing) -> float:
    """What 95 % of two samples of one renewal process differ by in their rate: its variance of a count n is CV^2 n.

    Of few slips 0: they say nothing of chance.

    Source: Cox, Renewal Theory, 1962, 3.3.
    """
    if min(len(a.slips), len(b.slips)) < MANY:
        return 0.0
    irregular = max(a.irregularity or 0.0, b.irregularity or 0.0)
    return float(1.96 * irregular * np.sqrt(1.0 / len(a.slips) + 1.0 / len(b.slips)))


def _same(starts: FloatArray, others: FloatArray, tolerance: float) -> int:
    """How many of two rising lists of times are the same, one by one."""
    count = i = j = 0
    while i < starts.size and j < others.size:
        if abs(starts[i] - others[j]) <= tolerance:
            count, i, j = count + 1, i + 1, j + 1
        elif starts[i] < others[j]:
            i += 1
        else:
            j += 1
    return count


def open_rubs(c: Convergence) -> list[RubSettling]:
    """Places whose friction or lasting force has not settled."""
    return [r for r in c.rubs if not r.settled]


def faint_rubs(rubs: Sequence[RubSettling], c: Convergence) -> bool:
    """Whether all friction at some places decides nothing: together it takes next to none of the energy."""
    forced = any(name.startswith("force") for r in rubs for name in r.open)
    return not forced and sum(r.energy for r in rubs) <= (1.0 - ENOUGH) * sum(r.energy for r in c.rubs)


def rubs_as_dict(c: Convergence) -> list[dict[str, Any]]:
    """For summary.json."""
    return [
        {
            "contact": r.contact,
            "place": r.number or None,
            "states": r.states,
            "settled": r.settled,
            "turned": r.turned,
            "parted": r.parted,
            "deciding": r.deciding,
            "figures": {
                name: {"values": f.values, "changes": f.changes, "settled_to": f.settled_to, "settled": f.settled}
                for name, f in r.figures.items()
            },
        }
        for r in c.rubs
    ]


def rub_words(r: RubSettling) -> str:
    """What a place does, and how far that has settled, in a sentence."""
    where = f"contact {r.contact}" + (f" (place {r.number})" if r.number else "")
    if r.states and r.turned:
        said = ", ".join(f"{state} with {name}" for name, state in r.states.items())
        if len(set(r.states.values())) == 1:
            said = "it sticks, slips by turns and slides for other parts of the time"
        return f"{where}: friction changes from run to run ({said})"
    what = f"{where}: {r.states[BASE]}" if BASE in r.states else f"{where}: lasting contact"
    if r.open:
        parts = [_open_words(r.figures[name]) for name in r.open]
        return f"{what}, which changes from run to run ({', '.join(parts)})"
    most = max((abs(x) for n in r.deciding for x in r.figures[n].changes.values() if n != "slips"), default=0.0)
    parted = ", single slips part from run to run" if r.parted else ""
    return f"{what}, the same within {percent(most)}{parted}"


def _open_words(f: Settling) -> str:
    to = f.settled_to
    return f"{WORDS[f.name]} by {percent(to)}" if np.isfinite(to) else f"{WORDS[f.name]}, which not all runs have"
