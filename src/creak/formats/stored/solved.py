"""What was solved once and is found again: arrays by name in HDF5 with a checksum, and what they were made from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.formats.stored.sealed import bound_file, is_bound, opened_hdf5

KIND, VERSION = "solved", 1


def write_solved(path: Path, made_from: str, arrays: Mapping[str, FloatArray]) -> None:
    """Write the file, complete or absent.

    Raises
    ------
    InputError, WriteError : the folder cannot be written, or the disk is full.
    """
    with bound_file(path, KIND, VERSION, made_from) as file:
        for name, array in arrays.items():
            file.create_dataset(name, data=array)


def read_solved(path: Path, made_from: str) -> dict[str, FloatArray] | None:
    """Name -> array; None where there is no such file, it is damaged, or it was made from something else."""
    try:
        with opened_hdf5(path) as file:
            if not is_bound(file, KIND, VERSION, made_from):
                return None
            return {name: np.asarray(file[name][()], dtype=np.float64) for name in file}
    except (OSError, LookupError, TypeError, ValueError, ArithmeticError, RuntimeError):  # Damaged is a ValueError
        return None


def as_numbers(text: str) -> FloatArray:
    """A text as it is kept: its bytes."""
    return np.frombuffer(text.encode(), dtype=np.uint8).astype(np.float64)


def as_text(numbers: FloatArray) -> str:
    """The text of `as_numbers`."""
    return numbers.astype(np.uint8).tobytes().decode()
