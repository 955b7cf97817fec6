"""Files of modal tests by their ending."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from creak.errors import InputError
from creak.formats.deck.command_files import plain_file
from creak.formats.measured.csv_modes import read_csv_modes
from creak.formats.measured.modes import Channel, MeasuredFrfs, MeasuredModes
from creak.formats.measured.uff_frfs import uff_frfs
from creak.formats.measured.uff_functions import histories_among
from creak.formats.measured.uff_modes import MODE, read_uff_modes, uff_modes
from creak.formats.measured.uff_sets import DataSet, data_sets

READERS: dict[str, Callable[[Path], MeasuredModes]] = {
    **dict.fromkeys((".unv", ".uff", ".u55"), read_uff_modes),
    **dict.fromkeys((".csv", ".txt"), read_csv_modes),
}
"""Ending of a file -> its reader."""


@dataclass(frozen=True)
class ModalTest:
    """What a file of a test holds, at least one of the three."""

    path: Path
    modes: MeasuredModes | None = None
    frfs: MeasuredFrfs | None = None
    channels: tuple[Channel, ...] = ()
    """Time histories, where they were asked for."""


def read_measured_modes(path: Path) -> MeasuredModes:
    """The modes of a universal file (.unv, .uff) or a table (.csv, .txt).

    Raises
    ------
    InputError : no such file; it is cut short, holds no modes, or is not of its kind.
    """
    with _reading(path):
        return _reader(path)(path)


def read_test(path: Path) -> ModalTest:
    """The modes and the frequency response functions of a file; functions are in universal files alone.

    Raises
    ------
    InputError : as `read_measured_modes`, or it holds neither modes nor such functions.
    """
    with _reading(path):
        if (read_modes := _reader(path)) is not read_uff_modes:
            return ModalTest(path, read_modes(path))
        return _of_sets(path, data_sets(path), [])


def read_universal(path: Path) -> ModalTest:
    """All that a universal file holds of a test: time histories besides.

    Raises
    ------
    InputError : as `read_test`, or it holds none of the three.
    """
    with _reading(path):
        channels, rest = histories_among(data_sets(path))
        return _of_sets(path, rest, channels)


def _of_sets(path: Path, sets: list[DataSet], channels: list[Channel]) -> ModalTest:
    frfs = uff_frfs(path, sets)
    has_modes = any(one.number == MODE for one in sets) or (frfs is None and not channels)
    return ModalTest(path, uff_modes(path, sets) if has_modes else None, frfs, tuple(channels))


def _reader(path: Path) -> Callable[[Path], MeasuredModes]:
    reader = READERS.get(plain_file(path).suffix.lower())
    if reader is None:
        raise InputError(f"measured modes in {path.name}", expected=f"a file that ends in {', '.join(READERS)}")
    return reader


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """What the system says about a file, as an InputError."""
    try:
        yield
    except FileNotFoundError as error:
        raise InputError(f"no such file: {path}", fix="Check the path.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8", fix="Save it as UTF-8.") from error
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
