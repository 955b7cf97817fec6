"""HDF5 files on their way to disk, written so that a full disk ends in one error.

The HDF5 library cannot close a file whose last writes fail: it tries again when the process ends, and crashes. So it
is given a Python object to write to, whose writes always succeed: the first error is remembered, and what comes after
it is kept in memory, where the library can read it back. Once the library has closed the file, the error is raised.

This holds for files of any size and on any file system, which neither an image of the file in memory nor space taken
beforehand does. Going on after the error tells how large the file would have become. Arrays that are made while they
are written call `Hdf5.check` between blocks, so that not much more than `KEPT` is kept of them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import h5py

from creak.formats.complete_file import Interrupts, Unfinished, complete_file, interrupts_later
from creak.formats.stored.sealed import BLOCK, seal

PAGE = 1 << 16
"""Bytes kept at a time after an error."""
KEPT = 1 << 26
"""Bytes kept before `check` gives up."""


@dataclass(frozen=True)
class Hdf5:
    """An HDF5 file that is being written."""

    file: h5py.File
    check: Callable[[int], None]
    """Called between blocks with the bytes still to come; raises Ctrl-C, and an error after which much is kept."""


@contextmanager
def hdf5_file(partial: Path) -> Iterator[Hdf5]:
    """Write a new HDF5 file with a checksum (`sealed_hdf5`); to be used inside `complete_file`.

    Raises
    ------
    Unfinished : the file could not be written; KeyboardInterrupt : Ctrl-C meanwhile. Both when the file is closed.
    """
    with interrupts_later() as interrupts:  # inside a call of the library one would be one more failure to write
        sink = _Sink(partial, interrupts)
        try:
            with h5py.File(sink, "w", userblock_size=BLOCK) as file:
                yield Hdf5(file, sink.check)
            sink.finish()
        finally:
            sink.close()


@contextmanager
def bound_file(path: Path, kind: str, version: int, made_from: str) -> Iterator[h5py.File]:
    """Write a file of creak's, complete or absent, with what it was made from (`is_bound`).

    Raises
    ------
    InputError, WriteError : the folder cannot be written, or the disk is full.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with complete_file(path, stream=False, kept=True) as partial, hdf5_file(partial) as out:
        out.file.attrs[f"creak_{kind}"] = version
        out.file.attrs["made_from"] = made_from
        yield out.file


def is_bound(file: h5py.File, kind: str, version: int, made_from: str) -> bool:
    """Whether a file is of that kind and was made from just that."""
    return (file.attrs[f"creak_{kind}"], file.attrs["made_from"]) == (version, made_from)


class _Sink:
    """What the library takes for a file (h5py: file-like objects); no method raises because of the disk."""

    def __init__(self, path: Path, interrupts: Interrupts) -> None:
        self._interrupts = interrupts
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0), 0o666)
        self._at = self._end = 0
        self._error: OSError | None = None
        self._kept: dict[int, bytearray] = {}
        """Number of the page -> content, of those written since the error."""

    def check(self, more: int) -> None:
        if self._error is not None and len(self._kept) * PAGE > KEPT:
            raise Unfinished(self._error, self._end + more) from self._error
        self._interrupts.check()

    def finish(self) -> None:
        """Write the checksum; raises what has gone wrong."""
        self._interrupts.check()
        if self._error is None:
            block = seal(self._on_disk, self._end)
            self._at = 0
            self.write(memoryview(block))
        if self._error is not None:
            raise Unfinished(self._error, self._end) from self._error

    def close(self) -> None:
        os.close(self._descriptor)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._end}[whence]
        self._at = start + offset
        return self._at

    def tell(self) -> int:
        return self._at

    def write(self, data: memoryview) -> int:
        view = memoryview(data).cast("B")
        if self._error is None:
            try:
                self._put(view)
            except OSError as error:
                self._error = error
        if self._error is not None:
            self._keep(view)
        self._at += len(view)
        self._end = max(self._end, self._at)
        return len(view)

    def readinto(self, buffer: memoryview) -> int:
        view = memoryview(buffer).cast("B")
        view[:] = self._content(self._at, len(view))
        self._at += len(view)
        return len(view)

    def read(self, n: int = -1) -> bytes:
        n = self._end - self._at if n < 0 else n
        self._at += n
        return self._content(self._at - n, n)

    def truncate(self, size: int) -> int:
        self._end = size
        if self._error is None:
            try:
                os.ftruncate(self._descriptor, size)
            except OSError as error:
                self._error = error
        return size

    def flush(self) -> None:
        """Nothing waits here."""

    def _put(self, view: memoryview) -> None:
        done = 0
        while done < len(view):
            os.lseek(self._descriptor, self._at + done, os.SEEK_SET)
            done += os.write(self._descriptor, view[done:])

    def _on_disk(self, at: int, n: int) -> bytes:
        """What the file holds there, zeros beyond its end."""
        found = b""
        try:
            os.lseek(self._descriptor, at, os.SEEK_SET)
            while len(found) < n and (piece := os.read(self._descriptor, n - len(found))):
                found += piece
        except OSError as error:
            self._error = self._error or error
        return found.ljust(n, b"\0")

    def _pages(self, at: int, n: int) -> Iterator[tuple[int, int, int]]:
        """Page, and the first and last byte of it, of each page that a range touches."""
        for page in range(at // PAGE, (at + n + PAGE - 1) // PAGE):
            yield page, max(at, page * PAGE) - page * PAGE, min(at + n, (page + 1) * PAGE) - page * PAGE

    def _keep(self, view: memoryview) -> None:
        for page, first, last in self._pages(self._at, len(view)):
            if page not in self._kept:
                self._kept[page] = bytearray(self._on_disk(page * PAGE, PAGE))
            start = page * PAGE - self._at
            self._kept[page][first:last] = view[start + first : start + last]

    def _content(self, at: int, n: int) -> bytes:
        if not self._kept:
            return self._on_disk(at, n)
        found = bytearray(self._on_disk(at, n))
        for page, first, last in self._pages(at, n):
            if page in self._kept:
                start = page * PAGE - at
                found[start + first : start + last] = self._kept[page][first:last]
        return bytes(found)
