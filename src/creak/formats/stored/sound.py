"""The sound that results.h5 keeps, as WAV files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from creak.errors import InputError
from creak.formats.destination import destination
from creak.formats.safe_names import file_stem
from creak.formats.stored.results import check_beside, reading
from creak.formats.stored.run_identity import RESULTS, SUMMARY
from creak.formats.stored.sealed_hdf5 import Damaged, opened_hdf5
from creak.formats.stored.sealed_json import read_sealed
from creak.formats.wav import write_wav


@dataclass(frozen=True)
class StoredSound:
    """Pressure at listeners."""

    listeners: tuple[str, ...]
    places: tuple[str, ...]
    """The last is all contact together."""
    pressure: NDArray[np.float32]
    """(n_listener, n_place, n) Pa"""
    rate: float
    """Hz"""
    full_scale: float
    """Pa, common to all files."""
    band: tuple[float, float]
    """Hz, what is in it."""


def read_sound(folder: Path) -> StoredSound:
    """The sound of a run from the folder that `creak run` wrote.

    Raises
    ------
    InputError : a file is missing, not whole, of another run, or holds no sound.
    """
    path = folder / RESULTS
    with reading(path), opened_hdf5(path) as file:
        check_beside(path, file)
        if "sound" not in file:
            raise _silent(folder)
        group = file["sound"]
        names = [tuple(group[key].asstr()[()].tolist()) for key in ("listeners", "places")]
        pressure = group["pressure"][()]
        rate, scale = float(group.attrs["rate"]), float(group.attrs["full_scale"])
        low, high = (float(x) for x in group.attrs["band"])
        if pressure.shape[:2] != (len(names[0]), len(names[1])) or not np.isfinite(pressure).all():
            raise Damaged("a sound that is not whole")
        return StoredSound(names[0], names[1], pressure, rate, scale, (low, high))


def _silent(folder: Path) -> InputError:
    why = ""
    text = folder / SUMMARY
    if text.is_file():
        found = read_sealed(text).get("sound")
        why = str(found["missing"]) if isinstance(found, dict) and "missing" in found else ""
    return InputError(
        f"no sound in {folder}" + (f": {why}" if why else ""),
        expected="results of creak run of a reduced model whose parts touch",
        fix="Run the study again." if not why else "Change the study and run it again.",
    )


def write_sound(sound: StoredSound, folder: Path, samples: str = "24") -> list[Path]:
    """Write a WAV file per listener and place into `folder`, all with one full scale; returns their paths.

    Raises
    ------
    InputError, WriteError : as `write_wav`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    names = ((a, b.replace(" ", "_")) for a in sound.listeners for b in sound.places)
    paths = [folder / f"{file_stem(listener)}_{file_stem(place)}.wav" for listener, place in names]
    for path in paths:
        destination(path)
    for i in range(len(sound.listeners)):
        for j in range(len(sound.places)):
            x = sound.pressure[i, j].astype(np.float64)
            path = paths[i * len(sound.places) + j]
            largest = float(np.abs(x).max(initial=0.0))
            write_wav(path, x, sound.rate, samples=samples, full_scale=max(sound.full_scale, largest))
    return paths
