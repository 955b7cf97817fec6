"""What joins the parts of a deck: springs, clips, connectors, ties, links, couplings and equations.

A part may be of several pieces that shells and solids hold together: what beams alone join may still hit each other."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from creak.arrays import BoolArray, IntArray
from creak.formats.deck.parts import number_pieces, stars
from creak.model.constraints import Constraint, DistributingCoupling, Equation, KinematicCoupling, RigidLink, Tie
from creak.model.faces import FACES, SHELL_FACETS
from creak.model.mesh import ElementBlock, Model, Part, some_of
from creak.studies.propose.opposite import element_numbers
from creak.studies.propose.proximity import titles_of
from creak.words import listed

ELEMENTS = {
    **dict.fromkeys(("beam2", "beam3"), "beam element(s)"),
    **dict.fromkeys(("spring2", "axial2"), "spring or dashpot element(s)"),
    "nodal2": "spring or matrix element(s)",
    "bush2": "connector or bushing element(s)",
}
CONSTRAINTS: dict[type[Constraint], str] = {
    Equation: "equation(s)",
    KinematicCoupling: "kinematic coupling(s)",
    DistributingCoupling: "distributing coupling(s)",
    RigidLink: "rigid link(s)",
    Tie: "tied node(s)",
}


def joints_of(model: Model) -> tuple[str, ...]:
    """`2 rigid link(s) between LID and BOX, first at nodes 12 and 40`: one line for each kind and pair of parts.

    Elements that lie in one part, and constraints among nodes of one part, are left out.
    """
    part = _part_of(model)
    found: dict[tuple[str, tuple[int, ...]], list[IntArray]] = {}
    for words, nodes in [*_elements(model.blocks), *_constraints(model.constraints)]:
        joined = np.unique(part[nodes])
        if joined.size > 1:
            found.setdefault((words, tuple(joined.tolist())), []).append(nodes)
    return tuple(_line(model, part, words, joined, each) for (words, joined), each in found.items())


def linked_parts(model: Model) -> set[frozenset[str]]:
    """Pairs of names of parts that one link, coupling, tie, equation or bushing (a weld is one) joins."""
    part = _part_of(model)
    found: set[frozenset[str]] = set()
    bushings = [b for b in model.blocks if b.kind == "bush2"]
    for _, nodes in [*_constraints(model.constraints), *_elements(tuple(bushings))]:
        joined = np.unique(part[nodes])
        names = [model.parts[i].name for i in joined[joined >= 0].tolist()]
        found.update(frozenset(pair) for pair in combinations(names, 2))
    return found


def _part_of(model: Model) -> IntArray:
    """(n_node,) row into `Model.parts`; -1 for none."""
    part = np.full(model.nodes.count, -1, dtype=np.int64)
    for i, p in enumerate(model.parts):
        part[p.nodes_idx] = i
    return part


def _elements(blocks: tuple[ElementBlock, ...]) -> list[tuple[str, IntArray]]:
    return [(ELEMENTS[block.kind], nodes) for block in blocks if block.kind in ELEMENTS for nodes in block.nodes_idx]


def _constraints(constraints: tuple[Constraint, ...]) -> list[tuple[str, IntArray]]:
    return [(CONSTRAINTS[type(c)], c.nodes) for c in constraints]


def _line(model: Model, part: IntArray, words: str, joined: tuple[int, ...], each: list[IntArray]) -> str:
    names = [model.parts[i].name if i >= 0 else "nodes of no part" for i in sorted(joined, reverse=True)]
    # One node of each, in the order of the names.
    nodes = [next(row for row in each[0].tolist() if part[row] == i) for i in sorted(joined, reverse=True)]
    first = [model.nodes.label(row) for row in nodes]
    return f"{len(each)} {words} between {listed(names)}, first at nodes {listed(first)}"


def by_bodies(model: Model) -> Model:
    """The model with each piece of a part as a part of its own, where a part has several: two plates on screws.

    It is for looking at: which parts a study has is told by the deck. A piece is called by a set of all its elements,
    else by the part and a number. Elements between pieces belong to no part.
    """
    of_node = np.full(model.nodes.count, -1, dtype=np.int64)
    surfaces = [b for b in model.blocks if b.kind in SHELL_FACETS or b.kind in FACES]
    pairs = [stars(b.nodes_idx) for b in surfaces]
    start, end = (np.concatenate([np.zeros(0, dtype=np.int64), *(p[k] for p in pairs)]) for k in (0, 1))
    body = number_pieces(np.unique([start, end]), start, end, start, of_node, 0)
    part_of = np.full(body, -1, dtype=np.int64)
    for b in surfaces:
        part_of[of_node[b.nodes_idx[:, 0]]] = b.part
    several = np.bincount(part_of[part_of >= 0], minlength=len(model.parts)) > 1
    if not several.any():
        return model
    parts, number = _parts(model, of_node, part_of, several)
    return _named(_divided(replace(model, parts=parts), of_node, number, several), model)


def _parts(model: Model, of_node: IntArray, part_of: IntArray, several: BoolArray) -> tuple[tuple[Part, ...], IntArray]:
    """The parts, those of several pieces without the nodes of all but their first one, and then these pieces.

    Returns with them the part of each piece.
    """
    parts, number, count = list(model.parts), part_of.copy(), dict[int, int]()
    for k, i in enumerate(part_of.tolist()):
        if i < 0 or not several[i]:
            continue
        count[i] = count.get(i, 0) + 1
        if count[i] > 1:
            rows = np.flatnonzero(of_node == k)
            number[k] = len(parts)
            parts.append(Part(f"{model.parts[i].name}-{count[i]}", rows))
            parts[i] = replace(parts[i], nodes_idx=np.setdiff1d(parts[i].nodes_idx, rows))
    return tuple(parts), number


def _divided(model: Model, of_node: IntArray, number: IntArray, several: BoolArray) -> Model:
    """Its blocks, sets and surfaces with each element in its piece."""
    blocks: list[ElementBlock] = []
    first = element_numbers(model)
    at = np.zeros((int(first[-1]), 2), dtype=np.int64)
    for row, b in enumerate(model.blocks):
        piece = np.full(b.ids.size, b.part, dtype=np.int64)
        if b.part >= 0 and several[b.part]:
            bodies = of_node[b.nodes_idx]
            own = (bodies == bodies[:, :1]).all(axis=1) & (bodies[:, 0] >= 0)
            piece = np.where(own, number[bodies[:, 0]], np.where((bodies < 0).all(axis=1), b.part, -1))
        for k in np.unique(piece).tolist():
            rows = np.flatnonzero(piece == k)
            at[first[row] + rows] = np.column_stack([np.full(rows.size, len(blocks)), np.arange(rows.size)])
            blocks.append(replace(some_of(b, rows), part=k))

    def moved(members: IntArray) -> IntArray:
        return at[first[members[:, 0]] + members[:, 1]]

    sets = {name: moved(members) for name, members in model.element_sets.items()}
    surfaces = {name: replace(s, facets=moved(s.facets)) for name, s in model.surfaces.items()}
    return replace(model, blocks=tuple(blocks), element_sets=sets, surfaces=surfaces)


def _named(model: Model, before: Model) -> Model:
    """Its parts by a set of all their elements, where they are not those of the deck."""
    known = {p.name: p.nodes_idx.size for p in before.parts}
    divided = [p.name for p in model.parts if known.get(p.name) != p.nodes_idx.size]
    titles = titles_of(model, divided)
    return replace(model, parts=tuple(replace(p, name=titles.get(p.name, p.name)) for p in model.parts))
