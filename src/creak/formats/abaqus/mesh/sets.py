"""*NSET and *ELSET; *SURFACE of shell facets, solid faces, shell edges or nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.mesh.elements import TYPES, Elements
from creak.formats.abaqus.text.fields import Registry, label_list, lookup, positive, qualified, to_int, unique_in_order
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.model.faces import (
    FACES,
    N_CORNER,
    SHELL_FACETS,
    face_numbers,
    facet_areas,
    facets_of_shells,
    sides_of_shells,
)


def read_sets(deck: Outline, elements: Elements, nodes: Registry, element_names: Registry) -> None:
    """Add the sets of *ELSET and *NSET to the registries, in deck order.

    Raises
    ------
    InputError : unknown label, set or instance; a range that makes no sense.
    """
    for scope, block in deck.blocks("ELSET"):
        _read_set(deck, scope.name, block, element_names)
    for scope, block in deck.blocks("NSET"):
        if block.has("ELSET"):
            rows = element_names.find(block.need("ELSET"), _scope_of(deck, scope.name, block), block.where)
            nodes.add(scope.name, block.need("NSET"), [nodes_of(elements, rows)])
        else:
            _read_set(deck, scope.name, block, nodes)


def nodes_of(elements: Elements, rows: IntArray) -> IntArray:
    """Node rows of elements, each once, in order of appearance."""
    flat = elements.nodes_idx[rows].ravel()
    return unique_in_order(flat[flat >= 0])


def _scope_of(deck: Outline, scope: str, block: Block) -> str:
    """Scope in which the members of a set are looked up: INSTANCE= or its own."""
    name = block.get("INSTANCE").upper()
    if not name:
        return scope
    found = lookup({s: s for s in deck.instances}, name, "", deck.assembly)
    if found is None:
        raise block.error(f"unknown instance {name!r}", fix=suggest(name, deck.instances))
    return found


def _read_set(deck: Outline, scope: str, block: Block, registry: Registry) -> None:
    name = block.need(block.name)
    if block.has("INTERNAL"):
        registry.internal.add(name.upper())
    inside = _scope_of(deck, scope, block)
    if block.has("GENERATE"):
        members = [_generated(deck, block, f, where, registry, inside) for f, where in block.rows()]
    else:
        members = _listed(block, registry, inside)
    registry.add(scope, name, members)


def _listed(block: Block, registry: Registry, scope: str) -> list[IntArray]:
    labels = label_list(block)
    if labels is not None and scope in registry.labels:
        rows = registry.labels[scope].find(labels)
        if rows.min() >= 0:
            return [rows]
    return [registry.find(f, scope, where) for fields, where in block.rows() for f in fields if f]


def _generated(deck: Outline, block: Block, fields: list[str], where: str, registry: Registry, scope: str) -> IntArray:
    """Rows of `first, last[, step]`; labels of the range that do not exist are left out and listed."""
    if len(fields) not in (2, 3):
        raise InputError(
            f"a range of {len(fields)} numbers",
            expected="first, last[, step]",
            where=where,
            fix="Correct the line or remove GENERATE.",
        )
    first, last, step = (to_int(f, where, "range limit") for f in [*fields, "1"][:3])
    if step <= 0 or last < first or (last - first) % step or first <= 0:
        raise InputError(
            f"the range {first} to {last} in steps of {step} is empty or does not end on its last number",
            expected="0 < first <= last, a positive step, and last = first + a multiple of it",
            where=where,
            fix="Correct the range.",
        )
    labels = registry.labels.get(scope)
    rows = np.zeros(0, np.int64) if labels is None else labels.in_range(first, last, step)
    missing = (last - first) // step + 1 - rows.size
    if rows.size == 0:
        raise InputError(
            f"no {registry.what} has a label in the range {first} to {last}, step {step}",
            where=where,
            fix="Correct the range.",
        )
    if missing:
        why = f"{missing} of the labels {first} to {last}, step {step}, do not exist and are left out"
        deck.note(block, why, changes=False, what=f"*{block.name}, GENERATE")
    return rows


_SIDES = {"": 0, "SPOS": 1, "SNEG": -1, "POS": 1, "NEG": -1, "S1": -1, "S2": 1}
_EDGES = {"E1": 0, "E2": 1, "E3": 2, "E4": 3}
_FACES = {f"S{k}": k for k in range(1, 7)}
_NONE = np.zeros(0, dtype=np.int64)
IS_SHELL = np.array([t.kind in SHELL_FACETS for t in TYPES])
_IS_SOLID = np.array([t.kind in FACES for t in TYPES])


@dataclass(frozen=True)
class RawSurface:
    """A surface in rows of the element table."""

    name: str
    element_rows: IntArray
    """(n_facet,) shells and solids, those with several facets several times; empty for a surface of nodes or edges."""
    side: IntArray
    """(n_facet,) of shells +1, -1, or 0 for both sides; of solids the number 1 to 6 of the face."""
    nodes_idx: IntArray
    """(n_node,) all its nodes."""
    weights: FloatArray
    """(n_node,) tributary area of facets, tributary length of edges, or the factors of a node surface."""
    where: str
    edges: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    """(n_edge, 2) ends of the shell edges of a surface of edges."""
    corners: IntArray = field(default_factory=lambda: np.zeros((0, 4), dtype=np.int64))
    """(n_facet, 4) node rows of the facets; a triangle repeats its third node. Faces of solids look outward."""

    @property
    def named(self) -> tuple[IntArray, IntArray]:
        """Each element and side once, in order."""
        _, first = np.unique(np.column_stack([self.element_rows, self.side]), axis=0, return_index=True)
        return self.element_rows[np.sort(first)], self.side[np.sort(first)]


def read_surfaces(
    deck: Outline, coords: FloatArray, elements: Elements, nodes: Registry, element_names: Registry
) -> dict[str, RawSurface]:
    """Surfaces by qualified name.

    On shells SPOS (or S2, POS) is the positive side, SNEG (or S1, NEG) the negative one, no label both,
    and E1 to E4 are edges, which become a surface of nodes. On solids S1 to S6 are faces, no label all faces
    that no other solid of the deck shares.

    Raises
    ------
    InputError : unknown set, element, side or face, neither shell nor solid, facets and edges in one surface,
        name used twice.
    """
    result: dict[str, RawSurface] = {}
    for scope, block in deck.blocks("SURFACE"):
        kind = block.option("TYPE", "ELEMENT")
        if kind not in ("ELEMENT", "NODE"):
            deck.note(
                block,
                "creak reads surfaces of elements and of nodes",
                changes=True,
                what=f"*SURFACE, TYPE={kind}",
            )
            continue
        key = qualified(scope.name, block.need("NAME"))
        if key in result:
            raise block.twice(f"surface {key!r}", result[key].where, "Rename one of them.")
        if kind == "NODE":
            result[key] = _node_surface(key, scope, block, nodes)
        else:
            result[key] = _element_surface(key, scope, block, coords, elements, element_names)
        if result[key].nodes_idx.size == 0:
            raise block.error(f"surface {key!r} is empty", fix="Add data lines.")
    return result


def _node_surface(name: str, scope: Scope, block: Block, nodes: Registry) -> RawSurface:
    rows, weights = [np.zeros(0, np.int64)], [np.zeros(0)]
    for fields, where in block.rows():
        found = nodes.find(fields[0], scope.name, where)
        factor = positive(fields[1], where, "area of the node surface") if len(fields) > 1 else 1.0
        rows.append(found)
        weights.append(np.full(found.size, factor))
    all_rows, all_weights = np.concatenate(rows), np.concatenate(weights)
    _, first = np.unique(all_rows, return_index=True)
    first = np.sort(first)
    none = np.zeros(0, np.int64)
    return RawSurface(name, none, none, all_rows[first], all_weights[first], block.where)


def _element_surface(
    name: str, scope: Scope, block: Block, coords: FloatArray, elements: Elements, names: Registry
) -> RawSurface:
    facets: dict[int, list[IntArray]] = {}
    faces: list[IntArray] = [np.zeros((0, 2), np.int64)]
    edges: list[tuple[IntArray, int]] = []
    for fields, where in block.rows():
        label = fields[1].upper() if len(fields) > 1 else ""
        rows = _shells_and_solids(fields[0], scope, where, elements, names)
        solid = _IS_SOLID[elements.type_idx[rows]]
        shells = rows[~solid]
        if solid.any():
            faces.append(faces_named(rows[solid], label, where, elements))
        if not shells.size:
            continue
        if label in _EDGES:
            edges.append((shells, _EDGES[label]))
        elif label in _SIDES:
            facets.setdefault(_SIDES[label], []).append(shells)
        else:
            raise InputError(
                f"unknown side {label!r} of a shell",
                expected="SPOS, SNEG, nothing (both), or E1 to E4",
                where=where,
                fix="Correct the side.",
            )
    chosen = np.concatenate(faces)
    if edges and (facets or chosen.size):
        raise block.error(f"surface {name!r} has both facets and edges", fix="Make two surfaces of them.")
    if edges:
        return _edge_surface(name, block, coords, elements, edges)
    rows, side = _merged_sides(facets)
    _, first = np.unique(chosen, axis=0, return_index=True)
    chosen = chosen[np.sort(first)]
    rows, side = np.concatenate([rows, chosen[:, 0]]), np.concatenate([side, chosen[:, 1]])
    rows, side, corners = facets_of(elements, rows, side)
    nodes_idx, weights = tributary_areas(coords, corners)
    return RawSurface(name, rows, side, nodes_idx, weights, block.where, corners=corners)


def _shells_and_solids(token: str, scope: Scope, where: str, elements: Elements, names: Registry) -> IntArray:
    if not token:
        raise InputError(
            "a surface line without an element set",
            expected="element set or element, side",
            where=where,
            fix="Name the elements.",
        )
    rows = names.find(token, scope.name, where)
    fits = (IS_SHELL | _IS_SOLID)[elements.type_idx[rows]]
    if not fits.all():
        row = int(rows[int(np.argmin(fits))])
        raise InputError(
            f"element {elements.ids[row]} ({elements.of(row).name}) of {token!r} is not a shell or a solid",
            expected="shell or solid elements in a surface",
            where=where,
            fix="Leave it out, or make a node surface (TYPE=NODE).",
        )
    return rows


def faces_named(rows: IntArray, label: str, where: str, elements: Elements) -> IntArray:
    """(k, 2) element row and number of the face: the one that `label` names, or all free ones."""
    if not label:
        return _free(rows, elements)
    if label not in _FACES:
        raise InputError(
            f"unknown face {label!r} of a solid",
            expected="S1 to S6, or nothing (all free faces)",
            where=where,
            fix="Correct the face.",
        )
    facets = [np.flatnonzero(face_numbers(t.kind) == _FACES[label]) + 1 if t.kind in FACES else _NONE for t in TYPES]
    n_facets = np.array([f.size for f in facets])[elements.type_idx[rows]]
    if not n_facets.all():
        row = int(rows[int(np.argmin(n_facets))])
        raise InputError(
            f"element {elements.ids[row]} ({elements.of(row).name}) has no face {label}",
            where=where,
            fix="Correct the face.",
        )
    number = np.concatenate([_NONE, *(facets[t] for t in elements.type_idx[rows].tolist())])
    return np.column_stack([np.repeat(rows, n_facets), number]).astype(np.int64)


def _free(rows: IntArray, elements: Elements) -> IntArray:
    """Free faces of the solids among these elements, kind by kind."""
    found = [np.zeros((0, 2), dtype=np.int64)]
    for kind in FACES:
        mine = rows[np.array([t.kind == kind for t in TYPES])[elements.type_idx[rows]]]
        element, face = np.nonzero(elements.free_faces[mine])
        found.append(np.column_stack([mine[element], face + 1]))
    return np.concatenate(found)


def facets_of(elements: Elements, rows: IntArray, side: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Facets of shells, and faces number `side` of solids: rows, sides, (n, 4) node rows as of `RawSurface`."""
    count = np.array([len(SHELL_FACETS.get(t.kind, "1")) for t in TYPES])[elements.type_idx[rows]]
    number = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    rows, side = np.repeat(rows, count), np.repeat(side, count)
    table, of_type = elements.nodes_idx[rows], elements.type_idx[rows]
    corners = np.zeros((rows.size, 4), dtype=np.int64)
    for kind in (*SHELL_FACETS, *FACES):
        mine = np.flatnonzero(np.array([t.kind == kind for t in TYPES])[of_type])
        if kind in SHELL_FACETS:
            corners[mine] = facets_of_shells(kind, table[mine])[np.arange(mine.size), number[mine]] if mine.size else 0
        else:
            corners[mine] = np.take_along_axis(table[mine], np.array(FACES[kind])[side[mine] - 1], axis=1)
    return rows, side, corners


def _merged_sides(facets: Mapping[int, list[IntArray]]) -> tuple[IntArray, IntArray]:
    """Each element once, in order; an element named with both sides gets 0."""
    chunks = [(rows, side) for side, parts in facets.items() for rows in parts]
    if not chunks:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    rows = np.concatenate([r for r, _ in chunks])
    side = np.concatenate([np.full(r.size, s, np.int64) for r, s in chunks])
    unique, first, inverse = np.unique(rows, return_index=True, return_inverse=True)
    low, high = np.full(unique.size, 2), np.full(unique.size, -2)
    np.minimum.at(low, inverse, side)
    np.maximum.at(high, inverse, side)
    merged = np.where(low == high, low, 0)
    order = np.argsort(first)
    return unique[order], merged[order].astype(np.int64)


def tributary_areas(coords: FloatArray, corners: IntArray) -> tuple[IntArray, FloatArray]:
    """Nodes of facets and, at each, the sum of facet area / number of facet nodes."""
    area = facet_areas(coords[corners])
    real = np.ones(corners.shape, dtype=bool)
    real[:, 3] = corners[:, 3] != corners[:, 2]
    share = np.repeat((area / real.sum(axis=1))[:, None], 4, axis=1)
    return _summed(corners[real], share[real])


def _edge_surface(
    name: str, block: Block, coords: FloatArray, elements: Elements, edges: list[tuple[IntArray, int]]
) -> RawSurface:
    pairs, lengths = [], []
    for rows, edge in edges:
        for of_type in np.unique(elements.type_idx[rows]).tolist():
            kind, mine = TYPES[of_type], rows[elements.type_idx[rows] == of_type]
            if N_CORNER[kind.kind] <= edge:
                raise block.error(f"element {elements.ids[mine[0]]} has no edge E{edge + 1}", fix="Correct the edge.")
            pair = sides_of_shells(kind.kind, elements.nodes_idx[mine, : kind.n_nodes], edge).reshape(-1, 2)
            length = np.linalg.norm(coords[pair[:, 1]] - coords[pair[:, 0]], axis=1)
            pairs.append(pair)
            lengths.append(np.repeat(0.5 * length, 2))
    ends = np.concatenate(pairs)
    nodes_idx, weights = _summed(ends.ravel(), np.concatenate(lengths))
    none = np.zeros(0, np.int64)
    return RawSurface(name, none, none, nodes_idx, weights, block.where, ends)


def _summed(rows: IntArray, values: FloatArray) -> tuple[IntArray, FloatArray]:
    """Sum of values per row, rows in order of appearance."""
    nodes_idx = unique_in_order(rows)
    order = np.argsort(nodes_idx)
    at = order[np.searchsorted(nodes_idx, rows, sorter=order)] if rows.size else rows
    return nodes_idx, np.bincount(at, weights=values, minlength=nodes_idx.size).astype(np.float64)
