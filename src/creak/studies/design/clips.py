"""[[clip]] tables -> bushings of the model and connectors with play, stops and pull-out.

A clip is told by a name, too: of those that come with creak, or of the file that a study names, in the study's units.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from creak.arrays import FloatArray, IntArray
from creak.contact.play import Play, check_play, nodes_of_ends
from creak.errors import InputError, suggest
from creak.model.contact_law import ContactLaw
from creak.model.materials import Bushing
from creak.model.mesh import ElementBlock, Model, Own
from creak.model.units import METRES, UNITS, UnitsName
from creak.studies.design.named_nodes import nearest_nodes
from creak.studies.file.case import Touching
from creak.studies.file.contact_tables import ClipTable, ClipValues, connector_names
from creak.studies.file.reader import explain, read_toml
from creak.studies.file.scatter_tables import Distribution
from creak.studies.file.table import Positive, Table

F = TypeVar("F", bound="ClipFile")
OWN = Path(__file__).with_name("clips.toml")


class ClipFile(Table):
    """A library of clips."""

    units: UnitsName
    """Of all its values."""
    clip: dict[str, ClipValues]
    """[clip.NAME]"""


class ClipScatter(Table):
    """How clips of one kind differ: standard deviations as shares of the value."""

    stiffness: Positive
    """Of stiffness and forces."""
    damping: Positive
    source: str
    """Where the figures come from."""


class OwnFile(ClipFile):
    """The library that comes with creak."""

    scatter: dict[str, ClipScatter]
    """[scatter.NAME]: a type of distribution."""


def clip_scatter(of: Distribution, key: str, where: str) -> Distribution:
    """The distribution that a type of the library stands for: lognormal, with its coefficient of variation c, so that
    sigma of the logarithm is sqrt(ln(1 + c^2)), about the value of the study.

    Raises
    ------
    InputError : a key that is neither the stiffness nor the damping of a clip.
    """
    table, word = _read(OWN, OwnFile).scatter[of.type], key.split(".")[-1]
    share = {"ageing": table.stiffness, "stiffness": table.stiffness, "damping": table.damping}.get(word)
    if share is None or not key.startswith("clip."):
        raise InputError(
            f"{key} does not scatter as a {of.type}",
            where=where,
            expected="clip.N.ageing (stiffness and forces), clip.N.stiffness or clip.N.damping",
            fix="Use another type.",
        )
    return Distribution(type="lognormal", sigma=math.sqrt(math.log1p(share**2)), relative=True, source=table.source)


def clips_of(touching: Touching) -> list[ClipTable]:
    """The clips of a study with the values that they take from the library.

    Raises
    ------
    InputError : no such file, or something wrong in it; an unknown name; a clip that is not complete.
    """
    tables, where = touching.clips, touching.places.where
    if not any(t.use for t in tables):
        return list(tables)
    known = _library(OWN, touching.units)
    if touching.library is not None:
        known |= _library(touching.places.sibling(touching.library), touching.units)
    return [t if t.use is None else _completed(t, known, where("clip", i)) for i, t in enumerate(tables)]


def _completed(table: ClipTable, known: dict[str, dict[str, Any]], where: str) -> ClipTable:
    name = table.use or ""
    if name not in known:
        raise InputError(f"unknown clip {name!r}", where=where, expected=", ".join(known), fix=suggest(name, known))
    own = table.model_dump(exclude_unset=True, exclude_none=True, exclude={"use"})
    given = dict(known[name])
    for key, other in (("stiffness", "table"), ("table", "stiffness")):
        if key in own:
            given.pop(other, None)
    try:
        return ClipTable.model_validate({**given, **own})
    except ValidationError as error:
        message = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise InputError(f"clip {name!r} with these values: {message}", where=where, fix="Correct them.") from error


def _library(path: Path, units: UnitsName) -> dict[str, dict[str, Any]]:
    """Name -> values in the units of the study."""
    found = _read(path, OwnFile if path == OWN else ClipFile)
    by, force = METRES[found.units] / METRES[units], UNITS[found.units].newton / UNITS[units].newton
    return {name: _in_units(values.model_dump(exclude_unset=True), by, force) for name, values in found.clip.items()}


def _read(path: Path, kind: type[F]) -> F:
    data, text = read_toml(path, "clip library")
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        raise explain(path, text, error, kind) from error


def _in_units(values: dict[str, Any], by: float, force: float) -> dict[str, Any]:
    """Values of a clip where lengths are `by` and forces `force` as large as numbers."""
    return {key: value if value is None else _one_in_units(key, value, by, force) for key, value in values.items()}


def _one_in_units(key: str, value: Any, by: float, force: float) -> Any:
    if key in ("lower", "upper", "gap"):
        return value * by
    if key == "table":
        return [(x * by, y * force) for x, y in value]
    if key not in ("stiffness", "damping"):
        return value
    if not isinstance(value, list):
        return value * force / by
    # force/length, then moment/rad
    return [x * force / by for x in value[:3]] + [x * force * by for x in value[3:]]


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
