"""[support.NAME] tables: dofs that the deck holds let go, and others held; static loads of the deck, and what they
free."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from creak.arrays import IntArray
from creak.assembly.coupling import Driven
from creak.errors import InputError, suggest
from creak.model.constraints import Equation, Fixed, held_labels, without
from creak.model.dofs import node_and_dof, node_dofs
from creak.model.mesh import Model
from creak.model.steps import StaticLoads
from creak.studies.file.case import Driving
from creak.studies.file.model_tables import SupportTable
from creak.studies.file.places import Places
from creak.studies.file.table import DOFS


def deck_loads(model: Model, driving: Driving, place: int) -> StaticLoads | None:
    """The loads of the deck that a [[static]] table names; None where it names none.

    Raises
    ------
    InputError : the deck has none of that name, or creak cannot read them.
    """
    given = driving.statics[place].deck_loads
    if given is None:
        return None
    name = str(given)
    if name not in model.static_loads:
        raise InputError(
            f"the deck has no static loads {name!r}",
            where=driving.places.where("static", place, "deck_loads"),
            expected=", ".join(model.static_loads) or "a Nastran deck with load sets",
            fix=suggest(name, model.static_loads),
        )
    loads = model.static_loads[name]
    if loads.flaw is not None:
        raise loads.flaw
    return loads


def loads_taken(model: Model, driving: Driving) -> Iterator[tuple[int, StaticLoads]]:
    """Place of each [[static]] table that names loads of the deck, and these."""
    for k in range(len(driving.statics)):
        loads = deck_loads(model, driving, k)
        if loads is not None:
            yield k, loads


def freed_where_moved(model: Model, driving: Driving) -> Model:
    """The model without the supports at dofs that loads of the deck move: they hold them at another place."""
    labels = [m.labels for _, loads in loads_taken(model, driving) for m in loads.moved]
    if not labels:
        return model
    freed = np.unique(np.concatenate(labels))
    return replace(model, fixed=without(model.fixed, freed))


def with_supports(model: Model, tables: Mapping[str, SupportTable], places: Places) -> tuple[Model, list[str]]:
    """The model held as the study says, and what was freed and held.

    Raises
    ------
    InputError : an unknown node set; nothing that the deck holds is freed; a support along other axes than the
        global ones.
    """
    notes = []
    for name, table in tables.items():
        where = places.where("support", name)
        freed = _freed(model, table, where)
        added: list[Fixed] = []
        if table.hold:
            nodes = model.node_set(table.nodes, where=places.where("support", name, "nodes"))
            added = [Fixed(nodes, tuple(DOFS.index(dof) + 1 for dof in table.hold), where)]
        model = replace(model, fixed=(*without(model.fixed, freed), *added))
        told = [f"{freed.size} dofs of the deck freed"] if freed.size else []
        told += [f"{', '.join(table.hold)} of {added[0].nodes_idx.size} nodes held"] if added else []
        notes.append(f"[support.{name}]: {' and '.join(told)}")
    return model, notes


def _freed(model: Model, table: SupportTable, where: str) -> IntArray:
    """Sorted dof labels that the deck holds and the table frees."""
    dofs = tuple(DOFS.index(dof) + 1 for dof in table.free)
    held = np.unique(held_labels(model.fixed))
    if not dofs:
        return held[:0]
    if table.nodes == "*":
        wanted = node_dofs(np.unique(held // len(DOFS)), dofs)
    else:
        nodes = model.node_set(table.nodes, where=where)
        _check_axes(model, nodes, table, where)
        wanted = node_dofs(nodes, dofs)
    found = np.intersect1d(held, wanted)
    for dof, word in zip(dofs, table.free, strict=True):
        if not (found % len(DOFS) == dof - 1).any():
            raise InputError(
                f"the deck holds no node of {table.nodes!r} in {word}",
                where=where,
                expected="dofs that it holds",
                fix=f"Leave {word} out of free.",
            )
    return found


def _check_axes(model: Model, nodes: IntArray, table: SupportTable, where: str) -> None:
    """Raise InputError where nodes are held along axes of their own (equations to ground)."""
    wanted = set(nodes.tolist())
    ground = {int(n) for f in model.fixed if f.dofs == (1, 2, 3, 4, 5, 6) for n in f.nodes_idx} - wanted
    for c in model.constraints:
        touched = set(c.nodes.tolist())
        if isinstance(c, Equation) and touched & wanted and len(touched - ground) <= 1:
            node = model.nodes.label(next(iter(touched & wanted)))
            raise InputError(
                f"node {node} of {table.nodes!r} is held along axes of its own",
                where=where,
                expected="supports along the global axes",
                fix="Free it in the deck.",
            )


def check_driven(model: Model, driving: Driving, driven: Driven) -> None:
    """Raise InputError where an excitation moves what is held."""
    held = held_labels(model.fixed)
    for name, labels in driven.labels.items():
        both = labels[np.isin(labels, held)]
        if not both.size or name not in driving.excitations:
            continue
        table = driving.excitations[name]
        raise InputError(
            f"[excitation.{name}] moves node {model.nodes.label(node_and_dof(int(both[0]))[0])} {table.dof}, which is "
            "held",
            where=driving.places.where("excitation", name),
            expected="dofs that nothing holds",
            fix=f'Free them: [support.NAME] with nodes = "{table.node_set}" and free = ["{table.dof}"].',
        )
