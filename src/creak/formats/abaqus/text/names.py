"""Labels and names: which rows a node label, an element label or a set name stands for."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.text.numbers import MAX_LABEL

T = TypeVar("T")


def unique_in_order(rows: IntArray) -> IntArray:
    """Drop repeats, keep the first of each."""
    _, first = np.unique(rows, return_index=True)
    return rows[np.sort(first)]


class Labels:
    """Labels of one scope, in any order and with gaps, and the rows they stand for."""

    def __init__(self, ids: IntArray, rows: IntArray) -> None:
        order = np.argsort(ids, kind="stable")
        self.ids, self.rows = ids[order], rows[order]

    def find(self, ids: IntArray) -> IntArray:
        """Rows of the labels, -1 for unknown ones."""
        if self.ids.size == 0:
            return np.full(ids.shape, -1, dtype=np.int64)
        at = np.minimum(np.searchsorted(self.ids, ids), self.ids.size - 1)
        return np.where(self.ids[at] == ids, self.rows[at], -1)

    def in_range(self, first: int, last: int, step: int) -> IntArray:
        """Rows of the labels first, first + step, ... last that exist."""
        low, high = np.searchsorted(self.ids, [first, last + 1])
        ids = self.ids[low:high]
        return self.rows[low:high][(ids - first) % step == 0]


def qualified(scope: str, name: str) -> str:
    """Name of a set as the assembly sees it: INSTANCE.SET."""
    return f"{scope}.{name.upper()}" if scope else name.upper()


def lookup(table: Mapping[str, T], name: str, scope: str, assembly: str) -> T | None:
    """Entry for a name: in the scope, in the assembly, or the only instance that has it."""
    name = name.upper()
    if assembly and name.startswith(f"{assembly}."):
        name = name[len(assembly) + 1 :]
    for key in (qualified(scope, name), name):
        if key in table:
            return table[key]
    endings = [key for key in table if key.endswith(f".{name}")]
    return table[endings[0]] if len(endings) == 1 else None


def split_name(name: str, instances: Iterable[str]) -> tuple[str, str]:
    """Instance ("" for none) and name there of a set or surface INSTANCE.NAME; either may hold dots of its own."""
    found = max((i for i in instances if i and name.startswith(f"{i}.")), key=len, default="")
    return found, name[len(found) + 1 :] if found else name


def with_short_names(table: Mapping[str, T], instances: Collection[str]) -> dict[str, T]:
    """The table plus SET for every INSTANCE.SET that only one instance has."""
    result = dict(table)
    shorts: dict[str, list[str]] = {}
    for key in table:
        instance, short = split_name(key, instances)
        if instance:
            shorts.setdefault(short, []).append(key)
    for short, keys in shorts.items():
        if len(keys) == 1:
            result.setdefault(short, table[keys[0]])
    return result


@dataclass
class Registry:
    """All nodes (or all elements) of a deck with their labels and sets."""

    what: str
    """node or element"""
    labels: dict[str, Labels]
    """Scope name -> labels."""
    assembly: str = ""
    sets: dict[str, IntArray] = field(default_factory=dict)
    """Qualified set name -> rows in deck order."""
    internal: set[str] = field(default_factory=set)
    """Names of sets that a program wrote for itself."""

    def add(self, scope: str, name: str, parts: Iterable[IntArray]) -> None:
        """Add rows to a set, which is created when needed."""
        key = qualified(scope, name)
        old = self.sets.get(key, np.zeros(0, dtype=np.int64))
        self.sets[key] = unique_in_order(np.concatenate([old, *parts]))

    def has_set(self, name: str, scope: str) -> bool:
        return lookup(self.sets, name, scope, self.assembly) is not None

    def find(self, token: str, scope: str, where: str) -> IntArray:
        """Rows of a label (17, INST.17) or of a set (SET, INST.SET).

        Raises
        ------
        InputError : unknown label, unknown set or empty set.
        """
        if token.isascii() and token.isdigit():
            return self._label(token, scope, where)
        rows = lookup(self.sets, token, scope, self.assembly)
        if rows is None:
            head, _, tail = token.upper().removeprefix(f"{self.assembly}.").rpartition(".")
            if head in self.labels and tail.isascii() and tail.isdigit():
                return self._label(tail, head, where)
            raise InputError(
                f"unknown {self.what} set {token!r}",
                where=where,
                fix=suggest(token, with_short_names(self.sets, self.labels)),
            )
        if rows.size == 0:
            raise InputError(f"{self.what} set {token!r} is empty", where=where, fix="Put something into it.")
        return rows

    def find_labels(self, ids: IntArray, scope: str, where: str) -> IntArray:
        """Rows of labels of a scope.

        Raises
        ------
        InputError : a label is unknown.
        """
        rows = self.labels[scope].find(ids) if scope in self.labels else np.full(ids.shape, -1)
        if rows.size and rows.min() < 0:
            label = int(ids[int(np.argmax(rows < 0))])
            inside = f" in instance {scope!r}" if scope else ""
            hint = "Define it or correct the label."
            if not scope and len(self.labels) > 1:
                hint = "In a deck with instances write INSTANCE.LABEL, or use INSTANCE= on the set."
            raise InputError(f"there is no {self.what} {label}{inside}", where=where, fix=hint)
        return rows

    def _label(self, digits: str, scope: str, where: str) -> IntArray:
        label = min(int(digits[:20]), MAX_LABEL)
        return self.find_labels(np.array([label], dtype=np.int64), scope, where)
