"""Clips by name: those that come with creak and those of the file that a study names, in the study's units."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from creak.errors import InputError, suggest
from creak.model.units import METRES, UnitsName
from creak.studies.file.case import Touching
from creak.studies.file.design.clip_tables import ClipTable, ClipValues
from creak.studies.file.design.scatter_tables import Distribution
from creak.studies.file.reader import explain, read_toml
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
    by = METRES[found.units] / METRES[units]
    return {name: _in_units(values.model_dump(exclude_unset=True), by) for name, values in found.clip.items()}


def _read(path: Path, kind: type[F]) -> F:
    data, text = read_toml(path, "clip library")
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        raise explain(path, text, error, kind) from error


def _in_units(values: dict[str, Any], by: float) -> dict[str, Any]:
    """Values of a clip where lengths are `by` as large as numbers; forces are newtons in both systems."""
    return {key: value if value is None else _one_in_units(key, value, by) for key, value in values.items()}


def _one_in_units(key: str, value: Any, by: float) -> Any:
    if key in ("lower", "upper", "gap"):
        return value * by
    if key == "table":
        return [(x * by, y) for x, y in value]
    if key not in ("stiffness", "damping"):
        return value
    if not isinstance(value, list):
        return value / by
    return [x / by for x in value[:3]] + [x * by for x in value[3:]]  # force/length, then moment/rad
