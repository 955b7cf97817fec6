"""Node-to-surface contact: the gap of each secondary node along the main normal."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.facets import Facets, nodes_of
from creak.contact.gap_operator import ChannelRows, GapOperator
from creak.contact.pair import (
    AUTO_FACTOR,
    ContactPair,
    channels_from_rows,
    gap_normals,
    main_facets,
    never_face,
    reach,
    tangents_of,
)
from creak.contact.search import Projection, project_closest
from creak.model.mesh import Model


def node_to_surface(model: Model, pair: ContactPair) -> tuple[GapOperator, list[str]]:
    """One channel per secondary node: g = g0 + n . (u_s - sum_j N_j u_j), n the main normal at the projection.

    The partner facet is found once, in the undeformed shape (small sliding). g0 is the distance of the
    mid-surfaces less half of both thicknesses. Pressure is not uniform on non-matching meshes; use
    `surface_to_surface` where that matters.

    Raises
    ------
    InputError : unknown or unfit surfaces; surfaces that never face each other; deep initial overclosure.
    """
    nodes, thickness, parent = nodes_of(model, pair.secondary, where=f"{pair.where} secondary")
    main = main_facets(model, pair)
    points = model.nodes.coords[nodes]
    limit = max(reach(points), reach(main.coords))
    meet = project_closest(points, main, limit)
    own = np.isin(nodes, main.nodes)
    found = np.flatnonzero(meet.found & ~own)
    if not found.size:
        raise never_face(pair, limit)
    meet = _subset(meet, found)
    distance, normal = gap_normals(meet, main.side[meet.facet])
    half = 0.5 * (thickness[found] + main.thickness[meet.facet])
    soft = np.minimum(parent[found], main.normal_stiffness[meet.facet])
    penalty = AUTO_FACTOR * soft if pair.stiffness is None else np.full(found.size, pair.stiffness)
    rows = _rows(nodes[found], main, meet, normal)
    return channels_from_rows(
        model, pair, rows, nodes[found], distance - half, penalty, np.zeros(found.size), 2.0 * half
    )


def _subset(meet: Projection, keep: IntArray) -> Projection:
    return Projection(
        meet.found[keep], meet.facet[keep], meet.shape[keep], meet.distance[keep], meet.direction[keep]
    )


def _rows(nodes: IntArray, main: Facets, meet: Projection, normal: FloatArray) -> ChannelRows:
    n = nodes.size
    all_nodes = np.column_stack([nodes, main.nodes[meet.facet]])
    weight = np.column_stack([np.ones(n), -meet.shape])
    channel = np.repeat(np.arange(n), 15)
    label = (6 * all_nodes[:, :, None] + np.arange(3)).ravel()
    vectors = [(weight[:, :, None] * v[:, None, :]).ravel() for v in (normal, *tangents_of(normal))]
    return ChannelRows(channel, label, *vectors)
