"""Where bending waves of shells are turned back, and so radiate: edges, and what holds a part inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.model.constraints import DistributingCoupling
from creak.model.mesh import Model
from creak.model.shell_facets import SHELL_FACETS
from creak.model.skin import Skin, panels, sides_of
from creak.model.solid_faces import FACES
from creak.model.volumes import LINES

ACROSS = 0.5
"""Share of the normal's square that supports must hold for a node to count as held across its plate."""


@dataclass(frozen=True)
class Edges:
    """Of the shells of one part."""

    held: float = 0.0
    """m along which they are held across: supported edges, both sides of lines inside, rims of rigid patches."""
    free: float = 0.0
    """m of edges and holes where nothing holds them."""
    points: int = 0
    """Separate places where something else holds them."""


def edges_of(model: Model, shells: Skin, metre: float) -> tuple[FloatArray, BoolArray, dict[int, Edges]]:
    """(n_node, 3) unit normals, turned alike over each panel; (n_node,) which lie on a free edge; by part its edges.

    Waves that run into a point that is held send what that pushes back; the rim of a patch that moves as one body is
    taken for a supported edge. Folds count as none: beads and flanges lie closer than half a wave mostly, where what
    one sends the next takes back.
    """
    n = model.nodes.count
    normal, free = np.zeros((n, 3)), np.zeros(n, dtype=bool)
    if not shells.count:
        return normal, free, {}
    sides = sides_of(shells.nodes_idx)
    turned = shells.areas * panels(shells.nodes_idx, sides)[0][:, None]
    for column in shells.nodes_idx.T:
        np.add.at(normal, column, turned)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    (facet, ends, _, count), (held, joined) = sides, _held(model, normal)
    along = model.nodes.coords[ends]
    length = metre * np.linalg.norm(along[:, 1] - along[:, 0], axis=1)
    both, rigid = held[ends].all(axis=1), np.asarray(held[shells.nodes_idx].all(axis=1))
    open_edge: BoolArray = np.logical_and(count == 1, ~both)
    free[ends[open_edge].ravel()] = True
    stops = np.where(both & ~rigid[facet], length, 0.0)
    cluster, part = _clusters(ends, joined), shells.part[facet]
    found: dict[int, Edges] = {}
    for k in np.unique(part).tolist():
        mine = part == k
        own = np.unique(ends[mine])
        points = np.unique(cluster[own[joined[own]]]).size
        found[k] = Edges(float(stops[mine].sum()), float(length[mine & open_edge].sum()), int(points))
    return normal, free, found


def _held(model: Model, normal: FloatArray) -> tuple[BoolArray, BoolArray]:
    """(n_node,) what supports, constraints and other elements hold; the same with what follows in the mean alone."""
    n = model.nodes.count
    across = np.zeros(n)
    for fixed in model.fixed:
        for dof in (d for d in fixed.dofs if d <= 3):
            across[fixed.nodes_idx] += normal[fixed.nodes_idx, dof - 1] ** 2
    held, joined = across > ACROSS, np.zeros(n, dtype=bool)
    for constraint in model.constraints:
        (joined if isinstance(constraint, DistributingCoupling) else held)[constraint.nodes] = True
    for block in model.blocks:
        if block.kind not in SHELL_FACETS and (block.kind in FACES or block.kind in LINES):
            held[block.nodes_idx] = True
    return held, held | joined


def _clusters(ends: IntArray, joined: BoolArray) -> IntArray:
    """(n_node,) number of the patch of joined nodes that each belongs to."""
    i, j = ends[joined[ends].all(axis=1)].T
    graph = sp.coo_array((np.ones(i.size), (i, j)), shape=(joined.size,) * 2)
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
