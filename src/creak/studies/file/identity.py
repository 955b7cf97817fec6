"""What a run was made from, and the number that tells it from every other."""

from __future__ import annotations

import uuid
from collections.abc import Iterable
from pathlib import Path

from creak.digest import file_sha256, sha256
from creak.formats.stored.run_identity import RunIdentity
from creak.studies.file.paths import DECKS, files_at, map_paths
from creak.studies.file.reader import Study

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
