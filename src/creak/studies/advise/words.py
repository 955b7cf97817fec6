"""Why: the advice in plain sentences, each with its evidence, and what looks wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from typing import Any

from creak.studies.advise.contact import STEPS_PER_BOUNCE, StepAdvice, substeps_for
from creak.studies.advise.evidence import (
    CONTACT,
    DOOR,
    RULE_OF_THUMB,
    case,
    penalty,
    points,
    record,
    varied,
)
from creak.studies.advise.facts import Facts, Option
from creak.studies.file.config import ReductionTable
from creak.studies.models.reduced import DIAGONAL_LIMIT
from creak.studies.prepare.excitation import POWER
from creak.words import duration, listed, percent

EVERYWHERE, MANY = 0.9, 20
"""Share of channels that stay, of at least so many, from which on the pre-check did not sort."""
BESIDE = "Craig-Bampton 15 x"
"""The case that others of the record differ from."""
AFFORDABLE_S = 600.0
"""An unreduced run up to this time needs no reduction for its own sake."""


def why_f_max(facts: Facts, option: Option | None) -> Iterator[str]:
    if option is None:
        return
    f, known = facts.excitation.frequency, points()[option.method]
    said = f"f_max: {option.f_max:g} Hz = {option.multiple:.3g} x the excitation ({f:.4g} Hz), because "
    left = (
        f"{listed([f'{p.multiple:g}' for p in known])} times left "
        f"{listed([percent(p.impulse_error) for p in known])} in the impulse of an event ({DOOR})"
    )
    if option.method == "craig-bampton":
        multiples, errors = zip(*RULE_OF_THUMB, strict=True)
        thumb = f"{listed([f'{m:g}' for m in multiples])} times leave {listed([percent(e) for e in errors])}"
        yield said + (
            f"{left}, and the thesis saw no gain beyond 11 to 13 times (4.1). Frequencies alone need less: {thumb} in "
            f"the rule of thumb, and no mode at {f:.4g} Hz can be off by more than {percent(option.bound)}"
        )
    else:
        yield said + f"modes of the assembly below it are exact and the static shapes carry the contact: {left}"


def why_step(step: StepAdvice, own: float, contacts: int) -> Iterator[str]:
    yield (
        f"step: {step.step:g} s, {step.per_period:.3g} in a period of the highest frequency, because such a forced "
        f"step left on the door: {step.hht} (docs/contact_convergence.md); periods at that frequency are "
        f"{percent(step.period_error)} too long with it. Without `step` and `integrator` in [time] creak chooses, and "
        "says how far the answer has settled"
    )
    if abs(step.step / own - 1.0) > 1e-6 and contacts:
        yield (
            "channels: counted with the study's own step; with another one the linear run moves differently and may "
            "keep others: ask again with the new step"
        )


def why_substeps(step: StepAdvice, substeps: int) -> Iterator[str]:
    if step.fixed is not None:
        yield (
            f"substeps: {substeps}, because with the stiffness given in numbers the lightest channel bounces for "
            f"{step.fixed.shortest_s:.3g} s (half a period of its local mass), and a bounce should have "
            f"{STEPS_PER_BOUNCE} steps"
        )
    elif step.automatic is not None:
        b = step.automatic
        yield (
            "substeps: as in the study, because automatic stiffness follows the step: the lightest channel bounces "
            f"for {b.shortest_s:.3g} s = {b.shortest_s / step.step:.2g} steps, and about as long in steps with any "
            "other. That resolves when a blow comes, not the force of one channel "
            f"(docs/contact_convergence.md). For forces give a stiffness in numbers with {STEPS_PER_BOUNCE} steps a "
            f"bounce; as stiff as here that is substeps = {substeps_for(step.step, b)}"
        )


def why_stiffness(kinds: Set[str], step: StepAdvice, substeps: int, unit: str) -> Iterator[str]:
    """unit : of stiffness."""
    if "auto" in kinds and step.automatic is not None:
        harder = ", harder with substeps" if substeps > 1 else ""
        yield (
            f"stiffness: auto (median {step.automatic.stiffness:.3g} {unit} a channel with this step{harder}), "
            "because a forced step resolves no more: beyond that limit it creates energy (docs/numerics.md). A number "
            "only to compare models or steps, hard only without a forced step"
        )
    if "number" in kinds and step.fixed is not None:
        yield (f"stiffness: the number stays (median {step.fixed.stiffness:.3g} {unit} a channel); {_stiffer()}")
    if "hard" in kinds:
        yield (
            "stiffness: hard and a forced step do not go together, because such a step throws a node back faster than "
            "it came: leave out step and integrator, then hard contact is resolved in its own time scale"
        )


def why_retained(table: ReductionTable, facts: Facts) -> Iterator[str]:
    parts = facts.sizes.parts
    by_reason: dict[str, int] = {}
    for part in parts:
        for reason, count in part.retained.items():
            by_reason[reason] = by_reason.get(reason, 0) + count
    reasons = ", ".join(f"{n:,} {reason}" for reason, n in by_reason.items())
    yield f"retained dofs with Craig-Bampton: {sum(by_reason.values()):,} in {len(parts)} parts ({reasons})"
    if table.keep_out:
        names = (BESIDE, *(f"keep_out {d}" for d in (8, 40, 90)))
        rows = [case(record(), name) for name in names]
        sizes, errors = [f"{row['unknowns']:,}" for row in rows], [percent(row["impulse_error"]) for row in rows]
        yield (
            "keep_out: 0, because contact dofs are retained directly: 0, 8, 40 and 90 mm of mesh left unreduced gave "
            f"{listed(sizes)} unknowns and {listed(errors)} in the impulse of an event ({DOOR}). Set it where that "
            "much matters"
        )
    if table.interface.type in ("spacing", "participation"):
        dropped, every_second = (case(record(), name) for name in ("participation 0.35", "spacing 2"))
        yield (
            f"interface: full, because {table.interface.type} leaves dofs uncoupled and loses modes and events "
            f"suddenly: participation .35 found {dropped['matched']} of {dropped['reference']} events (MAC "
            f"{dropped['lowest_mac']:.2g}), every second node {every_second['matched']} (MAC "
            f"{every_second['lowest_mac']:.2g}; {DOOR})"
        )


def why_exact(accuracy: str, kinds: Set[str], facts: Facts) -> Iterator[str]:
    """Why nothing is said of steps, and what the answer hangs on instead."""
    yield (
        f"steps: accuracy = {accuracy!r} chooses them: motion between contacts is exact, "
        "contact is resolved in its own time scale, its stiffness is used as it is (docs/numerics.md)"
    )
    if facts.gaps.m == 0:
        return
    kinds = kinds - {"table"}
    if kinds:
        own = "auto, 10 times that of the softer parent element," if kinds == {"auto"} else "as in the study,"
        yield f"stiffness: {own} because it hardly matters where the structure is softer: {_stiffer()}"
    base, less, more = varied("base", 1.0), varied("damping", 0.5), varied("damping", 2.0)
    yield (
        "damping: know it, because it decides how often it rattles: half and twice the door's gave "
        f"{less['events']} and {more['events']} events for {base['events']}, total impulse "
        f"{_change(less, base)} and {_change(more, base)} ({DOOR})"
    )
    low, high = varied("load", 0.9), varied("load", 1.1)
    yield (
        f"load level: the same holds for it: a load a tenth lower and higher gave {low['events']} and {high['events']} "
        f"events for {base['events']}, total impulse {_change(low, base)} and {_change(high, base)} ({DOOR})"
    )


def _change(row: Mapping[str, Any], base: Mapping[str, Any]) -> str:
    return f"{100.0 * (row['impulse'] / base['impulse'] - 1.0):+.0f} %"


def _stiffer() -> str:
    """What the contact stiffness changes."""
    base, half, twice, ten = (penalty(x) for x in (1.0, 0.5, 2.0, 10.0))
    return (
        f"half and twice of it changed the impulse of an event by {percent(half['impulse_error'])} and "
        f"{percent(twice['impulse_error'])}, ten times by {percent(ten['impulse_error'])}, and the raw peak of one "
        f"channel, which is no result, {ten['raw_peak'] / base['raw_peak']:.2g} times ({CONTACT})"
    )


def why_unreduced(facts: Facts, step: StepAdvice) -> Iterator[str]:
    u = facts.unreduced
    if u is None:
        yield "unreduced run: none, memory does not hold a factor of the whole model; one part is factorised at a time"
        return
    yield (
        f"unreduced run: at most {duration(step.unreduced_s)} for {step.steps:,} steps on this machine ({u.dofs:,} "
        f"dofs: factorisation {u.factor_s:.2g} s, back-substitution {1e3 * u.solve_s:.3g} ms)"
    )


def warnings(margin: str, unit: str, facts: Facts, option: Option | None) -> Iterator[str]:
    """What is unusual; margin: of the pre-check, in words; unit : of length."""
    yield from _load(facts)
    yield from _channels(margin, unit, facts)
    loose = [p.name for p in facts.sizes.parts if not p.held]
    if loose:
        yield (
            f"Craig-Bampton cannot reduce {', '.join(loose)}: the retained dofs do not hold it. Couple or support it, "
            "retain more nodes, or use gap-modes"
        )
    largest = max(o.unknowns for o in facts.options if o.method == "craig-bampton")
    if largest > DIAGONAL_LIMIT:
        yield (
            f"more than {DIAGONAL_LIMIT:,} unknowns with Craig-Bampton ({largest:,}): such a model is not diagonalised "
            "and its "
            'steps are slow. Use gap-modes, or interface = { type = "interpolation" } or "characteristic"'
        )
    yield from _memory(facts)
    if option is not None and option.offline_s + facts.steps[0].reduced_s > facts.steps[0].unreduced_s:
        yield "one reduced run costs more than the unreduced one: a reduction pays for many runs only"


def _memory(facts: Facts) -> Iterator[str]:
    peak, free = facts.memory.run_peak, facts.memory.free_gb
    if peak.gb > free:
        yield (
            f"memory: {peak.what} takes some {peak.gb:.2g} GB ({peak.why}), {free:.2g} GB are free: lower f_max, cut "
            "the largest part into substructures, leave out the reference run where that is the peak, or take a "
            "larger machine. Modes are found window by window then, in up to twice the time; what does not fit even "
            "so is refused before it is made"
        )


def _load(facts: Facts) -> Iterator[str]:
    e = facts.excitation
    if e.source == "sampled":
        yield (
            f"the excitation's highest frequency is not stated; {100.0 * POWER:.0f} % of the power of its samples lies "
            f"below {e.frequency:.4g} Hz, and all multiples refer to that: check it"
        )
    elif e.source == "assumed":
        yield (
            f"the excitation's highest frequency is not known: {e.frequency:.4g} Hz, the verification's mac_f_max, is "
            "used instead; set that to the highest frequency that matters"
        )


def _channels(margin: str, unit: str, facts: Facts) -> Iterator[str]:
    c = facts.channels
    if c.contacts + c.connectors == 0:
        yield "the study has neither contact nor connector: it is linear"
    elif c.smallest is not None and facts.gaps.m == 0:
        yield (
            f"no channel closes: the smallest gap of the linear run is {c.smallest:.3g} {unit}, the margin {margin}. "
            "Check load, units and clearance"
        )
    elif c.closing == 0 and not c.connectors:
        yield (
            f"no channel closes in the linear run (smallest gap {c.smallest:.3g} {unit}); {c.kept} stay because of the "
            "margin only. Without a first touch there is no contact at all"
        )
    if c.closing is None and c.contacts:
        yield "the pre-check could not be made, because only contact holds the structure: all channels are kept"
    elif c.contacts >= MANY and c.kept > EVERYWHERE * c.contacts:
        yield (
            f"contact everywhere: {c.kept} of {c.contacts} channels stay. Check load and units, and whether the margin "
            f"of {margin} is small against the gap"
        )
