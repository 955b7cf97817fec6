"""Records with one value for each gap channel, selected and joined by one rule.

A field with the metadata `per_channel` holds such values: an array (m,), a tuple of m texts, or a record of the same
kind; None stands for m times its `empty`. A field with the metadata `POOLED` is shared, others hold places in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import Field, fields, is_dataclass, replace
from itertools import accumulate
from typing import Any, TypeVar, cast

import numpy as np

from creak.arrays import IntArray

Record = TypeVar("Record")

POOLED = {"pooled": True}
"""Metadata of a field with a tuple that all channels share."""


def per_channel(empty: Any, into: str = "") -> dict[str, Any]:
    """Metadata of a field with one value a channel.

    Parameters
    ----------
    empty : what a channel has that says nothing: a number or several, a text, or the class of a record.
    into : the pooled field whose places the values are; -1 is none.
    """
    return {"empty": empty, "into": into}


def taken(record: Record, keep: IntArray) -> Record:
    """The record of the channels in `keep` alone."""
    values = {f.name: _taken(getattr(record, f.name), keep) for f in _own(record)}
    return cast(Record, replace(cast(Any, record), **values))


def _taken(value: Any, keep: IntArray) -> Any:
    if value is None:
        return None
    if isinstance(value, tuple):
        return tuple(value[i] for i in keep)
    return taken(value, keep) if is_dataclass(value) else value[keep]


def joined(kind: Any, records: Sequence[Any], sizes: Sequence[int]) -> dict[str, Any]:
    """Fields of one record over the channels of several, by name.

    Parameters
    ----------
    kind : the class of the records.
    records : None stands for channels that say nothing.
    sizes : their numbers of channels.
    """
    values = {f.name: [None if r is None else getattr(r, f.name) for r in records] for f in fields(kind)}
    out = {f.name: _joined(f, values[f.name], sizes) for f in _own(kind)}
    for f in fields(kind):
        if "pooled" in f.metadata:
            out[f.name] = tuple(x for pool in values[f.name] for x in pool or ())
        elif f.metadata.get("into"):
            counts = [len(pool or ()) for pool in values[f.metadata["into"]]]
            before = np.repeat(np.array([0, *accumulate(counts)][:-1], dtype=np.int64), sizes)
            out[f.name] = np.where(out[f.name] >= 0, out[f.name] + before, -1)
    return out


def _joined(of: Field[Any], values: Sequence[Any], sizes: Sequence[int]) -> Any:
    empty = of.metadata["empty"]
    if of.default is None and all(v is None for v in values):
        return None
    if isinstance(empty, type):
        return empty(**joined(empty, values, sizes))
    if isinstance(empty, str):
        return tuple(x for v, m in zip(values, sizes, strict=True) for x in (v or (empty,) * m))
    row = np.shape(empty)
    filled = (np.full((m, *row), empty) if v is None else v for v, m in zip(values, sizes, strict=True))
    return np.concatenate([np.full((0, *row), empty), *filled])


def _own(kind: Any) -> list[Field[Any]]:
    """Fields with one value a channel."""
    return [f for f in fields(kind) if "empty" in f.metadata]
