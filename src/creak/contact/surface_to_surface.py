"""Surface-to-surface contact: gaps weighted by the secondary shape functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import Facets, facets_of, nodal_normals
from creak.contact.gap_operator import ChannelRows, GapOperator
from creak.contact.pair import (
    AUTO_FACTOR,
    ContactPair,
    channels_from_rows,
    main_facets,
    never_face,
    reach,
    tangents_of,
)
from creak.contact.search import project_along
from creak.model.mesh import Model

QUADRATURE = 10
"""Gauss points per direction: the edges of the main facets cross a secondary facet unseen, so few are not enough."""
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


def surface_to_surface(model: Model, pair: ContactPair) -> tuple[GapOperator, list[str]]:
    """One channel per secondary node: g_i = int N_i g dA / int N_i dA over the facets around it.

    The pointwise gap g is measured along the averaged secondary normal, less half of both thicknesses; the
    force k_A A_i max(-g_i, 0) with A_i = int N_i dA acts through the same weights, so a uniform pressure is
    passed on exactly between non-matching meshes wherever the quadrature resolves the main facets.
    Weights follow Puso and Laursen, Comput. Methods Appl. Mech. Eng. 193 (2004), with one constraint per
    secondary node; partner facets are found once (small sliding).

    Raises
    ------
    InputError : unknown or unfit surfaces; surfaces that never face each other; deep initial overclosure.
    """
    secondary = facets_of(model, pair.secondary, where=f"{pair.where} secondary")
    main = main_facets(model, pair)
    limit = max(reach(secondary.coords), reach(main.coords))
    points = _integration_points(secondary)
    meet = project_along(points.position, points.normal, main, limit)
    found = meet.found & _right_sides(points, meet.distance, meet.facet, secondary, main)
    found &= ~_shares_nodes(secondary, main, points.facet, meet.facet)
    if not found.any():
        raise never_face(pair, limit)
    sign = np.where(meet.distance > 0.0, -1.0, 1.0)
    normal = points.normal * sign[:, None]
    half = 0.5 * (secondary.thickness[points.facet] + main.thickness[meet.facet])
    gap = np.where(found, np.abs(meet.distance) - half, 0.0)
    nodes, at, share, area, channel_of = _channels(secondary, points, found)
    gap0 = _summed(at[found], (share * gap[:, None])[found], channel_of.size)
    thick = _summed(at[found], (share * 2.0 * half[:, None])[found], channel_of.size)
    keep = np.flatnonzero(channel_of >= 0)
    stiffness = _surface_stiffness(pair, secondary, main, points, meet.facet, found, at, share, channel_of.size)
    rows = _rows(secondary, main, points, meet.shape, meet.facet, normal, found, at, share, channel_of)
    return channels_from_rows(
        model, pair, rows, nodes[keep], gap0[keep], stiffness[keep] * area[keep], area[keep], thick[keep]
    )


def _integration_points(facets: Facets) -> Points:
    """Gauss points on quads, six points (degree 4) on triangles."""
    normals = nodal_normals(facets)[np.searchsorted(facets.node_rows, facets.nodes)]
    pieces = []
    triangle = facets.is_triangle
    for mine, (N, dN, w) in ((np.flatnonzero(~triangle), _quad_rule()), (np.flatnonzero(triangle), _tri_rule())):
        X = facets.coords[mine]
        tangents = np.einsum("qja,njx->nqax", dN, X)
        jacobian = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2)
        n_q = np.einsum("qj,njx->nqx", N, normals[mine])
        n_q /= np.maximum(np.linalg.norm(n_q, axis=2), 1e-300)[:, :, None]
        pieces.append((
            np.einsum("qj,njx->nqx", N, X).reshape(-1, 3), n_q.reshape(-1, 3), (jacobian * w).ravel(),
            np.tile(N, (mine.size, 1)), np.repeat(mine, w.size),
        ))  # fmt: skip
    return Points(*(np.concatenate([p[i] for p in pieces]) for i in range(5)))


def _quad_rule() -> tuple[FloatArray, FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(QUADRATURE)
    r, s = (a.ravel() for a in np.meshgrid(x, x, indexing="ij"))
    N = 0.25 * np.stack([(1 - r) * (1 - s), (1 + r) * (1 - s), (1 + r) * (1 + s), (1 - r) * (1 + s)], axis=1)
    dr = 0.25 * np.stack([-(1 - s), 1 - s, 1 + s, -(1 + s)], axis=1)
    ds = 0.25 * np.stack([-(1 - r), -(1 + r), 1 + r, 1 - r], axis=1)
    return N, np.stack([dr, ds], axis=2), np.outer(w, w).ravel()


def _tri_rule() -> tuple[FloatArray, FloatArray, FloatArray]:
    a, b = 0.445948490915965, 0.091576213509771
    r = np.array([a, 1 - 2 * a, a, b, 1 - 2 * b, b])
    s = np.array([a, a, 1 - 2 * a, b, b, 1 - 2 * b])
    w = 0.5 * np.repeat([0.223381589678011, 0.109951743655322], 3)
    N = np.stack([1 - r - s, r, s, np.zeros(6)], axis=1)
    dN = np.broadcast_to(np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]), (6, 4, 2))
    return N, dN, w


def _right_sides(
    points: Points, distance: FloatArray, facet: IntArray, secondary: Facets, main: Facets
) -> BoolArray:
    """False where a one-sided surface would have to touch with its other side."""
    towards = np.sign(distance)
    own_side = secondary.side[points.facet]
    ok = (own_side == 0) | (towards >= 0)
    normal = main.area_normals[facet] * np.where(main.side == 0, 1, main.side)[facet][:, None]
    facing = np.einsum("nx,nx->n", normal, points.normal) * towards
    return ok & ((main.side[facet] == 0) | (facing < 0.0))


def _shares_nodes(secondary: Facets, main: Facets, facet_s: IntArray, facet_m: IntArray) -> BoolArray:
    """A facet cannot touch its own neighbours."""
    both = secondary.nodes[facet_s][:, :, None] == main.nodes[facet_m][:, None, :]
    return np.asarray(both.any(axis=(1, 2)))


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


def _surface_stiffness(
    pair: ContactPair, secondary: Facets, main: Facets, points: Points, facet: IntArray,
    found: BoolArray, at: IntArray, share: FloatArray, n: int,
) -> FloatArray:  # fmt: skip
    """(n,) force / length^3: the study's number, or 10 x the softer parent's kappa G t over its facet's area."""
    if pair.stiffness is not None:
        return np.full(n, pair.stiffness)
    per_area = [f.normal_stiffness / np.linalg.norm(f.area_normals, axis=1) for f in (secondary, main)]
    soft = AUTO_FACTOR * np.minimum(per_area[0][points.facet], per_area[1][facet])
    return _summed(at[found], (share * soft[:, None])[found], n)


def _rows(
    secondary: Facets, main: Facets, points: Points, main_shape: FloatArray, facet: IntArray, normal: FloatArray,
    found: BoolArray, at: IntArray, share: FloatArray, channel_of: IntArray,
) -> ChannelRows:  # fmt: skip
    """(channel, label) triplets: share_i(q) n_q . (sum_s N_s u_s - sum_m N_m u_m)."""
    q = np.flatnonzero(found)
    nodes = np.concatenate([secondary.nodes[points.facet[q]], main.nodes[facet[q]]], axis=1)
    weight = np.concatenate([points.shape[q], -main_shape[q]], axis=1)
    tangents = tangents_of(normal[q])
    pieces: list[list[Any]] = []
    for corner in range(4):
        channel = channel_of[at[q, corner]]
        use = np.flatnonzero((channel >= 0) & (share[q, corner] != 0.0))
        scaled = share[q, corner][use, None] * weight[use]
        label = 6 * nodes[use][:, :, None] + np.arange(3)
        values = [(scaled[:, :, None] * v[use][:, None, :]).ravel() for v in (normal[q], *tangents)]
        pieces.append([np.repeat(channel[use], 24), label.ravel(), *values])
    joined = [np.concatenate([p[i] for p in pieces]) for i in range(5)]
    return ChannelRows(joined[0].astype(np.int64), joined[1].astype(np.int64), *joined[2:])
