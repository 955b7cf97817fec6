"""Disks that are full, and files that are none."""

from __future__ import annotations

import os
import resource
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

NULL, FULL = os.makedev(1, 3), os.makedev(1, 7)


@contextmanager
def small_disk(folder: Path, taken_kb: int) -> Iterator[Path]:
    """A file system of 2 MB in memory, of which so many kB are taken; the test is skipped where none can be mounted."""
    folder.mkdir()
    done = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", str(folder)], capture_output=True, check=False
    )
    if done.returncode:
        pytest.skip(f"no file system can be mounted here: {done.stderr.decode().strip()}")
    try:
        (folder / "taken").write_bytes(bytes(1000 * taken_kb))
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


@contextmanager
def limited_files(most: int) -> Iterator[None]:
    """Files of this process may have so many bytes for a while, as by `ulimit -f`."""
    (soft, hard), before = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    sys.dont_write_bytecode = True  # Python would leave half a file of a module, and read it in other processes
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        sys.dont_write_bytecode = before


def device(path: Path, number: int, kind: int = stat.S_IFCHR) -> Path:
    """A node of a device; the test is skipped where none can be made or used."""
    try:
        os.mknod(path, kind | 0o666, number)
        os.close(os.open(path, os.O_WRONLY if kind == stat.S_IFCHR else os.O_PATH))
    except OSError as error:
        pytest.skip(f"no device can be made here: {error}")
    return path
