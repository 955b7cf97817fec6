"""Labels that tell all nodes and elements of a model apart, as Nastran needs them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError
from creak.model.mesh import Model

LARGEST = 99_999_999
"""Label of Nastran."""


def numbered(model: Model) -> tuple[Model, list[str]]:
    """The model with labels of its own for every node and element, and what was renumbered in words.

    Labels of a flat deck stay. Where instances use a label twice, those of each instance get a number in front: label +
    k 10^d, d the digits of the largest label.

    Raises
    ------
    InputError : a label that is not 1 to 99999999.
    """
    nodes, notes = model.nodes, list[str]()
    ids = nodes.ids
    if np.unique(ids).size < ids.size:
        step = 10 ** len(str(int(ids.max())))
        ids = ids + step * (nodes.instance_idx + 1)
        for k, name in enumerate(nodes.instance):
            notes.append(f"node n of instance {name} is grid {step * (k + 1)} + n")
    blocks, more = _elements(model)
    _check_labels(model, "node", ids)
    for block in blocks:
        _check_labels(model, "element", block)
    made = tuple(replace(b, ids=new) for b, new in zip(model.blocks, blocks, strict=True))
    flat = replace(nodes, ids=ids, instance=(), instance_idx=np.zeros(0, dtype=np.int64))
    return replace(model, nodes=flat, blocks=made), notes + more


def _elements(model: Model) -> tuple[list[IntArray], list[str]]:
    ids = [b.ids for b in model.blocks]
    every = np.concatenate([*ids, np.zeros(0, dtype=np.int64)])
    if np.unique(every).size == every.size:
        return ids, []
    step, nodes = 10 ** len(str(int(every.max()))), model.nodes
    owner = [nodes.instance_idx[b.nodes_idx].max(axis=1) if nodes.instance else b.ids * 0 - 1 for b in model.blocks]
    made = [i + step * (o + 1) for i, o in zip(ids, owner, strict=True)]
    whole = np.concatenate(made)
    if np.unique(whole).size < whole.size:
        counts = np.cumsum([0, *(i.size for i in ids)])
        anew = [np.arange(a + 1, b + 1) for a, b in pairwise(counts.tolist())]
        return anew, ["elements are numbered anew, in the order of the deck"]
    names = enumerate(nodes.instance, start=1)
    return made, [f"element n of instance {name} is element {step * k} + n" for k, name in names]


def _check_labels(model: Model, what: str, ids: IntArray) -> None:
    if ids.size and not 1 <= int(ids.min()) <= int(ids.max()) <= LARGEST:
        bad = int(ids.min()) if ids.min() < 1 else int(ids.max())
        raise InputError(
            f"{what} {bad} cannot stand in a Nastran deck",
            where=model.source,
            expected=f"labels from 1 to {LARGEST}",
            fix="Renumber the deck.",
        )
