"""*NSET and *ELSET."""

from __future__ import annotations

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.mesh.elements import Elements
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.names import Registry, lookup, unique_in_order
from creak.formats.abaqus.text.numbers import label_list, to_int
from creak.formats.abaqus.text.outline import Outline


def read_sets(deck: Outline, elements: Elements, nodes: Registry, element_names: Registry) -> None:
    """Add the sets of *ELSET and *NSET to the registries, in deck order.

    Raises
    ------
    InputError : unknown label, set or instance; a range that makes no sense.
    """
    for scope, block in deck.blocks("ELSET"):
        _read_set(deck, scope.name, block, element_names)
    for scope, block in deck.blocks("NSET"):
        if block.has("ELSET"):
            rows = element_names.find(block.need("ELSET"), _scope_of(deck, scope.name, block), block.where)
            nodes.add(scope.name, block.need("NSET"), [nodes_of(elements, rows)])
        else:
            _read_set(deck, scope.name, block, nodes)


def nodes_of(elements: Elements, rows: IntArray) -> IntArray:
    """Node rows of elements, each once, in order of appearance."""
    flat = elements.nodes_idx[rows].ravel()
    return unique_in_order(flat[flat >= 0])


def _scope_of(deck: Outline, scope: str, block: Block) -> str:
    """Scope in which the members of a set are looked up: INSTANCE= or its own."""
    name = block.get("INSTANCE").upper()
    if not name:
        return scope
    found = lookup({s: s for s in deck.instances}, name, "", deck.assembly)
    if found is None:
        raise block.error(f"unknown instance {name!r}", fix=suggest(name, deck.instances))
    return found


def _read_set(deck: Outline, scope: str, block: Block, registry: Registry) -> None:
    name = block.need(block.name)
    if block.has("INTERNAL"):
        registry.internal.add(name.upper())
    inside = _scope_of(deck, scope, block)
    if block.has("GENERATE"):
        members = [_generated(deck, block, f, where, registry, inside) for f, where in block.rows()]
    else:
        members = _listed(block, registry, inside)
    registry.add(scope, name, members)


def _listed(block: Block, registry: Registry, scope: str) -> list[IntArray]:
    labels = label_list(block)
    if labels is not None and scope in registry.labels:
        rows = registry.labels[scope].find(labels)
        if rows.min() >= 0:
            return [rows]
    return [registry.find(f, scope, where) for fields, where in block.rows() for f in fields if f]


def _generated(deck: Outline, block: Block, fields: list[str], where: str, registry: Registry, scope: str) -> IntArray:
    """Rows of `first, last[, step]`; labels of the range that do not exist are left out and listed."""
    if len(fields) not in (2, 3):
        raise InputError(
            f"a range of {len(fields)} numbers",
            expected="first, last[, step]",
            where=where,
            fix="Correct the line or remove GENERATE.",
        )
    first, last, step = (to_int(f, where, "range limit") for f in [*fields, "1"][:3])
    if step <= 0 or last < first or (last - first) % step or first <= 0:
        raise InputError(
            f"the range {first} to {last} in steps of {step} is empty or does not end on its last number",
            expected="0 < first <= last, a positive step, and last = first + a multiple of it",
            where=where,
            fix="Correct the range.",
        )
    labels = registry.labels.get(scope)
    rows = np.zeros(0, np.int64) if labels is None else labels.in_range(first, last, step)
    missing = (last - first) // step + 1 - rows.size
    if rows.size == 0:
        raise InputError(
            f"no {registry.what} has a label in the range {first} to {last}, step {step}",
            where=where,
            fix="Correct the range.",
        )
    if missing:
        why = f"{missing} of the labels {first} to {last}, step {step}, do not exist and are left out"
        deck.note(block, why, changes=False, what=f"*{block.name}, GENERATE")
    return rows
