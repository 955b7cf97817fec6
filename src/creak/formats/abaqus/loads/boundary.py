"""*BOUNDARY and *INITIAL CONDITIONS; *CLOAD and the *BOUNDARY lines of a step, with their amplitudes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.joints.couplings import note_rotated
from creak.formats.abaqus.loads.amplitudes import find_amplitude
from creak.formats.abaqus.mesh.directions import Transforms
from creak.formats.abaqus.text.fields import Registry, dof_range, to_dof, to_float
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, list_params
from creak.model.constraints import Fixed
from creak.model.dofs import dof_label, node_and_dof, nodes_of
from creak.model.steps import Amplitude, PointLoad, Prescribed

_NAMED = {
    "ENCASTRE": (1, 2, 3, 4, 5, 6),
    "PINNED": (1, 2, 3),
    "XSYMM": (1, 5, 6),
    "YSYMM": (2, 4, 6),
    "ZSYMM": (3, 4, 5),
    "XASYMM": (2, 3, 4),
    "YASYMM": (1, 3, 5),
    "ZASYMM": (1, 2, 6),
}


def read_boundaries(deck: Outline, nodes: Registry, held: Sequence[Block] = ()) -> list[Fixed]:
    """Dofs held at zero, in the model data and in the steps in force, whose OP=NEW takes those of the model data away.

    Non-zero values in the step are left to the study's [excitation], but for the blocks `held`, which fix their dofs.

    Raises
    ------
    InputError : unknown node or set, dof outside 1..6, non-zero value in the model data.
    """
    result: list[Fixed] = []
    for scope, block in deck.blocks("BOUNDARY"):
        note_rotated(deck, scope, block)
        result += _fixed(block, scope.name, nodes, in_step=False)
    if any(block.option("OP", "MOD") == "NEW" for block in deck.step_boundaries):
        result = []
    for block in deck.step_boundaries:
        result += _fixed(block, "", nodes, in_step=True, held=any(block is b for b in held))
    return result


def model_boundaries(deck: Outline, nodes: Registry) -> list[Fixed]:
    """Dofs that the model data alone hold at zero.

    Raises
    ------
    InputError : as `read_boundaries`.
    """
    return [f for scope, block in deck.blocks("BOUNDARY") for f in _fixed(block, scope.name, nodes, in_step=False)]


def boundary_dofs(fields: Sequence[str], where: str) -> tuple[tuple[int, ...], float | None]:
    """Dofs of a *BOUNDARY line and their value; None for a named condition (ENCASTRE, PINNED, ...).

    Raises
    ------
    InputError : no dof, an unknown name, a dof outside 1..6, a value that is no number.
    """
    if len(fields) < 2:
        raise InputError(
            f"*BOUNDARY on {fields[0]} names no degree of freedom",
            expected="node or set, first dof, last dof; or ENCASTRE, PINNED, XSYMM, ...",
            where=where,
            fix="Complete the line.",
        )
    dofs = _NAMED.get(fields[1].upper())
    if dofs is not None:
        return dofs, None
    if fields[1][:1].isalpha():
        raise InputError(
            f"*BOUNDARY on {fields[0]} is of unknown type {fields[1]!r}",
            expected=", ".join(_NAMED),
            where=where,
            fix=suggest(fields[1], _NAMED),
        )
    dofs = dof_range(fields[1:3], where)
    return dofs, to_float(fields[3] if len(fields) > 3 else "", where, "boundary value")


def _fixed(block: Block, scope: str, nodes: Registry, *, in_step: bool, held: bool = False) -> list[Fixed]:
    result: list[Fixed] = []
    for fields, where in block.rows():
        rows = nodes.find(fields[0], scope, where)
        dofs, value = boundary_dofs(fields, where)
        if value and in_step and not held:
            continue
        if value and not in_step:
            raise InputError(
                f"*BOUNDARY on {fields[0]} prescribes {value:g}",
                expected="0 in the model data",
                where=where,
                fix="Prescribe motion in the study's [excitation].",
            )
        result.append(Fixed(rows, dofs, where))
    return result


def read_initial_velocity(deck: Outline, nodes: Registry) -> list[tuple[int, int, float]]:
    """*INITIAL CONDITIONS, TYPE=VELOCITY; other types are listed as unread.

    Raises
    ------
    InputError : TYPE missing, unknown node or set, dof outside 1..6, not a number.
    """
    result: list[tuple[int, int, float]] = []
    for scope, block in deck.blocks("INITIAL CONDITIONS"):
        kind = block.need("TYPE").upper()
        if kind != "VELOCITY":
            harmless = kind in ("TEMPERATURE", "CONTACT")
            why = "creak reads TYPE=VELOCITY"
            if kind == "TEMPERATURE":
                why = "it acts only together with temperatures: *TEMPERATURE of a *STATIC step, a study's [[static]]"
            deck.note(block, why, changes=not harmless, what=f"*INITIAL CONDITIONS, TYPE={kind}")
            continue
        for fields, where in block.rows():
            if len(fields) != 3:
                raise InputError(
                    f"*INITIAL CONDITIONS line with {len(fields)} values",
                    expected="node or set, dof, velocity",
                    where=where,
                    fix="Correct the line.",
                )
            dof, value = to_dof(fields[1], where), to_float(fields[2], where, "velocity")
            result += [(int(row), dof, value) for row in nodes.find(fields[0], scope.name, where)]
    return result


KINDS = ("DISPLACEMENT", "VELOCITY", "ACCELERATION")


@dataclass
class Motion:
    """What every dof of the model is made to do; a later line replaces an earlier one."""

    entries: list[Fixed | Prescribed] = field(default_factory=list)
    by_label: dict[int, int] = field(default_factory=dict)
    """Label of a dof -> row of `entries`."""

    def hold(self, fixed: Fixed) -> None:
        self._set(fixed.nodes_idx, fixed.dofs, fixed)

    def move(self, motion: Prescribed) -> None:
        self._set(motion.nodes_idx, (motion.dof,), motion)

    def _set(self, nodes: IntArray, dofs: Iterable[int], entry: Fixed | Prescribed) -> None:
        self.entries.append(entry)
        row = len(self.entries) - 1
        self.by_label.update({dof_label(n, dof): row for n in nodes.tolist() for dof in dofs})

    def release(self) -> None:
        """OP=NEW: nothing of what was said before holds."""
        self.by_label.clear()

    def resolved(self) -> tuple[tuple[Fixed, ...], tuple[Prescribed, ...]]:
        """Held and moved dofs; each dof is in one of them at most."""
        labels: dict[int, list[int]] = {}
        for label, row in self.by_label.items():
            labels.setdefault(row, []).append(label)
        fixed: list[Fixed] = []
        moved: list[Prescribed] = []
        for row, found in sorted(labels.items()):
            entry = self.entries[row]
            if isinstance(entry, Fixed):
                fixed += _by_dofs(found, entry.where)
            else:
                moved.append(replace(entry, nodes_idx=nodes_of(np.array(found))))
        return tuple(fixed), tuple(moved)


def _by_dofs(labels: Iterable[int], where: str) -> list[Fixed]:
    """Held dofs, those of a node together: nodes that are held in the same dofs make one entry."""
    dofs: dict[int, list[int]] = {}
    for label in labels:
        node, dof = node_and_dof(label)
        dofs.setdefault(node, []).append(dof)
    nodes: dict[tuple[int, ...], list[int]] = {}
    for node, held in dofs.items():
        nodes.setdefault(tuple(sorted(held)), []).append(node)
    return [Fixed(np.array(rows, dtype=np.int64), held, where) for held, rows in nodes.items()]


def step_motion(
    deck: Outline,
    blocks: Sequence[Block],
    held: Iterable[Fixed],
    nodes: Registry,
    *,
    ramped: bool,
    amplitudes: Mapping[str, Amplitude],
) -> tuple[tuple[Fixed, ...], tuple[Prescribed, ...]]:
    """Dofs that a step holds and moves: those of the model data, changed by its *BOUNDARY lines.

    Parameters
    ----------
    held : of the model data.
    ramped : whether values without amplitude grow over the step.

    Raises
    ------
    InputError : unknown node, set, amplitude, TYPE or dof; a displacement that would jump.
    """
    motion = Motion()
    for fixed in held:
        motion.hold(fixed)
    if any(b.option("OP", "MOD") == "NEW" for b in blocks):
        motion.release()
    for block in blocks:
        _boundary(deck, block, motion, nodes, ramped, amplitudes)
    return motion.resolved()


def _boundary(
    deck: Outline, block: Block, motion: Motion, nodes: Registry, ramped: bool, amplitudes: Mapping[str, Amplitude]
) -> None:
    list_params(deck, block, "OP, TYPE, AMPLITUDE, REGION TYPE, FIXED")
    kind = block.option("TYPE", "DISPLACEMENT")
    if kind not in KINDS:
        raise block.error(f"*BOUNDARY has TYPE={kind}", expected=", ".join(KINDS), fix="Correct it.")
    amplitude = find_amplitude(amplitudes, block.get("AMPLITUDE"), block.where)
    absolute = bool(amplitude) and amplitudes[amplitude].absolute
    for fields, where in block.rows():
        rows, dofs, value = nodes.find(fields[0], "", where), *boundary_dofs(fields, where)
        if value is None or block.has("FIXED") or (value == 0.0 and not absolute and kind != "ACCELERATION"):
            motion.hold(Fixed(rows, dofs, where))
            continue
        if kind == "DISPLACEMENT" and not amplitude and not ramped:
            raise InputError(
                f"*BOUNDARY moves {fields[0]} by {value:g} at once",
                expected="an AMPLITUDE that starts at 0",
                where=where,
                fix="Give AMPLITUDE= on the *BOUNDARY line, or AMPLITUDE=RAMP on *STEP.",
            )
        for dof in dofs:
            factor = 1.0 if absolute else value
            motion.move(Prescribed(rows, dof, kind.lower(), factor, amplitude, fields[0].upper(), where))


def step_loads(
    deck: Outline, blocks: Iterable[Block], nodes: Registry, amplitudes: Mapping[str, Amplitude]
) -> tuple[PointLoad, ...]:
    """*CLOAD lines; several on one dof add up.

    Raises
    ------
    InputError : unknown node, set or amplitude, dof outside 1..6, not a number.
    """
    loads = []
    for block in blocks:
        list_params(deck, block, "OP, AMPLITUDE, REGION TYPE")
        amplitude = find_amplitude(amplitudes, block.get("AMPLITUDE"), block.where)
        for fields, where in block.rows():
            if len(fields) < 2:
                raise InputError(
                    f"*CLOAD line with {len(fields)} value(s)",
                    expected="node or set, dof, magnitude",
                    where=where,
                    fix="Correct the line.",
                )
            dof = to_dof(fields[1], where)
            value = to_float(fields[2] if len(fields) > 2 else "", where, "load")
            if amplitude and amplitudes[amplitude].absolute:
                value = 1.0
            rows = nodes.find(fields[0], "", where)
            loads.append(PointLoad(rows, dof, value, amplitude, fields[0].upper(), where))
    return tuple(loads)


def check_global(moved: Iterable[Prescribed], transforms: Transforms) -> None:
    """Prescribed motion is along global axes.

    Raises
    ------
    InputError : it is not, because its node has a *TRANSFORM.
    """
    for m in moved:
        if transforms.touched(m.nodes_idx):
            raise InputError(
                f"*BOUNDARY moves {m.name}, which has a *TRANSFORM",
                expected="motion along global axes",
                where=m.where,
                fix="Couple the nodes to a reference node without *TRANSFORM and move that one.",
            )


def along_global_axes(loads: Iterable[PointLoad], transforms: Transforms) -> tuple[PointLoad, ...]:
    """Loads on nodes with axes of their own, in global components."""
    result: list[PointLoad] = []
    for load in loads:
        turned = set(transforms.touched(load.nodes_idx))
        plain = np.array([n for n in load.nodes_idx.tolist() if n not in turned], dtype=np.int64)
        if plain.size:
            result.append(replace(load, nodes_idx=plain))
        for node in sorted(turned):
            for dof, share in transforms.terms(node, load.dof):
                one = np.array([node], dtype=np.int64)
                result.append(replace(load, nodes_idx=one, dof=dof, value=share * load.value))
    return tuple(result)
