"""*SURFACE of element facets, shell edges or nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.abaqus.elements import TYPES, Elements
from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.names import Registry, qualified, unique_in_order
from creak.formats.abaqus.numbers import positive
from creak.formats.abaqus.outline import Outline, Scope

_SIDES = {"": 0, "SPOS": 1, "SNEG": -1, "POS": 1, "NEG": -1, "S1": -1, "S2": 1}
_EDGES = {"E1": 0, "E2": 1, "E3": 2, "E4": 3}
_SHELL_KINDS = {"quad4": 4, "tri3": 3}


@dataclass(frozen=True)
class RawSurface:
    """A surface in rows of the element table."""

    name: str
    element_rows: IntArray
    """(n_facet,) shells; empty for a surface of nodes or edges."""
    side: IntArray
    """(n_facet,) +1, -1, or 0 for both sides."""
    nodes_idx: IntArray
    """(n_node,) all its nodes."""
    weights: FloatArray
    """(n_node,) tributary area of facets, tributary length of edges, or the factors of a node surface."""
    where: str
    edges: IntArray = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    """(n_edge, 2) ends of the shell edges of a surface of edges."""


def read_surfaces(
    deck: Outline, coords: FloatArray, elements: Elements, nodes: Registry, element_names: Registry
) -> dict[str, RawSurface]:
    """Surfaces by qualified name.

    On shells SPOS (or S2, POS) is the positive side, SNEG (or S1, NEG) the negative one, no label both,
    and E1 to E4 are edges, which become a surface of nodes.

    Raises
    ------
    InputError : unknown set, element or side, not a shell, facets and edges in one surface, name used twice.
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
            raise InputError(
                f"surface {key!r} is defined twice, first at {result[key].where}",
                where=block.where,
                fix="Rename one of them.",
            )
        if kind == "NODE":
            result[key] = _node_surface(key, scope, block, nodes)
        else:
            result[key] = _element_surface(key, scope, block, coords, elements, element_names)
        if result[key].nodes_idx.size == 0:
            raise InputError(f"surface {key!r} is empty", where=block.where, fix="Add data lines.")
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
    edges: list[tuple[IntArray, int]] = []
    for fields, where in block.rows():
        label = fields[1].upper() if len(fields) > 1 else ""
        rows = _shells(fields[0], scope, where, elements, names)
        if label in _EDGES:
            edges.append((rows, _EDGES[label]))
        elif label in _SIDES:
            facets.setdefault(_SIDES[label], []).append(rows)
        else:
            raise InputError(
                f"unknown side {label!r} of a shell",
                expected="SPOS, SNEG, nothing (both), or E1 to E4",
                where=where,
                fix="Correct the side.",
            )
    if facets and edges:
        raise InputError(
            f"surface {name!r} has both facets and edges", where=block.where, fix="Make two surfaces of them."
        )
    if edges:
        return _edge_surface(name, block, coords, elements, edges)
    rows, side = _merged_sides(facets)
    nodes_idx, weights = _tributary_areas(coords, elements, rows)
    return RawSurface(name, rows, side, nodes_idx, weights, block.where)


def _shells(token: str, scope: Scope, where: str, elements: Elements, names: Registry) -> IntArray:
    if not token:
        raise InputError(
            "a surface line without an element set",
            expected="element set or element, side",
            where=where,
            fix="Name the elements.",
        )
    rows = names.find(token, scope.name, where)
    is_shell = np.array([t.kind in _SHELL_KINDS for t in TYPES])[elements.type_idx[rows]]
    if not is_shell.all():
        row = int(rows[int(np.argmin(is_shell))])
        raise InputError(
            f"element {elements.ids[row]} ({elements.of(row).name}) of {token!r} is not a shell",
            expected="shell elements in a surface",
            where=where,
            fix="Leave it out, or make a node surface (TYPE=NODE).",
        )
    return rows


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


def _tributary_areas(coords: FloatArray, elements: Elements, rows: IntArray) -> tuple[IntArray, FloatArray]:
    """Nodes of facets and, at each, the sum of facet area / number of facet nodes."""
    table = elements.nodes_idx[rows]
    n_nodes = (table >= 0).sum(axis=1)
    corner = coords[np.where(table >= 0, table, table[:, :1])]
    quad_area = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    tri_area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = 0.5 * np.linalg.norm(np.where((n_nodes == 4)[:, None], quad_area, tri_area), axis=1)
    share = np.repeat((area / np.maximum(n_nodes, 1))[:, None], 4, axis=1)
    return _summed(table[table >= 0], share[table >= 0])


def _edge_surface(
    name: str, block: Block, coords: FloatArray, elements: Elements, edges: list[tuple[IntArray, int]]
) -> RawSurface:
    pairs, lengths = [], []
    for rows, edge in edges:
        table = elements.nodes_idx[rows]
        n_nodes = (table >= 0).sum(axis=1)
        if (n_nodes <= edge).any():
            row = int(rows[int(np.argmax(n_nodes <= edge))])
            raise InputError(
                f"element {elements.ids[row]} has no edge E{edge + 1}",
                where=block.where,
                fix="Correct the edge.",
            )
        pair = np.stack([table[:, edge], table[np.arange(rows.size), (edge + 1) % n_nodes]], axis=1)
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
