"""Which sides of quadrilateral shells are free: no other shell has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import BoolArray, IntArray
from creak.model.mesh import ElementBlock


def with_free_sides(blocks: Sequence[ElementBlock]) -> list[ElementBlock]:
    """The blocks, quadrilateral shells with their free sides among all shells of the blocks."""
    shells = [k for k, block in enumerate(blocks) if block.kind in ("quad4", "tri3")]
    out = list(blocks)
    for k, free in zip(shells, free_sides([blocks[k].nodes_idx for k in shells]), strict=True):
        if blocks[k].kind == "quad4":
            out[k] = replace(blocks[k], own=replace(blocks[k].own, free_sides=free))
    return out


def free_sides(elements: Sequence[IntArray]) -> list[BoolArray]:
    """(n, k) for each (n, k) array of corner nodes: whether side k, from node k to the next, is in one element only."""
    if not elements:
        return []
    sides = [np.sort(np.stack([e, np.roll(e, -1, axis=1)], axis=2), axis=2).reshape(-1, 2) for e in elements]
    every = np.concatenate(sides).astype(np.int64)
    _, which, count = np.unique(every[:, 0] * (every.max() + 1) + every[:, 1], return_inverse=True, return_counts=True)
    free = np.split(count[which] == 1, np.cumsum([len(s) for s in sides])[:-1])
    return [f.reshape(e.shape) for f, e in zip(free, elements, strict=True)]
