"""The surface that air touches: shells, and faces of solids that no other solid shares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from creak.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from creak.model.faces import FACES, SHELL_FACETS, faces_of, facets_of_shells, free_faces, vector_areas
from creak.model.plain_mesh import Mesh

CORNERS = np.array([[0.25, 0.25, 0.25, 0.25], [1 / 3, 1 / 3, 1 / 6, 1 / 6]])
"""Share of each column of `Skin.nodes_idx` in the area of a quadrilateral, of a triangle."""

EDGE_ON = 0.1
"""Solid angle over that of the same area looked at straight, below which a panel is looked at along its plane."""
CLOSED = 1e-6
"""Of the area of a panel that is closed, what is left of its sum with directions."""
ASKEW = np.array([1.0, 0.5**0.5, 3.0**-0.5])
"""A direction that no panel is likely to hold: sides of panels are told by it, those of parallel ones alike."""
AT_ONCE = 4_000_000
"""Products worked on at a time."""


@dataclass(frozen=True)
class Skin:
    """Facets of a model; a triangle repeats its third node."""

    nodes_idx: IntArray
    """(n, 4) rows of the model's nodes."""
    corners: FloatArray
    """(n, 4, 3) length."""
    part: IntArray
    """(n,) row into `Model.parts`, -1 for none."""
    solid: BoolArray
    """(n,) the facet's normal looks out of a solid; that of a shell looks anywhere."""

    @property
    def count(self) -> int:
        return int(self.part.size)

    @property
    def areas(self) -> FloatArray:
        """(n, 3) area along the normal, length^2."""
        return vector_areas(self.corners)

    @property
    def shares(self) -> FloatArray:
        """(n, 4) of the area, column by column of `nodes_idx`."""
        return CORNERS[(self.nodes_idx[:, 2] == self.nodes_idx[:, 3]).astype(np.int64)]

    @property
    def centres(self) -> FloatArray:
        """(n, 3)"""
        return np.asarray(np.einsum("nc,ncx->nx", self.shares, self.corners))

    @property
    def size(self) -> FloatArray:
        """(n,) longest side, length."""
        return np.asarray(np.linalg.norm(np.roll(self.corners, -1, axis=1) - self.corners, axis=2).max(axis=1))

    def select(self, which: BoolArray) -> Skin:
        """Some of the facets."""
        return Skin(self.nodes_idx[which], self.corners[which], self.part[which], self.solid[which])

    def has(self, nodes_idx: IntArray) -> BoolArray:
        """(n,) which facets are among others (k, 4), whichever way these are turned."""
        both = np.sort(np.concatenate([self.nodes_idx, nodes_idx]), axis=1)
        _, which = np.unique(both, axis=0, return_inverse=True)
        own, others = np.split(which.ravel(), [self.count])
        return np.isin(own, others)

    def toward(self, point: FloatArray) -> ComplexArray:
        """(n, 3) `areas` that send to a point: shells turned to it, faces of solids as far as they look at it.

        Shells joined along their edges are a panel, with one side that looks at the point, that of its solid angle: a
        curved one moves as much air as it pushes. It sends as much to either side, with the opposite sign. Near its
        plane the sign turns as a phase, so that nothing jumps where several panels are heard; that of the panel which
        is heard best is 0 or half a turn. A face of a solid that looks away fades out over the depth of its body
        behind it, while the opposite one fades in.
        """
        areas = self.areas.astype(np.complex128)
        away = np.einsum("nx,nx->n", self.areas, point - self.centres)
        solid = np.flatnonzero(self.solid & (away < 0.0))
        areas[solid] *= np.maximum(1.0 + away[solid] / self._depths(solid), 0.0)[:, None]
        shell = np.flatnonzero(~self.solid)
        if shell.size:
            turn, panel, sign = self._panels(shell, point)
            loud = np.linalg.norm(self.areas, axis=1) / np.linalg.norm(self.centres - point, axis=1)
            best = np.bincount(panel, loud[shell])
            if best.max() > loud[self.solid].sum():
                loudest = sign[best.argmax()]
                sign = sign / loudest * np.copysign(1.0, loudest.real)
            areas[shell] *= (turn * sign[panel])[:, None]
        return areas

    def _panels(self, shell: IntArray, point: FloatArray) -> tuple[FloatArray, IntArray, ComplexArray]:
        """Facets of shells turned alike and their panels, as `panels`, and each panel's sign as a point sees it."""
        turn, panel = panels(self.nodes_idx[shell])
        areas, middles, x = self.areas[shell] * turn[:, None], self.centres[shell], self.corners[shell] - point

        def of_panel(each: FloatArray) -> FloatArray:
            return np.stack([np.bincount(panel, column) for column in each.T], axis=1)

        whole = of_panel(areas)
        closed = np.linalg.norm(whole, axis=1) <= CLOSED * np.bincount(panel, np.linalg.norm(areas, axis=1))
        swells = np.bincount(panel, np.einsum("nx,nx->n", areas, middles - middles.mean(axis=0)))
        side = np.where(np.where(closed, swells, whole @ ASKEW) < 0.0, -1.0, 1.0)
        straight = np.linalg.norm(of_panel(areas / ((middles - point) ** 2).sum(axis=1)[:, None]), axis=1)
        angle = -turn * sum(_solid_angle(x[:, 0], x[:, i], x[:, i + 1]) for i in (1, 2))
        height = side * np.bincount(panel, angle) / np.maximum(EDGE_ON * straight, np.finfo(np.float64).tiny)
        before = np.sin(0.5 * np.pi * np.clip(np.where(closed, 1.0, height), -1.0, 1.0))
        return turn * side[panel], panel, np.exp(0.5j * np.pi * (1.0 - before))

    def _depths(self, which: IntArray) -> FloatArray:
        """(k,) of facets of solids: how far their body reaches behind them, times their area, length^3."""
        solid = np.flatnonzero(self.solid)
        nodes, row = np.unique(self.nodes_idx[solid], return_inverse=True)
        row = row.reshape(-1, 4)
        joined = sp.coo_array((np.ones(row.size), (np.repeat(row[:, 0], 4), row.ravel())), shape=(nodes.size,) * 2)
        body = connected_components(joined, directed=False)[1]
        points = np.zeros((nodes.size, 3))
        points[row] = self.corners[solid]
        areas, middles, own = self.areas[which], self.centres[which], body[row[np.searchsorted(solid, which), 0]]
        found = np.einsum("nx,nx->n", areas, middles)
        for k in np.unique(own).tolist():
            of_body = points[body == k]
            mine = np.flatnonzero(own == k)
            for some in np.array_split(mine, 1 + mine.size * of_body.shape[0] // AT_ONCE):
                found[some] -= (areas[some] @ of_body.T).min(axis=1)
        return np.maximum(found, np.finfo(np.float64).tiny)

    def holds(self, point: FloatArray) -> bool:
        """Whether a point lies inside the solids: they fill most of the solid angle around it."""
        x = self.corners[self.solid] - point
        angle = sum(_solid_angle(x[:, 0], x[:, i], x[:, i + 1]).sum() for i in (1, 2))
        return bool(abs(angle) > 2.0 * np.pi)


def skin_of(model: Mesh) -> Skin:
    """All shells and free faces of solids."""
    solids = [b for b in model.blocks if b.kind in FACES]
    every = [faces_of(b.kind, b.nodes_idx).reshape(-1, 4) for b in solids]
    nodes = [np.zeros((0, 4), dtype=np.int64)]
    part = [np.zeros(0, dtype=np.int64)]
    for block, faces in zip(solids, every, strict=True):
        free = faces[free_faces(faces, every)]
        nodes.append(free)
        part.append(np.full(free.shape[0], block.part, dtype=np.int64))
    of_solids = sum(p.size for p in part)
    for block in model.blocks:
        if block.kind in SHELL_FACETS:
            nodes.append(facets_of_shells(block.kind, block.nodes_idx).reshape(-1, 4))
            part.append(np.full(nodes[-1].shape[0], block.part, dtype=np.int64))
    table = np.concatenate(nodes)
    return Skin(table, model.nodes.coords[table], np.concatenate(part), np.arange(table.shape[0]) < of_solids)


Sides = tuple[IntArray, IntArray, IntArray, IntArray]
"""Of facets, see `sides_of`."""


def sides_of(nodes_idx: IntArray) -> Sides:
    """Sides of facets (n, 4), in their order: the facet of each, its ends (n_side, 2) as the facet is turned, the edge
    on which it lies, and how many facets meet there."""
    start, end = nodes_idx.ravel(), np.roll(nodes_idx, -1, axis=1).ravel()
    there = start != end  # a triangle repeats a corner
    ends = np.stack([start, end], axis=1)[there]
    _, edge, count = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    return np.repeat(np.arange(nodes_idx.shape[0]), 4)[there], ends, edge.ravel(), count[edge.ravel()]


def panels(nodes_idx: IntArray, sides: Sides | None = None) -> tuple[FloatArray, IntArray]:
    """Facets (n, 4) of shells as panels: 1 or -1 (n,) that turns all of one alike, and the panel (n,) of each.

    Facets are joined along edges that two of them share. One that cannot be turned as its neighbours are, as on a strip
    with a twist, is a panel by itself.

    Parameters
    ----------
    sides : `sides_of` these, where they are known.
    """
    n, (facet, ends, edge, count) = nodes_idx.shape[0], sides or sides_of(nodes_idx)
    order = np.argsort(edge, kind="stable")
    i, j = order[count[order] == 2].reshape(-1, 2).T
    # Neighbours that are turned alike run along their edge in opposite directions. Facet k turned round is n + k.
    across = np.where(ends[i, 0] == ends[j, 0], n, 0)
    i, j = facet[i], facet[j]
    joined = sp.coo_array(
        (np.ones(2 * i.size), (np.concatenate([i, i + n]), np.concatenate([j + across, (j + n + across) % (2 * n)]))),
        shape=(2 * n, 2 * n),
    )
    label = connected_components(joined, directed=False)[1]
    own, turned = label[:n], label[n:]
    panel = np.where(own == turned, 2 * n + np.arange(n), np.minimum(own, turned))
    return np.where(own <= turned, 1.0, -1.0), np.unique(panel, return_inverse=True)[1].ravel()


def _solid_angle(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Solid angles of triangles seen from the origin (van Oosterom and Strackee, 1983)."""
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    top = np.einsum("nx,nx->n", a, np.cross(b, c))
    dots = [np.einsum("nx,nx->n", u, v) for u, v in ((a, b), (a, c), (b, c))]
    return np.asarray(2.0 * np.arctan2(top, la * lb * lc + dots[0] * lc + dots[1] * lb + dots[2] * la))
