"""Measured modes by the ending of their file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from creak.errors import InputError
from creak.formats.measured.csv_modes import read_csv_modes
from creak.formats.measured.modes import MeasuredModes
from creak.formats.measured.uff_modes import read_uff_modes

READERS: dict[str, Callable[[Path], MeasuredModes]] = {
    **dict.fromkeys((".unv", ".uff", ".u55"), read_uff_modes),
    **dict.fromkeys((".csv", ".txt"), read_csv_modes),
}
"""Ending of a file -> its reader."""


def read_measured_modes(path: Path) -> MeasuredModes:
    """The modes of a universal file (.unv, .uff) or a table (.csv, .txt).

    Raises
    ------
    InputError : no such file; it is cut short, holds no modes, or is not of its kind.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"measured modes in {path.name}", expected=f"a file that ends in {', '.join(READERS)}")
    try:
        return reader(path)
    except FileNotFoundError as error:
        raise InputError(f"no such file: {path}", fix="Check the path.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8", fix="Save it as UTF-8.") from error
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
