"""Modes of a test, as files of the trade hold them: universal files (data set 55) and CSV."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from creak.arrays import ComplexArray, FloatArray, IntArray


@dataclass(frozen=True)
class MeasuredModes:
    """Frequencies, damping and shapes at sensors. A channel is one direction at one point."""

    path: Path
    frequencies: FloatArray
    """(n_mode,) Hz, rising."""
    damping: FloatArray
    """(n_mode,) share of critical damping; nan where the file does not tell."""
    shapes: ComplexArray
    """(n_channel, n_mode) motion along `directions`, any scale."""
    sensors: tuple[str, ...]
    """(n_channel,) name of the point of each."""
    points: FloatArray
    """(n_channel, 3) in the axes and the length of the file; nan where it does not tell."""
    directions: FloatArray
    """(n_channel, 3) unit vectors in global axes."""
    per_metre: float | None = None
    """Units of length in 1 m, where the file tells."""
    lines: tuple[tuple[str, str], ...] = ()
    """Names of points that are joined in drawings."""
    notes: tuple[str, ...] = ()
    """What was left out or taken for granted."""

    def channel_axes(self) -> IntArray:
        """(n_channel,) 0, 1, 2: the global axis nearest to each direction."""
        return abs(self.directions).argmax(axis=1)


def read_measured_modes(path: Path) -> MeasuredModes:
    """The modes of a universal file (.unv, .uff) or a table (.csv, .txt).

    Raises
    ------
    InputError : no such file; it is cut short, holds no modes, or is not of its kind.
    """
    from creak.errors import InputError
    from creak.formats.measured.csv_modes import read_csv_modes
    from creak.formats.measured.uff_modes import read_uff_modes

    readers = {
        **dict.fromkeys((".unv", ".uff", ".u55"), read_uff_modes),
        **dict.fromkeys((".csv", ".txt"), read_csv_modes),
    }
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"measured modes in {path.name}", expected=f"a file that ends in {', '.join(readers)}")
    try:
        return reader(path)
    except FileNotFoundError as error:
        raise InputError(f"no such file: {path}", fix="Check the path.") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8", fix="Save it as UTF-8.") from error
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
