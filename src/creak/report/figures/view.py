"""Where the reader stands, and what can be drawn of a model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.faces import FACES, SHELL_FACETS, faces_of, facets_of_shells, free_faces
from creak.model.plain_mesh import Mesh

LINES = ("beam2", "beam3", "truss2", "spring2")
FLAT = 0.25
"""Extent along z over the lesser of the others, up to which a model is looked at from above."""
EDGES_UP_TO = 8000
"""Facets up to which element edges are drawn."""


class Sides(Protocol):
    """Nodes on both sides of gap channels; `GapOperator` has them."""

    @property
    def m(self) -> int: ...
    @property
    def nodes_idx(self) -> IntArray: ...
    @property
    def retained_nodes(self) -> IntArray: ...


@dataclass(frozen=True)
class View:
    """Parallel projection; columns of `matrix` are right, up and toward the reader."""

    matrix: FloatArray

    def rotate(self, xyz: FloatArray) -> FloatArray:
        """(n, 3) right, up, toward."""
        return xyz @ self.matrix

    def flat(self, xyz: FloatArray) -> FloatArray:
        """(n, 2) position on paper."""
        return xyz @ self.matrix[:, :2]


@dataclass(frozen=True)
class Facets:
    """Surfaces to paint; a triangle repeats its last corner."""

    nodes_idx: IntArray
    """(n, 4)"""
    part: IntArray
    """(n,) row into `Model.parts`, -1 for none."""

    @property
    def count(self) -> int:
        return int(self.part.size)


def facets_of(model: Mesh) -> Facets:
    """Shell elements and free faces of solids."""
    nodes, part = [np.zeros((0, 4), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for faces, owner in _solid_faces(model):
        nodes.append(faces)
        part.append(owner)
    for block in model.blocks:
        if block.kind in SHELL_FACETS:
            nodes.append(facets_of_shells(block.kind, block.nodes_idx).reshape(-1, 4))
            part.append(np.full(nodes[-1].shape[0], block.part, dtype=np.int64))
    return Facets(np.concatenate(nodes), np.concatenate(part))


def _solid_faces(model: Mesh) -> list[tuple[IntArray, IntArray]]:
    """Free faces (k, 4) of the solids and their parts (k,); none where there are no solids."""
    solids = [b for b in model.blocks if b.kind in FACES]
    if not solids:
        return []
    faces = [faces_of(b.kind, b.nodes_idx) for b in solids]
    every = np.concatenate([f.reshape(-1, 4) for f in faces])
    owner = np.concatenate([np.full(f.shape[0] * f.shape[1], b.part) for f, b in zip(faces, solids, strict=True)])
    free = free_faces(every, [every])
    return [(every[free], owner[free].astype(np.int64))]


def lines_of(model: Mesh) -> IntArray:
    """(n, 2) ends of beams, trusses and springs."""
    ends = [b.nodes_idx[:, :2] for b in model.blocks if b.kind in LINES]
    return np.concatenate([np.zeros((0, 2), dtype=np.int64), *ends])


def front(coords: FloatArray, outward: FloatArray) -> View:
    """Look along the shorter of x and y, z up; on a model that is flat along z from above, y up.

    Parameters
    ----------
    outward : (3,) roughly the way from the hidden to the facing side; zero where there is no such way.
    """
    extent = np.ptp(coords, axis=0)
    toward = 2 if extent[2] <= FLAT * extent[:2].min() else int(np.argmin(extent[:2]))
    up = 2 if toward != 2 else 1
    axes = np.eye(3)
    sign = float(np.sign(outward[toward])) or (-1.0 if toward == 1 else 1.0)
    t, u = sign * axes[toward], axes[up]
    return View(np.column_stack([np.cross(u, t), u, t]))


def three_quarter(straight: View) -> View:
    """The front view turned by 32 degrees about the vertical and tilted by 18."""
    a, e = np.radians([-32.0, 18.0])
    right, up, toward = straight.matrix.T
    t = np.cos(e) * (np.cos(a) * toward + np.sin(a) * right) + np.sin(e) * up
    r = np.cos(a) * right - np.sin(a) * toward
    return View(np.column_stack([r, np.cross(t, r), t]))


def outward(gaps: Sides, coords: FloatArray) -> FloatArray:
    """From the main to the secondary side of the contact, (3,); zero without contact."""
    other = np.setdiff1d(gaps.retained_nodes, gaps.nodes_idx)
    if gaps.m == 0 or other.size == 0:
        return np.zeros(3)
    return np.asarray(coords[gaps.nodes_idx].mean(axis=0) - coords[other].mean(axis=0))


def cut_up(corners: FloatArray, cuts: int) -> tuple[FloatArray, FloatArray]:
    """Quadrilaterals (n, 4, 3) divided into cuts x cuts each, and their edges as patches without width.

    Returns
    -------
    inner : (n cuts^2, 4, 3), edges : (4 n cuts, 4, 3); the pieces of one quadrilateral follow each other.
    """
    s = np.linspace(0.0, 1.0, cuts + 1)
    u, v = np.meshgrid(s, s, indexing="ij")
    weight = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=-1)
    grid = np.einsum("uvk,nkx->nuvx", weight, corners)
    inner = np.stack([grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:]], axis=3)
    sides = np.stack([grid[:, :, 0], grid[:, :, -1], grid[:, 0, :], grid[:, -1, :]], axis=1)
    ends = sides[:, :, :-1], sides[:, :, 1:]
    edges = np.stack([ends[0], ends[1], ends[1], ends[0]], axis=3)
    return inner.reshape(-1, 4, 3), edges.reshape(-1, 4, 3)
