"""Files that are there whole or not at all."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from creak.errors import InputError
from creak.formats import complete_file
from creak.formats.stored.sealed import read_sealed, sealed_text
from creak.given import of_kind, path_of


def write_text(path: str | Path, text: str) -> None:
    """Write a text file in UTF-8; what was there stays until the new one is whole.

    Raises
    ------
    InputError : `path` names something that cannot be written. WriteError : the disk is full, or fails.
    """
    of_kind(text, str, "text", "a text")
    complete_file.write_text(path_of(path, "path"), text)


def write_json(path: str | Path, data: Mapping[str, Any]) -> None:
    """Write a JSON file with a checksum of its content, the key `sha256`; the folder is made if missing.

    Numbers that are not finite are written as NaN and Infinity.

    Raises
    ------
    InputError : `data` is no JSON, or `path` names something that cannot be written. WriteError : the disk fails.
    """
    of_kind(data, Mapping, "data", "a mapping, as a summary is one")
    try:
        text = sealed_text(data, allow_nan=True)
    except TypeError as error:
        raise InputError(str(error), where=str(path), expected="what JSON can hold") from error
    path_of(path, "path").parent.mkdir(parents=True, exist_ok=True)
    complete_file.write_text(path_of(path, "path"), text)


def read_json(path: str | Path) -> dict[str, Any]:
    """What `write_json` wrote.

    Raises
    ------
    InputError : no such file, or it was changed since.
    """
    try:
        return read_sealed(path_of(path, "path"))
    except (OSError, ValueError) as error:
        raise InputError(str(error), where=str(path), expected="a file that creak.write_json wrote") from error
