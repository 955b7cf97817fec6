"""The sound that results.h5 keeps, as WAV files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from creak.arrays import FloatArray
from creak.digest import file_stem
from creak.errors import InputError
from creak.formats.destination import destination
from creak.formats.stored.results import check_beside, reading
from creak.formats.stored.run_identity import RESULTS, SUMMARY
from creak.formats.stored.sealed import Damaged, opened_hdf5, read_sealed
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
    ears: tuple[str, ...]
    """Of each listener the ear that `pressure` is at, "left" or "right"; empty: it has no head."""
    other: Mapping[int, NDArray[np.float32]]
    """Row of a listener with a head -> (n_place, n) Pa at its other ear."""

    def of(self, listener: int, place: int) -> FloatArray:
        """(n,) Pa; of a listener with a head (n, 2), left and right."""
        here = self.pressure[listener, place].astype(np.float64)
        if listener not in self.other:
            return here
        both = [here, self.other[listener][place].astype(np.float64)]
        return np.stack(both if self.ears[listener] == "left" else both[::-1], axis=1)


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
        ears, other = _ears(group, pressure)
        return StoredSound(names[0], names[1], pressure, rate, scale, (low, high), ears, other)


def _ears(group: h5py.Group, pressure: NDArray[np.float32]) -> tuple[tuple[str, ...], dict[int, NDArray[np.float32]]]:
    """`StoredSound.ears` and `.other`; runs of an earlier creak have neither."""
    if "ears" not in group:
        return ("",) * pressure.shape[0], {}
    ears = tuple(group["ears"].asstr()[()].tolist())
    other = {int(row): data[()] for row, data in group["other_ear"].items()}
    heads = {k for k, ear in enumerate(ears) if ear}
    whole = all(x.shape == pressure.shape[1:] and np.isfinite(x).all() for x in other.values())
    if len(ears) != pressure.shape[0] or heads != other.keys() or not whole:
        raise Damaged("a sound that is not whole")
    return ears, other


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
    """Write a WAV file per listener and place into `folder`, all with one full scale; returns their paths. Those of a
    listener with a head have two channels, left and right.

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
            x = sound.of(i, j)
            path = paths[i * len(sound.places) + j]
            largest = float(np.abs(x).max(initial=0.0))
            write_wav(path, x, sound.rate, samples=samples, full_scale=max(sound.full_scale, largest))
    return paths
