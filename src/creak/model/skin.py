"""The surface that air touches: shells, and faces of solids that no other solid shares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.model.plain_mesh import Mesh
from creak.model.shell_facets import SHELL_FACETS, facets_of_shells
from creak.model.solid_faces import FACES, faces_of, free_faces

CORNERS = np.array([[0.25, 0.25, 0.25, 0.25], [1 / 3, 1 / 3, 1 / 6, 1 / 6]])
"""Share of each column of `Skin.nodes_idx` in the area of a quadrilateral, of a triangle."""


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
        x = self.corners
        return 0.5 * np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])

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

    def toward(self, point: FloatArray) -> FloatArray:
        """(n, 3) `areas` that look at a point: shells turned to it, faces of solids that look away 0."""
        areas = self.areas
        side = np.sign(np.einsum("nx,nx->n", areas, point - self.centres))
        return np.where(self.solid, np.maximum(side, 0.0), side)[:, None] * areas

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


def _solid_angle(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Solid angles of triangles seen from the origin (van Oosterom and Strackee, 1983)."""
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    top = np.einsum("nx,nx->n", a, np.cross(b, c))
    dots = [np.einsum("nx,nx->n", u, v) for u, v in ((a, b), (a, c), (b, c))]
    return np.asarray(2.0 * np.arctan2(top, la * lb * lc + dots[0] * lc + dots[1] * lb + dots[2] * la))
