"""*STEP: which step of a deck creak can run, and what it asks for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NoReturn

from creak.errors import InputError
from creak.formats.abaqus.joints import contact
from creak.formats.abaqus.joints.interactions import read_interactions
from creak.formats.abaqus.loads.amplitudes import read_amplitudes
from creak.formats.abaqus.loads.boundary import (
    along_global_axes,
    check_global,
    model_boundaries,
    step_loads,
    step_motion,
)
from creak.formats.abaqus.loads.modal_steps import PROCEDURE, in_modes, moved_bases, with_supports_of_modes
from creak.formats.abaqus.loads.modal_steps import USED as OF_MODES
from creak.formats.abaqus.loads.pressures import Bodies
from creak.formats.abaqus.loads.prestress import list_restart
from creak.formats.abaqus.loads.static_steps import USED as OF_STATIC
from creak.formats.abaqus.loads.static_steps import check_same_supports, is_static, read_static
from creak.formats.abaqus.mesh.directions import Transforms
from creak.formats.abaqus.text.fields import Registry, lookup, positive, to_float
from creak.formats.abaqus.text.keywords import meaning
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, StepBlocks, list_params
from creak.model.constraints import Fixed
from creak.model.steps import EVERY_NODE, Amplitude, DeckRun, DynamicStep
from creak.words import listed

PERTURBATIONS = (
    "FREQUENCY",
    "MODAL DYNAMIC",
    "STEADY STATE DYNAMICS",
    "RANDOM RESPONSE",
    "RESPONSE SPECTRUM",
    "BUCKLE",
    "COMPLEX FREQUENCY",
    "SUBSTRUCTURE GENERATE",
    "MATRIX GENERATE",
)
"""Procedures that leave the state as it was."""
PROCEDURES = (
    *PERTURBATIONS,
    "DYNAMIC",
    "STATIC",
    "VISCO",
    "HEAT TRANSFER",
    "COUPLED TEMPERATURE-DISPLACEMENT",
    "ANNEAL",
    "GREEN",
    "MODAL",
)
APPLICATIONS = ("TRANSIENT FIDELITY", "MODERATE DISSIPATION")
MOST = 1e8
"""Increments of a step; their samples alone would fill the memory."""
_CONTROLS = ("CONTROLS", "SOLUTION TECHNIQUE", "SECTION CONTROLS", "DIAGNOSTICS")
_USED = ("BOUNDARY", "CLOAD", "AMPLITUDE", "DYNAMIC")
_AT_REST = dict.fromkeys(
    ("DLOAD", "DSLOAD"),
    "in a step of its own creak has forces at nodes (*CLOAD), and gravity that a *STATIC step before it begins; in a "
    "study (`creak new DECK`) [[static]] gravity is that of the whole run",
)
"""What is said of loads that a run starts under."""
_NODE_OUTPUT = ("NODE OUTPUT", "NODE PRINT", "NODE FILE")
_DYNAMIC = (
    "ALPHA, DIRECT, APPLICATION, TIME INTEGRATOR, HAFTOL, HALFINC SCALE FACTOR, NOHAF, INITIAL, IMPACT,"
    "INCREMENTATION, SINGULAR MASS"
)
_STEP = "NAME, NLGEOM, INC, AMPLITUDE, UNSYMM, EXTRAPOLATION, CONVERT SDI, SOLVER, PERTURBATION"


def read_run(deck: Outline, nodes: Registry, bodies: Bodies, transforms: Transforms) -> DeckRun:
    """The first *DYNAMIC step, or else the first *MODAL DYNAMIC step, with contact, amplitudes, motion and loads.

    Everything of it that creak does not use is listed in `deck.unread`, in place of what is listed there for a deck
    whose step a study defines.

    Parameters
    ----------
    bodies : elements and surfaces.
    transforms : axes of the nodes that have their own.

    Raises
    ------
    InputError : no step that creak can run, or anything wrong with it.
    """
    at = _runnable(deck.steps)
    step = with_supports_of_modes(deck.steps, at) if _is(deck.steps[at], PROCEDURE) else deck.steps[at]
    statics = [s for s in deck.steps[:at] if is_static(s)]
    _relist(deck, step, statics)
    blocks = [*deck.set_aside, *(b for s in deck.steps[: at + 1] for b in s.blocks)]
    amplitudes = read_amplitudes(deck, [b for b in blocks if b.name == "AMPLITUDE"])
    interactions = read_interactions(deck, deck.set_aside)
    pairs = contact.read_pairs(deck, deck.set_aside, interactions, bodies.surfaces)
    contact.list_node_areas(deck, pairs, interactions)
    held = model_boundaries(deck, nodes)
    static = None
    used = {b.get("AMPLITUDE").upper() for b in blocks}
    late = [b for b in blocks if b.name == "AMPLITUDE" and b.option("TIME") == "TOTAL TIME"]
    late = [b for b in late if b.get("NAME").upper() in used]
    if statics and late:
        raise InputError(
            f"amplitude {late[0].get('NAME')!r} has TIME=TOTAL TIME, which begins with the *STATIC step",
            expected="STEP TIME",
            where=late[0].where,
            fix="Take the period of the *STATIC steps off its times.",
        )
    if statics:
        static, still = read_static(deck, statics, step, held, nodes, bodies, transforms, amplitudes)
        held = list(still)
    dynamic = _dynamic(deck, step, at, held, nodes, transforms, amplitudes)
    if dynamic.modes is None:
        _list_later(deck, at)
    if static is not None:
        check_same_supports(held, dynamic.fixed, dynamic.moved, static.forces, dynamic.loads, static.where)
    return DeckRun(
        dynamic,
        amplitudes,
        interactions,
        pairs,
        tuple(_title(s, i) for i, s in enumerate(deck.steps[:at]) if s not in statics),
        tuple(_title(s, i) for i, s in enumerate(deck.steps[at + 1 :], start=at + 1)),
        static=static,
    )


def _list_later(deck: Outline, at: int) -> None:
    """List the steps in which the run goes on: all after row `at` but perturbations, which leave the state as it is."""
    for i, step in enumerate(deck.steps[at + 1 :], start=at + 1):
        procedure = _procedure(step)
        if step.block.has("PERTURBATION") or (procedure is not None and procedure.name in PERTURBATIONS):
            continue
        why = f"the run goes on in it (*{'STEP' if procedure is None else procedure.name}); creak runs the first"
        why += " *DYNAMIC step alone: write it as one step with amplitudes over the whole time"
        deck.note(step.block, why, changes=True, what=f"*STEP {step.block.get('NAME') or i + 1}")


def _procedure(step: StepBlocks) -> Block | None:
    return next((b for b in step.blocks if b.name in PROCEDURES), None)


def _title(step: StepBlocks, row: int) -> str:
    procedure = _procedure(step)
    name = step.block.get("NAME") or str(row + 1)
    return f"{name} (*{procedure.name if procedure is not None else 'STEP'}, {step.block.where})"


def _runnable(steps: list[StepBlocks]) -> int:
    """Row of the first *DYNAMIC step, without any of the first *MODAL DYNAMIC step."""
    if not steps:
        raise InputError(
            "the deck has no *STEP",
            expected="a *DYNAMIC or *MODAL DYNAMIC step",
            fix="Write a study for it: `creak new DECK`. Or add such a step.",
        )
    rows = [i for name in ("DYNAMIC", PROCEDURE) for i, s in enumerate(steps) if _is(s, name)]
    at = rows[0] if rows else -1
    for i, step in enumerate(steps):
        procedure = _procedure(step)
        if at == i:
            return i
        follows = at >= 0
        static = procedure is not None and procedure.name == "STATIC" and follows
        if procedure is None or (procedure.name not in PERTURBATIONS and not static):
            _stop(step, procedure, follows)
    found = [p for p in map(_procedure, steps) if p is not None]
    names = dict.fromkeys(f"*{p.name}" for p in found)
    use = "Use `creak modes DECK`" if [*names] == ["*FREQUENCY"] else "Write a study: `creak new DECK`"
    raise InputError(
        f"the deck has no *DYNAMIC or *MODAL DYNAMIC step, only {listed([*names])}",
        expected="a *DYNAMIC step",
        where=found[-1].where,
        fix=f"{use}, or add a *DYNAMIC step.",
    )


def _is(step: StepBlocks, name: str) -> bool:
    procedure = _procedure(step)
    return procedure is not None and procedure.name == name


def _stop(step: StepBlocks, procedure: Block | None, dynamic: bool) -> NoReturn:
    """The error for a step that changes the state before there is a *DYNAMIC step."""
    if procedure is None:
        raise InputError(
            "the step names no procedure that creak knows",
            expected="*DYNAMIC",
            where=step.block.where,
            fix="Put *DYNAMIC after *STEP.",
        )
    if not dynamic:
        raise InputError(
            f"the deck has no *DYNAMIC step; creak does not run *{procedure.name}",
            expected="a *DYNAMIC step",
            where=procedure.where,
            fix="Write a study for it: `creak new DECK`. Or add a *DYNAMIC step.",
        )
    raise InputError(
        f"a *{procedure.name} step comes before the *DYNAMIC step; creak starts a run at rest, or from *STATIC steps",
        expected="*DYNAMIC as the first step that changes the state, or *STATIC before it",
        where=procedure.where,
        fix="Remove that step where its result does not matter.",
    )


def list_yielding(deck: Outline) -> None:
    """Say of materials that yield what a run of the deck's own *DYNAMIC step asks for, where it has one."""
    if not any(_is(step, "DYNAMIC") for step in deck.steps):
        return
    for entry in [u for u in deck.unread if u.why == meaning("PLASTIC").why]:
        del deck.unread[entry]
        asks = f"{entry.why} (a run of the deck's own *DYNAMIC step asks for --ignore '{entry.keyword.lstrip('*')}')"
        deck.unread[replace(entry, why=asks)] = None


def _relist(deck: Outline, step: StepBlocks, statics: list[StepBlocks]) -> None:
    """List again what is left out, now that the deck's own contact, amplitudes and step are used."""
    ours = {b.where for b in deck.set_aside if meaning(b.name).why in (*_OURS, meaning("PLASTIC").why)}
    ours |= {b.where for s in deck.steps for b in (s.block, *s.blocks)}
    deck.unread = {u: None for u in deck.unread if u.where not in ours}
    list_restart(deck)
    for block in deck.set_aside:
        if meaning(block.name).why == meaning("PLASTIC").why:
            follows = "the step follows this material law at large strain; creak's run is elastic"
            why = "a step in modes is elastic" if _is(step, PROCEDURE) and not statics else follows
            deck.note(block, why, changes=why == follows)
        used = block.name in contact.KEYWORDS or block.name == "AMPLITUDE"
        if meaning(block.name).why in _OURS and not used:
            deck.note(block, "of contact creak reads pairs of surfaces and their *SURFACE INTERACTION", changes=True)
    own: tuple[str, ...] = (*_USED, *OF_MODES) if _is(step, PROCEDURE) else _USED
    given: list[tuple[Block, tuple[str, ...]]] = [(b, (*own, "DLOAD") if statics else own) for b in step.blocks]
    given += [(b, (*_USED, *OF_STATIC)) for s in statics for b in s.blocks]
    for block, used_here in given:
        known = meaning(block.name)
        if known.why in _OUTPUT or block.name in _CONTROLS:
            why = "creak writes its own results" if known.why in _OUTPUT else "it controls the job, not the model"
            deck.note(block, why, changes=False)
        elif block.name not in used_here:
            deck.note(block, _AT_REST.get(block.name, "creak does not read this keyword of a step"), changes=True)


_OURS = tuple(meaning(name).why for name in ("CONTACT PAIR", "CONTACT CONTROLS", "AMPLITUDE"))
_OUTPUT = (meaning("OUTPUT").why, meaning("RESTART").why)


def _dynamic(
    deck: Outline,
    step: StepBlocks,
    row: int,
    held: Sequence[Fixed],
    nodes: Registry,
    transforms: Transforms,
    amplitudes: Mapping[str, Amplitude],
) -> DynamicStep:
    block = next(b for b in step.blocks if b.name in ("DYNAMIC", PROCEDURE))
    modes = in_modes(deck, step) if block.name == PROCEDURE else None
    ramped = _step_line(deck, step.block, modes is not None)
    application, alpha = _scheme(deck, block) if modes is None else ("", None)
    increment, period, where = _times(block)
    boundaries = [b for b in step.blocks if b.name == "BOUNDARY"]
    fixed, moved = step_motion(deck, boundaries, held, nodes, ramped=ramped, amplitudes=amplitudes)
    bases = [b for b in step.blocks if b.name == "BASE MOTION" and modes is not None]
    fixed, driven = moved_bases(deck, bases, fixed, amplitudes)
    moved = (*moved, *driven)
    loads = step_loads(deck, [b for b in step.blocks if b.name == "CLOAD"], nodes, amplitudes)
    check_global(moved, transforms)
    loads = along_global_axes(loads, transforms)
    return DynamicStep(
        name=step.block.get("NAME") or str(row + 1),
        where=step.block.where,
        increment=increment,
        period=period,
        direct=block.has("DIRECT"),
        alpha=alpha,
        application=application,
        ramped=ramped,
        fixed=fixed,
        moved=moved,
        loads=loads,
        output_sets=_output_sets(step, nodes),
        places={"time": where, "dynamic": block.where},
        modes=modes,
    )


def _step_line(deck: Outline, block: Block, in_modes: bool) -> bool:
    """Whether values without amplitude grow over the step; *STEP is checked."""
    list_params(deck, block, _STEP)
    if block.has("NLGEOM") and block.option("NLGEOM", "YES") != "NO":
        deck.note(block, "creak's structure is linear", changes=True, what="*STEP, NLGEOM")
    if block.has("PERTURBATION") and not in_modes:
        raise block.error("*STEP, PERTURBATION with *DYNAMIC", expected="a general step", fix="Remove PERTURBATION.")
    course = block.option("AMPLITUDE", "STEP")
    if course not in ("STEP", "RAMP"):
        raise block.error(f"*STEP has AMPLITUDE={course}", expected="STEP or RAMP", fix="Correct it.")
    return course == "RAMP"


def _scheme(deck: Outline, block: Block) -> tuple[str, float | None]:
    """APPLICATION and ALPHA, each empty where the deck does not give it."""
    for param, why in (("EXPLICIT", "creak integrates implicitly"), ("SUBSPACE", "creak uses all coordinates")):
        if block.has(param):
            raise block.error(
                f"*DYNAMIC, {param}: {why}",
                expected="*DYNAMIC without it",
                fix="Give an implicit step with its increment and period.",
            )
    list_params(deck, block, _DYNAMIC)
    application = block.option("APPLICATION")
    scheme = {"HHT-TF": APPLICATIONS[0], "HHT-MD": APPLICATIONS[1], "": application}
    integrator = block.option("TIME INTEGRATOR")
    if application not in ("", *APPLICATIONS) or integrator not in scheme:
        wrong = f"APPLICATION={application}" if integrator in scheme else f"TIME INTEGRATOR={integrator}"
        raise block.error(
            f"*DYNAMIC has {wrong}",
            expected=f"APPLICATION={' or '.join(APPLICATIONS)}",
            fix="creak has no backward Euler scheme.",
        )
    if not block.has("ALPHA"):
        return scheme[integrator], None
    alpha = to_float(block.need("ALPHA"), block.where, "ALPHA")
    if not -0.5 <= alpha <= 0.0:
        raise block.error(f"*DYNAMIC has ALPHA={alpha:g}", expected="-0.5 to 0", fix="Correct it.")
    return scheme[integrator], alpha


def _times(block: Block) -> tuple[float, float, str]:
    """Increment, period and file:line."""
    rows = list(block.rows())
    if not rows:
        raise block.error(f"*{block.name} without a data line", expected="increment, period of the step", fix="Add it.")
    fields, where = rows[0]
    increment = positive(fields[0], where, "time increment")
    period = positive(fields[1] if len(fields) > 1 else "", where, "period of the step")
    if not 2.0 <= period / increment <= MOST:
        raise InputError(
            f"increments of {increment:g} s in a step of {period:g} s",
            expected=f"2 to {MOST:g} of them",
            where=where,
            fix="Shorten the increment." if period < 2.0 * increment else "Give a longer increment.",
        )
    return increment, period, where


def _output_sets(step: StepBlocks, nodes: Registry) -> tuple[str, ...]:
    names = [b.get("NSET").upper() or EVERY_NODE for b in step.blocks if b.name in _NODE_OUTPUT]
    for block in step.blocks:
        name = block.get("NSET")
        if block.name in _NODE_OUTPUT and name and lookup(nodes.sets, name, "", nodes.assembly) is None:
            nodes.find(name, "", block.where)
    return tuple(dict.fromkeys(names))
