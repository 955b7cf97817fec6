"""What joins the parts of a deck: springs, clips, connectors, ties, links, couplings and equations."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from creak.arrays import IntArray
from creak.model.constraints import (
    Constraint,
    DistributingCoupling,
    Equation,
    KinematicCoupling,
    RigidLink,
    Tie,
)
from creak.model.mesh import ElementBlock, Model
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
