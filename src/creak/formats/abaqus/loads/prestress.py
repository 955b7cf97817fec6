"""Steps before the modes: which of them leave a stress that would stiffen the structure."""

from __future__ import annotations

from collections.abc import Sequence

from creak.formats.abaqus.loads.boundary import along_global_axes, check_global, step_loads, step_motion
from creak.formats.abaqus.mesh.directions import Transforms
from creak.formats.abaqus.text.fields import Registry, to_float
from creak.formats.abaqus.text.keywords import meaning
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, StepBlocks
from creak.formats.deck.catalogue import misspelling
from creak.model.steps import StaticStep

GENERAL = ("STATIC", "VISCO", "DYNAMIC", "COUPLED TEMPERATURE-DISPLACEMENT")
"""Procedures that change the state."""
ABOUT_IT = ("FREQUENCY", "COMPLEX FREQUENCY", "STEADY STATE DYNAMICS", "SUBSTRUCTURE GENERATE", "MATRIX GENERATE")
"""Linear procedures about the state that the steps before them left."""
_FOLLOWED = {"STATIC", "CLOAD", "BOUNDARY", "CONTROLS", "SOLUTION TECHNIQUE", "MONITOR", "PRINT"} | {
    *("OUTPUT", "NODE OUTPUT", "ELEMENT OUTPUT", "NODE PRINT", "EL PRINT", "NODE FILE", "EL FILE", "ENERGY OUTPUT"),
    *("CONTACT OUTPUT", "RESTART", "ENERGY PRINT", "ENERGY FILE", "FILE FORMAT", "CONTACT PRINT", "CONTACT FILE"),
}
"""What a step may hold whose stress creak follows."""
_OF_STRUCTURE = {
    "MODEL CHANGE": "elements or contact that a step before the modes takes out or puts in are not followed",
    "CONNECTOR MOTION": "connectors that a step before the modes holds or moves are not followed",
}
_LOADS = (
    *("CLOAD", "DLOAD", "DSLOAD", "TEMPERATURE", "FIELD", "INERTIA RELIEF", "CONTACT INTERFERENCE", "CLEARANCE"),
    *("CONNECTOR LOAD", "CFLUX", "DFLUX", "DSFLUX", "FILM", "SFILM", "CFILM", "RADIATE", "SRADIATE", "CRADIATE"),
)


def list_prestress(deck: Outline) -> StepBlocks | None:
    """List loaded general steps before the modes as ones that change the answer, where their stress would count.

    So do elements that come or go in a step. Returns the *STATIC step whose stress counts, if it is one that creak can
    follow (`read_static`): the only one, with forces and prescribed displacements, without contact,
    of linear materials, and no supports after it.

    The supports of these steps, and of that of the modes, hold in the modes (`_in_force`).
    It counts in Abaqus with NLGEOM, and in CalculiX where the step of the modes is a PERTURBATION. NLGEOM=NO on either
    step (as Abaqus/CAE writes it), or no load, leaves the structure as it was.
    """
    at = step_of_modes(deck)
    deck.step_boundaries[:] = [b for step in _in_force(deck.steps[: at + 1]) for b in _boundaries(step)]
    for block in (b for step in deck.steps[: at + 1] for b in step.blocks if b.name in _OF_STRUCTURE):
        deck.note(block, _OF_STRUCTURE[block.name], changes=not block.has("ACTIVATE"))
    list_restart(deck)
    _list_other_supports(deck, at)
    stressed: list[StepBlocks] = []
    nonlinear, linear = False, deck.steps[at].block.option("NLGEOM") == "NO" if deck.steps else False
    for step in deck.steps[:at]:
        procedure = _named(step, GENERAL)
        given = (step.block.option("NLGEOM") or "YES") if step.block.has("NLGEOM") else ""
        nonlinear = nonlinear or given == "YES"
        if procedure is None:
            continue
        changes = _loaded(step)
        if not changes:
            why = "the step before the modes has no load, so it leaves no stress"
        elif nonlinear:
            why = "its stress stiffens the structure (NLGEOM); creak follows forces and displacements, in modes alone"
        elif given == "NO" or linear or not deck.steps[at].block.has("PERTURBATION"):
            why = "the step before the modes is linear (no NLGEOM): its stress does not stiffen the structure"
            changes = False
        else:
            why = (
                "CalculiX takes the stress of this step into the modes (PERTURBATION), Abaqus does not without NLGEOM;"
            )
            why += " creak's modes are those without stress: give NLGEOM=NO if that is meant"
        deck.note(procedure, why, changes=changes)
        stressed += [step] * changes
    if (
        _unlinear(deck)
        or not nonlinear
        or len(stressed) != 1
        or not all(b.name in _FOLLOWED for b in stressed[0].blocks)
    ):
        return None
    later = deck.steps[deck.steps.index(stressed[0]) + 1 : at + 1]
    supported = any(b.name in ("BOUNDARY", *_OF_STRUCTURE) for step in later for b in step.blocks)
    return None if supported or _named(stressed[0], ("STATIC",)) is None else stressed[0]


def list_restart(deck: Outline) -> None:
    """List the state of an earlier analysis that the deck begins with."""
    for block in (b for b in deck.set_aside if b.name == "RESTART" and b.has("READ")):
        deck.note(block, "the state of the earlier analysis is not read", changes=True, what="*RESTART, READ")


def _list_other_supports(deck: Outline, at: int) -> None:
    """List later steps whose modes have other supports than those of step `at`, and what looks like a *BOUNDARY."""
    for i, step in enumerate(deck.steps[at + 1 :], start=at + 2):
        procedure = _named(step, ("FREQUENCY",))
        if procedure is not None and _supports(step) != _supports(deck.steps[at]):
            why = "its modes have other supports; creak takes those of the first such step: write a deck for each"
            deck.note(step.block, why, changes=True, what=f"*STEP {step.block.get('NAME') or i}")
    for block in (b for step in deck.steps[: at + 1] for b in step.blocks):
        meant = misspelling(block.name, ("BOUNDARY",))
        if meant:
            deck.note(block, meant, changes=True)


def _supports(step: StepBlocks) -> list[tuple[dict[str, str], list[str]]]:
    return [(b.params, b.lines) for b in _boundaries(step)]


def _unlinear(deck: Outline) -> bool:
    """Whether contact or a material that is not linear would take part in the step."""
    inside = [b for step in deck.steps for b in step.blocks]
    if any(b.name in ("CONTACT PAIR", "CONTACT") for b in [*deck.set_aside, *inside]):
        return True
    rubber = any(b.name in ("HYPERELASTIC", "HYPERFOAM") for _, m in deck.blocks("MATERIAL") for b in m.options)
    return rubber or any(meaning(b.name).why == meaning("PLASTIC").why for b in deck.set_aside)


def read_static(deck: Outline, step: StepBlocks | None, nodes: Registry, transforms: Transforms) -> StaticStep | None:
    """Forces and displacements of the step that `list_prestress` found.

    Raises
    ------
    InputError : unknown node or set, dof outside 1..6, not a number.
    """
    if step is None:
        return None
    moved, unread = _boundaries(step), dict(deck.unread)
    loads = [b for b in step.blocks if b.name == "CLOAD"]
    if any(b.has("AMPLITUDE") or b.has("FOLLOWER") or b.option("OP") == "NEW" or b.has("FIXED") for b in moved + loads):
        return None
    if any(b.option("TYPE", "DISPLACEMENT") != "DISPLACEMENT" for b in moved):
        return None
    _, motion = step_motion(deck, moved, (), nodes, ramped=True, amplitudes={})
    check_global(motion, transforms)
    forces = along_global_axes(step_loads(deck, loads, nodes, {}), transforms)
    deck.unread = unread
    if any(f.dof > 3 for f in forces):
        return None
    return StaticStep("*STATIC", forces, motion, step.block.where)


def step_of_modes(deck: Outline) -> int:
    """Row of the first step about the state that those before it leave, else of the first."""
    return next((i for i, step in enumerate(deck.steps) if _named(step, ABOUT_IT)), 0)


def held_in_modes(deck: Outline, followed: StepBlocks | None) -> list[Block]:
    """*BOUNDARY blocks whose dofs are fixed in the modes of *FREQUENCY whatever their values, as in Abaqus.

    They are those in force in its step, but for those of the static step that is `followed`: `read_static` reads how
    that moves them.
    """
    at = step_of_modes(deck)
    if not deck.steps or _named(deck.steps[at], ("FREQUENCY",)) is None:
        return []
    return [b for step in _in_force(deck.steps[: at + 1]) if step is not followed for b in _boundaries(step)]


def _in_force(steps: Sequence[StepBlocks]) -> list[StepBlocks]:
    """Those whose supports hold in the last of these steps, as in Abaqus.

    Supports of a general step go on until a step with OP=NEW takes all before it away; those of a linear perturbation
    hold in it alone.
    """
    found: list[StepBlocks] = []
    for step in steps:
        if step is not steps[-1] and (step.block.has("PERTURBATION") or _named(step, ("BUCKLE",))):
            continue
        if any(b.option("OP", "MOD") == "NEW" for b in _boundaries(step)):
            found = []
        found.append(step)
    return found


def _boundaries(step: StepBlocks) -> list[Block]:
    return [b for b in step.blocks if b.name == "BOUNDARY"]


def _named(step: StepBlocks, names: tuple[str, ...]) -> Block | None:
    return next((b for b in step.blocks if b.name in names), None)


def _loaded(step: StepBlocks) -> bool:
    """Whether anything of the step is not zero."""
    for block in step.blocks:
        if block.name in _LOADS:
            return True
        if block.name == "BOUNDARY":
            for fields, where in block.rows():
                if len(fields) > 3 and to_float(fields[3], where, "boundary value"):
                    return True
    return False
