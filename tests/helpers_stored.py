"""Stored files changed on purpose, with checksums that fit what they hold then."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from creak.formats.complete_file import complete_file
from creak.formats.stored.sealed import KEY, hdf5_file, seal, sealed_text


@contextmanager
def changed_hdf5(path: Path) -> Iterator[h5py.File]:
    """A stored HDF5 file opened for changes; sealed again afterwards."""
    with h5py.File(path, "r+") as file:
        yield file
    resealed(path)


def resealed(path: Path) -> None:
    """Give an HDF5 file the checksum of what it holds now."""
    with path.open("rb+") as raw:

        def read(at: int, n: int) -> bytes:
            raw.seek(at)
            return raw.read(n)

        block = seal(read, os.fstat(raw.fileno()).st_size)
        raw.seek(0)
        raw.write(block)


def write_changed_json(path: Path, data: dict[str, Any]) -> None:
    """Write the content of a stored JSON file with its checksum."""
    path.write_text(sealed_text({k: v for k, v in data.items() if k != KEY}), encoding="utf-8")


def read_json(path: Path) -> dict[str, Any]:
    """Its content, the checksum included."""
    return dict(json.loads(path.read_text(encoding="utf-8")))


def write_small_results(path: Path) -> None:
    """As much of a results.h5 as its histories need: four times, a node, a channel."""
    n = 4
    arrays = {
        "time": np.arange(n) * 1e-3,
        "node_ids": np.array([3]),
        "node_names": ["A.3"],
        "displacement": np.ones((n, 1, 6)),
        "channels": ["edge 3"],
        "channel_nodes": np.array([3]),
        "gap": np.ones((n, 1)),
        "normal_force": np.zeros((n, 1)),
        "peak_force": np.zeros((n, 1)),
    }
    with complete_file(path) as partial, hdf5_file(partial) as unfinished:
        unfinished.file.attrs["units"] = "mm-t-s"
        group = unfinished.file.create_group("runs/reduced")
        for name, data in arrays.items():
            group[name] = data
