"""What a run holds at an instant, to go on from: one dataclass in HDF5 with a checksum, and what it belongs to."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

from creak.formats.complete_file import complete_file
from creak.formats.stored.hdf5 import hdf5_file
from creak.formats.stored.sealed_hdf5 import Damaged, opened_hdf5
from creak.formats.stored.tree import read_tree, write_tree

T = TypeVar("T")
VERSION = 1


def write_checkpoint(path: Path, made_from: str, held: Any) -> None:
    """Write the file, complete or absent: the one before stays until this one is whole.

    Raises
    ------
    InputError, WriteError : the folder cannot be written, or the disk is full.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with complete_file(path, stream=False) as partial, hdf5_file(partial) as out:
        out.file.attrs["creak_checkpoint"] = VERSION
        out.file.attrs["made_from"] = made_from
        write_tree(out.file.create_group("held"), held, packed=False)


def read_checkpoint(path: Path, made_from: str, kind: type[T]) -> T | None:
    """The dataclass; None where there is no such file, or it belongs to something else.

    Raises
    ------
    Damaged : the file is not as creak wrote it.
    """
    if not path.is_file():
        return None
    try:
        with opened_hdf5(path) as file:
            if (file.attrs["creak_checkpoint"], file.attrs["made_from"]) != (VERSION, made_from):
                return None
            return read_tree(kind, file["held"])
    except Damaged:
        raise
    except (OSError, LookupError, TypeError, ValueError, ArithmeticError, RuntimeError, AttributeError) as error:
        raise Damaged(next(iter(str(error).splitlines()), "unreadable")) from error
