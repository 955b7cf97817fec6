"""HDF5 on disks that are full: one error, no crash; else the same bytes as ever."""

import errno
import json
import os
import signal
import subprocess
import sys

import h5py
import numpy as np
import pytest

from creak.errors import WriteError
from creak.formats.complete_file import Unfinished, complete_file
from creak.formats.stored import sealed as piece
from creak.formats.stored.sealed import hdf5_file
from helpers_disk import small_disk


def fill(file, n=40):
    """Groups, compressed and plain data sets, one written out of step with its chunks, attributes, text."""
    rng = np.random.default_rng(1)
    for k in range(n):
        group = file.create_group(f"group {k}")
        group.attrs["unit"] = "mm"
        group.create_dataset("packed", data=rng.standard_normal((300, 40)), compression="gzip", shuffle=True)
        group.create_dataset("plain", data=rng.standard_normal(1000))
    rows = file.create_dataset("rows", (3000, 17), dtype="f8", compression="gzip")
    for k in range(0, 3000, 37):
        rows[k : k + 37] = rng.standard_normal((min(37, 3000 - k), 17))
    file.create_dataset("words", data=["a", "b"], dtype=h5py.string_dtype())


def content(path):
    """Name -> what it holds: attributes, bytes of arrays."""
    found = {}

    def note(name, item):
        values = item[()] if isinstance(item, h5py.Dataset) else None
        plain = None if values is None else values.tolist()
        found[name] = (dict(item.attrs), plain, getattr(item, "chunks", None), getattr(item, "compression", None))

    with h5py.File(path) as file:
        file.visititems(note)
    return found


def test_the_file_holds_what_the_library_would_have_written(tmp_path):
    with h5py.File(tmp_path / "plain.h5", "w") as file:
        fill(file)
    with complete_file(tmp_path / "ours.h5") as partial, hdf5_file(partial) as out:
        fill(out.file)
    assert content(tmp_path / "ours.h5") == content(tmp_path / "plain.h5")
    sizes = [(tmp_path / name).stat().st_size for name in ("ours.h5", "plain.h5")]
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-3)


@pytest.mark.parametrize("allowed", [0, 1, 2, 3, 5, 8, 13, 50, 130])
def test_whenever_the_disk_fills_up_the_file_is_closed_and_its_size_known(tmp_path, monkeypatch, allowed):
    with hdf5_file(tmp_path / "whole.h5") as out:
        fill(out.file)
    whole, write, count = (tmp_path / "whole.h5").stat().st_size, os.write, 0

    def full(descriptor, data):
        nonlocal count
        count += 1
        if count > allowed:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(descriptor, data)

    monkeypatch.setattr(piece.os, "write", full)
    with pytest.raises(Unfinished, match="No space left on device") as stop, hdf5_file(tmp_path / "ours.h5") as out:  # noqa: PT012
        fill(out.file)
        np.testing.assert_array_equal(out.file["group 3/plain"][:3], out.file["group 3/plain"][()][:3])
        assert out.file["rows"][()].any(axis=1).all()  # what was kept reads back
    assert stop.value.errno == errno.ENOSPC
    assert stop.value.needed == whole
    assert count == allowed + 1
    assert not out.file.id.valid


def test_little_is_kept_of_what_is_made_while_it_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(piece, "KEPT", 1_000_000)
    monkeypatch.setattr(piece.os, "write", lambda *_: (_ for _ in ()).throw(OSError(errno.ENOSPC, "full")))
    done = 0
    with pytest.raises(Unfinished, match="full") as stop, hdf5_file(tmp_path / "ours.h5") as out:  # noqa: PT012
        motion = out.file.create_dataset("motion", (1000, 10_000), dtype="f8", chunks=(1, 10_000))
        for done in range(1000):
            motion[done] = 1.0
            out.check(80_000 * (999 - done))
    assert done < 300  # the library keeps some blocks itself
    assert stop.value.needed == pytest.approx(80e6, rel=0.2)


def test_an_interruption_waits_for_the_library(tmp_path):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where tests run in the background
    steps = 0
    path = tmp_path / "ours.h5"
    with pytest.raises(KeyboardInterrupt), complete_file(path) as partial, hdf5_file(partial) as out:  # noqa: PT012
        for steps in range(10):
            out.file.create_dataset(f"{steps}", data=np.ones(1000))
            if steps == 3:
                os.kill(os.getpid(), signal.SIGINT)
            out.check(0)
    assert steps == 3
    assert list(tmp_path.iterdir()) == []
    assert signal.signal(signal.SIGINT, before) is signal.default_int_handler


LIMITED = """
import json, resource, sys
from pathlib import Path
import numpy as np
from creak.errors import WriteError
from creak.formats.complete_file import complete_file
from creak.formats.stored.sealed import hdf5_file
sys.dont_write_bytecode = True  # Python would leave half a file of a module
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
try:
    with complete_file(Path(sys.argv[1])) as partial, hdf5_file(partial) as out:
        for k in range(50):
            out.file.create_dataset(f"{k}", data=np.full(1000, float(k)))
except WriteError as error:
    print(json.dumps(str(error)))
"""


def test_a_limit_of_the_process_is_told(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, str(tmp_path / "a.h5")], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    told = json.loads(done.stdout)
    assert "a.h5: file too large; at least 4" in told
    assert "may have 100 kB (ulimit -f)" in told
    assert list(tmp_path.iterdir()) == []


def test_a_real_disk_that_is_full(tmp_path):
    with small_disk(tmp_path / "disk", 1600) as disk:
        told = r"no space left on device; at least 4\.\d+ MB are needed, 4\d\d kB are free"
        with pytest.raises(WriteError, match=told), complete_file(disk / "a.h5") as partial, hdf5_file(partial) as out:
            fill(out.file)
        assert [p.name for p in disk.iterdir()] == ["taken"]
