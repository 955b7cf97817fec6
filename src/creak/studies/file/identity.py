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


def store_of(study: Study) -> Path:
    """Where a study's superelements lie unless the user says otherwise."""
    return study.path.parent / STORE


def new_identity(study: Study, deck_sha256: str, files_sha256: str) -> RunIdentity:
    """The identity of a run that is made now."""
    return RunIdentity(uuid.uuid4().hex, sha256([study.text.encode("utf-8")]), deck_sha256, files_sha256)


def decks_sha256(study: Study) -> str:
    """Digest of the decks of a study with all that they include, as they are now; empty where there is none."""
    return files_sha256(_named(study, decks=True))


def other_files_sha256(study: Study) -> str:
    """Digest of the other files that a study names, with those that come with them, as they are now; empty where there
    are none."""
    return files_sha256(_named(study, decks=False))


def _named(study: Study, *, decks: bool) -> list[Path]:
    """Files that are there, each with what comes with it (`files_at`)."""
    found: list[Path] = []

    def note(place: tuple[str, ...], name: str) -> str:
        path = study.places.sibling(name)
        if (place in DECKS) == decks and (path.is_file() or not decks):
            found.extend(file for file in files_at(place, path) if file.is_file())
        return name

    map_paths(study.config.model_dump(mode="json"), note)
    return found


def files_sha256(files: Iterable[Path]) -> str:
    """SHA-256 of a file; of several, of their SHA-256, in hexadecimal, a line each; of none, empty."""
    found = [file_sha256(path) for path in files]
    if len(found) < 2:
        return "".join(found)
    return sha256(f"{one}\n".encode("ascii") for one in found)
