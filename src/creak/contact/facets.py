"""Facets of contact surfaces: geometry, thickness, stiffness of the parent shells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.model.materials import ShellSection
from creak.model.mesh import Model

SHEAR_CORRECTION = 5.0 / 6.0
SHELLS = ("quad4", "tri3")


@dataclass(frozen=True)
class Facets:
    """Shell facets of a surface; triangles repeat their third node in the fourth column."""

    nodes: IntArray
    """(n, 4) node rows."""
    coords: FloatArray
    """(n, 4, 3)"""
    side: IntArray
    """(n,) +1, -1, or 0 for both sides."""
    thickness: FloatArray
    """(n,)"""
    normal_stiffness: FloatArray
    """(n,) kappa G t: how the parent shell resists a transverse displacement of one node, force / length."""

    @property
    def count(self) -> int:
        return int(self.nodes.shape[0])

    @property
    def is_triangle(self) -> BoolArray:
        return self.nodes[:, 2] == self.nodes[:, 3]

    @property
    def area_normals(self) -> FloatArray:
        """(n, 3) normals whose length is the facet's area (half the cross product of the diagonals)."""
        x = self.coords
        return 0.5 * np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])

    @property
    def node_rows(self) -> IntArray:
        """Sorted node rows of the surface."""
        return np.unique(self.nodes)


def facets_of(model: Model, name: str, *, where: str) -> Facets:
    """The shell facets of a surface or element set.

    Raises
    ------
    InputError : no such surface or set; it is node-based; it has elements that are no shells.
    """
    surface = model.surfaces.get(name.upper())
    if surface is not None and not surface.is_node_based:
        return _gather(model, surface.facets, surface.side, name, where)
    if surface is None and name.upper() in model.element_sets:
        facets = model.element_sets[name.upper()]
        return _gather(model, facets, np.zeros(facets.shape[0], dtype=np.int64), name, where)
    if surface is not None or name.upper() in model.node_sets:
        raise InputError(
            f"{name!r} is a set of nodes, without facets", where=where, expected="an element-based surface or set",
            fix='Give one, or use it as secondary with method = "node-to-surface".',
        )  # fmt: skip
    raise _unknown(model, name, where)


def nodes_of(model: Model, name: str, *, where: str) -> tuple[IntArray, FloatArray, FloatArray]:
    """Node rows of a secondary surface, their thickness and parent stiffness (0 and inf for node sets).

    A node-based surface has no thickness, as in Abaqus.
    """
    surface = model.surfaces.get(name.upper())
    if surface is not None and surface.is_node_based:
        rows = np.unique(surface.nodes_idx)
    elif surface is None and name.upper() not in model.element_sets and name.upper() in model.node_sets:
        rows = np.unique(model.node_set(name, where=where))
    else:
        facets = facets_of(model, name, where=where)
        return facets.node_rows, nodal(facets, facets.thickness), nodal(facets, facets.normal_stiffness)
    return rows, np.zeros(rows.size), np.full(rows.size, np.inf)


def nodal(facets: Facets, values: FloatArray) -> FloatArray:
    """Mean of a facet quantity at the surface's nodes, in the order of `node_rows`."""
    rows = facets.node_rows
    at = np.searchsorted(rows, facets.nodes)
    total = np.zeros(rows.size)
    count = np.zeros(rows.size)
    np.add.at(total, at, values[:, None])
    np.add.at(count, at, 1.0)
    return total / count


def nodal_normals(facets: Facets) -> FloatArray:
    """(n_node, 3) area-weighted unit normals at `node_rows`; neighbouring facets are first turned to one side.

    Where the normals of the facets cancel (a sharp fold) the largest facet decides.
    """
    normals = facets.area_normals * _orientation(facets)[:, None]
    rows = facets.node_rows
    at = np.searchsorted(rows, facets.nodes)
    total = np.zeros((rows.size, 3))
    for column in range(4):
        np.add.at(total, at[:, column], normals)
    length = np.linalg.norm(total, axis=1)
    weak = np.flatnonzero(length < 1e-6 * np.linalg.norm(normals, axis=1).max())
    for node in weak:
        mine = np.flatnonzero((at == node).any(axis=1))
        total[node] = normals[mine[np.argmax(np.linalg.norm(normals[mine], axis=1))]]
    return total / np.linalg.norm(total, axis=1)[:, None]


def _orientation(facets: Facets) -> FloatArray:
    """+1 or -1 per facet so that facets sharing an edge have the same orientation (given sides are kept)."""
    n = facets.count
    given = facets.side != 0
    if given.all():
        return facets.side.astype(np.float64)
    edges, owner, direction = _directed_edges(facets)
    order = np.lexsort((owner, edges[:, 1], edges[:, 0]))
    edges, owner, direction = edges[order], owner[order], direction[order]
    same = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    a, b = owner[same], owner[same + 1]
    agree = direction[same] != direction[same + 1]
    return _propagate(n, a, b, agree)


def _directed_edges(facets: Facets) -> tuple[IntArray, IntArray, BoolArray]:
    start = facets.nodes
    stop = np.roll(facets.nodes, -1, axis=1)
    owner = np.repeat(np.arange(facets.count), 4)
    pairs = np.stack([start.ravel(), stop.ravel()], axis=1)
    real = pairs[:, 0] != pairs[:, 1]
    pairs, owner = pairs[real], owner[real]
    return np.sort(pairs, axis=1), owner, pairs[:, 0] < pairs[:, 1]


def _propagate(n: int, a: IntArray, b: IntArray, agree: BoolArray) -> FloatArray:
    sign = np.ones(n)
    graph = sp.coo_matrix((np.ones(a.size), (a, b)), shape=(n, n)).tocsr()
    flips = {(int(i), int(j)): bool(ok) for i, j, ok in zip(a, b, agree, strict=True)}
    seen = np.zeros(n, dtype=bool)
    for root in range(n):
        if seen[root]:
            continue
        order, parent = sp.csgraph.breadth_first_order(graph, root, directed=False)
        seen[order] = True
        for k in order[1:].tolist():
            j = int(parent[k])
            ok = flips.get((j, k), flips.get((k, j), True))
            sign[k] = sign[j] if ok else -sign[j]
    return sign


def _gather(model: Model, pairs: IntArray, side: IntArray, name: str, where: str) -> Facets:
    nodes = np.zeros((pairs.shape[0], 4), dtype=np.int64)
    thickness, stiffness = np.zeros(pairs.shape[0]), np.zeros(pairs.shape[0])
    for row in np.unique(pairs[:, 0]).tolist():
        block, mine = model.blocks[row], np.flatnonzero(pairs[:, 0] == row)
        section = block.section
        if block.kind not in SHELLS or not isinstance(section, ShellSection):
            raise InputError(
                f"surface {name!r} holds {block.kind} elements (element {block.ids[pairs[mine[0], 1]]})",
                where=where, expected="shell elements", fix="Take only shells into a contact surface.",
            )  # fmt: skip
        corner = block.nodes_idx[pairs[mine, 1]]
        nodes[mine, : corner.shape[1]] = corner
        if corner.shape[1] == 3:
            nodes[mine, 3] = corner[:, 2]
        thickness[mine] = section.thickness
        stiffness[mine] = SHEAR_CORRECTION * section.material.shear_modulus * section.thickness
    if not nodes.size:
        raise InputError(f"surface {name!r} is empty", where=where, fix="Put shell elements into it.")
    return Facets(nodes, model.nodes.coords[nodes], side, thickness, stiffness)


def _unknown(model: Model, name: str, where: str) -> InputError:
    known = [*model.surfaces, *model.element_sets, *model.node_sets]
    return InputError(f"unknown surface or set {name!r}", where=where, fix=suggest(name, known))
