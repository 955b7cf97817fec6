"""Which part every node and element belongs to: the connected pieces of structure."""

from __future__ import annotations

import numpy as np

from creak.arrays import IntArray
from creak.formats.deck.parts import NO_LINKS, Rows, join_neighbours, number_points
from creak.formats.nastran.joints.points import heavy_rows
from creak.formats.nastran.text.deck import Deck, Group
from creak.model.constraints import Constraint
from creak.model.materials import Structural
from creak.model.mesh import Part


def read_parts(deck: Deck, constraints: list[Constraint], ground: set[int]) -> tuple[tuple[Part, ...], IntArray]:
    """Parts, and the part of every node (-1: none).

    Connected shells, solids, bars and rods make a part. Other nodes join the one part that constraints tie them to;
    those between parts stay loose. What then is left and carries mass, or springs that reach no part or several
    grids of their own, makes parts of its own; nodes on springs of one part join it.

    Parameters
    ----------
    ground : rows of fixed nodes that belong to no part.
    """
    n = len(deck.grids.ids)
    of_node = np.full(n, -1, dtype=np.int64)
    structural = [g for g in deck.groups.values() if isinstance(g.section, Structural)]
    rows = Rows.of_lists([nodes for g in structural for nodes in g.nodes])
    count = number_points(rows, NO_LINKS, rows.node, of_node, 0)
    n_structural = count
    links = [c.nodes.tolist() for c in constraints]
    join_neighbours(Rows.of_lists([[i for i in link if i not in ground] for link in links]), of_node)
    count = _points(deck, of_node, links, count)
    titles = _titles(deck, structural, of_node, n_structural, count)
    parts = tuple(Part(titles[i], np.flatnonzero(of_node == i)) for i in range(count))
    return parts, of_node


def _points(deck: Deck, of_node: IntArray, links: list[list[int]], count: int) -> int:
    """Nodes that only carry masses and springs; constraints join those of them that they tie."""
    rows = Rows.of_lists(
        [nodes for g in deck.groups.values() if not isinstance(g.section, Structural) for nodes in g.nodes]
    )
    used = set(rows.node[of_node[rows.node] < 0].tolist())
    tied = [[i for i in link if i in used] for link in links]
    pairs = np.array([(link[0], other) for link in tied for other in link[1:]], dtype=np.int64).reshape(-1, 2)
    return number_points(rows, pairs, np.array(list(heavy_rows(deck)), dtype=np.int64), of_node, count)


def _titles(deck: Deck, structural: list[Group], of_node: IntArray, n_structural: int, count: int) -> list[str]:
    """PID_<id> for a part that has all elements of one property and no other, else PART-1, PART-2, ..."""
    inside: list[set[int | None]] = [set() for _ in range(count)]
    parts_of: dict[int | None, set[int]] = {}
    for group in structural:
        for identifier, nodes in zip(group.ids, group.nodes, strict=True):
            pid, part = deck.property_of.get(identifier), int(of_node[nodes[0]])
            inside[part].add(pid)
            parts_of.setdefault(pid, set()).add(part)
    titles = []
    for i in range(count):
        pid = next(iter(inside[i])) if len(inside[i]) == 1 else None
        alone = i < n_structural and pid is not None and len(parts_of[pid]) == 1
        titles.append(f"PID_{pid}" if alone else f"PART-{i + 1}")
    return titles
