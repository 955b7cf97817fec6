"""*COUPLING, *KINEMATIC COUPLING and *RIGID BODY."""

from __future__ import annotations

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.elements import Elements
from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.names import Registry, lookup, unique_in_order, with_short_names
from creak.formats.abaqus.numbers import dof_range
from creak.formats.abaqus.outline import Outline, Scope
from creak.formats.abaqus.sets import nodes_of
from creak.formats.abaqus.surfaces import RawSurface
from creak.model.constraints import Constraint, DistributingCoupling, KinematicCoupling


def read_couplings(
    deck: Outline,
    surfaces: dict[str, RawSurface],
    elements: Elements,
    nodes: Registry,
    element_names: Registry,
) -> list[Constraint]:
    """All couplings and rigid bodies.

    Raises
    ------
    InputError : unknown reference node, set or surface; more than one reference node; nothing coupled.
    """
    result: list[Constraint] = []
    for scope, block in deck.blocks("COUPLING"):
        result.append(_coupling(deck, scope, block, surfaces, nodes))
        note_rotated(deck, scope, block)
    for scope, block in deck.blocks("KINEMATIC COUPLING"):
        result += _kinematic_coupling(scope, block, nodes)
        note_rotated(deck, scope, block)
    for scope, block in deck.blocks("RIGID BODY"):
        result += _rigid_body(deck, scope, block, elements, nodes, element_names)
    return result


def reference_node(scope: Scope, block: Block, nodes: Registry) -> int:
    """Row of REF NODE=, a label or a set of one node.

    Raises
    ------
    InputError : unknown, or more than one node.
    """
    token = block.need("REF NODE")
    try:
        rows = nodes.find(token, scope.name, block.where)
    except InputError as error:
        raise InputError(
            f"reference node of *{block.name}: {error.what}",
            expected="REF NODE= a node or a set of one node",
            where=block.where,
            fix=error.fix,
        ) from None
    if rows.size != 1:
        raise InputError(
            f"REF NODE={token} is a set of {rows.size} nodes",
            expected="one node",
            where=block.where,
            fix="Name a node, or a set of one node.",
        )
    return int(rows[0])


def note_rotated(deck: Outline, scope: Scope, block: Block) -> None:
    """List a keyword with directions inside a rotated instance: creak takes them as global."""
    if scope.rotated:
        why = f"creak takes its directions as global, though instance {scope.name!r} is rotated"
        deck.note(block, why, changes=True, what=f"*{block.name} in a rotated instance")


def _others(rows: IntArray, ref_idx: int, block: Block) -> IntArray:
    rest = unique_in_order(rows[rows != ref_idx])
    if rest.size == 0:
        raise InputError(
            f"*{block.name} couples no node but its reference node",
            where=block.where,
            fix="Couple other nodes to it.",
        )
    return rest


def _coupling(
    deck: Outline, scope: Scope, block: Block, surfaces: dict[str, RawSurface], nodes: Registry
) -> Constraint:
    ref_idx = reference_node(scope, block, nodes)
    name = block.get("CONSTRAINT NAME") or block.get("SURFACE")
    surface = lookup(surfaces, block.need("SURFACE"), scope.name, deck.assembly)
    if surface is None:
        raise InputError(
            f"*COUPLING on unknown surface {block.get('SURFACE')!r}",
            where=block.where,
            fix=suggest(block.get("SURFACE"), with_short_names(surfaces)),
        )
    if len(block.options) != 1:
        raise InputError(
            f"*COUPLING is followed by {len(block.options)} of *KINEMATIC and *DISTRIBUTING",
            expected="one of the two",
            where=block.where,
            fix="Say which kind of coupling it is.",
        )
    option = block.options[0]
    dofs = _listed_dofs(option)
    coupled = _others(surface.nodes_idx, ref_idx, block)
    if option.name == "KINEMATIC":
        return KinematicCoupling(name, ref_idx, coupled, dofs, block.where)
    _note_weighting(deck, option)
    weights = surface.weights[surface.nodes_idx != ref_idx]
    if not 0.0 < float(weights.sum()) < np.inf:
        raise InputError(
            f"surface {surface.name!r} has no area", where=block.where, fix="Check its elements."
        )
    return DistributingCoupling(name, ref_idx, coupled, weights, dofs, block.where)


def _listed_dofs(option: Block) -> tuple[int, ...]:
    """Union of the `first, last` lines; all six when there are none."""
    dofs: set[int] = set()
    for fields, where in option.rows():
        dofs.update(dof_range(fields, where))
    return tuple(sorted(dofs)) or (1, 2, 3, 4, 5, 6)


def _note_weighting(deck: Outline, option: Block) -> None:
    if option.option("WEIGHTING METHOD", "UNIFORM") != "UNIFORM":
        deck.note(
            option,
            "creak weights by area only, not by distance",
            changes=True,
            what="*DISTRIBUTING, WEIGHTING METHOD",
        )
    if option.option("COUPLING", "CONTINUUM") != "CONTINUUM":
        deck.note(
            option,
            "creak does not couple rotations of the coupled nodes",
            changes=True,
            what="*DISTRIBUTING, COUPLING=STRUCTURAL",
        )


def _kinematic_coupling(scope: Scope, block: Block, nodes: Registry) -> list[Constraint]:
    """One coupling for each set of dofs that the data lines name."""
    ref_idx = reference_node(scope, block, nodes)
    groups: dict[tuple[int, ...], list[IntArray]] = {}
    for fields, where in block.rows():
        dofs = dof_range(fields[1:3], where)
        groups.setdefault(dofs, []).append(nodes.find(fields[0], scope.name, where))
    if not groups:
        raise InputError(
            "*KINEMATIC COUPLING has no data line",
            expected="node or set, first dof, last dof",
            where=block.where,
            fix="Name the coupled nodes.",
        )
    name = f"KINEMATIC-{block.get('REF NODE')}"
    return [
        KinematicCoupling(name, ref_idx, _others(np.concatenate(rows), ref_idx, block), dofs, block.where)
        for dofs, rows in groups.items()
    ]


def _rigid_body(
    deck: Outline, scope: Scope, block: Block, elements: Elements, nodes: Registry, element_names: Registry
) -> list[Constraint]:
    """Kinematic couplings: ELSET and TIE NSET in all dofs, PIN NSET in the displacements."""
    ref_idx = reference_node(scope, block, nodes)
    if block.option("POSITION", "INPUT") != "INPUT":
        deck.note(
            block, "creak leaves the reference node where it is", changes=True, what="*RIGID BODY, POSITION"
        )
    tied: list[IntArray] = []
    if block.has("ELSET"):
        tied.append(nodes_of(elements, element_names.find(block.need("ELSET"), scope.name, block.where)))
    if block.has("TIE NSET"):
        tied.append(nodes.find(block.need("TIE NSET"), scope.name, block.where))
    result: list[Constraint] = []
    name = f"RIGID-{block.get('REF NODE')}"
    pinned = np.zeros(0, np.int64)
    if block.has("PIN NSET"):
        pinned = nodes.find(block.need("PIN NSET"), scope.name, block.where)
        coupled = _others(pinned, ref_idx, block)
        result.append(KinematicCoupling(name, ref_idx, coupled, (1, 2, 3), block.where))
    if tied:
        rows = np.concatenate(tied)
        coupled = _others(rows[~np.isin(rows, pinned)], ref_idx, block)
        result.append(KinematicCoupling(name, ref_idx, coupled, (1, 2, 3, 4, 5, 6), block.where))
    if not result:
        raise InputError(
            "*RIGID BODY names no nodes",
            expected="ELSET=, TIE NSET= or PIN NSET=",
            where=block.where,
            fix="Name what is rigid.",
        )
    return result
