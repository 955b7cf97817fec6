"""Measured material pairs: those of the study and of the file that it names."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

from pydantic import ConfigDict, Field, ValidationError

from creak.errors import InputError, suggest
from creak.studies.file.case import Lines
from creak.studies.file.eline_tables import MaterialPairTable
from creak.studies.file.named_columns import UNIT, ColumnTable, Wanted, meaning, read_columns
from creak.studies.file.reader import explain, read_toml
from creak.studies.file.scatter_tables import names_table
from creak.studies.file.table import Table

KEYS = tuple(MaterialPairTable.model_fields)
NEEDED = tuple(key for key, field in MaterialPairTable.model_fields.items() if field.is_required())
UNITS = {
    "impulse_rate_min": ("1/mm", "mm^-1"),
    "impulse_rate_max": ("1/mm", "mm^-1"),
    "friction_static": ("-", "1"),
    "friction_kinetic": ("-", "1"),
    "friction_decay": ("mm/s",),
    "normal_force": ("N",),
    "speed": ("mm/s",),
    "temperature": ("°C", "C", "degC", "deg C"),
    "humidity": ("%", "% relative", "%rh", "% rh"),
}
"""Column -> how its unit may be written in the head; the first is it."""
WANTED = Wanted(
    "file of material pairs",
    (("name",),),
    {re.sub("[^a-z]", "", key): key for key in ("name", *KEYS)} | {"pair": "name", "materialpair": "name"},
    frozenset(),
    ",".join(("name", *NEEDED)),
)


class MaterialFile(Table):
    """A file of measurements."""

    model_config = ConfigDict(populate_by_name=True)

    material_pair: Annotated[dict[str, MaterialPairTable], Field(alias="material-pair")]
    """[material-pair.NAME]: as in a study."""


def material_pairs(lines: Lines) -> dict[str, MaterialPairTable]:
    """Name -> material pair.

    Raises
    ------
    InputError : no such file, or something wrong in it; a pair that is in the study and in the file.
    """
    own, name = lines.materials, lines.library
    if name is None:
        return dict(own)
    path = lines.places.sibling(name)
    found = _of_csv(path, lines.places.where("material_pairs")) if names_table(name) else _of_toml(path)
    twice = sorted(own.keys() & found.keys())
    if twice:
        raise InputError(
            f"material pair {twice[0]!r} is in the study and in {name}",
            where=lines.places.where("material-pair", twice[0]),
            expected="one of both",
            fix="Remove one of them.",
        )
    return {**found, **own}


def _of_toml(path: Path) -> dict[str, MaterialPairTable]:
    data, text = read_toml(path, "material pair")
    try:
        return MaterialFile.model_validate(data).material_pair
    except ValidationError as error:
        raise explain(path, text, error, MaterialFile) from error


def _of_csv(path: Path, where: str) -> dict[str, MaterialPairTable]:
    """A pair from each row; the columns are `name` and the keys of `MaterialPairTable`, blank cells are not given."""
    table = read_columns(path, where, WANTED, {}, "mm-t-s")
    _check_head(table)
    found: dict[str, MaterialPairTable] = {}
    for k in range(len(table.lines)):
        name = table.cells["name"][k]
        if not name or name in found:
            raise InputError(
                f"material pair {name!r} has a second row" if name else "a row without a name",
                where=table.where(k),
                expected="one row for each pair",
                fix="Remove one of them, or give it another name." if name else "Name the pair.",
            )
        found[name] = _pair(table, k, name)
    return found


def _check_head(table: ColumnTable) -> None:
    """Raise InputError for a column that there is not, one that is missing, and a unit that is not that of the key."""
    at = f"{table.path}:{table.head_line}"
    for cell in filter(None, table.head):
        column, unit = meaning(cell, WANTED, {}), UNIT.search(cell)
        if column is None:
            raise InputError(
                f"unknown column {cell!r}", where=at, expected=", ".join(("name", *KEYS)), fix=suggest(cell, KEYS)
            )
        told = None if unit is None else (unit[1] or unit[2]).strip()
        known = UNITS.get(column, ())
        if told is not None and known and told.casefold() not in (word.casefold() for word in known):
            raise InputError(
                f"the unit of {column} is {told!r}",
                where=at,
                expected=known[0],
                fix="Convert the column: the units of material pairs are the same in every study.",
            )
    missing = [key for key in NEEDED if key not in table.cells]
    if missing:
        raise InputError(
            f"the file of material pairs has no column {missing[0]}",
            where=at,
            expected=WANTED.headers,
            fix="Add it.",
        )


def _pair(table: ColumnTable, k: int, name: str) -> MaterialPairTable:
    values: dict[str, Any] = {"source": table.cells["source"][k]}
    values |= {key: table.number(k, key) for key in UNITS}
    given = {key: value for key, value in values.items() if value not in (None, "")}
    try:
        return MaterialPairTable.model_validate(given)
    except ValidationError as error:
        problem = error.errors()[0]
        key = ".".join(str(word) for word in problem["loc"])
        message = problem["msg"].removeprefix("Value error, ")
        missing = problem["type"] == "missing"
        raise InputError(
            f"material pair {name!r} has no {key}" if missing else f"{key or name}: {message[:1].lower()}{message[1:]}",
            where=table.where(k),
            expected="a cell that is not blank" if missing else "",
            fix="Fill it in." if missing else "Correct the row.",
        ) from error
