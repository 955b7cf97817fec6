"""Elements while a deck is read: groups of one kind and section, which become blocks of one part each; parts of a flat
deck: the connected pieces, and where nodes belong that only carry masses and springs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from creak.arrays import FloatArray, IntArray
from creak.model.constraints import Constraint
from creak.model.materials import NodalMatrices, Section, Structural
from creak.model.mesh import ElementBlock, Own, Part


@dataclass
class Group:
    """Elements of one kind and one section."""

    kind: str
    section: Section
    ids: list[int] = field(default_factory=list)
    nodes: list[list[int]] = field(default_factory=list)
    where: str = ""
    own: dict[str, list[FloatArray]] = field(default_factory=dict)
    """axis1, axis2, thickness, arms: one entry for each element, or none at all."""

    def put(self, identifier: int, nodes: list[int], own: Mapping[str, FloatArray]) -> None:
        """One more element, with what it has of its own."""
        self.ids.append(identifier)
        self.nodes.append(nodes)
        for name, value in own.items():
            self.own[name].append(np.asarray(value, dtype=np.float64))


Groups = dict[tuple[object, ...], Group]
"""By a key that tells sections apart."""


def group_of(
    groups: Groups, key: tuple[object, ...], kind: str, section: Section, where: str, own: Collection[str]
) -> Group:
    """The group of a kind, a section and the names of what its elements have of their own; `where`: of its first."""
    full = (kind, *key, *sorted(own))
    if full not in groups:
        groups[full] = Group(kind, section, where=where, own={name: [] for name in own})
    return groups[full]


def blocks_of(groups: Groups, of_node: IntArray) -> tuple[ElementBlock, ...]:
    """One block for each group and part."""
    found: list[ElementBlock] = []
    for group in groups.values():
        nodes = np.array(group.nodes, dtype=np.int64)
        part = of_node[nodes]
        part_of = np.where((part == part[:, :1]).all(axis=1), part[:, 0], -1)
        for p in dict.fromkeys(part_of.tolist()):
            found.append(_block(group, nodes, np.flatnonzero(part_of == p), p))
    return tuple(found)


def _block(group: Group, nodes: IntArray, rows: IntArray, part: int) -> ElementBlock:
    own: dict[str, Any] = {name: np.array(values)[rows] for name, values in group.own.items()}
    ids = np.array(group.ids, dtype=np.int64)[rows]
    return ElementBlock(group.kind, ids, nodes[rows], group.section, int(part), group.where, Own(**own))


NO_LINKS = np.zeros((0, 2), dtype=np.int64)
NameOf = Callable[[Group, int], str | None]


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


def flat_parts(
    groups: Sequence[Group], n: int, constraints: Sequence[Constraint], name_of: NameOf
) -> tuple[tuple[Part, ...], IntArray]:
    """Parts, and the part of every one of n nodes (-1: none).

    Connected shells, solids, bars and rods make a part. Other nodes join the one part that constraints tie them to;
    those between parts stay loose. What then is left and carries mass, or springs that reach no part or several
    nodes of their own, makes parts of its own; nodes on springs of one part join it.

    Parameters
    ----------
    name_of : group, element id -> name of its property, which a part takes that has all of its elements and no other.
    """
    of_node = np.full(n, -1, dtype=np.int64)
    structural = [g for g in groups if isinstance(g.section, Structural)]
    rows = Rows.of_lists([nodes for g in structural for nodes in g.nodes])
    count = number_points(rows, NO_LINKS, rows.node, of_node, 0)
    n_structural = count
    links = [c.nodes.tolist() for c in constraints]
    join_neighbours(Rows.of_lists(links), of_node)
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
