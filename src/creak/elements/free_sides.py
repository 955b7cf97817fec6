"""Which sides of quadrilateral shells are free: no other shell has them. At which ones of triangles a plane ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.elements.geometry import unit
from creak.elements.shells.common import mean_normal
from creak.model.faces import SMOOTH
from creak.model.mesh import ElementBlock

SHELLS = ("quad4", "tri3")
HOLDS = 0.5
"""Share of a rotation that must be held at both ends of a side for its edge to have a twisting moment."""


def with_free_sides(blocks: Sequence[ElementBlock], beside: Sequence[IntArray] = ()) -> list[ElementBlock]:
    """The blocks, quadrilateral shells with their free sides among all shells of the blocks and those `beside` them."""
    shells = [k for k, block in enumerate(blocks) if block.kind in SHELLS]
    out = list(blocks)
    for k, free in zip(shells, free_sides([*(blocks[k].nodes_idx for k in shells), *beside]), strict=False):
        if blocks[k].kind == "quad4":
            out[k] = replace(blocks[k], own=replace(blocks[k].own, free_sides=free))
    return out


def free_sides(elements: Sequence[IntArray]) -> list[BoolArray]:
    """(n, k) for each (n, k) array of corner nodes: whether side k, from node k to the next, is in one element only."""
    if not elements:
        return []
    _, which, count = np.unique(_keys(elements), return_inverse=True, return_counts=True)
    return _by_element(count[which] == 1, elements)


def ending_sides(coords: FloatArray, elements: Sequence[IntArray]) -> list[BoolArray]:
    """The same: whether no other element continues the surface beyond side k, within 20 degrees. Folds are ends."""
    if not elements:
        return []
    normals = np.concatenate([np.repeat(mean_normal(coords[e]), e.shape[1], axis=0) for e in elements])
    keys = _keys(elements)
    order = np.argsort(keys, kind="stable")
    keys, normals = keys[order], normals[order]
    goes_on, apart = np.zeros(keys.size, dtype=bool), 1
    while (same := np.flatnonzero(keys[apart:] == keys[:-apart])).size:
        smooth = same[np.abs(np.einsum("ni,ni->n", normals[same], normals[same + apart])) >= SMOOTH]
        goes_on[smooth] = goes_on[smooth + apart] = True
        apart += 1
    ends = np.empty_like(goes_on)
    ends[order] = ~goes_on
    return _by_element(ends, elements)


def twisting_sides(
    coords: FloatArray, triangles: IntArray, ends: BoolArray, nodes: IntArray, held: FloatArray
) -> BoolArray:
    """Sides (n, 3) at which a plane ends and the rotation about the normal to the edge in that plane is not held.

    Along these a twisting moment falls to nothing in a layer, see `shells.tri3`; elsewhere the edge bears it.

    Parameters
    ----------
    coords : (n_node, 3). triangles : (n, 3) corner nodes. ends : (n, 3) of `ending_sides`.
    nodes : (k,) sorted, those where something holds rotations.
    held : (k, 3, 3) the projection on the rotations held there.
    """
    out = ends.copy()
    element, side = np.nonzero(ends)
    if not nodes.size or not element.size:
        return out
    ends_of = np.stack([triangles[element, side], triangles[element, (side + 1) % 3]], axis=1)
    at = np.minimum(np.searchsorted(nodes, ends_of), nodes.size - 1)
    some = np.flatnonzero((nodes[at] == ends_of).all(axis=1))
    along = coords[ends_of[some, 1]] - coords[ends_of[some, 0]]
    across = unit(np.cross(mean_normal(coords[triangles[element[some]]]), along))
    share = np.einsum("ei,ekij,ej->ek", across, held[at[some]], across)
    borne = some[(share >= HOLDS).all(axis=1)]
    out[element[borne], side[borne]] = False
    return out


def _keys(elements: Sequence[IntArray]) -> IntArray:
    """One number for each side of each element, the same for the same two nodes."""
    sides = [np.sort(np.stack([e, np.roll(e, -1, axis=1)], axis=2), axis=2).reshape(-1, 2) for e in elements]
    every = np.concatenate(sides).astype(np.int64)
    return np.asarray(every[:, 0] * (every.max(initial=0) + 1) + every[:, 1], dtype=np.int64)


def _by_element(of_sides: BoolArray, elements: Sequence[IntArray]) -> list[BoolArray]:
    each = np.split(of_sides, np.cumsum([e.size for e in elements])[:-1])
    return [part.reshape(e.shape) for part, e in zip(each, elements, strict=True)]
