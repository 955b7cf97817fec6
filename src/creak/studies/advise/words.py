"""Why: the advice in plain sentences, each with its evidence, and what looks wrong."""

from __future__ import annotations

from collections.abc import Iterator

from creak.studies.advise.contact import STEPS_PER_BOUNCE, StepAdvice, substeps_for
from creak.studies.advise.evidence import DOOR
from creak.studies.advise.facts import Facts, Option
from creak.studies.models.reduced import DIAGONAL_LIMIT
from creak.studies.prepare.setup import Setup

EVERYWHERE, MANY = 0.9, 20
"""Share of channels that stay, of at least so many, from which on the pre-check did not sort."""
AFFORDABLE_S = 600.0
"""An unreduced run up to this time needs no reduction for its own sake."""


def why_f_max(facts: Facts, option: Option | None) -> Iterator[str]:
    if option is None:
        return
    f = facts.excitation.frequency
    said = f"f_max: {option.f_max:g} Hz = {option.multiple:.3g} x the excitation ({f:.4g} Hz), because "
    if option.method == "craig-bampton":
        yield said + (
            f"7, 11, 15 and 20 times left 7.6, 2.6, 1.0 and .4 % in the impulse of an event ({DOOR}), and the thesis "
            "saw no gain beyond 11 to 13 times (4.1). Frequencies alone need less: 2, 3 and 5 times leave 1, .1 and "
            f".03 % in the rule of thumb, and no mode at {f:.4g} Hz can be off by more than {100 * option.bound:.2g} %"
        )
    elif option.method == "massless-boundary":
        yield said + (
            "its modes fade towards the cut (.5 % of a mode's share is missing at a tenth of it), and at 7 times the "
            "next modes change impulses by 1.5 % (docs/massless_boundary.md, docs/contact_convergence.md)"
        )
    else:
        yield said + (
            "modes of the assembly below it are exact and the static shapes carry the contact: 3 times left .4 % in "
            f"the force and impulse of an event, 7 times .09 % ({DOOR})"
        )


def why_step(setup: Setup, step: StepAdvice, massless: bool) -> Iterator[str]:
    yield (
        f"step: {step.step:g} s, {step.per_period:.3g} in a period of the highest frequency, because such a step left "
        f"on the door: {step.massless if massless else step.hht} (docs/contact_convergence.md)"
        + ("" if massless else f"; periods at that frequency are {100 * step.period_error:.2g} % too long with it")
    )
    if abs(step.step / setup.study.config.time.step - 1.0) > 1e-6 and setup.contacts.m:
        yield (
            "channels: counted with the study's own step; with another one the linear run moves differently and may "
            "keep others (docs/contact_convergence.md): ask again with the new step"
        )


def why_substeps(step: StepAdvice, substeps: int, massless: bool) -> Iterator[str]:
    if massless:
        yield "substeps: as in the study; the massless boundary takes more by itself where contact springs need them"
    elif step.fixed is not None:
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
            "other. That resolves when a blow comes and its impulse, not the force of one channel "
            f"(docs/contact_convergence.md). For forces give a stiffness in numbers with {STEPS_PER_BOUNCE} steps a "
            f"bounce; as stiff as here that is substeps = {substeps_for(step.step, b)}"
        )


def why_stiffness(setup: Setup, step: StepAdvice, substeps: int, massless: bool) -> Iterator[str]:
    kinds = {
        ("table" if t.overclosure is not None else t.stiffness if isinstance(t.stiffness, str) else "number")
        for t in setup.study.config.contact.values()
    }
    if "auto" in kinds and step.automatic is not None:
        harder = ", harder with substeps" if substeps > 1 else ""
        yield (
            f"stiffness: auto (median {step.automatic.stiffness:.3g} force/length a channel with this step{harder}), "
            "because the step resolves no more, and with that limit no run of 36 created more than .5 % of energy, "
            "without it all did (docs/numerics.md). A number only to compare models or steps, hard only with the "
            "massless boundary"
        )
    if "number" in kinds and step.fixed is not None:
        yield (
            f"stiffness: the number stays (median {step.fixed.stiffness:.3g} force/length a channel); raw forces grow "
            "with about its square root, impulses change by some per cent (docs/contact_convergence.md)"
        )
    if "hard" in kinds and massless:
        yield (
            "stiffness: hard stays, because the massless boundary needs no penalty; forces at an instant ring with "
            "the highest modes, impulses converge (docs/massless_boundary.md)"
        )


def why_retained(setup: Setup, facts: Facts) -> Iterator[str]:
    table, parts = setup.study.config.reduction, facts.sizes.parts
    by_reason: dict[str, int] = {}
    for part in parts:
        for reason, count in part.retained.items():
            by_reason[reason] = by_reason.get(reason, 0) + count
    listed = ", ".join(f"{n:,} {reason}" for reason, n in by_reason.items())
    yield f"retained dofs with Craig-Bampton: {sum(by_reason.values()):,} in {len(parts)} parts ({listed})"
    if table.keep_out:
        yield (
            "keep_out: 0, because contact dofs are retained directly: 0, 8, 40 and 90 mm of mesh left unreduced gave "
            f"1,320, 1,740, 2,945 and 4,436 unknowns and 1.0, 1.0, 1.2 and 1.1 % in the impulse of an event ({DOOR})"
        )
    if table.interface.type in ("spacing", "participation"):
        yield (
            f"interface: full, because {table.interface.type} leaves dofs uncoupled and loses modes and events "
            f"suddenly: participation kept 0 to 2 of 29 events, every second node a MAC of .67 ({DOOR})"
        )


def why_exact(setup: Setup) -> str:
    """Why nothing is said of steps."""
    return (
        f"steps: accuracy = {setup.study.config.time.accuracy!r} chooses them: motion between contacts is exact, "
        "contact is resolved in its own time scale, its stiffness is used as it is (docs/numerics.md)"
    )


def why_unreduced(facts: Facts, step: StepAdvice) -> Iterator[str]:
    u = facts.unreduced
    yield (
        f"unreduced run: at most {duration(step.unreduced_s)} for {step.steps:,} steps on this machine ({u.dofs:,} "
        f"dofs: factorisation {u.factor_s:.2g} s, back-substitution {1e3 * u.solve_s:.3g} ms)"
    )


def warnings(setup: Setup, facts: Facts, option: Option | None) -> Iterator[str]:
    """What is unusual."""
    yield from _load(facts)
    yield from _channels(setup, facts)
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
    if option is not None and option.offline_s + facts.steps[0].reduced_s > facts.steps[0].unreduced_s:
        yield "one reduced run costs more than the unreduced one: a reduction pays for many runs only"


def _load(facts: Facts) -> Iterator[str]:
    e = facts.excitation
    if e.source == "sampled":
        yield (
            "the excitation's highest frequency is not stated; 99 % of the power of its samples lies below "
            f"{e.frequency:.4g} Hz, and all multiples refer to that: check it"
        )
    elif e.source == "assumed":
        yield (
            f"the excitation's highest frequency is not known: {e.frequency:.4g} Hz, the verification's mac_f_max, is "
            "used instead; set that to the highest frequency that matters"
        )


def _channels(setup: Setup, facts: Facts) -> Iterator[str]:
    c, margin = facts.channels, setup.study.config.precheck.margin
    if c.contacts + c.connectors == 0:
        yield "the study has neither contact nor connector: it is linear"
    elif c.smallest is not None and facts.gaps.m == 0:
        yield (
            f"no channel closes: the smallest gap of the linear run is {c.smallest:.3g}, the margin {margin:g}. Check "
            "load, units and clearance"
        )
    elif c.closing == 0 and not c.connectors:
        yield (
            f"no channel closes in the linear run (smallest gap {c.smallest:.3g}); {c.kept} stay because of the margin "
            "only. Without a first touch there is no contact at all"
        )
    if c.closing is None and c.contacts:
        yield "the pre-check could not be made, because only contact holds the structure: all channels are kept"
    elif c.contacts >= MANY and c.kept > EVERYWHERE * c.contacts:
        yield (
            f"contact everywhere: {c.kept} of {c.contacts} channels stay. Check load and units, and whether the margin "
            f"of {margin:g} is small against the gap"
        )


def duration(seconds: float) -> str:
    """`21 us`, `4.2 ms`, `38 s`, `12 min`, `5.2 h`."""
    if seconds < 1e-3:
        return f"{1e6 * seconds:.2g} us"
    if seconds < 0.1:
        return f"{1e3 * seconds:.2g} ms"
    if seconds < 100.0:
        return f"{seconds:.2g} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.2g} h"
