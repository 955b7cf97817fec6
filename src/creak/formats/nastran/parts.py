"""Which part every node and element belongs to: the connected pieces of structure."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from creak.arrays import IntArray
from creak.formats.nastran.deck import Deck, Group
from creak.formats.nastran.points import heavy_rows
from creak.model.constraints import Constraint, Equation, RigidLink, Tie
from creak.model.materials import Structural
from creak.model.mesh import Part


@dataclass
class _Union:
    """Disjoint sets of nodes."""

    above: list[int] = field(default_factory=list)

    def find(self, i: int) -> int:
        while self.above[i] != i:
            self.above[i] = self.above[self.above[i]]
            i = self.above[i]
        return i

    def join(self, i: int, j: int) -> None:
        a, b = self.find(i), self.find(j)
        self.above[max(a, b)] = min(a, b)


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
    count = _number(of_node, [nodes for g in structural for nodes in g.nodes], n, 0)
    n_structural = count
    links = [_nodes_of(c) for c in constraints]
    _attach(of_node, [[i for i in link if i not in ground] for link in links])
    count = _points(deck, of_node, links, count)
    titles = _titles(deck, structural, of_node, n_structural, count)
    parts = tuple(Part(titles[i], np.flatnonzero(of_node == i)) for i in range(count))
    return parts, of_node


def _nodes_of(constraint: Constraint) -> list[int]:
    if isinstance(constraint, RigidLink):
        return [constraint.dependent_idx, constraint.independent_idx]
    if isinstance(constraint, Equation):
        return sorted(set(constraint.nodes_idx.tolist()))
    if isinstance(constraint, Tie):
        return [constraint.node_idx, *constraint.nodes_idx.tolist()]
    return [constraint.ref_idx, *constraint.nodes_idx.tolist()]


def _number(of_node: IntArray, chains: list[list[int]], n: int, count: int) -> int:
    """Give each connected group of unassigned nodes the next number, in the order of the deck."""
    union = _Union(list(range(n)))
    for chain in chains:
        for other in chain[1:]:
            union.join(chain[0], other)
    number: dict[int, int] = {}
    for chain in chains:
        number.setdefault(union.find(chain[0]), count + len(number))
    for chain in chains:
        of_node[chain] = number[union.find(chain[0])]
    return count + len(number)


def _attach(of_node: IntArray, links: list[list[int]]) -> None:
    """Clusters of unassigned nodes that constraints tie to exactly one part join it."""
    union = _Union(list(range(of_node.size)))
    for link in links:
        loose = [i for i in link if of_node[i] < 0]
        for other in loose[1:]:
            union.join(loose[0], other)
    near: dict[int, set[int]] = {}
    members: dict[int, set[int]] = {}
    for link in links:
        loose = [i for i in link if of_node[i] < 0]
        if loose:
            root = union.find(loose[0])
            members.setdefault(root, set()).update(loose)
            near.setdefault(root, set()).update(int(of_node[i]) for i in link if of_node[i] >= 0)
    for root, parts in near.items():
        if len(parts) == 1:
            of_node[list(members[root])] = next(iter(parts))


def _points(deck: Deck, of_node: IntArray, links: list[list[int]], count: int) -> int:
    """Nodes that only carry masses and springs."""
    groups = [g for g in deck.groups.values() if not isinstance(g.section, Structural)]
    chains = [[i for i in nodes if of_node[i] < 0] for g in groups for nodes in g.nodes]
    near_chain = [{int(of_node[i]) for i in nodes if of_node[i] >= 0} for g in groups for nodes in g.nodes]
    tied = [[i for i in link if of_node[i] < 0] for link in links]
    used = {i for chain in chains for i in chain}
    chains += [[i for i in link if i in used] for link in tied]
    near_chain += [set() for _ in tied]
    trial = np.full(of_node.size, -1, dtype=np.int64)
    total = _number(trial, [c for c in chains if c], of_node.size, 0)
    heavy = {int(trial[i]) for i in heavy_rows(deck) if of_node[i] < 0}
    near: list[set[int]] = [set() for _ in range(total)]
    for chain, parts in zip(chains, near_chain, strict=True):
        if chain:
            near[int(trial[chain[0]])] |= parts
    order = np.argsort(trial, kind="stable")
    bounds = np.searchsorted(trial[order], np.arange(total + 1))
    for cluster in range(total):
        rows = order[bounds[cluster] : bounds[cluster + 1]]
        if cluster in heavy or not near[cluster]:
            of_node[rows] = count
            count += 1
        elif len(near[cluster]) == 1:
            of_node[rows] = next(iter(near[cluster]))
    return count


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
