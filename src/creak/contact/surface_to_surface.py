"""Surface-to-surface contact: gaps weighted by the secondary shape functions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import Facets, corner_normals, facets_of
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
    given_normal,
    looks_along,
    main_facets,
    overlap,
    reach,
    searched,
    tangents_of,
    turns_of,
)
from creak.contact.search import Accept, Projection, project_along, project_twice
from creak.elements.geometry import gauss_triangle
from creak.model.dofs import ROTATIONS, TRANSLATIONS, node_dofs
from creak.model.mesh import Model
from creak.model.projection import facet_shape

QUADRATURE = 10
"""Gauss points per direction: the edges of the main facets cross a secondary facet unseen, so few are not enough."""
CUTS = 4
"""Parts of a triangle's side: CUTS^2 times six points, about as many as a quadrilateral has."""
LEAST_SHARE = 0.05
"""A node with less than this share of its tributary area opposite the main surface gets no channel."""


@dataclass(frozen=True)
class Points:
    """Integration points on the secondary facets."""

    position: FloatArray
    """(n, 3)"""
    normal: FloatArray
    """(n, 3) interpolated nodal normals."""
    weight: FloatArray
    """(n,) area."""
    shape: FloatArray
    """(n, 4) secondary shape functions."""
    facet: IntArray


def surface_to_surface(model: Model, pair: ContactPair, keep: Keep | None = None) -> tuple[GapOperator, list[str]]:
    """One channel per secondary node: g_i = int N_i g dA / int N_i dA over the facets around it.

    The pointwise gap g is measured along the averaged secondary normal, less half of both thicknesses; the
    force k_A A_i max(-g_i, 0) with A_i = int N_i dA acts through the same weights, so a uniform pressure is
    passed on exactly between non-matching meshes wherever the quadrature resolves the main facets.
    Weights follow Puso and Laursen, Comput. Methods Appl. Mech. Eng. 193 (2004), with one constraint per
    secondary node; partner facets are found once (small sliding). A normal given by the study replaces the
    averaged one. Faces of solids touch with their outer side; one that starts inside counts as closed up to the
    height of the element behind it. A surface that touches with both sides and lies between walls has a channel for
    each of them (NAME and NAME:2).

    Parameters
    ----------
    keep : takes what was found of the same facets before; None: they are searched.

    Raises
    ------
    InputError : unknown or unfit surfaces; surfaces that never face each other; deep initial overclosure; a normal
        of length zero.
    """
    secondary = facets_of(model, pair.secondary, where=f"{pair.where} secondary")
    main, given = main_facets(model, pair), given_normal(pair)
    limit = max(reach(secondary.coords), reach(main.coords))
    depends_on = [*secondary.arrays, *main.arrays, np.zeros(0) if given is None else given]
    walls = searched(keep, depends_on, lambda: _searched(secondary, main, given, limit))
    return channels_of_walls(model, pair, walls, limit)


def _searched(secondary: Facets, main: Facets, given: FloatArray | None, limit: float) -> list[Wall]:
    """The channels to each wall; none where the surfaces never face each other."""
    points = _integration_points(secondary)
    if given is not None:
        points = replace(points, normal=np.tile(-given, (points.weight.size, 1)))
    sides = _Sides(points, secondary, main, given is not None, limit)
    walls = _walls(sides)
    return [_of_wall(sides, wall) for wall in walls] if walls[0].found.any() else []


def _walls(sides: _Sides) -> list[Projection]:
    """Where the points meet the main surface; one by one for both sides of a secondary surface that lies between walls
    and touches with both, the nearer first."""
    points, main = sides.points, sides.main
    two_sided = sides.secondary.side[points.facet] == 0
    sought = points.position, points.normal, main, sides.limit, sides.accept
    if sides.given or not two_sided.any():
        return [project_along(*sought)]

    def then(meet: Projection) -> Accept:
        def accept(row: IntArray, facet: IntArray, distance: FloatArray, direction: FloatArray) -> BoolArray:
            sign, first = sides.sign(row, facet, distance), sides.sign(row, meet.facet[row], meet.distance[row])
            other = meet.found[row] & two_sided[row] & (sign * first < 0.0) & (-sign * distance > 0.0)
            return other & sides.accept(row, facet, distance, direction)

        return accept

    meet, behind = project_twice(*sought, then)
    if not behind.found.any():
        return [meet]
    first = sides.sign(np.arange(meet.found.size), meet.facet, meet.distance)
    walls = [_chosen(meet, behind, first == sign) for sign in (1.0, -1.0)]
    return sorted(walls, key=lambda w: float(np.abs(w.distance[w.found]).mean()) if w.found.any() else np.inf)


def _chosen(a: Projection, b: Projection, first: BoolArray) -> Projection:
    """Rows of `a` where `first`, of `b` elsewhere."""
    other = ~first
    pick = [np.where(first.reshape(-1, *[1] * (x.ndim - 1)), x, y) for x, y in zip(a.fields, b.fields, strict=True)]
    return Projection((a.found & first) | (b.found & other), *pick)


def _of_wall(sides: _Sides, meet: Projection) -> Wall:
    """The channels of the points that meet the main surface."""
    secondary, main, points, found = sides.secondary, sides.main, sides.points, meet.found
    sign = sides.sign(np.arange(found.size), meet.facet, meet.distance)
    normal = points.normal * sign[:, None]
    half = 0.5 * (secondary.thickness[points.facet] + main.thickness[meet.facet])
    gap = np.where(found, -sign * np.where(found, meet.distance, 0.0) - half, 0.0)
    nodes, at, share, area, channel_of = _channels(secondary, points, found)
    keep = np.flatnonzero(channel_of >= 0)

    def mean(values: FloatArray) -> FloatArray:
        return _summed(at[found], (share * values[:, None])[found], channel_of.size)[keep]

    width = np.minimum(secondary.width[points.facet], main.width[meet.facet])
    # (n,) smallest of the values (k,) at the points of each node; `at` (k, 4).
    least = np.full(nodes.size, np.inf)
    np.minimum.at(least, at[found], width[found][:, None])
    # (n_point,) force / length^3: 10 x the softer parent's stiffness over its facet's area.
    per_area = [f.normal_stiffness / np.linalg.norm(f.area_normals, axis=1) for f in (secondary, main)]
    channels = Channels(
        nodes_idx=nodes[keep],
        gap=mean(gap),
        depth=mean(
            overlap(
                (secondary.thickness[points.facet], main.thickness[meet.facet]),
                (secondary.depth[points.facet], main.depth[meet.facet]),
            )
        ),
        stiffness=mean(AUTO_FACTOR * np.minimum(per_area[0][points.facet], per_area[1][meet.facet])),
        area=area[keep],
        size=least[keep],
        scale=area[keep],
    )
    return _rows(sides, meet, normal, channel_of[at], share), channels


def _integration_points(facets: Facets) -> Points:
    """Gauss points on quads, as many in parts on triangles."""
    normals = corner_normals(facets)
    pieces = []
    triangle = facets.is_triangle
    for mine, (N, dN, w) in ((np.flatnonzero(~triangle), _quad_rule()), (np.flatnonzero(triangle), _tri_rule())):
        X = facets.coords[mine]
        tangents = np.einsum("qja,njx->nqax", dN, X)
        jacobian = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2)
        n_q = np.einsum("qj,njx->nqx", N, normals[mine])
        n_q /= np.maximum(np.linalg.norm(n_q, axis=2), 1e-300)[:, :, None]
        pieces.append(
            (
                np.einsum("qj,njx->nqx", N, X).reshape(-1, 3),
                n_q.reshape(-1, 3),
                (jacobian * w).ravel(),
                np.tile(N, (mine.size, 1)),
                np.repeat(mine, w.size),
            )
        )
    return Points(*(np.concatenate([p[i] for p in pieces]) for i in range(5)))


def _quad_rule() -> tuple[FloatArray, FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(QUADRATURE)
    xi = np.stack([a.ravel() for a in np.meshgrid(x, x, indexing="ij")], axis=1)
    return *facet_shape(xi, np.zeros(len(xi), dtype=bool)), np.outer(w, w).ravel()


def _tri_rule() -> tuple[FloatArray, FloatArray, FloatArray]:
    """The six-point rule in each of `CUTS`^2 triangles that the unit triangle is cut into."""
    points, weights = gauss_triangle()
    pieces = []
    for i in range(CUTS):
        for j in range(CUTS - i):
            pieces.append(np.array([i, j]) + points)
            if i + j < CUTS - 1:
                pieces.append(np.array([i + 1, j + 1]) - points)
    r, s = np.concatenate(pieces).T / CUTS
    w = np.tile(0.5 * weights / CUTS**2, len(pieces))
    N = np.stack([1 - r - s, r, s, np.zeros(r.size)], axis=1)
    dN = np.broadcast_to(np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]), (r.size, 4, 2))
    return N, dN, w


@dataclass(frozen=True)
class _Sides:
    """Which side of the surfaces may touch."""

    points: Points
    secondary: Facets
    main: Facets
    given: bool
    """The points' normal is the study's, not the surface's."""
    limit: float

    def sign(self, row: IntArray, facet: IntArray, distance: FloatArray) -> FloatArray:
        """+1 or -1: the normal from main to secondary is this times the points' normal.

        One-sided secondary surfaces touch along their normal, two-sided ones with the side that looks at a
        one-sided main surface, or at wherever a two-sided main surface lies.
        """
        one_sided = self.given | (self.secondary.side[self.points.facet[row]] != 0)
        outward = self.main.area_normals[facet] * self.main.side[facet][:, None]
        along = np.einsum("nx,nx->n", outward, self.points.normal[row])
        by_main = np.where(along > 0.0, 1.0, -1.0)
        free = np.where(self.main.side[facet] != 0, by_main, np.where(distance > 0.0, -1.0, 1.0))
        return np.where(one_sided, -1.0, free)

    @property
    def accept(self) -> Accept:
        """Meetings on the right sides, at most as deep as what lies behind, and not with a facet's own neighbours."""
        behind_s, behind_m = deepest(self.secondary), deepest(self.main)
        cosine = EDGE_ON if self.given else 0.0

        def accepted(row: IntArray, facet: IntArray, distance: FloatArray, _: FloatArray) -> BoolArray:
            own, sign = self.points.facet[row], self.sign(row, facet, distance)
            normal = self.points.normal[row] * sign[:, None]
            behind = np.maximum(behind_s[own], behind_m[facet])
            if self.given:
                behind = np.where(behind > 0.0, behind, self.limit)
            good = (-sign * distance >= -behind) & looks_along(self.main, facet, normal, cosine)
            if self.given:
                good &= looks_along(self.secondary, own, -normal, cosine)
            # A facet cannot touch its own neighbours.
            both = self.secondary.nodes[own][:, :, None] == self.main.nodes[facet][:, None, :]
            return good & ~both.any(axis=(1, 2))

        return accepted


def _channels(
    secondary: Facets, points: Points, found: BoolArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray, IntArray]:
    """Nodes, node position per point, N_i w / A_i per point, A_i, and the channel number of each node (-1: none)."""
    nodes = secondary.node_rows
    at = np.searchsorted(nodes, secondary.nodes[points.facet]).astype(np.int64)
    weighted = points.shape * points.weight[:, None]
    area = _summed(at[found], weighted[found], nodes.size)
    whole = _summed(at, weighted, nodes.size)
    enough = area > LEAST_SHARE * whole
    channel_of = np.where(enough, np.cumsum(enough) - 1, -1).astype(np.int64)
    share = np.where(enough[at], weighted / np.where(enough, area, 1.0)[at], 0.0)
    return nodes, at, np.asarray(share, dtype=np.float64), area, channel_of


def _summed(at: IntArray, values: FloatArray, n: int) -> FloatArray:
    """(n,) sums of the values that belong to each node."""
    return np.bincount(at.ravel(), values.ravel(), minlength=n).astype(np.float64)


def _rows(sides: _Sides, meet: Projection, normal: FloatArray, channel: IntArray, share: FloatArray) -> ChannelRows:
    """(channel, label) triplets: sum_q share_i(q) n_q . (sum_s N_s u_s - sum_m N_m u_m), along tangents with what the
    nodes' rotations move the sides that touch. N are the shape functions of the whole faces (`FaceShapes`).

    The weights of the points on every pair of channel and node come first; their product with the points' normals and
    tangents then sums over the points.
    """
    secondary, main, points, q = sides.secondary, sides.main, sides.points, np.flatnonzero(meet.found)
    own, own_shape = secondary.shapes.at(points.facet[q], points.shape[q])
    other, other_shape = main.shapes.at(meet.facet[q], meet.shape[q])
    nodes, weight = np.concatenate([own, other], axis=1), np.concatenate([own_shape, -other_shape], axis=1)
    channel, share = channel[q], share[q]
    row, corner = np.nonzero((channel >= 0) & (share != 0.0))
    n_node = int(nodes.max(initial=0)) + 1
    pairs, pair = np.unique((channel[row, corner, None] * n_node + nodes[row]).ravel(), return_inverse=True)
    weights = (share[row, corner, None] * weight[row]).ravel()
    W = sp.csr_matrix((weights, (pair, np.repeat(row, weight.shape[1]))), shape=(pairs.size, q.size))
    label = node_dofs(pairs % n_node, TRANSLATIONS)
    tangents, of = tangents_of(normal[q]), np.repeat(pairs // n_node, 3)
    rows = ChannelRows(of, label, *((W @ v).ravel() for v in (normal[q], *tangents)))
    of_own = np.arange(weight.shape[1]) < own.shape[1]
    arms = np.where(of_own, -secondary.arm[points.facet[q], None], main.arm[meet.facet[q], None])
    if not arms.any():
        return rows
    levers = (share[row, corner, None] * (weight * arms)[row]).ravel()
    W = sp.csr_matrix((levers, (pair, np.repeat(row, weight.shape[1]))), shape=(pairs.size, q.size))
    return rows.turning(of, node_dofs(pairs % n_node, ROTATIONS), *((W @ v).ravel() for v in turns_of(*tangents)))
