"""Node-to-surface contact: the gap of each secondary node along the main normal."""

from __future__ import annotations

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import Facets, facets_of, nodes_of
from creak.contact.gap_operator import ChannelRows, GapOperator
from creak.contact.pair import (
    AUTO_FACTOR,
    EDGE_ON,
    Channels,
    ContactPair,
    channels_from_rows,
    deepest,
    gap_normals,
    given_normal,
    looks_along,
    main_facets,
    never_face,
    overlap,
    reach,
    tangents_of,
)
from creak.contact.search import Projection, project_along, project_closest
from creak.errors import InputError
from creak.model.mesh import Model


def node_to_surface(model: Model, pair: ContactPair) -> tuple[GapOperator, list[str]]:
    """One channel per secondary node: g = g0 + n . (u_s - sum_j N_j u_j), n the main normal at the projection.

    The partner facet is found once, in the undeformed shape (small sliding); n is the study's normal where it
    gives one. g0 is the distance of the mid-surfaces less half of both thicknesses (beams: their radius). A node
    behind a solid counts as inside it up to the height of the element under the face. Pressure is not uniform on
    non-matching meshes; use `surface_to_surface` where that matters.

    Raises
    ------
    InputError : unknown or unfit surfaces; surfaces that never face each other; deep initial overclosure; a normal
        of length zero.
    """
    secondary = nodes_of(model, pair.secondary, where=f"{pair.where} secondary")
    main = main_facets(model, pair)
    meet, limit = _partners(model, pair, secondary.rows, main)
    found = np.flatnonzero(meet.found & ~np.isin(secondary.rows, main.nodes))
    if not found.size:
        raise never_face(pair, limit)
    nodes, meet = secondary.rows[found], _subset(meet, found)
    sides = main.side[meet.facet] if pair.normal is None else np.ones(nodes.size, dtype=np.int64)
    distance, normal = gap_normals(meet, sides)
    channels = Channels(
        nodes_idx=nodes,
        gap=distance - 0.5 * (secondary.thickness[found] + main.thickness[meet.facet]),
        depth=overlap(
            (secondary.thickness[found], main.thickness[meet.facet]), (secondary.depth[found], main.depth[meet.facet])
        ),
        stiffness=AUTO_FACTOR * np.minimum(secondary.normal_stiffness[found], main.normal_stiffness[meet.facet]),
        area=np.zeros(nodes.size),
        size=np.minimum(secondary.width[found], main.width[meet.facet]),
        scale=_areas(model, pair, nodes) if pair.per_area else np.ones(nodes.size),
    )
    return channels_from_rows(model, pair, _rows(nodes, main, meet, normal), channels)


def _partners(model: Model, pair: ContactPair, nodes: IntArray, main: Facets) -> tuple[Projection, float]:
    """The main facet opposite each node, and how far it was looked for."""
    points, normal = model.nodes.coords[nodes], given_normal(pair)
    limit, behind = max(reach(points), reach(main.coords)), deepest(main)

    def accept(row: IntArray, facet: IntArray, distance: FloatArray, direction: FloatArray) -> BoolArray:
        inside = distance if normal is not None else distance * main.side[facet]
        good = ~main.is_solid[facet] | (inside <= behind[facet])
        return good if normal is None else good & looks_along(main, facet, direction, EDGE_ON)

    if normal is None:
        return project_closest(points, main, limit, accept), limit
    return project_along(points, np.tile(normal, (nodes.size, 1)), main, limit, accept), limit


def _areas(model: Model, pair: ContactPair, nodes: IntArray) -> FloatArray:
    """(n,) area of the secondary surface that belongs to each node: an equal share of every facet around it.

    Raises
    ------
    InputError : the surface has no facets; the stiffness of the elements is asked for, which is not per area.
    """
    if pair.stiffness is None and pair.overclosure is None:
        raise InputError(
            "per_area with the stiffness of the elements",
            where=f"{pair.where} per_area",
            expected="a stiffness or an overclosure curve",
            fix="Give one, or leave out per_area.",
        )
    facets = facets_of(model, pair.secondary, where=f"{pair.where} secondary")
    area = np.linalg.norm(facets.area_normals, axis=1) / np.where(facets.is_triangle, 3.0, 4.0)
    corners = np.where(facets.is_triangle, 3, 4)[:, None] > np.arange(4)
    share = np.bincount(
        facets.nodes[corners], np.broadcast_to(area[:, None], corners.shape)[corners], model.nodes.count
    )
    return np.asarray(share[nodes])


def _subset(meet: Projection, keep: IntArray) -> Projection:
    return Projection(meet.found[keep], meet.facet[keep], meet.shape[keep], meet.distance[keep], meet.direction[keep])


def _rows(nodes: IntArray, main: Facets, meet: Projection, normal: FloatArray) -> ChannelRows:
    n = nodes.size
    all_nodes = np.column_stack([nodes, main.nodes[meet.facet]])
    weight = np.column_stack([np.ones(n), -meet.shape])
    channel = np.repeat(np.arange(n), 15)
    label = (6 * all_nodes[:, :, None] + np.arange(3)).ravel()
    vectors = [(weight[:, :, None] * v[:, None, :]).ravel() for v in (normal, *tangents_of(normal))]
    return ChannelRows(channel, label, *vectors)
