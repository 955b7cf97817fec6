"""Every n-th node of an interface; which of its nodes are neighbours, and how far apart."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, connected_components, depth_first_order

from creak.arrays import IntArray, Matrix
from creak.errors import InputError
from creak.model.faces import FACES, MIDDLES, N_CORNER, SHELL_FACETS, sides_of_shells, solid_corners
from creak.model.mesh import Model

Edges = tuple[tuple[int, int], ...]


def _of_solid(kind: str) -> Edges:
    """Sides of the faces, in halves where there are middle nodes."""
    faces = solid_corners(kind)
    if kind in MIDDLES:
        first = 1 + max(map(max, faces))
        return tuple(half for k, (a, b) in enumerate(MIDDLES[kind], first) for half in ((a, k), (k, b)))
    around = {tuple(sorted(pair)) for face in faces for pair in zip(face, (*face[1:], face[0]), strict=True)}
    return tuple((a, b) for a, b in sorted(around))


def _of_shell(kind: str) -> Edges:
    """Sides, in halves where there are middle nodes."""
    every = np.unique(SHELL_FACETS[kind])[None]
    halves = [sides_of_shells(kind, every, side)[0] for side in range(N_CORNER[kind])]
    return tuple((int(a), int(b)) for a, b in np.concatenate(halves))


EDGES: dict[str, Edges] = {
    "beam2": ((0, 1),),
    "beam3": ((0, 1), (1, 2)),
    "truss2": ((0, 1),),
    **{kind: _of_shell(kind) for kind in SHELL_FACETS},
    **{kind: _of_solid(kind) for kind in FACES},
}
"""Sides of the element kinds that make a mesh; diagonals are no edges."""
SHORTEST = 1e-3
"""Length of an edge between coincident nodes, as a share of the longest edge."""


def interface_graph(model: Model, nodes_idx: IntArray) -> Matrix:
    """Edges of the mesh between interface nodes, with their lengths.

    Parameters
    ----------
    nodes_idx : (n,) rows of the model; position k of the graph is node nodes_idx[k].

    Returns
    -------
    (n, n) symmetric csr matrix, entry = length of the element edge (sides of quad4 and tri3, axes of beam2 and
    truss2); no entry where two nodes share no edge. Coincident nodes joined by an edge get 1e-3 of the longest.

    Raises
    ------
    InputError : a node is given twice.
    """
    n = nodes_idx.size
    if np.unique(nodes_idx).size != n:
        raise InputError("the interface lists a node twice", expected="every node once", fix="Remove the duplicates.")
    place = np.full(model.nodes.count, -1, dtype=np.int64)
    place[nodes_idx] = np.arange(n)
    found = [_edges(block.nodes_idx, block.kind, place) for block in model.blocks if block.kind in EDGES]
    pairs = np.unique(np.vstack([np.zeros((0, 2), dtype=np.int64), *found]), axis=0)
    a, b = pairs.T
    coords = model.nodes.coords[nodes_idx]
    length = np.linalg.norm(coords[a] - coords[b], axis=1)
    length = np.maximum(length, SHORTEST * length.max(initial=0.0))
    ends = np.concatenate([a, b]), np.concatenate([b, a])
    graph = sp.csr_matrix((np.concatenate([length, length]), ends), shape=(n, n))
    graph.sort_indices()
    return graph


def _edges(elements: IntArray, kind: str, place: IntArray) -> IntArray:
    """(k, 2) sorted positions of the edges with both ends on the interface."""
    pairs = place[elements][:, np.array(EDGES[kind])].reshape(-1, 2)
    inside = (pairs >= 0).all(axis=1) & (pairs[:, 0] != pairs[:, 1])
    return np.sort(pairs[inside], axis=1)


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
