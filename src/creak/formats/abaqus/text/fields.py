"""Fields of data lines: numbers, and which rows a node label, an element label or a set name stands for.

Numbers have a fast path for whole blocks, and are else read one by one, with errors that name the line."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.text.lexer import Block
from creak.given import LARGEST, computable

_INTEGER = re.compile(r"[+-]?[0-9]{1,18}")
_REAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([EeDd][+-]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[+-]?(nan|inf(inity)?)", re.IGNORECASE)
MAX_LABEL = 10**15


def to_int(field: str, where: str, what: str) -> int:
    """An integer field.

    Raises
    ------
    InputError : not an integer.
    """
    if not _INTEGER.fullmatch(field):
        raise InputError(f"{what} is {field!r}", expected="an integer", where=where, fix="Correct the number.")
    return int(field)


def to_label(field: str, where: str, what: str) -> int:
    """A node or element label: a positive integer.

    Raises
    ------
    InputError : not a positive integer.
    """
    label = to_int(field, where, what)
    if not 0 < label < MAX_LABEL:
        raise InputError(f"{what} is {field}", expected="a positive integer", where=where, fix="Correct the label.")
    return label


def to_float(field: str, where: str, what: str) -> float:
    """A real field; an empty field is 0, and 1.5D3 is 1500, as in Abaqus.

    Raises
    ------
    InputError : not a finite number.
    """
    if not field:
        return 0.0
    if _REAL.fullmatch(field):
        value = computable(float(field.upper().replace("D", "E")))
        if math.isfinite(value):
            return value
    finite = "a finite number" if _NOT_FINITE.fullmatch(field) else "a number"
    raise InputError(f"{what} is {field!r}", expected=finite, where=where, fix="Correct the number.")


def positive(field: str, where: str, what: str) -> float:
    """A real field greater than zero.

    Raises
    ------
    InputError : not a number, or not positive.
    """
    value = to_float(field, where, what)
    if not value > 0.0:
        shown = field or "missing"
        raise InputError(
            f"{what} is {shown}",
            expected="a number greater than zero",
            where=where,
            fix=f"Give a positive {what}.",
        )
    return value


def floats(fields: Sequence[str], where: str, what: str, count: int) -> list[float]:
    """The first `count` fields as numbers, missing ones 0."""
    padded = [*fields, *[""] * count][:count]
    return [to_float(f, where, what) for f in padded]


def to_dof(field: str, where: str, *, what: str = "degree of freedom") -> int:
    """A degree of freedom 1..6.

    Raises
    ------
    InputError : anything else.
    """
    dof = to_int(field, where, what)
    if not 1 <= dof <= 6:
        raise InputError(
            f"{what} is {dof}",
            expected="1 to 6",
            where=where,
            fix=f"1, 2, 3 are the displacements and 4, 5, 6 the rotations. {_of_no_motion(dof)}".rstrip(),
        )
    return dof


def _of_no_motion(dof: int) -> str:
    """What a degree of freedom of Abaqus and CalculiX is that moves nothing."""
    names = {0: "the temperature", 7: "warping", 8: "a pressure", 9: "the electric potential", 10: "a flow"}
    name = "the temperature" if 11 <= dof <= 30 else names.get(dof)
    return f"{dof} is {name}, which creak does not have: delete the line." if name else ""


def dof_range(fields: Sequence[str], where: str) -> tuple[int, ...]:
    """`first[, last]` as a tuple of dofs; nothing at all means all six.

    Raises
    ------
    InputError : not 1..6, or the last is below the first.
    """
    if not any(fields):
        return (1, 2, 3, 4, 5, 6)
    first = to_dof(fields[0], where, what="first degree of freedom")
    last = first
    if len(fields) > 1 and fields[1]:
        last = to_dof(fields[1], where, what="last degree of freedom")
    if last < first:
        raise InputError(
            f"degrees of freedom {first} to {last}",
            expected="the last not below the first",
            where=where,
            fix="Swap the two numbers.",
        )
    return tuple(range(first, last + 1))


def integer_table(block: Block, n_columns: int) -> IntArray | None:
    """All data lines as an (n, n_columns) integer array, or None when the block is not that regular."""
    fields = _regular_fields(block, n_columns)
    if fields is None:
        return None
    try:
        table = np.array(fields, dtype=np.int64).reshape(-1, n_columns)
    except (ValueError, OverflowError):
        return None
    return table if table.min() > 0 and table.max() < MAX_LABEL else None


def label_and_reals(block: Block, n_reals: int) -> tuple[IntArray, FloatArray] | None:
    """All data lines as labels (n,) and finite numbers (n, n_reals), or None when not that regular."""
    fields = _regular_fields(block, n_reals + 1)
    if fields is None:
        return None
    step = n_reals + 1
    try:
        labels = np.array(fields[::step], dtype=np.int64)
        del fields[::step]
        reals = np.array(fields, dtype=np.float64).reshape(-1, n_reals)
    except (ValueError, OverflowError):
        return None
    good = labels.min() > 0 and labels.max() < MAX_LABEL and bool((np.abs(reals) <= LARGEST).all())
    return (labels, reals) if good else None


def label_list(block: Block) -> IntArray | None:
    """All fields of a block as labels in order, or None when some are not labels."""
    text = ",".join(block.lines)
    if "_" in text or not text.isascii():
        return None
    fields = [f for f in text.split(",") if f and not f.isspace()]
    try:
        labels = np.array(fields, dtype=np.int64)
    except (ValueError, OverflowError):
        return None
    return labels if labels.size and labels.min() > 0 else None


def _regular_fields(block: Block, n_columns: int) -> list[str] | None:
    """Fields of a block whose lines all have `n_columns` of them, in one flat list."""
    lines = block.lines
    if lines and lines[0].endswith(","):
        lines = [line.removesuffix(",") for line in lines]
    if not lines or any(line.count(",") != n_columns - 1 for line in lines):
        return None
    text = ",".join(lines)
    return text.split(",") if text.isascii() and "_" not in text and '"' not in text else None


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
