"""Node-to-surface contact: the gap of each secondary node along the main normal, thickness and stiffness of what it
stands for."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import Facets, bends, facets_of
from creak.contact.gap_operator import ChannelRows, GapOperator
from creak.contact.pair import (
    AUTO_FACTOR,
    EDGE_ON,
    Channels,
    ContactPair,
    Keep,
    Wall,
    channels_of_walls,
    deepest,
    gap_normals,
    given_normal,
    looks_along,
    main_facets,
    overlap,
    reach,
    searched,
    tangents_of,
    turns_of,
)
from creak.contact.search import Projection, project_along, project_closest
from creak.errors import InputError
from creak.model.dofs import ROTATIONS, TRANSLATIONS, dof_labels, node_dofs
from creak.model.faces import FACES, SHELL_FACETS
from creak.model.materials import BeamSection
from creak.model.mesh import Model


@dataclass(frozen=True)
class SecondaryNodes:
    """Nodes that may touch a main surface."""

    rows: IntArray
    thickness: FloatArray
    """(n,) twice the distance from the node to the surface it stands for."""
    normal_stiffness: FloatArray
    """(n,) of the parent elements, see `Facets`; inf where there is none to ask."""
    depth: FloatArray
    """(n,) see `Facets`."""
    width: FloatArray
    """(n,) of the facets around; inf for nodes without."""
    arm: FloatArray
    """(n,) see `Facets`; of nodes of shells without facets half the thickness, which their gap does not know of."""


def nodes_of(model: Model, name: str, *, where: str) -> SecondaryNodes:
    """Nodes of a secondary surface, element set or node set.

    Nodes of facets take the mean of the facets around them. Nodes of beams have the section's outer radius where
    it is known (CIRC, PIPE; RECT: half the smaller side), also in node sets and node-based surfaces; all other
    nodes of these have no thickness, as in Abaqus.

    Raises
    ------
    InputError : see `facets_of`.
    """
    surface = model.surfaces.get(name.upper())
    if surface is not None and surface.is_node_based:
        return _bare_nodes(model, np.unique(surface.nodes_idx))
    members = model.element_sets.get(name.upper()) if surface is None else None
    if surface is None and members is None and name.upper() in model.node_sets:
        return _bare_nodes(model, np.unique(model.node_set(name, where=where)))
    if members is not None:
        lines = np.array([model.blocks[row].kind in ("beam2", "beam3", "truss2") for row in members[:, 0]], dtype=bool)
        if lines.any() and lines.all():
            ends = [model.blocks[row].nodes_idx[element] for row, element in members]
            return _bare_nodes(model, np.unique(np.concatenate(ends)))
    facets = facets_of(model, name, where=where)
    values = (facets.thickness, facets.normal_stiffness, facets.depth, facets.width, facets.arm)
    return SecondaryNodes(facets.node_rows, *(nodal(facets, v) for v in values))


def _bare_nodes(model: Model, rows: IntArray) -> SecondaryNodes:
    """Nodes without facets: those of beams alone have the radius of the thickest."""
    n = model.nodes.count
    radius, arm, other = np.zeros(n), np.zeros(n), np.zeros(n, dtype=bool)
    for block in model.blocks:
        if isinstance(block.section, BeamSection):
            np.maximum.at(radius, block.nodes_idx, block.section.radius)
            np.maximum.at(arm, block.nodes_idx, block.section.radius * (block.kind != "truss2"))
        elif block.kind in SHELL_FACETS or block.kind in FACES:
            other[block.nodes_idx] = True
            if bends(block.section):
                np.maximum.at(arm, block.nodes_idx, 0.5 * block.section.thickness)
    endless = np.full(rows.size, np.inf)
    thickness = np.where(other, 0.0, 2.0 * radius)[rows]
    return SecondaryNodes(rows, thickness, endless, np.zeros(rows.size), endless, arm[rows])


def nodal(facets: Facets, values: FloatArray) -> FloatArray:
    """Mean of a facet quantity at the surface's nodes, in the order of `node_rows`."""
    rows = facets.node_rows
    at = np.searchsorted(rows, facets.nodes)
    total = np.zeros(rows.size)
    count = np.zeros(rows.size)
    np.add.at(total, at, values[:, None])
    np.add.at(count, at, 1.0)
    return total / count


ANOTHER = 0.5
"""Walls of the main surface whose normals are 60 degrees or more apart are different ones for a node between them."""
MOST_WALLS = 6
"""Of a node: those of a box."""
IN_FRONT = 1e-9
"""Share of the reach that a further wall must be away from a node whose own surface does not look at it."""


def node_to_surface(model: Model, pair: ContactPair, keep: Keep | None = None) -> tuple[GapOperator, list[str]]:
    """One channel per secondary node: g = g0 + n . (u_s - sum_j N_j u_j), n the main normal at the projection.

    The partner facet is found once, in the undeformed shape (small sliding); n is the study's normal where it
    gives one. A node between walls that look in clearly different directions has a channel for each of them, named
    after their order (NAME:2). g0 is the distance of the mid-surfaces less half of both thicknesses (beams: their
    radius). A node behind a solid counts as inside it up to the height of the element under the face. Nodes without a
    partner are counted in a note. Pressure is not uniform on non-matching meshes; use `surface_to_surface` where that
    matters.

    Parameters
    ----------
    keep : takes what was found of the same nodes and facets before; None: they are searched.

    Raises
    ------
    InputError : unknown or unfit surfaces; surfaces that never face each other; deep initial overclosure; a normal
        of length zero.
    """
    secondary = nodes_of(model, pair.secondary, where=f"{pair.where} secondary")
    if pair.clearance is None:  # sides lie where the gap says
        secondary = replace(secondary, arm=np.minimum(secondary.arm, 0.5 * secondary.thickness))
    main = main_facets(model, pair)
    points, given = model.nodes.coords[secondary.rows], given_normal(pair)
    limit, outward = max(reach(points), reach(main.coords)), _outward(model, pair, secondary)
    depends_on = [points, outward, *vars(secondary).values(), *main.arrays]
    depends_on.append(np.zeros(0) if given is None else given)
    walls = searched(keep, depends_on, lambda: _searched(points, outward, secondary, main, given, limit))
    if pair.per_area:
        walls = [(rows, replace(c, scale=_areas(model, pair, rows, c.nodes_idx))) for rows, c in walls]
    return channels_of_walls(model, pair, walls, limit)


def _searched(
    points: FloatArray,
    outward: FloatArray,
    secondary: SecondaryNodes,
    main: Facets,
    given: FloatArray | None,
    limit: float,
) -> list[Wall]:
    """The channels to each wall; none where the nodes face no facet."""
    meet = _partners(points, given, main, limit)
    apart = ~np.isin(secondary.rows, main.nodes)
    found = np.flatnonzero(meet.found & apart)
    if not found.size:
        return []
    walls, seen = [_channels(secondary, main, meet, found, given)], [(found, _normals(main, meet, found))]
    while given is None and len(walls) < MOST_WALLS:
        other = _other_wall(points, outward, main, limit, seen)
        more = np.flatnonzero(other.found & apart)
        if not more.size:
            break
        seen.append((more, _normals(main, other, more)))
        walls.append(_channels(secondary, main, other, more, given))
    return walls


def _channels(
    secondary: SecondaryNodes, main: Facets, meet: Projection, found: IntArray, given: FloatArray | None
) -> Wall:
    """A channel for each node `found` to meet the main surface."""
    nodes, meet = secondary.rows[found], _subset(meet, found)
    sides = main.side[meet.facet] if given is None else np.ones(nodes.size, dtype=np.int64)
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
        scale=np.ones(nodes.size),
    )
    return _rows(nodes, main, meet, normal, secondary.arm[found]), channels


def _partners(points: FloatArray, normal: FloatArray | None, main: Facets, limit: float) -> Projection:
    """The main facet opposite each point."""
    behind = deepest(main)

    def accept(row: IntArray, facet: IntArray, distance: FloatArray, direction: FloatArray) -> BoolArray:
        inside = distance if normal is not None else distance * main.side[facet]
        good = ~main.is_solid[facet] | (inside <= behind[facet])
        return good if normal is None else good & looks_along(main, facet, direction, EDGE_ON)

    if normal is None:
        return project_closest(points, main, limit, accept)
    return project_along(points, np.tile(normal, (points.shape[0], 1)), main, limit, accept)


def _normals(main: Facets, meet: Projection, rows: IntArray) -> FloatArray:
    """(k, 3) from the main surface to the nodes `rows`, its own normals."""
    return gap_normals(_subset(meet, rows), main.side[meet.facet[rows]])[1]


def _other_wall(
    points: FloatArray, outward: FloatArray, main: Facets, limit: float, seen: list[tuple[IntArray, FloatArray]]
) -> Projection:
    """The nearest facet in front of each node that looks in a clearly different direction from those `seen`.

    Of surfaces with one side only walls that the node's own surface looks at count.
    """
    before = np.full((len(seen), points.shape[0], 3), np.nan)
    for k, (rows, normals) in enumerate(seen):
        before[k, rows] = normals

    def accept(row: IntArray, facet: IntArray, distance: FloatArray, direction: FloatArray) -> BoolArray:
        side = main.side[facet]
        normal = direction * np.where(side == 0, np.where(distance > 0.0, -1.0, 1.0), side)[:, None]
        front = np.where(side == 0, np.abs(distance), -distance * side)
        like = np.nan_to_num(np.einsum("krx,rx->kr", before[:, row], normal), nan=-1.0).max(axis=0)
        looks = np.nanmin(np.einsum("rfx,rx->rf", outward[row], normal), axis=1) < -ANOTHER if outward.size else True
        near = (-IN_FRONT if outward.size else IN_FRONT) * limit
        return np.asarray((front > near) & (like < ANOTHER) & looks)

    return project_closest(points, main, limit, accept)


def _outward(model: Model, pair: ContactPair, secondary: SecondaryNodes) -> FloatArray:
    """(n, f, 3) normals of the one-sided facets around each node, nan where there are fewer; empty where any facet
    has two sides or there are none."""
    if not np.isfinite(secondary.width).all():
        return np.zeros((0, 0, 3))
    facets = facets_of(model, pair.secondary, where=f"{pair.where} secondary")
    if (facets.side == 0).any():
        return np.zeros((0, 0, 3))
    normal = facets.area_normals * facets.side[:, None]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    corner = np.where(facets.is_triangle, 3, 4)[:, None] > np.arange(4)
    at, facet = np.searchsorted(secondary.rows, facets.nodes[corner]), np.nonzero(corner)[0]
    order = np.argsort(at, kind="stable")
    at, facet = at[order], facet[order]
    place = np.arange(at.size) - np.searchsorted(at, at)
    out = np.full((secondary.rows.size, int(place.max()) + 1, 3), np.nan)
    out[at, place] = normal[facet]
    return out


def overhang(model: Model, pair: ContactPair, operator: GapOperator) -> tuple[IntArray, int]:
    """Nodes of the secondary surface that face no facet of the main one and touch nothing, and how many may touch.

    Parameters
    ----------
    operator : the channels of the pair.
    """
    rows = nodes_of(model, pair.secondary, where=f"{pair.where} secondary").rows
    left = np.setdiff1d(rows, operator.nodes_idx)
    if left.size:
        left = np.setdiff1d(left, main_facets(model, pair).nodes)
    return left, left.size + np.unique(operator.nodes_idx).size


def _areas(model: Model, pair: ContactPair, rows: ChannelRows, nodes: IntArray) -> FloatArray:
    """(n,) area of the secondary surface that belongs to each channel: an equal share of every facet around its node
    that looks at the wall, as the other faces of a solid at its edges do not. Of a node without any, it is that of all.

    Parameters
    ----------
    rows : of the channels, their nodes (n,).

    Raises
    ------
    InputError : the surface has no facets; the stiffness of the elements is asked for, which is not per area.
    """
    if pair.law.automatic:
        raise InputError(
            "per_area with the stiffness of the elements",
            where=f"{pair.where} per_area",
            expected="a stiffness or an overclosure curve",
            fix="Give one, or leave out per_area.",
        )
    facets = facets_of(model, pair.secondary, where=f"{pair.where} secondary")
    size = np.linalg.norm(facets.area_normals, axis=1) / np.where(facets.is_triangle, 3.0, 4.0)
    node = np.where(np.where(facets.is_triangle, 3, 4)[:, None] > np.arange(4), facets.nodes, -1)
    normal = np.zeros((nodes.size, 3))
    for x, dof in enumerate(TRANSLATIONS):
        own = rows.label == dof_labels(nodes[rows.channel], np.array(dof))
        normal[rows.channel[own], x] = rows.normal[own]
    order = np.argsort(node.ravel(), kind="stable")
    first, last = (np.searchsorted(node.ravel(), nodes, side, order) for side in ("left", "right"))
    channel = np.repeat(np.arange(nodes.size), last - first)
    facet = order[np.arange(channel.size) - np.repeat(np.cumsum(last - first) - last, last - first)] // 4
    looks = looks_along(facets, facet, -normal[channel], EDGE_ON)
    facing, every = (np.bincount(channel, size[facet] * x, nodes.size) for x in (looks, np.ones(looks.size)))
    return np.asarray(np.where(facing > 0.0, facing, every), dtype=np.float64)


def _subset(meet: Projection, keep: IntArray) -> Projection:
    return Projection(meet.found[keep], meet.facet[keep], meet.shape[keep], meet.distance[keep], meet.direction[keep])


def _rows(nodes: IntArray, main: Facets, meet: Projection, normal: FloatArray, arm: FloatArray) -> ChannelRows:
    """arm : (n,) of the secondary nodes, as `SecondaryNodes` has it."""
    n = nodes.size
    partners, shape = main.shapes.at(meet.facet, meet.shape)
    all_nodes, weight = np.column_stack([nodes, partners]), np.column_stack([np.ones(n), -shape])
    channel = np.repeat(np.arange(n), 3 * weight.shape[1])
    label = node_dofs(all_nodes.ravel(), TRANSLATIONS)
    tangents = tangents_of(normal)
    vectors = [(weight[:, :, None] * v[:, None, :]).ravel() for v in (normal, *tangents)]
    lever = weight * np.column_stack([-arm, np.tile(main.arm[meet.facet][:, None], shape.shape[1])])
    turns = [(lever[:, :, None] * v[:, None, :]).ravel() for v in turns_of(*tangents)]
    return ChannelRows(channel, label, *vectors).turning(channel, node_dofs(all_nodes.ravel(), ROTATIONS), *turns)
