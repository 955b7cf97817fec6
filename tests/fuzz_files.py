"""Stored files and matrix files damaged from a seed: bytes flipped, cut, repeated, or arrays of the wrong kind."""

from __future__ import annotations

import random
import shutil
import tempfile
import time
from pathlib import Path

import numpy as np

from creak.formats.matrices.superelements import FORMATS, read_superelement, write_superelement
from creak.formats.measured.files import is_measured, read_channels
from creak.formats.measured.histories import read_histories
from creak.formats.measured.uff import DISPLACEMENT, Function, write_functions
from creak.formats.stored.superelement import SavedSuperelement, read_superelement_file, write_superelement_file
from creak.studies.file.tables import read_table
from fuzz_decks import READERS, VALUES, Tally, guarded
from helpers_matrices import random_superelement
from helpers_rpc3 import COURSES, TIME, rpc3
from helpers_stored import resealed, write_small_results

WORDS = [*(v.encode() for v in VALUES), b"\0", b"\xff" * 8, b"9" * 5000, b"x" * 140_000, b"1e308", b'"', b"=1+1"]
ARRAYS = (
    np.array(3.0),
    np.array([None, {}], dtype=object),
    np.zeros(3, dtype=[("a", "f8"), ("b", "i4")]),
    np.array(["a", "b"]),
    np.array([1j]),
    np.full((2, 2), np.nan),
    np.array([2**62, -1]),
    np.zeros((0, 3)),
    np.zeros((2, 2, 2)),
    np.array([True]),
)


def fuzz_files(first: int, count: int) -> Tally:
    """Damage and read `count` files from seed `first` on."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as name:
        good = write_good(Path(name) / "good")
        for seed in range(first, first + count):
            rng, bad = random.Random(f"files {seed}"), Path(name) / "bad"
            shutil.rmtree(bad, ignore_errors=True)
            main, *_ = files = rng.choice(good)
            bad.mkdir()
            for file in files:
                shutil.copy(file, bad)
            damage(rng, bad / rng.choice(files).name)
            start = time.perf_counter()
            tally.add(guarded("files", seed, bad / main.name, tally), time.perf_counter() - start)
    return tally


def write_good(folder: Path) -> list[list[Path]]:
    """Files that belong together, the one that is read first."""
    folder.mkdir()
    found = [write_superelement(random_superelement(), folder / name, name) for name in FORMATS]
    rng = np.random.default_rng(1)
    K = np.diag(rng.random(4))
    ids, at = np.array([7, 8, 0, 0]), np.array([1, 4])
    saved = SavedSuperelement(
        *("DOOR", {"creak": "1"}, {"K": K, "M": K, "M_alone": K}, rng.random((3, 2)), np.ones(2), rng.random((5, 2))),
        *(9.0, ids, ids, {}, at, rng.random((2, 2))),
    )
    superelement, results, table = folder / "DOOR.h5", folder / "results.h5", folder / "table.csv"
    write_superelement_file(superelement, saved)
    write_small_results(results)
    table.write_text("time,value\n" + "".join(f"{k / 10},{k}\n" for k in range(30)))
    road, bench = folder / "road.rsp", folder / "bench.unv"
    road.write_bytes(rpc3())
    write_functions(bench, [Function("A", 17, 3, DISPLACEMENT, "Displacement", "mm", TIME, COURSES["Acc_X"])])
    return [*found, [superelement], [results], [table], [road], [bench]]


def damage(rng: random.Random, path: Path) -> None:
    """One to three faults in a file; sealed files get a checksum that fits one time in two, so that more is looked at."""
    if path.suffix == ".npz" and rng.random() < 0.5:
        with np.load(path) as file:
            arrays = {key: file[key] for key in file.files}
        arrays[rng.choice(sorted(arrays))] = rng.choice(ARRAYS)
        np.savez(path, **arrays)
        return
    data = path.read_bytes()
    for _ in range(rng.choice([1, 1, 2, 3])):
        at = rng.randrange(len(data) + 1)
        end = min(len(data), at + rng.choice([0, 1, 1, 4, 8, 50]))
        bit = bytes(b ^ (1 << rng.randrange(8)) for b in data[at : at + 1])
        put = rng.choice([bit, bit, b"", data[at:end] * 2, rng.choice(WORDS), rng.randbytes(4)])
        data = data[:at] + put + data[at + 1 if put is bit else end :]
        if rng.random() < 0.1:
            data = data[: rng.randrange(len(data) + 1)]
    path.write_bytes(data)
    if path.suffix == ".h5" and len(data) > 512 and rng.random() < 0.1:
        resealed(path)


def _read(path: Path) -> str:
    if path.name == "results.h5":
        read_histories(path)
    elif path.suffix == ".h5":
        read_superelement_file(path)
    elif is_measured(path):
        read_channels(path)
    elif path.name == "table.csv":
        read_table(path, "table")
    else:
        read_superelement(path)
    return "read"


READERS["files"] = _read
