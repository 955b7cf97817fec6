"""Files that are complete or absent, alone or together: the one way by which creak writes files."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from creak.errors import CreakError, InputError, WriteError
from creak.formats.deck.command_files import has_written, refuse_to_replace
from creak.formats.destination import Destination, destination, partial_name, remove_dead_once

WRONG_PLACE = (
    errno.ENOENT,
    errno.ENOTDIR,
    errno.EISDIR,
    errno.EEXIST,
    errno.EACCES,
    errno.EPERM,
    errno.EROFS,
    errno.ENAMETOOLONG,
    errno.ELOOP,
)
"""Errors of the name that was given, not of the disk."""
KILO = 1000.0


class Unfinished(OSError):
    """A failure of writing, with what the whole file would have taken."""

    def __init__(self, error: OSError, needed: int) -> None:
        super().__init__(error.errno, error.strerror or str(error))
        self.needed = needed


class Together:
    """Files that appear together or not at all; made by `files_together`."""

    def __init__(self) -> None:
        self._files: list[tuple[Path, Path]] = []
        """Partial names and where they go."""

    @contextmanager
    def file(self, path: Path, more: int = 0, *, kept: bool = False) -> Iterator[Path]:
        """A temporary name beside `path` to write to; a link stays, the file that it leads to is replaced.

        Parameters
        ----------
        more : bytes of the files that follow, for the message. kept : as of `complete_file`.

        Raises
        ------
        InputError : `path` is not the name of a plain file, that file has to stay, or its folder cannot be written.
        WriteError : the disk is full, or fails.
        """
        target = destination(path, stream=False, kept=kept).path
        remove_dead_once(target.parent)
        partial = target.with_name(partial_name(target.name))
        self._files.append((partial, target))
        try:
            yield partial
            with partial.open("rb+") as file:
                os.fsync(file.fileno())
            refuse_to_replace(target, by=partial, kept=kept)
        except OSError as error:
            needed = self._needed(error, more)
            self.discard()
            raise cannot_write(path, error, needed) from error

    def appear(self, stale: Iterable[Path] = ()) -> None:
        """Give all files their names, in the order in which they were written.

        One file replaces its predecessor at once. Of several, the predecessors and what is `stale` are removed first,
        the last one's foremost: whenever it is there, so are all others, and they belong to it.
        """
        path = Path()
        with interrupts_later():  # Ctrl-C midway would cost both the old and the new
            try:
                old = [] if len(self._files) == 1 else [target for _, target in reversed(self._files)]
                for path in (*old, *stale):
                    path.unlink(missing_ok=True)
                for partial, path in self._files:
                    os.replace(partial, path)
                    has_written(path)
                for folder in {path.parent for _, path in self._files}:
                    _flush_folder(folder)
            except OSError as error:
                raise cannot_write(path, error) from error
            self._files.clear()

    def discard(self) -> None:
        """Remove what has not appeared."""
        for partial, _ in self._files:
            partial.unlink(missing_ok=True)
        self._files.clear()

    def _needed(self, error: OSError, more: int) -> int:
        """Bytes of all files, the one under way as far as it is known; where each is too large, of that one."""
        *before, last = [path.stat().st_size if path.exists() else 0 for path, _ in self._files]
        this = max(last, error.needed if isinstance(error, Unfinished) else 0)
        return this if error.errno == errno.EFBIG else sum(before) + this + more


@contextmanager
def files_together() -> Iterator[Together]:
    """Several files that appear when `Together.appear` is called; what has not appeared at the end is removed."""
    together = Together()
    try:
        yield together
    finally:
        together.discard()


@contextmanager
def complete_file(path: Path, *, stream: bool = True, kept: bool = False) -> Iterator[Path]:
    """A temporary name to write to; renamed to `path` at the end, removed after a failure.

    Of several writers of one path, on any machine, each has a name of its own; the last to finish stays. A pipe or a
    character device is not replaced: when all is written, it is written into it.

    Parameters
    ----------
    stream : whether a reader can take the format from start to end, so that a pipe or a device may be given.
    kept : whether creak keeps the file for itself: a damaged one is replaced too.

    Raises
    ------
    InputError : `path` names something that cannot be written, or that has to stay (`command_files`).
    WriteError : the disk is full, or fails.
    """
    found = destination(path, stream=stream, kept=kept)
    if found.stream:
        with tempfile.TemporaryDirectory() as folder:
            partial = Path(folder) / (path.name or "stream")
            try:
                yield partial
                _pour(partial, found)
            except OSError as error:
                raise WriteError(f"cannot write {path}: {_reason(error)}") from error
        return
    with files_together() as together:
        with together.file(path, kept=kept) as partial:
            yield partial
        together.appear()


@contextmanager
def partial_folder(path: Path) -> Iterator[Path]:
    """A hidden folder beside `path` for files that are moved from there when all are complete; removed at the end.

    Raises
    ------
    InputError : it cannot be made there. WriteError : the disk is full, or fails.
    """
    remove_dead_once(path.parent)
    folder = path.with_name(partial_name(path.name))
    try:
        folder.mkdir()
        yield folder
    except OSError as error:
        needed = sum(file.stat().st_size for file in folder.glob("*"))
        shutil.rmtree(folder, ignore_errors=True)
        raise cannot_write(path, error, needed) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def write_text(path: Path, text: str) -> None:
    """Write a text in UTF-8, line ends as they are; errors as `complete_file`."""
    with complete_file(path) as partial:
        write_bytes(partial, text.encode("utf-8"))


def write_bytes(partial: Path, data: bytes) -> None:
    """Write a file whose size is known.

    Raises
    ------
    Unfinished : it cannot be written; says how much was needed.
    """
    try:
        partial.write_bytes(data)
    except OSError as error:
        raise Unfinished(error, len(data)) from error


def cannot_write(path: Path, error: OSError, needed: int = 0) -> CreakError:
    """The one message for a file that could not be written; call it when its remains are gone.

    Parameters
    ----------
    needed : bytes that would have been written, as far as they are known.
    """
    reason = _reason(error)
    if error.errno in WRONG_PLACE:
        return InputError(f"cannot write {path}: {reason}", fix="Name another file, or make its folder writable.")
    return WriteError(f"cannot write {path}: {reason}{_room(path, error, needed)}")


def _reason(error: OSError) -> str:
    return (error.strerror or str(error) or "it cannot be written").lower()


def _room(path: Path, error: OSError, needed: int) -> str:
    """How much there is, how much it takes, and what to do."""
    number, least = error.errno, "at least" if isinstance(error, Unfinished) else "more than"
    takes = f"; {least} {_size(needed)} are needed" if needed else ""
    if number == errno.EFBIG:
        limit = _file_limit()
        most = "" if limit is None else f"; files of this process may have {_size(limit)} (ulimit -f)"
        return f"{takes}{most}. Raise the limit, or name another place."
    if number == errno.EDQUOT:
        return f"{takes}. Make room, or name another place."
    if number != errno.ENOSPC or not path.parent.is_dir():
        return ""
    try:
        free = f", {_size(shutil.disk_usage(path.parent).free)} are free in {path.parent}"
    except OSError:
        free = ""
    return f"{takes}{free}. Make room, or name another place."


def _file_limit() -> int | None:
    """Bytes that a file of this process may have; None: any number, or the system does not say."""
    try:
        import resource
    except ImportError:
        return None
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
    return None if limit == resource.RLIM_INFINITY else limit


def _size(n: int) -> str:
    """Bytes for people."""
    value, unit = n / KILO, "kB"
    for larger in ("MB", "GB", "TB"):
        if value < KILO:
            break
        value, unit = value / KILO, larger
    return f"{value:.3g} {unit}" if value < KILO else f"{value:.0f} {unit}"


def _flush_folder(folder: Path) -> None:
    """Have the names reach the disk, where the system can."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EBADF):  # file systems that cannot
            raise
    finally:
        os.close(descriptor)


def _pour(partial: Path, found: Destination) -> None:
    """Write a finished file into a pipe or a device."""
    if found.descriptor is None:
        into = os.open(found.path, os.O_WRONLY | getattr(os, "O_NOCTTY", 0))
    else:
        sys.stdout.flush()
        sys.stderr.flush()
        into = os.dup(found.descriptor)
    with partial.open("rb") as source, open(into, "wb") as stream:
        shutil.copyfileobj(source, stream)


@dataclass
class Interrupts:
    """What came meanwhile."""

    came: bool = False

    def check(self) -> None:
        """Raise KeyboardInterrupt where Ctrl-C came."""
        if self.came:
            raise KeyboardInterrupt


@contextmanager
def interrupts_later() -> Iterator[Interrupts]:
    """Ctrl-C waits for `Interrupts.check`, at the latest for the end; it only ever comes to the main thread."""
    found = Interrupts()

    def remember(number: int, frame: FrameType | None) -> None:
        found.came = True

    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield found
        return
    signal.signal(signal.SIGINT, remember)
    try:
        yield found
    finally:
        signal.signal(signal.SIGINT, before)
    found.check()
