"""Steps before the modes: which of them leave a stress that would stiffen the structure."""

from __future__ import annotations

from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.numbers import to_float
from creak.formats.abaqus.outline import Outline, StepBlocks

GENERAL = ("STATIC", "VISCO", "DYNAMIC", "COUPLED TEMPERATURE-DISPLACEMENT")
"""Procedures that change the state."""
ABOUT_IT = ("FREQUENCY", "COMPLEX FREQUENCY", "STEADY STATE DYNAMICS", "SUBSTRUCTURE GENERATE", "MATRIX GENERATE")
"""Linear procedures about the state that the steps before them left."""
_OF_STRUCTURE = {
    "MODEL CHANGE": "elements or contact that a step before the modes takes out or puts in are not followed",
    "CONNECTOR MOTION": "connectors that a step before the modes holds or moves are not followed",
}
_LOADS = (
    *("CLOAD", "DLOAD", "DSLOAD", "TEMPERATURE", "FIELD", "INERTIA RELIEF", "CONTACT INTERFERENCE", "CLEARANCE"),
    *("CONNECTOR LOAD", "CFLUX", "DFLUX", "DSFLUX", "FILM", "SFILM", "CFILM", "RADIATE", "SRADIATE", "CRADIATE"),
)


def list_prestress(deck: Outline) -> None:
    """List loaded general steps before the modes as ones that change the answer, where their stress would count.

    So do elements that come or go in a step.

    The supports of these steps, and of that of the modes, hold in the modes as those of the first step do.
    It counts in Abaqus with NLGEOM, and in CalculiX where the step of the modes is a PERTURBATION. NLGEOM=NO on either
    step (as Abaqus/CAE writes it), or no load, leaves the structure as it was.
    """
    at = step_of_modes(deck)
    for step in deck.steps[1 : at + 1]:
        deck.step_boundaries += [b for b in step.blocks if b.name == "BOUNDARY"]
    for block in (b for step in deck.steps[: at + 1] for b in step.blocks if b.name in _OF_STRUCTURE):
        deck.note(block, _OF_STRUCTURE[block.name], changes=not block.has("ACTIVATE"))
    for block in (b for b in deck.set_aside if b.name == "RESTART" and b.has("READ")):
        deck.note(block, "the state of the earlier analysis is not read", changes=True, what="*RESTART, READ")
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
            why = "its stress stiffens the structure (NLGEOM), and creak's modes are those without stress"
        elif given == "NO" or linear or not deck.steps[at].block.has("PERTURBATION"):
            why = "the step before the modes is linear (no NLGEOM): its stress does not stiffen the structure"
            changes = False
        else:
            why = (
                "CalculiX takes the stress of this step into the modes (PERTURBATION), Abaqus does not without NLGEOM;"
            )
            why += " creak's modes are those without stress: give NLGEOM=NO if that is meant"
        deck.note(procedure, why, changes=changes)


def step_of_modes(deck: Outline) -> int:
    """Row of the first step about the state that those before it leave, else of the first."""
    return next((i for i, step in enumerate(deck.steps) if _named(step, ABOUT_IT)), 0)


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
