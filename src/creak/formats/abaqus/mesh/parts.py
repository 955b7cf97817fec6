"""Which part every node and element belongs to, and what the parts are called; by parts and sections the element
blocks, and the geometry checks of each."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError
from creak.formats.abaqus.mesh.elements import TYPES, Elements
from creak.formats.abaqus.sections.assigned import Assigned
from creak.formats.abaqus.text.fields import Registry
from creak.formats.abaqus.text.outline import Outline
from creak.formats.deck.parts import Rows, number_pieces, number_points, stars
from creak.model.constraints import Constraint, DistributingCoupling, KinematicCoupling, RigidLink
from creak.model.faces import N_CORNER, SHELL_FACETS
from creak.model.materials import AxialSpring, BeamSection, NodalMatrices
from creak.model.mesh import ElementBlock, Nodes, Own, Part

_HAS_MASS = np.array([t.kind in ("mass", "rotary") for t in TYPES])


@dataclass(frozen=True)
class Partition:
    """Parts, and the part of every element."""

    parts: tuple[Part, ...]
    element_part: IntArray
    """(n_elem,) rows into `parts`, -1 for elements between parts."""


def read_parts(
    deck: Outline, nodes: Nodes, elements: Elements, names: Registry, constraints: list[Constraint]
) -> Partition:
    """Find the parts.

    Every instance with elements is a part. In a flat deck (and for structure at assembly level) the
    connected pieces of shells, beams and trusses are the parts. Nodes outside the structure join the part
    they are coupled or linked to, when it is one part. What is left and carries masses or springs makes
    parts of its own, one per connected group.
    """
    node_part = np.full(nodes.count, -1, dtype=np.int64)
    titles, aliases = _instance_parts(deck, nodes, elements, node_part)
    n_instances = len(titles)
    n_structural = _structural_parts(elements, node_part, n_instances)
    attach(node_part, constraints)
    n_parts = _point_parts(elements, constraints, node_part, n_structural)
    # Part of all nodes of each element, -1 when they lie in different parts.
    table = elements.nodes_idx
    first = node_part[table[:, 0]]
    same = (np.where(table >= 0, node_part[table], first[:, None]) == first[:, None]).all(axis=1)
    element_part = np.where(same, first, -1)
    named = _element_set_names(elements, element_part, names, n_instances, n_structural, n_parts)
    taken = {*titles, *(n for n in named if n)}
    count = 0
    for name in named:
        if not name:
            count += 1
            while f"PART-{count}" in taken:
                count += 1
            name = f"PART-{count}"
        titles.append(name)
        aliases.append(())
    rows = [np.flatnonzero(node_part == p) for p in range(n_parts)]
    parts = tuple(Part(t, r, a) for t, r, a in zip(titles, rows, aliases, strict=True))
    return Partition(parts, element_part)


def _instance_parts(
    deck: Outline, nodes: Nodes, elements: Elements, node_part: IntArray
) -> tuple[list[str], list[tuple[str, ...]]]:
    """Names and other names of the instances that are parts; fills `node_part`."""
    titles: list[str] = []
    aliases: list[tuple[str, ...]] = []
    used = [s.part for s in deck.scopes]
    instance_names = {s.name for s in deck.scopes}
    for k, scope in enumerate(deck.scopes):
        if not scope.name or not (elements.scope_idx == k).any():
            continue
        node_part[nodes.instance_idx == k] = len(titles)
        titles.append(scope.name)
        single = used.count(scope.part) == 1 and scope.part not in instance_names
        aliases.append((scope.part,) if single else ())
    return titles, aliases


def _structural_parts(elements: Elements, node_part: IntArray, n_parts: int) -> int:
    """Number the connected pieces of structure outside the instances; returns the number of parts."""
    table = elements.nodes_idx
    outside = elements.structural & (node_part[table[:, 0]] < 0)
    table = table[outside]
    start, end = stars(table)
    inside = (node_part[start] < 0) & (node_part[end] < 0)
    return number_pieces(np.unique(table[table >= 0]), start[inside], end[inside], table[:, 0], node_part, n_parts)


def attach(node_part: IntArray, constraints: list[Constraint]) -> None:
    """Give unassigned nodes the part they are coupled or linked to, when that is a single one.

    Reference nodes come first: one whose coupled nodes all lie in one part belongs to it. Then nodes
    that hang on an assigned node. Repeated until nothing changes.
    """
    couplings = [c for c in constraints if isinstance(c, KinematicCoupling | DistributingCoupling)]
    links = [c for c in constraints if isinstance(c, RigidLink)]
    changed = True
    while changed:
        changed = False
        for c in couplings:
            parts = node_part[c.nodes_idx]
            if node_part[c.ref_idx] < 0 and parts[0] >= 0 and (parts == parts[0]).all():
                node_part[c.ref_idx] = parts[0]
                changed = True
        if not changed:
            changed = _attach_hanging(node_part, couplings, links)


def _attach_hanging(
    node_part: IntArray, couplings: list[KinematicCoupling | DistributingCoupling], links: list[RigidLink]
) -> bool:
    wanted: dict[int, set[int]] = {}
    for c in couplings:
        for node in c.nodes_idx[node_part[c.nodes_idx] < 0]:
            wanted.setdefault(int(node), set()).add(int(node_part[c.ref_idx]))
    for link in links:
        for a, b in ((link.dependent_idx, link.independent_idx), (link.independent_idx, link.dependent_idx)):
            if node_part[a] < 0:
                wanted.setdefault(a, set()).add(int(node_part[b]))
    found = {node: next(iter(p - {-1})) for node, p in wanted.items() if len(p - {-1}) == 1}
    for node, part in found.items():
        node_part[node] = part
    return bool(found)


def _point_parts(elements: Elements, constraints: list[Constraint], node_part: IntArray, n_parts: int) -> int:
    """Number the connected groups of leftover nodes that carry masses or springs (`deck.parts.number_points`)."""
    points = ~elements.structural & ~elements.of_kinds(("gap2",))
    table = elements.nodes_idx[points]
    pairs = [(c.dependent_idx, c.independent_idx) for c in constraints if isinstance(c, RigidLink)]
    links = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    heavy = elements.nodes_idx[points & _HAS_MASS[elements.type_idx], 0]
    return number_points(Rows.of_table(table), links, heavy, node_part, n_parts, order=table[:, 0])


def _element_set_names(
    elements: Elements, element_part: IntArray, names: Registry, first: int, n_structural: int, n_parts: int
) -> list[str]:
    """Names of parts `first` onwards: the smallest element set that holds all of it and no other, or ""."""
    counted: BoolArray = elements.structural | (element_part >= n_structural)
    sizes = np.bincount(element_part[counted & (element_part >= 0)], minlength=n_parts)
    best: dict[int, tuple[bool, int, str]] = {}
    for name, rows in names.sets.items():
        parts = element_part[rows]
        inside = parts[parts >= 0]
        if inside.size == 0 or (inside != inside[0]).any():
            continue
        part = int(inside[0])
        if np.count_nonzero(counted[rows] & (parts >= 0)) == sizes[part]:
            internal = name in names.internal or name.startswith("_")
            entry = (internal, int(rows.size), name)
            if part not in best or entry[:2] < best[part][:2]:
                best[part] = entry
    return [best[p][2] if p in best else "" for p in range(first, n_parts)]


_KINDS = tuple(dict.fromkeys(t.kind for t in TYPES))
_KIND_OF_TYPE = np.array([_KINDS.index(t.kind) for t in TYPES])
_N_NODES = {t.kind: t.n_nodes for t in TYPES}
_SMALL = 1e-12
"""Relative size below which a length, area or angle counts as zero."""


@dataclass(frozen=True)
class Blocks:
    """Element blocks, and where each row of the element table went."""

    blocks: tuple[ElementBlock, ...]
    place: IntArray
    """(n_elem, 2) row into `blocks`, row in that block; -1 for gaps, which are stops and no structure."""


def make_blocks(elements: Elements, assigned: Assigned, partition: Partition, coords: FloatArray) -> Blocks:
    """Split the elements so that each block has one kind, section and part, in deck order.

    Raises
    ------
    InputError : an element of zero length or area, a beam along its own axis 1.
    """
    kinds = _KIND_OF_TYPE[elements.type_idx]
    keys = np.stack([kinds, assigned.section_idx, partition.element_part], axis=1)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    inverse = inverse.reshape(-1)
    place = np.full((elements.ids.size, 2), -1, dtype=np.int64)
    blocks: list[ElementBlock] = []
    by_group = np.argsort(inverse, kind="stable")
    bounds = np.searchsorted(inverse[by_group], np.arange(first.size + 1))
    for group in np.argsort(first):
        rows = by_group[bounds[group] : bounds[group + 1]]
        if elements.of(int(rows[0])).kind == "gap2":
            continue
        block = _block(elements, rows, assigned, partition)
        _check_geometry(block, elements, rows, coords)
        place[rows, 0] = len(blocks)
        place[rows, 1] = np.arange(rows.size)
        blocks.append(block)
    return Blocks(tuple(blocks), place)


def _block(elements: Elements, rows: IntArray, assigned: Assigned, partition: Partition) -> ElementBlock:
    row = int(rows[0])
    kind, section = elements.of(row).kind, assigned.sections[int(assigned.section_idx[row])]
    formulation = kind
    if isinstance(section, NodalMatrices):
        formulation = f"nodal{_N_NODES[kind]}"
    elif isinstance(section, AxialSpring):
        formulation = "axial2"
    return ElementBlock(
        formulation,
        elements.ids[rows],
        elements.nodes_idx[rows, : _N_NODES[kind]],
        section,
        int(partition.element_part[row]),
        elements.where(row),
        _corners_only(assigned.own_of(rows), _N_NODES[kind]),
    )


def _corners_only(own: Own, n_node: int) -> Own:
    return own if own.thickness is None else replace(own, thickness=own.thickness[:, :n_node])


def _check_geometry(block: ElementBlock, elements: Elements, rows: IntArray, coords: FloatArray) -> None:
    corner = coords[block.nodes_idx]
    if block.kind == "beam3":
        halves = np.diff(corner, axis=1)
        back = np.einsum("ni,ni->n", halves[:, 0], halves[:, 1]) < 0.0
        _refuse(back, "goes back on itself: its second node is the one in the middle", elements, rows)
        for half in ([0, 1], [1, 2]):
            _check_geometry(replace(block, kind="beam2", nodes_idx=block.nodes_idx[:, half]), elements, rows, coords)
    elif block.kind in ("beam2", "truss2", "axial2"):
        along = corner[:, 1] - corner[:, 0]
        size = np.linalg.norm(along, axis=1)
        _refuse(size <= _SMALL * np.abs(corner).max(), "has zero length", elements, rows)
        if isinstance(block.section, BeamSection):
            axis = np.array(block.section.axis1) if block.own.axis1 is None else block.own.axis1
            across = np.linalg.norm(np.cross(along, axis), axis=1)
            parallel = across <= 1e-6 * size * np.linalg.norm(axis, axis=-1)
            _refuse(parallel, "lies along the direction of its section axis 1", elements, rows)
    elif block.kind in SHELL_FACETS:
        corner = corner[:, : N_CORNER[block.kind]]
        diagonals = (corner[:, 2] - corner[:, 0], corner[:, -1] - corner[:, 1])
        if N_CORNER[block.kind] == 3:
            diagonals = (corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        lengths = [np.linalg.norm(d, axis=1) for d in diagonals]
        size = lengths[0] * lengths[0] + lengths[1] * lengths[1]
        area = np.linalg.norm(np.cross(*diagonals), axis=1)
        _refuse(area <= _SMALL * size, "has zero area", elements, rows)


def _refuse(bad: np.ndarray, problem: str, elements: Elements, rows: IntArray) -> None:
    if bad.any():
        row = int(rows[int(np.argmax(bad))])
        raise InputError(
            f"element {elements.ids[row]} ({elements.of(row).name}) {problem}",
            where=elements.where(row),
            fix="Check the coordinates and the order of its nodes, and its section.",
        )
