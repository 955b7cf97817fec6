"""Which scope of a deck nodes and elements are written in, and what they are called there."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeVar

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.abaqus.text.fields import split_name
from creak.model.mesh import ElementBlock, Model

T = TypeVar("T")
PER_LINE = 8
ROOT = -1
"""The flat deck or the assembly."""
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")


def number(value: float) -> str:
    """Shortest decimal that reads back exactly."""
    return repr(float(value))


def numbers(values: Iterable[float]) -> str:
    return ", ".join(number(v) for v in values)


def listed(tokens: Sequence[str]) -> Iterator[str]:
    """Data lines with eight fields each."""
    for k in range(0, len(tokens), PER_LINE):
        yield ", ".join(tokens[k : k + PER_LINE])


def vector(values: FloatArray | Sequence[float]) -> str:
    return numbers(np.asarray(values, dtype=np.float64).tolist())


def quoted(name: str) -> str:
    """A name as Abaqus takes it: in quotes where it holds more than letters, digits, _ and -, or begins otherwise."""
    return name if _PLAIN.fullmatch(name) else f'"{name}"'


class Scopes:
    """Instances of a model, and labels of nodes and elements as each scope sees them."""

    def __init__(self, model: Model) -> None:
        self.model = model
        nodes = model.nodes
        self.names = nodes.instance
        self.shown = [quoted(name) for name in self.names]
        self.of_node = nodes.instance_idx if nodes.instance else np.full(nodes.count, ROOT, dtype=np.int64)
        self.of_block = self._of_blocks(model.blocks)

    @property
    def all(self) -> list[int]:
        """Instances, then the root."""
        return [*range(len(self.names)), ROOT]

    def _of_blocks(self, blocks: Sequence[ElementBlock]) -> list[int]:
        """Blocks follow each other scope by scope, instances first; labels are used once in a scope."""
        result: list[int] = []
        current = 0 if self.names else ROOT
        used: dict[int, set[int]] = {}
        for block in blocks:
            owners = np.unique(self.of_node[block.nodes_idx])
            own = int(owners[0]) if owners.size == 1 else ROOT
            ids = set(block.ids.tolist())
            if current == ROOT or own < current or used.get(own, set()) & ids:
                own = ROOT
            current = own
            used.setdefault(own, set()).update(ids)
            result.append(own)
        return result

    def node(self, row: int, scope: int = ROOT) -> str:
        """Label of a node, with its instance when seen from the root."""
        if scope != ROOT or self.of_node[row] == ROOT:
            return str(int(self.model.nodes.ids[row]))
        return f"{self.shown[int(self.of_node[row])]}.{int(self.model.nodes.ids[row])}"

    def nodes(self, rows: IntArray, scope: int = ROOT) -> list[str]:
        return [self.node(r, scope) for r in rows.tolist()]

    def element(self, block: int, row: int, scope: int = ROOT) -> str:
        """Label of an element, with its instance when seen from the root."""
        label, own = int(self.model.blocks[block].ids[row]), self.of_block[block]
        return str(label) if scope != ROOT or own == ROOT else f"{self.shown[own]}.{label}"

    def elements(self, pairs: IntArray, scope: int = ROOT) -> list[str]:
        return [self.element(b, r, scope) for b, r in pairs.tolist()]

    def split(self, name: str) -> tuple[int, str]:
        """Scope and name there of a set or surface INSTANCE.NAME."""
        instance, short = split_name(name, self.names)
        return (self.names.index(instance) if instance else ROOT), short

    def seen(self, name: str) -> str:
        """A set or surface INSTANCE.NAME as data lines of the root name it."""
        instance, short = split_name(name, self.names)
        return f"{quoted(instance)}.{quoted(short)}" if instance else quoted(short)

    def own(self, table: Mapping[str, T]) -> list[tuple[int, str, T]]:
        """(scope, name, entry) without the short names that reading adds."""
        result = []
        for name, entry in table.items():
            scope, short = self.split(name)
            alike = [key for key in table if self.names and key.endswith(f".{name}")]
            full = [key for key in alike if self.split(key)[0] != ROOT and self.split(key)[1] == name]
            if scope == ROOT and len(full) == 1 and table[full[0]] is entry:
                continue
            result.append((scope, short, entry))
        return result
