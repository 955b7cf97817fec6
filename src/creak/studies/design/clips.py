"""[[clip]] tables -> bushings of the model and connectors with play, stops and pull-out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.play import Play, check_play, nodes_of_ends
from creak.errors import InputError
from creak.model.contact_law import ContactLaw
from creak.model.materials import Bushing
from creak.model.mesh import ElementBlock, Model, Own
from creak.model.units import UNITS
from creak.studies.design.named_nodes import nearest_nodes
from creak.studies.file.case import Touching
from creak.studies.file.contact_tables import connector_names
from creak.studies.file.design.clip_tables import ClipTable

ENDS = ("first", "second")
BETWEEN = -1
"""The part of a clip: none, so that no part is reduced again when it changes."""


def with_clips(model: Model, touching: Touching) -> tuple[Model, list[tuple[Play, str]], list[str]]:
    """The model with the bushings of a study, the connectors that its other clips are with their places, and notes.

    Raises
    ------
    InputError : a name given twice; unknown sets, parts or library names; no node near a place; values that are no law.
    """
    blocks, plays, notes = [], [], []
    for name, table, where in _named(touching):
        model, ends, told = _ends(model, table, name, where, UNITS[touching.units].length)
        notes += told
        if table.type == "bushing":
            blocks.append(_bushing(model, table, ends, name, where))
        else:
            plays.append((_play(table, ends, name, where), where))
    return (replace(model, blocks=(*model.blocks, *blocks)) if blocks else model), plays, notes


def check_clips(touching: Touching) -> None:
    """Raise InputError for clips, and names of contacts, connectors and clips, that are wrong on any model."""
    for name, table, where in _named(touching):
        if table.type == "bushing":
            _axes(table, *_six(table), where)
        else:
            check_play(_play(table, table.node_sets, name, where), where)


def _named(touching: Touching) -> list[tuple[str, ClipTable, str]]:
    """Name, values and place of each clip; contacts and connectors have other names."""
    taken, found = {*touching.contacts}, []
    for i, name in enumerate(connector_names(touching.connectors)):
        _take(name, taken, touching.places.where("connector", i))
    if not touching.clips:
        return []
    from creak.studies.design.clip_library import clips_of  # its tables take time to make

    for i, table in enumerate(clips_of(touching)):
        name = table.name or f"{touching.clips[i].use or table.type}.{i + 1}"
        found.append((name, table, touching.places.where("clip", i)))
        _take(name, taken, found[-1][2])
    return found


def _take(name: str, taken: set[str], where: str) -> None:
    """Add a name to those taken, or raise InputError."""
    if name in taken:
        raise InputError(
            f"the name {name!r} is taken by another contact, connector or clip",
            where=where,
            expected="a name of its own: results tell places by it",
            fix="Rename one of them.",
        )
    taken.add(name)


def _ends(model: Model, table: ClipTable, name: str, where: str, unit: str) -> tuple[Model, tuple[str, ...], list[str]]:
    """Node sets of both ends; those at points are made. unit : of length."""
    if table.at is None:
        return model, table.node_sets, []
    sets, notes = dict(model.node_sets), []
    names = []
    for part, end in zip(table.part_names, ENDS, strict=False):
        rows, off = nearest_nodes(model, table.at, table.within, part, where, unit)
        names.append(f"{name} {end}".upper())
        sets[names[-1]] = rows
        notes.append(f"clip {name}: nodes of {part} lie up to {off:.3g} {unit} from the given places")
    return replace(model, node_sets=sets), tuple(names), notes


def _bushing(model: Model, table: ClipTable, ends: tuple[str, ...], name: str, where: str) -> ElementBlock:
    nodes: IntArray = np.column_stack(nodes_of_ends(model, ends, where))
    stiffness, damping = _six(table)
    first, second = _axes(table, stiffness, damping, where)
    own = Own(axis1=np.tile(first, (len(nodes), 1)), axis2=np.tile(second, (len(nodes), 1)))
    section = Bushing(name, table.ageing * np.diag(stiffness), np.diag(damping), 0.5)
    return ElementBlock(f"bush{len(ends)}", np.arange(1, len(nodes) + 1), nodes, section, BETWEEN, where, own)


def _six(table: ClipTable) -> tuple[FloatArray, FloatArray]:
    """Stiffness and damping of a bushing."""
    return np.array(table.stiffness, dtype=np.float64), np.array(table.damping or [0.0] * 6)


def _axes(table: ClipTable, k: FloatArray, c: FloatArray, where: str) -> tuple[FloatArray, FloatArray]:
    """Directions 1 and 2."""
    first = np.array(table.axis or (1.0, 0.0, 0.0))
    first /= np.linalg.norm(first)
    differ = any(a[1] != a[2] or a[4] != a[5] for a in (k, c))
    if table.lateral is None and differ and table.axis is not None:
        raise InputError(
            "the values of this bushing across its axis differ",
            where=where,
            expected="lateral: the direction of the first of them",
            fix="Give lateral.",
        )
    helper = np.eye(3)[int(np.argmin(np.abs(first)))] if table.axis is not None else np.array([0.0, 1.0, 0.0])
    second = np.array(table.lateral) if table.lateral is not None else helper
    second = second - (second @ first) * first
    if np.linalg.norm(second) < 1e-6 * np.linalg.norm(table.lateral or (1.0,)):
        raise InputError("lateral is the same direction as axis", where=where, fix="Give one across it.")
    return first, second / np.linalg.norm(second)


def _play(table: ClipTable, ends: tuple[str, ...], name: str, where: str) -> Play:
    axis = np.array(table.axis)
    direction = tuple((axis / np.linalg.norm(axis)).tolist())
    curve = None if table.table is None else np.array(table.table) * (1.0, table.ageing)
    stiffness = None if table.stiffness is None else table.ageing * float(np.asarray(table.stiffness))
    damping = 0.0 if table.damping is None else float(np.asarray(table.damping))
    lower, upper, preload = table.lower, table.upper, 0.0
    if table.type == "pull-out":
        lower, preload = 0.0, table.ageing * (table.pull_out or 0.0)
    elif table.type != "play":
        upper = table.gap or 0.0
    law = ContactLaw(stiffness, curve, damping, preload=preload, where=where)
    return Play(name, ends, 1, lower, upper, law, direction)
