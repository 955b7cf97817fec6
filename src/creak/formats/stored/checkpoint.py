"""What a run holds at an instant, to go on from: one dataclass in HDF5 with a checksum, and what it belongs to."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

from creak.formats.stored.hdf5 import bound_file, is_bound
from creak.formats.stored.sealed_hdf5 import Damaged, opened_hdf5
from creak.formats.stored.tree import read_tree, write_tree

T = TypeVar("T")
KIND, VERSION = "checkpoint", 2


def write_checkpoint(path: Path, made_from: str, held: Any) -> None:
    """Write the file, complete or absent: the one before stays until this one is whole.

    Raises
    ------
    InputError, WriteError : the folder cannot be written, or the disk is full.
    """
    with bound_file(path, KIND, VERSION, made_from) as file:
        write_tree(file.create_group("held"), held, packed=False)


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
            if not is_bound(file, KIND, VERSION, made_from):
                return None
            return read_tree(kind, file["held"])
    except Damaged:
        raise
    except (OSError, LookupError, TypeError, ValueError, ArithmeticError, RuntimeError, AttributeError) as error:
        raise Damaged(next(iter(str(error).splitlines()), "unreadable")) from error
