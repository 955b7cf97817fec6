"""What joins two parts at a pair of nodes: found, taken out of the model, and put elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.elements.block_matrices import block_matrices
from creak.model.dofs import PER_NODE
from creak.model.mesh import ElementBlock, Model, some_of


@dataclass(frozen=True)
class Fastener:
    """Elements between two parts, or links of one node to one."""

    nodes: tuple[int, int]
    """Rows of the nodes, in order."""
    stiffness: FloatArray | None
    """(3, 3) against relative translation; None: it is rigid."""


def nearest_fastener(model: Model, parts: tuple[int, int], point: FloatArray, beyond: float) -> Fastener | None:
    """The one between two parts that is nearest to a point, of those further than `beyond` from it."""
    found = []
    for pair in sorted({pair for _, pair in _pairs(model)}):
        if {part_of(model, n) for n in pair} != set(parts):
            continue
        away = float(np.linalg.norm(model.nodes.coords[list(pair)].mean(axis=0) - point))
        if away > beyond:
            found.append((away, pair))
    if not found:
        return None
    pair = min(found)[1]
    return Fastener(pair, _stiffness(model, pair))


def without_fastener(model: Model, fastener: Fastener) -> Model:
    """The model with neither elements nor links between its two nodes."""
    blocks: list[ElementBlock] = []
    for block in model.blocks:
        own = _between(block, fastener.nodes)
        kept = np.flatnonzero(~own)
        blocks.append(some_of(block, kept) if own.any() else block)
    links = tuple(c for c in model.constraints if _ends(c.nodes) != fastener.nodes)
    return replace(model, blocks=tuple(b for b in blocks if b.ids.size), constraints=links)


def part_of(model: Model, node: int) -> int:
    """Row of the part that has a node, -1: none."""
    return next((i for i, p in enumerate(model.parts) if p.has(node)), -1)


def _pairs(model: Model) -> Iterator[tuple[object, tuple[int, int]]]:
    """Everything that has just two nodes, in different parts."""
    for block in model.blocks:
        if block.part < 0 and block.nodes_idx.shape[1] == 2:
            yield from ((block, pair) for pair in map(_ends, block.nodes_idx) if pair is not None)
    for link in model.constraints:
        pair = _ends(link.nodes)
        if pair is not None:
            yield link, pair


def _ends(nodes_idx: IntArray) -> tuple[int, int] | None:
    """The two nodes, in order; None where there are not two."""
    nodes = np.unique(nodes_idx)
    return (int(nodes[0]), int(nodes[1])) if nodes.size == 2 else None


def _between(block: ElementBlock, nodes: tuple[int, int]) -> np.ndarray:
    """(n_elem,) elements between parts that have these two nodes."""
    if block.part >= 0 or block.nodes_idx.shape[1] != 2:
        return np.zeros(block.ids.size, dtype=bool)
    return np.asarray((np.sort(block.nodes_idx, axis=1) == nodes).all(axis=1))


def _stiffness(model: Model, nodes: tuple[int, int]) -> FloatArray | None:
    """(3, 3) of the elements between two nodes against relative translation; None where a link holds them."""
    if any(_ends(c.nodes) == nodes for c in model.constraints):
        return None
    k = np.zeros((3, 3))
    for block in model.blocks:
        rows = np.flatnonzero(_between(block, nodes))
        if rows.size:
            k += block_matrices(block, rows, model.nodes.coords)[0][:, :3, :3].sum(axis=0)
    return k


def translations(k: FloatArray) -> FloatArray:
    """(12, 12) stiffness of two nodes that resist relative translation with k (3, 3)."""
    D = np.zeros((3, 2 * PER_NODE))
    D[:, :3], D[:, PER_NODE : PER_NODE + 3] = np.eye(3), -np.eye(3)
    return np.asarray(D.T @ k @ D)
