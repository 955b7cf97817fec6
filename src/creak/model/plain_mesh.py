"""Nodes, elements and parts alone: what pictures and ParaView need of a model, and what results.h5 keeps of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from creak.arrays import IntArray
from creak.model.mesh import Nodes, Part


class Block(Protocol):
    """Elements of one kind and one part; `ElementBlock` is one."""

    @property
    def kind(self) -> str: ...
    @property
    def ids(self) -> IntArray: ...
    @property
    def nodes_idx(self) -> IntArray: ...
    @property
    def part(self) -> int: ...


class Mesh(Protocol):
    """What can be drawn; `Model` is one."""

    @property
    def nodes(self) -> Nodes: ...
    @property
    def blocks(self) -> Sequence[Block]: ...
    @property
    def parts(self) -> tuple[Part, ...]: ...
    @property
    def n_elements(self) -> int: ...


@dataclass(frozen=True)
class PlainBlock:
    """Elements of one kind and one part."""

    kind: str
    ids: IntArray
    """(n_elem,) labels as written in the deck."""
    nodes_idx: IntArray
    """(n_elem, n_node_per_element) rows into `Nodes`."""
    part: int
    """Row into the parts, -1 for elements that belong to none."""


@dataclass(frozen=True)
class PlainMesh:
    """A model without sections, constraints and sets."""

    nodes: Nodes
    blocks: tuple[PlainBlock, ...]
    parts: tuple[Part, ...]

    @property
    def n_elements(self) -> int:
        return sum(b.ids.size for b in self.blocks)


def plain_mesh(model: Mesh) -> PlainMesh:
    """The mesh of a model; blocks that only their sections tell apart become one."""
    alike: dict[tuple[str, int, int], list[Block]] = {}
    for b in model.blocks:
        alike.setdefault((b.kind, b.part, b.nodes_idx.shape[1]), []).append(b)
    blocks = tuple(
        PlainBlock(kind, np.concatenate([b.ids for b in some]), np.concatenate([b.nodes_idx for b in some]), part)
        for (kind, part, _), some in alike.items()
    )
    return PlainMesh(model.nodes, blocks, model.parts)
