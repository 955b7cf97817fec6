"""*STATIC steps before the *DYNAMIC one: the loads from whose equilibrium the run starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.abaqus.loads.boundary import along_global_axes, step_loads, step_motion
from creak.formats.abaqus.loads.pressures import Bodies, Gravity, gravity_of, pressures_of, together
from creak.formats.abaqus.loads.temperatures import heated
from creak.formats.abaqus.mesh.directions import Transforms
from creak.formats.abaqus.text.fields import Registry
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, StepBlocks, list_params
from creak.model.constraints import Fixed
from creak.model.dofs import node_dofs
from creak.model.steps import Amplitude, PointLoad, Prescribed, StaticLoads

DISTRIBUTED = ("DLOAD", "DSLOAD")
USED = ("STATIC", "BOUNDARY", "CLOAD", *DISTRIBUTED, "TEMPERATURE")
_STEP = "NAME, NLGEOM, INC, AMPLITUDE, UNSYMM, EXTRAPOLATION, CONVERT SDI, SOLVER"


def is_static(step: StepBlocks) -> bool:
    """Whether a step is one of *STATIC that changes the state, which a perturbation does not."""
    return not step.block.has("PERTURBATION") and any(b.name == "STATIC" for b in step.blocks)


def read_static(
    deck: Outline,
    steps: Sequence[StepBlocks],
    dynamic: StepBlocks,
    held: Sequence[Fixed],
    nodes: Registry,
    bodies: Bodies,
    transforms: Transforms,
    amplitudes: Mapping[str, Amplitude],
) -> tuple[StaticLoads, tuple[Fixed, ...]]:
    """The loads at the end of the *STATIC steps, which go on through the *DYNAMIC one, and what they hold.

    Parameters
    ----------
    steps : those of *STATIC, in order. held : by the model data.

    Raises
    ------
    InputError : a load on some of the elements, with an amplitude, or that the *DYNAMIC step changes; a support that
        moves.
    """
    given: Gravity = {}
    where, forces, pressed = "", list[PointLoad](), dict[tuple[str, str], list[PointLoad]]()
    fixed = tuple(held)
    for step in steps:
        list_params(deck, step.block, _STEP)
        if step.block.has("NLGEOM") and step.block.option("NLGEOM", "YES") != "NO":
            deck.note(step.block, "creak's structure is linear", changes=True, what="*STEP, NLGEOM")
        for block in step.blocks:
            _no_amplitude(block)
        fixed = _supports(deck, step, fixed, nodes, amplitudes)
        own = [b for b in step.blocks if b.name == "CLOAD"]
        if any(b.option("OP", "MOD") == "NEW" for b in own):
            forces.clear()
        forces = _replaced(forces, step_loads(deck, own, nodes, amplitudes))
        if any(b.option("OP", "MOD") == "NEW" for b in step.blocks if b.name in DISTRIBUTED):
            given, pressed = {}, {}
        for block in [b for b in step.blocks if b.name in DISTRIBUTED]:
            where = block.where
            pressed |= pressures_of(block, bodies)
            if block.name == "DLOAD":
                given |= gravity_of(block, bodies)
    gravity = together(given, bodies)
    _check_goes_on(dynamic, gravity, bool(forces), bool(pressed), bodies)
    loads = (*along_global_axes(forces, transforms), *(load for found in pressed.values() for load in found))
    first = steps[0].block.where if steps else ""
    warm = heated(deck, [b for step in steps for b in step.blocks if b.name == "TEMPERATURE"], nodes)
    return StaticLoads((float(gravity[0]), float(gravity[1]), float(gravity[2])), loads, where or first, warm), fixed


def _no_amplitude(block: Block) -> None:
    if block.name in USED and block.get("AMPLITUDE"):
        raise block.error(
            f"*{block.name} of a *STATIC step has an AMPLITUDE",
            expected="its value at the end of the step",
            fix="Leave AMPLITUDE out: the run starts from the equilibrium at the end.",
        )


def _supports(
    deck: Outline,
    step: StepBlocks,
    fixed: tuple[Fixed, ...],
    nodes: Registry,
    amplitudes: Mapping[str, Amplitude],
) -> tuple[Fixed, ...]:
    blocks = [b for b in step.blocks if b.name == "BOUNDARY"]
    now, moved = step_motion(deck, blocks, fixed, nodes, ramped=True, amplitudes=amplitudes)
    if moved:
        raise InputError(
            f"a *STATIC step moves {moved[0].name}",
            expected="supports at rest",
            where=moved[0].where,
            fix="Write a study (.toml) with [[static]] displacement.",
        )
    return now


def _replaced(before: list[PointLoad], now: Sequence[PointLoad]) -> list[PointLoad]:
    """Loads of earlier steps, but for those that are given anew.

    Raises
    ------
    InputError : a node has one of an earlier step, given under another name: whether they add up is not told.
    """
    new = {(load.name, load.dof) for load in now}
    kept = [load for load in before if (load.name, load.dof) not in new]
    names = {int(x): load.name for load in kept for x in node_dofs(load.nodes_idx, (load.dof,))}
    for load in now:
        other = next((names[x] for x in node_dofs(load.nodes_idx, (load.dof,)).tolist() if x in names), None)
        if other is not None:
            raise InputError(
                f"*CLOAD on {load.name} loads nodes that an earlier step loads as {other}",
                expected="the same name, to replace it",
                where=load.where,
                fix="Name the same set in both, or give all loads anew with OP=NEW.",
            )
    return [*kept, *now]


def _check_goes_on(
    dynamic: StepBlocks,
    gravity: FloatArray,
    forces: bool,
    pressed: bool,
    bodies: Bodies,
) -> None:
    """Raise InputError where the *DYNAMIC step changes the static loads."""
    again, last = Gravity(), None
    for block in dynamic.blocks:
        spread = block.name in DISTRIBUTED and pressed
        if block.option("OP", "MOD") == "NEW" and (spread or (block.name == "CLOAD" and forces)):
            raise block.error(
                f"*{block.name}, OP=NEW takes the loads of the *STATIC step away at once",
                expected="loads that go on",
                fix="Leave OP=NEW out, or the loads of the *STATIC step.",
            )
        if block.name == "DLOAD" and pressures_of(block, bodies):
            raise block.error(
                "*DLOAD of the *DYNAMIC step with pressure, which creak does not read there",
                expected="pressure in a *STATIC step before it, which goes on",
                fix="Move it there, or write what varies in time as *CLOAD.",
            )
        if block.name == "DLOAD":
            again, last = again | gravity_of(block, bodies), block
    if last is not None and not np.allclose(together(again, bodies), gravity, rtol=1e-9):
        raise InputError(
            "*DLOAD of the *DYNAMIC step is another gravity than that of the *STATIC step",
            expected="the same, or none",
            where=last.where,
            fix="Give it in the *STATIC step alone: it goes on.",
        )


def check_same_supports(
    static: Sequence[Fixed],
    fixed: Sequence[Fixed],
    moved: Sequence[Prescribed],
    forces: Sequence[PointLoad],
    loads: Sequence[PointLoad],
    where: str,
) -> None:
    """Raise InputError where the *DYNAMIC step frees what the *STATIC one held, holds more, or loads the same dofs."""
    before = {int(x) for f in static for x in node_dofs(f.nodes_idx, f.dofs)}
    after = {int(x) for f in fixed for x in node_dofs(f.nodes_idx, f.dofs)}
    after |= {int(x) for m in moved for x in node_dofs(m.nodes_idx, (m.dof,))}
    if before != after:
        raise InputError(
            "the *STATIC step holds other dofs than the *DYNAMIC step holds or moves",
            expected="the same",
            where=where,
            fix="Hold in the *STATIC step what the *DYNAMIC step moves.",
        )
    both = [int(x) for load in forces if not load.spread for x in node_dofs(load.nodes_idx, (load.dof,))]
    again = [load for load in loads if set(both) & {int(x) for x in node_dofs(load.nodes_idx, (load.dof,))}]
    if again:
        raise InputError(
            f"*CLOAD of the *DYNAMIC step replaces that of the *STATIC step on {again[0].name}",
            expected="loads on other dofs",
            where=again[0].where,
            fix="Write a study (.toml): [[static]] force and [excitation] add up.",
        )
