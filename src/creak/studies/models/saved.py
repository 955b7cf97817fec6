"""Files of superelements: where they lie in their folder, and which of them fits."""

from __future__ import annotations

import os
import shutil
import weakref
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Literal

from creak.arrays import FloatArray
from creak.digest import digest, file_stem
from creak.errors import InputError
from creak.formats.deck.command_files import plain_file
from creak.formats.stored.superelement import (
    Boundary,
    SavedSuperelement,
    boundary_arrays,
    boundary_of,
    read_superelement_file,
    read_where_it_fits,
    state_of,
)
from creak.studies.file.reader import Study
from creak.studies.solved import SOLVED, solved
from creak.studies.tasks.queue import Runner

Keep = Literal["nothing", "last", "all"]
"""What stays of new superelements for the runs to come: nothing, the last ones of each part, or all (sweeps)."""


@dataclass(frozen=True)
class Store:
    """Where superelements lie, what stays there of those that are made, and who makes them."""

    folder: Path | None = None
    """None: nothing is looked for or kept."""
    keep: Keep = "nothing"
    runner: Runner | None = None
    """Workers who reduce parts into the folder; None: this process does it."""
    study: Study | None = None
    """What they set up."""
    ignore: tuple[str, ...] = ()
    """Of the deck, which they may leave unread."""


NO_STORE = Store()

WORDS = {
    "stiffness": "its stiffness changed",
    "mass": "its mass changed",
    "damping": "its damping changed",
    "dofs": "its dofs changed",
    "retained": "other dofs are retained",
    "interface": "its interface is reduced differently",
    "modes": "other modes are asked for",
    "creak": "it was made by another version of creak",
}


def is_saved(folder: Path, name: str, made_from: Mapping[str, str]) -> bool:
    """Whether the folder has the superelement already."""
    path = part_path(folder, name)
    if shared_path(folder, name, made_from).exists():
        return True
    return path.exists() and read_where_it_fits(path, lambda _: False)[0] == made_from


def is_kept(folder: Path, name: str, made_from: Mapping[str, str]) -> bool:
    """The same, where a run would take it from."""
    return is_saved(folder, name, made_from) or shared_path(folder / SOLVED, name, made_from).exists()


def part_path(folder: Path, name: str) -> Path:
    return folder / f"{file_stem(name)}.h5"


def shared_path(folder: Path, name: str, made_from: Mapping[str, str]) -> Path:
    """File of one of several superelements of a part that lie in one folder, told apart by what they depend on."""
    path = part_path(folder, name)
    return path.with_name(f"{path.stem}.{digest(made_from, 8)}.h5")


def from_store(folder: Path | None, name: str, made_from: Mapping[str, str]) -> tuple[Boundary | None, list[str]]:
    """What fits, or but for its retained dofs does, and notes for people."""
    if folder is None:
        return None, []
    shared = shared_path(folder, name, made_from)
    if shared.exists():
        found = boundary(folder, shared)
        if found.saved.made_from == made_from:
            return found, [f"superelement {name}: taken from {shared.name}"]
    path = part_path(folder, name)
    if not path.exists():
        return None, []
    found = boundary(folder, path)
    other = {key for key in made_from if found.saved.made_from.get(key) != made_from[key]}
    changed = [WORDS[key] for key in made_from if key in other]
    if not changed:
        return found, [f"superelement {name}: taken from {path.name}"]
    stale = f"superelement {name}: the saved one in {path.name} is stale ({', '.join(changed)}); reduced again"
    return found if other <= {"retained"} else None, [stale]


def very_same(folder: Path, name: str, made_from: Mapping[str, str]) -> tuple[Boundary | None, list[str]]:
    """The very same that a run or a sweep has kept, and a note; a damaged one is made again."""
    both = (shared_path(place, name, made_from) for place in (folder / SOLVED, folder))
    path = next((p for p in both if p.exists()), None)
    if path is None:
        return None, []
    try:
        found = boundary(folder, path)
    except InputError:
        return None, []
    if found.saved.made_from != made_from:
        return None, []
    return found, [f"superelement {name}: taken from {path.relative_to(folder)}"]


def boundary(folder: Path, path: Path) -> Boundary:
    """A saved superelement; as long as its file is not touched, its large modes are read only where they are needed.

    Raises
    ------
    InputError : it is no superelement file, or a damaged one.
    """
    whole: list[SavedSuperelement] = []
    try:
        plain_file(path, is_input=False)
    except OSError as error:
        raise InputError(
            f"cannot read {path}: {error.strerror}", fix="Delete it and run `creak reduce` again."
        ) from error
    state, held = state_of(path), os.open(path, os.O_RDONLY) if os.name == "posix" else -1

    def read() -> SavedSuperelement:
        if whole or held < 0 or state_of(path) == state:
            return whole[0] if whole else read_superelement_file(path)
        with NamedTemporaryFile(suffix=".h5") as copy, os.fdopen(os.dup(held), "rb") as file:
            file.seek(0)  # as it was, though another lies in its place now
            shutil.copyfileobj(file, copy)
            copy.flush()
            return read_superelement_file(Path(copy.name))

    if held >= 0:
        weakref.finalize(read, os.close, held)

    def make() -> dict[str, FloatArray]:
        whole.append(read_superelement_file(path))
        return boundary_arrays(whole[0])

    return boundary_of(solved(folder, boundary_kind(path), [state], make, most=1), read)


def boundary_kind(path: Path) -> str:
    """First word of the file with the boundary of a superelement."""
    return f"boundary_{path.stem.replace('.', '_')}"
