"""A symmetric matrix cut into pieces that only a separator joins: nested dissection of its graph by level sets.

Source: George, SIAM J. Numer. Anal. 10 (1973); level sets from a peripheral vertex as in Gibbs, Poole, Stockmeyer,
SIAM J. Numer. Anal. 13 (1976).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, connected_components

from creak.arrays import FloatArray, IntArray

SMALLER_SIDE = 0.3
"""Share of a graph that both sides of a separator hold at least, where its levels allow that."""
PERIPHERAL = 3
"""Searches for a vertex at the rim."""
ROWS = 200_000
"""Rows looked at at a time."""
TOO_FEW = 100
"""A piece of fewer equations is not cut."""


@dataclass(frozen=True)
class Dissection:
    """Rows of a matrix: those of the pieces, which have no entry with one another, and of the separator."""

    pieces: tuple[IntArray, ...]
    """Rising rows of each."""
    separator: IntArray
    """Rising rows."""


def whole(n: int) -> Dissection:
    """One piece."""
    return Dissection((np.arange(n, dtype=np.int64),), np.zeros(0, dtype=np.int64))


def cut_once_more(A: sp.csr_matrix, before: Dissection, size: Callable[[IntArray], float]) -> Dissection | None:
    """The dissection with its largest piece (by `size` of its rows) cut in two; None where that has no separator."""
    largest = max(range(len(before.pieces)), key=lambda k: size(before.pieces[k]))
    rows = before.pieces[largest]
    halves = _halves(A[rows][:, rows]) if rows.size >= TOO_FEW else None
    if halves is None:
        return None
    left, middle, right = halves
    pieces = [*before.pieces[:largest], rows[left], rows[right], *before.pieces[largest + 1 :]]
    return Dissection(tuple(pieces), np.union1d(before.separator, rows[middle]))


def _halves(A: sp.csr_matrix) -> tuple[IntArray, IntArray, IntArray] | None:
    """Rows left of a separator, on it and right of it."""
    group, graph = _compressed(A)
    weight = np.bincount(group).astype(float)
    side = _sides(graph, weight)
    if side is None:
        return None
    of_row = side[group]
    left, middle, right = (np.flatnonzero(of_row == k) for k in (-1, 0, 1))
    return left, middle, right


def _compressed(A: sp.csr_matrix) -> tuple[IntArray, sp.csr_matrix]:
    """Rows with the same neighbours (dofs of a node) as one vertex: (n,) vertex of each row, graph of the vertices."""
    marks = np.random.default_rng(1973).integers(0, 2**63, A.shape[0], dtype=np.uint64)
    same = np.zeros(A.shape[0], dtype=np.uint64)
    for start in range(0, A.shape[0], ROWS):
        some = slice(start, min(start + ROWS, A.shape[0]))
        first, last = A.indptr[some.start], A.indptr[some.stop]
        total = np.concatenate([np.zeros(1, dtype=np.uint64), np.cumsum(marks[A.indices[first:last]])])
        same[some] = total[A.indptr[some.start + 1 : some.stop + 1] - first] - total[A.indptr[some] - first]
    _, chosen, group = np.unique(same, return_index=True, return_inverse=True)
    group = group.reshape(-1).astype(np.int64)
    rows = A[chosen]
    ends = np.repeat(np.arange(chosen.size), np.diff(rows.indptr)), group[rows.indices]
    graph = sp.csr_matrix((np.ones(rows.nnz), ends), shape=(chosen.size, chosen.size))
    return group, graph


def _sides(graph: sp.csr_matrix, weight: FloatArray) -> IntArray | None:
    """-1, 0 or 1 for every vertex: left, separator, right; None where there is nothing to separate."""
    count, label = connected_components(graph, directed=False)
    total = np.bincount(label, weights=weight, minlength=count)
    side, load = np.zeros(weight.size, dtype=np.int64), {-1: 0.0, 1: 0.0}
    order = np.argsort(-total)
    if total[order[0]] > (1.0 - SMALLER_SIDE) * weight.sum():  # one body makes up most of it
        body = np.flatnonzero(label == order[0])
        found = _cut(graph[body][:, body], weight[body])
        if found is None:
            return None
        side[body] = found
        load = {k: float(weight[body][found == k].sum()) for k in load}
        order = order[1:]
    where = np.zeros(count, dtype=np.int64)
    for component in order.tolist():
        lighter = min(load, key=lambda k: load[k])
        where[component] = lighter
        load[lighter] += float(total[component])
    loose = where[label] != 0
    side[loose] = where[label[loose]]
    return side if (side < 0).any() and (side > 0).any() else None


def _cut(graph: sp.csr_matrix, weight: FloatArray) -> IntArray | None:
    """The level set of a connected graph that is lightest for what it leaves on the smaller side."""
    level = _levels(graph)
    of_level = np.bincount(level, weights=weight)
    if of_level.size < 3:
        return None
    below = np.cumsum(of_level) - of_level
    smaller = np.minimum(below, weight.sum() - below - of_level)
    enough = np.flatnonzero(smaller >= min(SMALLER_SIDE * weight.sum(), float(smaller.max())))
    at = int(enough[np.argmin(of_level[enough] / smaller[enough])])
    side = np.sign(level - at)
    middle, after = np.flatnonzero(level == at), (level > at).astype(float)
    side[middle[graph[middle] @ after == 0.0]] = -1  # touches nothing beyond
    return np.asarray(side, dtype=np.int64)


def _levels(graph: sp.csr_matrix) -> IntArray:
    """Distance of every vertex of a connected graph from one at its rim."""
    start = 0
    for _ in range(PERIPHERAL):
        start = int(breadth_first_order(graph, start, directed=False, return_predecessors=False)[-1])
    order, before = breadth_first_order(graph, start, directed=False)
    place = np.empty(order.size, dtype=np.int64)
    place[order] = np.arange(order.size)
    parent = place[before[order[1:]]]  # rises along the order
    level, last, depth = np.zeros(order.size, dtype=np.int64), 1, 0
    while last < order.size:
        end = 1 + int(np.searchsorted(parent, last))  # children of the vertices before `last`
        depth += 1
        level[order[last:end]] = depth
        last = end
    return level
