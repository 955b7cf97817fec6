"""Elements while a deck is read: groups of one kind and section, which become blocks of one part each."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.materials import Section
from creak.model.mesh import ElementBlock, Own


@dataclass
class Group:
    """Elements of one kind and one section."""

    kind: str
    section: Section
    ids: list[int] = field(default_factory=list)
    nodes: list[list[int]] = field(default_factory=list)
    where: str = ""
    own: dict[str, list[FloatArray]] = field(default_factory=dict)
    """axis1, axis2, thickness, arms: one entry for each element, or none at all."""

    def put(self, identifier: int, nodes: list[int], own: Mapping[str, FloatArray]) -> None:
        """One more element, with what it has of its own."""
        self.ids.append(identifier)
        self.nodes.append(nodes)
        for name, value in own.items():
            self.own[name].append(np.asarray(value, dtype=np.float64))


Groups = dict[tuple[object, ...], Group]
"""By a key that tells sections apart."""


def group_of(
    groups: Groups, key: tuple[object, ...], kind: str, section: Section, where: str, own: Collection[str]
) -> Group:
    """The group of a kind, a section and the names of what its elements have of their own; `where`: of its first."""
    full = (kind, *key, *sorted(own))
    if full not in groups:
        groups[full] = Group(kind, section, where=where, own={name: [] for name in own})
    return groups[full]


def blocks_of(groups: Groups, of_node: IntArray) -> tuple[ElementBlock, ...]:
    """One block for each group and part."""
    found: list[ElementBlock] = []
    for group in groups.values():
        nodes = np.array(group.nodes, dtype=np.int64)
        part = of_node[nodes]
        part_of = np.where((part == part[:, :1]).all(axis=1), part[:, 0], -1)
        for p in dict.fromkeys(part_of.tolist()):
            found.append(_block(group, nodes, np.flatnonzero(part_of == p), p))
    return tuple(found)


def _block(group: Group, nodes: IntArray, rows: IntArray, part: int) -> ElementBlock:
    own: dict[str, Any] = {name: np.array(values)[rows] for name, values in group.own.items()}
    ids = np.array(group.ids, dtype=np.int64)[rows]
    return ElementBlock(group.kind, ids, nodes[rows], group.section, int(part), group.where, Own(**own))
