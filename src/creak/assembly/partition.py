"""Parts cut up: some elements of a part become a part of their own, which shares nodes with the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import IntArray
from creak.model.mesh import ElementBlock, Model, Part, some_of


@dataclass(frozen=True)
class Pieces:
    """A model whose parts were cut up. Only for assembly: its sets and surfaces are left out."""

    model: Model
    group: tuple[int, ...]
    """(n_part,) the group that each part was made for, 0 for what remained."""


def cut(model: Model, groups: Sequence[IntArray], names: Sequence[str]) -> Pieces:
    """Give every group of elements a part of its own.

    Parameters
    ----------
    groups : for each block of the model (n_elem,) group number of its elements, 0 to stay.
    names : name of group 1, 2, ...; `{part}` stands for the part that was cut.

    Nodes that elements of both pieces use belong to both parts: `couple` ties them. Nodes without elements
    (reference nodes) stay with what remains.
    """
    parts, group = list(model.parts), [0] * len(model.parts)
    row: dict[tuple[int, int], int] = {}
    blocks: list[ElementBlock] = []
    for block, of in zip(model.blocks, groups, strict=True):
        for g in np.unique(of) if of.size else np.array([0]):
            part = block.part
            if g > 0 and part >= 0:
                if (part, int(g)) not in row:
                    row[part, int(g)] = len(parts)
                    title = names[int(g) - 1].format(part=model.parts[part].name)
                    parts.append(Part(title, np.zeros(0, dtype=np.int64)))
                    group.append(int(g))
                part = row[part, int(g)]
            mine = np.flatnonzero(of == g)
            blocks.append(replace(some_of(block, mine), part=part))
    used = [_nodes_of(blocks, i) for i in range(len(parts))]
    for (part, _), new in row.items():
        parts[new] = replace(parts[new], nodes_idx=used[new])
        gone = np.setdiff1d(used[new], used[part])
        parts[part] = replace(parts[part], nodes_idx=np.setdiff1d(parts[part].nodes_idx, gone))
    pieces = replace(model, blocks=tuple(blocks), parts=tuple(parts), node_sets={}, element_sets={}, surfaces={})
    return Pieces(pieces, tuple(group))


def _nodes_of(blocks: Sequence[ElementBlock], part: int) -> IntArray:
    mine = [b.nodes_idx.ravel() for b in blocks if b.part == part]
    return np.unique(np.concatenate(mine)) if mine else np.zeros(0, dtype=np.int64)


def shared_nodes(model: Model) -> IntArray:
    """Nodes that belong to several parts."""
    count = np.zeros(model.nodes.count, dtype=np.int64)
    for part in model.parts:
        count[part.nodes_idx] += 1
    return np.flatnonzero(count > 1)
