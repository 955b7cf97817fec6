"""*COUPLING, *KINEMATIC COUPLING, *DISTRIBUTING COUPLING and *RIGID BODY."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.mesh.directions import Transforms
from creak.formats.abaqus.mesh.elements import Elements
from creak.formats.abaqus.mesh.sets import RawSurface, nodes_of
from creak.formats.abaqus.sections.orientations import Orientations, constant_axes
from creak.formats.abaqus.text.fields import Registry, dof_range, lookup, positive, unique_in_order, with_short_names
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.model.constraints import Constraint, DistributingCoupling, Equation, KinematicCoupling, on_a_line


def read_couplings(
    deck: Outline,
    surfaces: dict[str, RawSurface],
    elements: Elements,
    nodes: Registry,
    element_names: Registry,
    place: Placement,
) -> list[Constraint]:
    """All couplings and rigid bodies.

    Raises
    ------
    InputError : unknown reference node, set or surface; more than one reference node; nothing coupled.
    """
    result: list[Constraint] = []
    for scope, block in deck.blocks("COUPLING"):
        result += _coupling(deck, scope, block, surfaces, nodes, place, elements)
    for scope, block in deck.blocks("KINEMATIC COUPLING"):
        for found in _kinematic_coupling(scope, block, nodes):
            result += _along_axes(found, constant_axes(deck, scope, block, place.orientations), place)
            if place.transforms.touched(found.nodes_idx) and any(
                0 < len(set(g) & set(found.dofs)) < 3 for g in ((1, 2, 3), (4, 5, 6))
            ):
                why = "creak takes its directions as global, though some of its nodes have a *TRANSFORM"
                deck.note(block, why, changes=True, what=f"*{block.name} on transformed nodes")
    for scope, block in deck.blocks("DISTRIBUTING COUPLING"):
        result += _distributing_elements(scope, block, elements, nodes, element_names)
    for scope, block in deck.blocks("RIGID BODY"):
        result += _rigid_body(deck, scope, block, elements, nodes, element_names)
    return result


@dataclass(frozen=True, eq=False)
class Placement:
    """Where nodes are and along which axes their dofs and orientations lie."""

    coords: FloatArray
    orientations: Orientations
    transforms: Transforms


def _along_axes(c: KinematicCoupling, frame: FloatArray | None, place: Placement) -> list[Constraint]:
    """The coupling, or equations where it holds one or two directions along axes that are not global.

    e . (u - u_ref - theta_ref x r) = 0 and e . (theta - theta_ref) = 0 for each listed direction e.
    """
    partial = [g for g in ((1, 2, 3), (4, 5, 6)) if 0 < len(set(g) & set(c.dofs)) < 3]
    if frame is None or not partial:
        return [c]
    result: list[Constraint] = []
    whole = tuple(d for d in c.dofs if all(d not in g for g in partial))
    if whole:
        result.append(replace(c, dofs=whole))
    for node in c.nodes_idx.tolist():
        lever = place.coords[node] - place.coords[c.ref_idx]
        for dof in (d for g in partial for d in g if d in c.dofs):
            result.append(_one_direction(node, c.ref_idx, frame[(dof - 1) % 3], lever, dof > 3, c.where))
    return result


def _one_direction(node: int, ref: int, e: FloatArray, lever: FloatArray, turn: bool, where: str) -> Equation:
    base = 4 if turn else 1
    order = np.argsort(-np.abs(e), kind="stable")
    terms = [(node, base + int(k), float(e[k])) for k in order] + [(ref, base + k, -float(e[k])) for k in range(3)]
    if not turn:
        terms += [(ref, 4 + k, -float(v)) for k, v in enumerate(np.cross(lever, e))]
    kept = [t for t in terms if abs(t[2]) > 1e-14]
    nodes_idx, dofs = (np.array([t[k] for t in kept], dtype=np.int64) for k in (0, 1))
    return Equation(nodes_idx, dofs, np.array([t[2] for t in kept]), where)


def _distributing_elements(
    scope: Scope, block: Block, elements: Elements, nodes: Registry, element_names: Registry
) -> list[Constraint]:
    """The node of each DCOUP3D element follows the weighted mean of the nodes on the data lines."""
    coupled: list[IntArray] = []
    weights: list[FloatArray] = []
    for fields, where in block.rows():
        rows = nodes.find(fields[0], scope.name, where)
        coupled.append(rows)
        weight = positive(fields[1], where, "weight of the coupling") if len(fields) > 1 and fields[1] else 1.0
        weights.append(np.full(rows.size, weight))
    result: list[Constraint] = []
    for element in element_names.find(block.need("ELSET"), scope.name, block.where).tolist():
        ref = int(elements.nodes_idx[element, 0])
        rows, first = np.unique(np.concatenate([np.zeros(0, np.int64), *coupled]), return_index=True)
        share = np.concatenate([np.zeros(0), *weights])[first]
        keep = rows != ref
        if not keep.any():
            raise block.error(
                "*DISTRIBUTING COUPLING names no nodes",
                expected="node or set, weight",
                fix="Name the nodes that carry the load.",
            )
        result.append(
            DistributingCoupling(block.get("ELSET"), ref, rows[keep], share[keep], (1, 2, 3, 4, 5, 6), block.where)
        )
    return result


def reference_node(scope: Scope, block: Block, nodes: Registry, key: str = "REF NODE") -> int:
    """Row of REF NODE= or another key, a label or a set of one node.

    Raises
    ------
    InputError : unknown, or more than one node.
    """
    token = block.need(key)
    try:
        rows = nodes.find(token, scope.name, block.where)
    except InputError as error:
        raise block.error(
            f"{key}= of *{block.name}: {error.what}",
            expected=f"{key}= a node or a set of one node",
            fix=error.fix,
        ) from None
    if rows.size != 1:
        raise block.error(
            f"{key}={token} is a set of {rows.size} nodes",
            expected="one node",
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
        raise block.error(f"*{block.name} couples no node but its reference node", fix="Couple other nodes to it.")
    return rest


def _coupling(
    deck: Outline,
    scope: Scope,
    block: Block,
    surfaces: dict[str, RawSurface],
    nodes: Registry,
    place: Placement,
    elements: Elements,
) -> list[Constraint]:
    ref_idx = reference_node(scope, block, nodes)
    name = block.get("CONSTRAINT NAME") or block.get("SURFACE")
    surface = lookup(surfaces, block.need("SURFACE"), scope.name, deck.assembly)
    if surface is None:
        raise block.error(
            f"*COUPLING on unknown surface {block.get('SURFACE')!r}",
            fix=suggest(block.get("SURFACE"), with_short_names(surfaces, deck.instances)),
        )
    if len(block.options) != 1:
        raise block.error(
            f"*COUPLING is followed by {len(block.options)} of *KINEMATIC and *DISTRIBUTING",
            expected="one of the two",
            fix="Say which kind of coupling it is.",
        )
    option = block.options[0]
    dofs = _listed_dofs(option)
    frame = constant_axes(deck, scope, block, place.orientations)
    near = _within_radius(surface.nodes_idx, ref_idx, block, place)
    coupled = _others(surface.nodes_idx[near], ref_idx, block)
    if option.name == "KINEMATIC":
        return _along_axes(KinematicCoupling(name, ref_idx, coupled, dofs, block.where), frame, place)
    _note_weighting(deck, option, turn=elements.turn(coupled))
    if frame is not None and any(0 < len(set(g) & set(dofs)) < 3 for g in ((1, 2, 3), (4, 5, 6))):
        deck.note(
            block,
            "creak takes the dofs of distributing couplings as global",
            changes=True,
            what="*DISTRIBUTING along other axes",
        )
    weights = surface.weights[near & (surface.nodes_idx != ref_idx)]
    if not 0.0 < float(weights.sum()) < np.inf:
        raise block.error(f"surface {surface.name!r} has no area", fix="Check its elements.")
    line = on_a_line(place.coords[coupled])
    if line and coupled.size > 1:
        why = "its nodes lie on a line: it passes no moment about that line, as in Abaqus"
        deck.note(option, why, changes=False, what=f"*DISTRIBUTING {name} on a line")
    return [DistributingCoupling(name, ref_idx, coupled, weights, dofs, block.where, turns_on_line=line)]


def _within_radius(rows: IntArray, ref_idx: int, block: Block, place: Placement) -> BoolArray:
    """Mask of the nodes within INFLUENCE RADIUS of the reference node; all without it."""
    radius = np.inf
    if block.has("INFLUENCE RADIUS"):
        radius = positive(block.get("INFLUENCE RADIUS"), block.where, "INFLUENCE RADIUS")
    distance = np.linalg.norm(place.coords[rows] - place.coords[ref_idx], axis=1)
    return np.asarray(distance <= radius * (1.0 + 1e-9), dtype=np.bool_)


def _listed_dofs(option: Block) -> tuple[int, ...]:
    """Union of the `first, last` lines; all six when there are none."""
    dofs: set[int] = set()
    for fields, where in option.rows():
        dofs.update(dof_range(fields, where))
    return tuple(sorted(dofs)) or (1, 2, 3, 4, 5, 6)


def _note_weighting(deck: Outline, option: Block, *, turn: bool) -> None:
    """`turn` tells whether the coupled nodes have rotations, which COUPLING=STRUCTURAL would couple too."""
    if option.option("WEIGHTING METHOD", "UNIFORM") != "UNIFORM":
        deck.note(
            option,
            "creak weights by area only, not by distance",
            changes=True,
            what="*DISTRIBUTING, WEIGHTING METHOD",
        )
    for parameter in ("COUPLING", "ROTATIONAL COUPLING"):
        if option.option(parameter, "CONTINUUM") != "CONTINUUM":
            why = (
                "no published source tells how rotations of the coupled nodes are weighed against their displacements;"
                f" without {parameter} creak couples the displacements alone"
            )
            deck.note(
                option,
                why if turn else "the coupled nodes have no rotations: the same as CONTINUUM",
                changes=turn,
                what=f"*DISTRIBUTING, {parameter}=STRUCTURAL",
            )


def _kinematic_coupling(scope: Scope, block: Block, nodes: Registry) -> list[KinematicCoupling]:
    """One coupling for each set of dofs that the data lines name."""
    ref_idx = reference_node(scope, block, nodes)
    groups: dict[tuple[int, ...], list[IntArray]] = {}
    for fields, where in block.rows():
        dofs = dof_range(fields[1:3], where)
        groups.setdefault(dofs, []).append(nodes.find(fields[0], scope.name, where))
    if not groups:
        raise block.error(
            "*KINEMATIC COUPLING has no data line",
            expected="node or set, first dof, last dof",
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
    """Kinematic couplings: ELSET, TIE NSET and CalculiX's NSET in all dofs, PIN NSET in the displacements.

    The displacements of CalculiX's ROT NODE are the rotations of the reference node: u_rot = theta_ref.
    """
    ref_idx = reference_node(scope, block, nodes)
    if block.option("POSITION", "INPUT") != "INPUT":
        deck.note(block, "creak leaves the reference node where it is", changes=True, what="*RIGID BODY, POSITION")
    tied: list[IntArray] = []
    if block.has("ELSET"):
        tied.append(nodes_of(elements, element_names.find(block.need("ELSET"), scope.name, block.where)))
    tied += [nodes.find(block.need(k), scope.name, block.where) for k in ("TIE NSET", "NSET") if block.has(k)]
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
        raise block.error(
            "*RIGID BODY names no nodes", expected="ELSET=, TIE NSET= or PIN NSET=", fix="Name what is rigid."
        )
    if block.has("ROT NODE"):
        turning = reference_node(scope, block, nodes, "ROT NODE")
        if turning == ref_idx or any(turning in c.nodes for c in result):
            raise block.error(
                f"ROT NODE={block.get('ROT NODE')} of *RIGID BODY is the reference node or a node of the body",
                expected="a node of its own, whose displacements are the rotations of the body",
                fix="Name another node, or leave ROT NODE out.",
            )
        pair = np.array([turning, ref_idx])
        result += [Equation(pair, np.array([k, k + 3]), np.array([1.0, -1.0]), block.where) for k in (1, 2, 3)]
    return result
