"""The files that a study names: their paths rewritten, their contents hashed; by them a run tells what it was made
from."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from creak.digest import digest, file_sha256, sha256
from creak.errors import InputError
from creak.formats.deck.command_files import plain_file
from creak.formats.decks import format_of
from creak.formats.stored.run_identity import RunIdentity
from creak.studies.file.reader import Study
from creak.studies.file.scatter_tables import names_table

PLACES = (
    ("model", "deck"),
    ("contact", "*", "clearance"),
    ("excitation", "*", "signal", "file"),
    ("superelement", "*", "file"),
    ("superelement", "*", "map"),
    ("eline", "*", "points"),
    ("eline", "*", "tolerance"),
    ("eline", "*", "tolerance", "file"),
    ("limit", "tolerance"),
    ("limit", "tolerance", "file"),
    ("scatter", "vary", "*", "tolerance"),
    ("scatter", "vary", "*", "tolerance", "file"),
    ("material_pairs",),
    ("background", "file"),
    ("room", "reverberation"),
    ("listener", "*", "transfer", "*", "file"),
    ("listener", "*", "hrtf"),
    ("clips",),
    ("static", "*", "temperature"),
    ("damping", "from_test"),
    ("test", "*", "file"),
    ("test", "*", "sensors"),
    ("reduction", "interface", "deck"),
)
"""Keys of a study whose strings are paths; a tolerance may be a length."""
DECKS = (PLACES[0], PLACES[-1])


def map_paths(
    data: Mapping[str, Any], change: Callable[[tuple[str, ...], str], str], at: tuple[str, ...] = ()
) -> dict[str, Any]:
    """The tables of a study with every path replaced by `change(place, path)`."""
    out: dict[str, Any] = {}
    for key, value in data.items():
        here = next(((*at, k) for k in (key, "*") if any(p[: len(at) + 1] == (*at, k) for p in PLACES)), None)
        if here is None:
            out[key] = value
        elif isinstance(value, Mapping):
            out[key] = map_paths(value, change, here)
        elif isinstance(value, list | tuple):
            rows = (*here, "*")
            out[key] = [map_paths(row, change, rows) if isinstance(row, Mapping) else row for row in value]
        else:
            named = here in PLACES and isinstance(value, str) and (key != "tolerance" or names_table(value))
            out[key] = change(here, value) if named else value
    return out


class Contents:
    """Hashes of files, each read once."""

    def __init__(self) -> None:
        self._known: dict[tuple[tuple[str, ...], Path], str] = {}

    def of(self, place: tuple[str, ...], path: Path) -> str:
        """Hash of the file that a key of a study names, with those that come with it.

        Raises
        ------
        InputError : a file is missing or cannot be read.
        """
        path, kind = path.resolve(), place[:1]
        if (kind, path) not in self._known:
            self._known[kind, path] = digest([sha256([_content(p, p == path)]) for p in files_at(place, path)])
        return self._known[kind, path]


def files_at(place: tuple[str, ...], path: Path) -> list[Path]:
    """The file that a key of a study names, and what comes with it: the includes of a deck, in reading order, and the
    other matrices of a superelement."""
    if place in DECKS:
        return format_of(path).files(path)
    return _family(path) if place[0] == "superelement" else [path]


def _family(path: Path) -> list[Path]:
    """A file and those beside it whose names begin alike up to the last underscore; of a beginning, all with it."""
    own = [path] if path.is_file() else []
    stem = path.stem.rpartition("_")[0] or path.stem if own else path.name
    beside = [p for p in sorted(path.parent.glob("*")) if p.is_file() and p.name.startswith(stem) and p != path]
    return [*own, *(p for p in beside if p.suffix.lower() not in (".toml", ".html"))] or [path]


def _content(path: Path, is_input: bool) -> bytes:
    try:
        return plain_file(path, is_input=is_input).read_bytes()
    except FileNotFoundError as error:
        raise InputError(f"no such file: {path}", fix="Check the path.") from error
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error


STORE = "superelements"
"""Folder beside a study where its superelements lie unless the user says otherwise."""


def store_of(study: Path) -> Path:
    """Where the superelements of a study file lie unless the user says otherwise."""
    return study.parent / STORE


def new_identity(study: str, digests: tuple[str, str]) -> RunIdentity:
    """The identity of a run that is made now, of the text of a study and the `digests_of` its files."""
    return RunIdentity(uuid.uuid4().hex, sha256([study.encode("utf-8")]), *digests)


def digests_of(study: Study) -> tuple[str, str]:
    """Of the decks of a study, and of the other files that it names, all with what comes with them (`files_at`), as
    they are now; empty where there are none."""
    decks: list[Path] = []
    others: list[Path] = []

    def note(place: tuple[str, ...], name: str) -> str:
        path = study.places.sibling(name)
        found = decks if place in DECKS else others
        if found is others or path.is_file():
            found.extend(file for file in files_at(place, path) if file.is_file())
        return name

    map_paths(study.config.model_dump(mode="json"), note)
    return files_sha256(decks), files_sha256(others)


def files_sha256(files: Iterable[Path]) -> str:
    """SHA-256 of a file; of several, of their SHA-256, in hexadecimal, a line each; of none, empty."""
    found = [file_sha256(path) for path in files]
    if len(found) < 2:
        return "".join(found)
    return sha256(f"{one}\n".encode("ascii") for one in found)
