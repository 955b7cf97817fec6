"""Which part every node of a flat deck belongs to: the connected pieces of structure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from creak.arrays import IntArray
from creak.formats.deck.groups import Group
from creak.formats.deck.parts import NO_LINKS, Rows, join_neighbours, number_points
from creak.model.constraints import Constraint
from creak.model.materials import NodalMatrices, Structural
from creak.model.mesh import Part

NameOf = Callable[[Group, int], str | None]


def flat_parts(
    groups: Sequence[Group], n: int, constraints: Sequence[Constraint], ground: set[int], name_of: NameOf
) -> tuple[tuple[Part, ...], IntArray]:
    """Parts, and the part of every one of n nodes (-1: none).

    Connected shells, solids, bars and rods make a part. Other nodes join the one part that constraints tie them to;
    those between parts stay loose. What then is left and carries mass, or springs that reach no part or several
    nodes of their own, makes parts of its own; nodes on springs of one part join it.

    Parameters
    ----------
    ground : rows of fixed nodes that belong to no part.
    name_of : group, element id -> name of its property, which a part takes that has all of its elements and no other.
    """
    of_node = np.full(n, -1, dtype=np.int64)
    structural = [g for g in groups if isinstance(g.section, Structural)]
    rows = Rows.of_lists([nodes for g in structural for nodes in g.nodes])
    count = number_points(rows, NO_LINKS, rows.node, of_node, 0)
    n_structural = count
    links = [c.nodes.tolist() for c in constraints]
    join_neighbours(Rows.of_lists([[i for i in link if i not in ground] for link in links]), of_node)
    count = _points(groups, of_node, links, count)
    titles = _titles(structural, name_of, of_node, n_structural, count)
    parts = tuple(Part(titles[i], np.flatnonzero(of_node == i)) for i in range(count))
    return parts, of_node


def _points(groups: Sequence[Group], of_node: IntArray, links: list[list[int]], count: int) -> int:
    """Nodes that only carry masses and springs; constraints join those of them that they tie."""
    rows = Rows.of_lists([nodes for g in groups if not isinstance(g.section, Structural) for nodes in g.nodes])
    used = set(rows.node[of_node[rows.node] < 0].tolist())
    tied = [[i for i in link if i in used] for link in links]
    pairs = np.array([(link[0], other) for link in tied for other in link[1:]], dtype=np.int64).reshape(-1, 2)
    return number_points(rows, pairs, np.array(list(_heavy_rows(groups)), dtype=np.int64), of_node, count)


def _heavy_rows(groups: Sequence[Group]) -> Iterator[int]:
    """Rows of the nodes that carry concentrated mass."""
    for group in groups:
        with_mass = group.kind in ("mass", "rotary")
        with_mass |= isinstance(group.section, NodalMatrices) and bool(group.section.mass.any())
        if with_mass:
            yield from (row for nodes in group.nodes for row in nodes)


def _titles(structural: list[Group], name_of: NameOf, of_node: IntArray, n_structural: int, count: int) -> list[str]:
    """The property's name for a part that has all elements of one property and no other, else PART-1, PART-2, ..."""
    inside: list[set[str | None]] = [set() for _ in range(count)]
    parts_of: dict[str | None, set[int]] = {}
    for group in structural:
        for identifier, nodes in zip(group.ids, group.nodes, strict=True):
            name, part = name_of(group, identifier), int(of_node[nodes[0]])
            inside[part].add(name)
            parts_of.setdefault(name, set()).add(part)
    titles = []
    for i in range(count):
        name = next(iter(inside[i])) if len(inside[i]) == 1 else None
        alone = i < n_structural and name is not None and len(parts_of[name]) == 1
        titles.append(name if alone and name is not None else f"PART-{i + 1}")
    return titles
