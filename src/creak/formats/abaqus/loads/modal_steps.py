"""*MODAL DYNAMIC: a transient step in the modes of the *FREQUENCY step before it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import inf

import numpy as np

from creak.errors import InputError
from creak.formats.abaqus.loads.amplitudes import find_amplitude
from creak.formats.abaqus.loads.boundary import KINDS, Motion
from creak.formats.abaqus.text.fields import floats, to_dof, to_float, to_int
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, StepBlocks, list_params
from creak.formats.deck.catalogue import same_share
from creak.model.constraints import Fixed
from creak.model.steps import BASE, Amplitude, InModes, Prescribed

PROCEDURE = "MODAL DYNAMIC"
USED = (PROCEDURE, "MODAL DAMPING", "BASE MOTION", "SELECT EIGENMODES")
"""Keywords that such a step has besides those of *DYNAMIC."""
_INCREMENTS = "DIRECT, DELTMX"
"""Parameters of CalculiX, which say how its increments are chosen: creak's step in modes has none."""
_CRITICAL = ("FRACTION OF CRITICAL DAMPING", "DIRECT", "")
_WAY_OUT = "write a study (`creak new DECK`) with [damping]: modal, rayleigh or from_test"


def with_supports_of_modes(steps: Sequence[StepBlocks], at: int) -> StepBlocks:
    """The step with the *BOUNDARY lines of the last *FREQUENCY step before it, in whose modes it runs."""
    of_modes = [s for s in steps[:at] if any(b.name == "FREQUENCY" for b in s.blocks)]
    held = [b for b in of_modes[-1].blocks if b.name == "BOUNDARY"] if of_modes else []
    return replace(steps[at], blocks=[*held, *steps[at].blocks])


def in_modes(deck: Outline, step: StepBlocks) -> InModes:
    """What the step says of its modes; what of it creak does not follow is listed.

    creak keeps as many modes as the answer takes, so *SELECT EIGENMODES that takes all up to some one says nothing.

    Raises
    ------
    InputError : a number that is none.
    """
    for block in step.blocks:
        if block.name == PROCEDURE:
            list_params(deck, block, f"CONTINUE, {_INCREMENTS}, STEADY STATE")
            if block.has("STEADY STATE"):
                why = "it asks for the motion that is left in the end; creak runs over the time of the step, from rest"
                deck.note(block, why, changes=True, what=f"*{PROCEDURE}, STEADY STATE")
            if block.option("CONTINUE", "NO") == "YES":
                why = "it starts where the step before ends; creak starts at rest, or with the initial velocities"
                deck.note(block, why, changes=True, what=f"*{PROCEDURE}, CONTINUE")
        elif block.name == "SELECT EIGENMODES" and not _all_up_to_one(block):
            deck.note(block, "creak takes all modes, these and those between and below them", changes=True)
    damping = InModes()
    for block in step.blocks:
        if block.name == "MODAL DAMPING":
            damping = _damping(deck, block, damping)
    return damping


def list_damping(deck: Outline) -> None:
    """List the *MODAL DAMPING of steps that gives all modes one share, which a study may give instead."""
    blocks = [b for step in deck.steps for b in step.blocks if b.name == "MODAL DAMPING"]
    for block in blocks:
        shares = set[float]()
        with suppress(InputError):  # of a step that is not run
            found = _damping(replace(deck, unread={}), block, InModes())
            shares = {p[-1] for p in (*found.by_number, *found.by_frequency)}
        if len(shares) == 1 and (share := shares.pop()) > 0.0:
            deck.note(block, same_share(share), changes=False, damps=True, share=share)


def _all_up_to_one(block: Block) -> bool:
    """Whether modes 1 to n are selected, or all frequencies from 0 on."""
    rows = [fields for fields, _ in block.rows()]
    if block.option("DEFINITION", "MODE NUMBERS") == "FREQUENCY RANGE":
        return all(to_float(fields[0], block.where, "frequency") <= 0.0 for fields in rows)
    if block.has("GENERATE"):
        return all(to_int(f[0], block.where, "mode") == 1 and f[2:] in ([], ["1"]) for f in rows)
    found = sorted(to_int(field, block.where, "mode") for fields in rows for field in fields)
    return found == list(range(1, len(found) + 1))


def _damping(deck: Outline, block: Block, before: InModes) -> InModes:
    list_params(deck, block, "MODAL, VISCOUS, RAYLEIGH, STRUCTURAL, DEFINITION")
    kind = block.option("VISCOUS") or block.option("MODAL") or ("RAYLEIGH" if block.has("RAYLEIGH") else "")
    rows = list(block.rows())
    refused = ""
    if block.has("STRUCTURAL"):
        refused = "structural damping has no meaning in time"
    elif kind == "RAYLEIGH":
        numbers = {tuple(floats(fields, where, "modal damping", 4)[2:]) for fields, where in rows}
        if len(numbers) == 1:
            alpha, beta = numbers.pop()
            return replace(before, rayleigh=(alpha, beta))
        refused = "it differs from mode to mode"
    elif kind in _CRITICAL and block.option("DEFINITION", "MODE NUMBERS") == "MODE NUMBERS":
        return replace(before, by_number=tuple(sorted(_share(fields, where) for fields, where in rows)))
    elif kind in _CRITICAL:
        return replace(before, by_frequency=tuple(_points(rows)))
    else:
        refused = f"of modal damping creak reads the share of critical and Rayleigh's numbers, not {kind}"
    deck.note(block, f"{refused}; {_WAY_OUT}", changes=True, damps=True)
    return before


def _points(rows: Sequence[tuple[Sequence[str], str]]) -> Iterator[tuple[float, float]]:
    """Frequency, rising, and share of critical damping of each line."""
    last = -inf
    for fields, where in rows:
        freq, _, share = to_float(fields[0], where, "frequency"), *_share(["1", "1", *fields[1:2]], where)[1:]
        if not freq > last:
            raise InputError(
                f"modal damping at {freq:g} Hz stands after {last:g} Hz",
                expected="frequencies that rise from line to line",
                where=where,
                fix="Sort the lines.",
            )
        last = freq
        yield freq, share


def _share(fields: Sequence[str], where: str) -> tuple[int, int, float]:
    """First and last mode of a line and their share of critical damping."""
    first, last, share = (*fields, "", "", "")[:3]
    number = to_int(first, where, "mode")
    found = (number, to_int(last, where, "mode") if last else number, to_float(share, where, "share of critical"))
    if not (1 <= found[0] <= found[1] and 0.0 <= found[2] < 1.0):
        raise InputError(
            f"modes {found[0]} to {found[1]} have {found[2]:g} of critical damping",
            expected="first mode, last mode, a share from 0 to below 1",
            where=where,
            fix="Correct the line; 2 % of critical is 0.02.",
        )
    return found


def moved_bases(
    deck: Outline, blocks: Iterable[Block], fixed: Sequence[Fixed], amplitudes: Mapping[str, Amplitude]
) -> tuple[tuple[Fixed, ...], tuple[Prescribed, ...]]:
    """*BASE MOTION: all dofs that are held along its DOF move together; what stays held, and what moves.

    Secondary bases (BASE NAME) and turns of the base are listed as not read.

    Raises
    ------
    InputError : no amplitude or an unknown one, DOF or TYPE that is none, nothing held along DOF.
    """
    motion = Motion()
    for one in fixed:
        motion.hold(one)
    for block in blocks:
        list_params(deck, block, "DOF, AMPLITUDE, SCALE, TYPE, BASE NAME")
        dof, kind = to_dof(block.need("DOF"), block.where), block.option("TYPE", "ACCELERATION")
        amplitude = find_amplitude(amplitudes, block.need("AMPLITUDE"), block.where)
        if block.has("BASE NAME") or dof > 3:
            why = "creak moves all supports together along x, y or z; give the others in a study, [excitation.NAME]"
            deck.note(block, why, changes=True)
            continue
        if kind not in KINDS:
            raise block.error(f"*BASE MOTION has TYPE={kind}", expected=", ".join(KINDS), fix="Correct it.")
        if not block.has("TYPE"):
            why = "its amplitude is an acceleration, as in Abaqus; in CalculiX it is a displacement (TYPE=DISPLACEMENT)"
            deck.note(block, why, changes=False)
        held = [one.nodes_idx for one in fixed if dof in one.dofs]
        if not held:
            raise block.error(
                f"*BASE MOTION along {dof}, in which the deck holds no node",
                expected="a *BOUNDARY in this direction, of the model data or the *FREQUENCY step",
                fix="Hold the nodes that move.",
            )
        scale = to_float(block.get("SCALE", "1."), block.where, "SCALE")
        nodes = np.unique(np.concatenate(held))
        motion.move(Prescribed(nodes, dof, kind.lower(), scale, amplitude, BASE, block.where))
    return motion.resolved()
