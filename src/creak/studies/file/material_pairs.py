"""Measured material pairs: those of the study and of the file that it names."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field, ValidationError

from creak.errors import InputError
from creak.studies.file.case import Lines
from creak.studies.file.eline_tables import MaterialPairTable
from creak.studies.file.reader import explain, read_toml
from creak.studies.file.table import Table


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
    data, text = read_toml(path, "material pair")
    try:
        found = MaterialFile.model_validate(data).material_pair
    except ValidationError as error:
        raise explain(path, text, error, MaterialFile) from error
    twice = sorted(own.keys() & found.keys())
    if twice:
        raise InputError(
            f"material pair {twice[0]!r} is in the study and in {name}",
            where=lines.places.where("material-pair", twice[0]),
            expected="one of both",
            fix="Remove one of them.",
        )
    return {**found, **own}
