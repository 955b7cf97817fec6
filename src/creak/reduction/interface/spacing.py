"""Every n-th node of an interface."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import breadth_first_order, connected_components, depth_first_order

from creak.arrays import IntArray, Matrix
from creak.errors import InputError


def every_nth(graph: Matrix, n: int) -> IntArray:
    """Keep every n-th node of an interface, distributed equally along it.

    * open line: nodes 0, n, 2 n, ... counted along the line from its end with the lower position, and the other end;
    * closed loop of L nodes: ceil(L / n) nodes from its first one, equally spread (gaps of at most n edges);
    * patch (a node with more than two neighbours): free ends, then breadth first from the node with the fewest
      neighbours every node that is at least n edges away from all kept ones, so no node is n or more edges from one;
    * single nodes are kept.

    Parameters
    ----------
    graph : (m, m) symmetric, as `interface_graph` gives it. Only which entries exist matters.
    n : spacing in edges; 1 keeps all nodes.

    Returns
    -------
    Sorted positions of the kept nodes.

    Raises
    ------
    InputError : n is below 1.

    Source: section 3.3.1 of Valiyakath Basheer and Godborg, Chalmers 2019 ("every x-th node is retained,
    distributed equally"). There the nodes in between are left uncoupled; with `interpolation` they follow instead.
    """
    if n < 1:
        raise InputError(f"node spacing {n}", expected="1 or more", fix="Use 1 to keep every node.")
    degree = np.diff(graph.indptr)
    _, component = connected_components(graph, directed=False)
    order = np.argsort(component, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(component[order])) + 1) if order.size else []
    kept = [_kept(graph, nodes, degree, n) for nodes in groups]
    return np.sort(np.concatenate([np.zeros(0, dtype=np.int64), *kept]))


def _kept(graph: Matrix, nodes: IntArray, degree: IntArray, n: int) -> IntArray:
    """Kept nodes of one connected component, whose sorted positions are `nodes`."""
    if n == 1 or nodes.size == 1:
        return nodes
    ends = nodes[degree[nodes] == 1]
    if degree[nodes].max() > 2:
        return _greedy(graph, nodes[np.argmin(degree[nodes])], ends, n)
    start = ends[0] if ends.size else nodes[0]
    along = depth_first_order(graph, start, directed=False, return_predecessors=False)
    if ends.size:
        return along[np.union1d(np.arange(0, along.size, n), along.size - 1)]
    count = -(-along.size // n)
    return along[np.arange(count) * along.size // count]


def _greedy(graph: Matrix, start: int, ends: IntArray, n: int) -> IntArray:
    """Nodes in breadth-first order that are n edges or more from all those kept before."""
    near = np.zeros(graph.shape[0], dtype=bool)
    kept = ends.tolist()
    for node in kept:
        near[_within(graph, node, n)] = True
    for node in breadth_first_order(graph, start, directed=False, return_predecessors=False).tolist():
        if not near[node]:
            kept.append(node)
            near[_within(graph, node, n)] = True
    return np.array(kept, dtype=np.int64)


def _within(graph: Matrix, node: int, n: int) -> list[int]:
    """Nodes fewer than n edges away, the node itself included."""
    seen, front = {node}, {node}
    for _ in range(n - 1):
        reached = {j for i in front for j in graph.indices[graph.indptr[i] : graph.indptr[i + 1]].tolist()}
        front = reached - seen
        seen |= front
    return list(seen)
