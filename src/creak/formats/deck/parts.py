"""Parts of a flat deck: the connected pieces, and where nodes belong that only carry masses and springs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from creak.arrays import IntArray


def stars(table: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs (first, other) of the nodes in each row; -1 is no node."""
    start = np.repeat(table[:, :1], max(table.shape[1] - 1, 0), axis=1)
    valid = (table[:, 1:] >= 0) & (start >= 0)
    return start[valid], table[:, 1:][valid]


def number_pieces(members: IntArray, start: IntArray, end: IntArray, order: IntArray, of_node: IntArray, n: int) -> int:
    """Give each connected group of unassigned `members` the next number from n on; returns the number after them.

    Parameters
    ----------
    start, end : pairs of nodes that are connected.
    order : nodes, in the order in which their groups are numbered; the rest follows in the order of `members`.
    of_node : (n_node,) part of each node, -1 for none; filled.
    """
    members = members[of_node[members] < 0]
    if members.size == 0:
        return n
    size = of_node.size
    graph = coo_array((np.ones(start.size, np.int8), (start, end)), shape=(size, size))
    _, label = connected_components(graph, directed=False)
    order = order[of_node[order] < 0]
    firsts = label[np.concatenate([order, members])]
    groups, at = np.unique(firsts, return_index=True)
    rank = np.empty(groups.size, dtype=np.int64)
    rank[np.argsort(at)] = np.arange(groups.size)
    of_node[members] = n + rank[np.searchsorted(groups, label[members])]
    return n + groups.size


NO_LINKS = np.zeros((0, 2), dtype=np.int64)


@dataclass(frozen=True)
class Rows:
    """Nodes that belong together, row by row: the nodes of an element, or of a constraint."""

    row: IntArray
    """(n,) number of the row, ascending."""
    node: IntArray
    """(n,)"""

    @classmethod
    def of_table(cls, table: IntArray) -> Rows:
        """From (n_row, k), -1 for no node."""
        row, column = np.nonzero(table >= 0)
        return cls(row, table[row, column])

    @classmethod
    def of_lists(cls, lists: Sequence[Sequence[int]]) -> Rows:
        sizes = [len(nodes) for nodes in lists]
        node = np.array([i for nodes in lists for i in nodes], dtype=np.int64)
        return cls(np.repeat(np.arange(len(lists)), sizes), node)


def join_neighbours(rows: Rows, of_node: IntArray) -> None:
    """Connected unassigned nodes whose rows reach exactly one part join it."""
    for group, near in _loose_groups(rows, NO_LINKS, None, of_node):
        if len(near) == 1:
            of_node[group] = next(iter(near))


def number_points(
    rows: Rows, links: IntArray, heavy: IntArray, of_node: IntArray, n: int, order: IntArray | None = None
) -> int:
    """Number the connected groups of unassigned nodes that carry masses or springs; returns the number after them.

    A group with mass, or that hangs on nothing, is a part of its own. One without mass whose springs reach one part
    joins it; one between several joins none.

    Parameters
    ----------
    rows : nodes of the masses and springs.
    links : (n, 2) nodes joined otherwise.
    heavy : nodes with mass.
    of_node, n : as in `number_pieces`; so is `order`, by default that of the rows.
    """
    with_mass = np.zeros(of_node.size, dtype=bool)
    with_mass[heavy] = True
    for group, near in _loose_groups(rows, links, order, of_node):
        if not near or with_mass[group].any():
            of_node[group] = n
            n += 1
        elif len(near) == 1:
            of_node[group] = next(iter(near))
    return n


def _loose_groups(
    rows: Rows, links: IntArray, order: IntArray | None, of_node: IntArray
) -> list[tuple[IntArray, set[int]]]:
    """Connected groups of the unassigned nodes of the rows, and the parts that their rows reach."""
    loose = of_node[rows.node] < 0
    _, first = np.unique(rows.row[loose], return_index=True)
    anchor_of = np.full(int(rows.row.max(initial=-1)) + 1, -1, dtype=np.int64)
    anchor_of[rows.row[loose][first]] = rows.node[loose][first]
    members, anchors = rows.node[loose], anchor_of[rows.row[loose]]
    links = links[(of_node[links] < 0).all(axis=1)]
    start, end = np.concatenate([anchors, links[:, 0]]), np.concatenate([members, links[:, 1]])
    trial = of_node.copy()
    base = int(of_node.max(initial=-1)) + 1
    total = number_pieces(np.unique(members), start, end, anchors if order is None else order, trial, base)
    beside = ~loose & (anchor_of[rows.row] >= 0)
    near: list[set[int]] = [set() for _ in range(base, total)]
    groups = trial[anchor_of[rows.row[beside]]] - base
    for group, part in zip(groups.tolist(), of_node[rows.node[beside]].tolist(), strict=True):
        near[group].add(part)
    by_group = np.argsort(trial, kind="stable")
    bounds = np.searchsorted(trial[by_group], np.arange(base, total + 1))
    return [(by_group[bounds[k] : bounds[k + 1]], parts) for k, parts in enumerate(near)]
