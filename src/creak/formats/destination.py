"""Where an output goes: a plain file is replaced, a pipe or a device is written into, anything else is refused; names
of files and folders on their way, and the removal of those whose process is gone."""

from __future__ import annotations

import os
import re
import shutil
import socket
import stat
import time
import uuid
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from creak.errors import InputError
from creak.formats.deck.command_files import refuse_to_replace

OLD = 7 * 86_400.0
"""s since the last change after which what another machine left, or one that was started anew since, is removed."""
LONGEST = 100
"""Bytes of the own name in a partial one."""
OWNED = re.compile(
    r"\.(?P<owner>.+)\.(?P<process>\d+)\.((?P<start>\d*)-(?P<machine>[0-9a-f]{8})-)?[0-9a-f]{4,12}\.partial", re.S
)
NAMELESS = re.compile(r"\..+\.[0-9a-f]{32}\.partial", re.S)
"""As earlier versions called them: nothing tells whose they are. Files of any other name are not creak's."""


def partial_name(name: str) -> str:
    """Hidden, with the host and process that it belongs to: .NAME.HOST.PROCESS.START-MACHINE-RANDOM.partial."""
    short = name.encode()[:LONGEST].decode(errors="ignore")
    process = os.getpid()
    own = f"{_start(process)}-{_machine()}-{uuid.uuid4().hex[:12]}"
    return f".{short}.{socket.gethostname()}.{process}.{own}.partial"


def remove_dead(folder: Path) -> None:
    """Remove the partial files and folders of processes that no longer run.

    Of this machine, since it was started: those whose process is gone or was started at another time. Of others
    that share the folder, which cannot be asked: those that have not changed for a week.
    """
    for path in folder.glob(".*.partial"):
        if not _may_live(path):
            _remove(path)


@cache
def remove_dead_once(folder: Path) -> None:
    """The same, once in the life of this process."""
    remove_dead(folder)


def _may_live(path: Path) -> bool:
    """Whether somebody may still be writing it, or it is none of creak's."""
    found = OWNED.fullmatch(path.name)
    if found is None and NAMELESS.fullmatch(path.name) is None:
        return True
    if found and found["owner"].endswith(f".{socket.gethostname()}") and found["machine"] in (None, _machine()):
        alive = _alive(int(found["process"]), found["start"] or "")
        if alive is not None:
            return alive
    try:
        return time.time() - path.lstat().st_mtime < OLD
    except OSError:  # gone meanwhile
        return True


def _alive(process: int, start: str) -> bool | None:
    """Whether a process of this machine runs, started then (empty: whenever); None: this system does not say."""
    if Path("/proc/self/stat").exists():
        now = _start(process)
        return bool(now) and start in ("", now)
    if os.name != "posix":
        return None
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def _start(process: int) -> str:
    """When a process was started, in ticks since the machine was; empty: there is none, or the system does not say."""
    try:
        words = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
    except OSError:
        return ""
    return "" if words[0] == "Z" else words[19]


@cache
def _machine() -> str:
    """This machine since its start, and the container on it: process numbers mean the same only within one."""
    found = [socket.gethostname()]
    try:
        found += [Path("/proc/sys/kernel/random/boot_id").read_text(encoding="utf-8"), os.readlink("/proc/self/ns/pid")]
    except OSError:
        found.append("")
    from creak.digest import digest  # with NumPy, which no help of a command needs

    return digest(found, 4)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
        return
    try:
        path.unlink(missing_ok=True)
    except OSError:  # of another user: left to them
        return


FIX = "Name another file."
LINKS = 40
"""Links followed before a loop is assumed."""


@dataclass(frozen=True)
class Destination:
    """An output that may be written."""

    path: Path
    """The plain file itself where a link leads to it, whether it exists or not; else the pipe or device."""
    stream: bool = False
    """A pipe or a character device: written into, never replaced."""
    descriptor: int | None = None
    """Of this process, for /dev/stdout and its like."""


def destination(path: Path, *, stream: bool = True, kept: bool = False) -> Destination:
    """Look at what a path names, and whether the command under way may write it (`command_files`).

    Parameters
    ----------
    stream : whether the format can be written into a pipe or a device from start to end. kept : as of
        `refuse_to_replace`.

    Raises
    ------
    InputError : a file that has to stay, a folder, a socket, a block device, a link that leads in a circle, a place
        that cannot be looked at; a pipe or a device where only a file will do.
    """
    descriptor = descriptor_of(path)
    try:
        mode = (os.stat(path) if descriptor is None else os.fstat(descriptor)).st_mode
    except FileNotFoundError:
        return Destination(_end_of_links(path))
    except OSError as error:
        raise InputError(f"cannot write to {path}: {(error.strerror or str(error)).lower()}", fix=FIX) from error
    flows = descriptor is not None or stat.S_ISFIFO(mode) or stat.S_ISCHR(mode)
    if stat.S_ISDIR(mode) or not (flows or stat.S_ISREG(mode)):
        expected = "a file, a pipe or a character device" if stream else "a file"
        raise InputError(f"cannot write to {path}: it is {_kind(mode)}", expected=expected, fix=FIX)
    if flows and not stream:
        raise InputError(
            f"cannot write to {path}: it is {_kind(mode)}", expected="a file: this format is no stream", fix=FIX
        )
    if flows:
        return Destination(path, True, descriptor)
    refuse_to_replace(path, kept=kept)
    return Destination(_end_of_links(path))


def descriptor_of(path: Path) -> int | None:
    """The number of an open file of this process that a path stands for: 1 of /dev/stdout; None of other paths."""
    own = re.compile(rf"/(?:dev|proc/(?:self|thread-self|{os.getpid()}))/fd/(\d+)")
    here = str(path)
    for _ in range(LINKS):
        found = own.fullmatch(here)
        if found:
            return int(found.group(1))
        if not os.path.islink(here):
            return None
        here = os.path.normpath(os.path.join(os.path.dirname(here), os.readlink(here)))
    return None


def _end_of_links(path: Path) -> Path:
    """The file that a link leads to, whether it exists or not; other paths as they are."""
    return Path(os.path.realpath(path)) if path.is_symlink() else path


def _kind(mode: int) -> str:
    kinds = (
        (stat.S_ISDIR, "a folder"),
        (stat.S_ISSOCK, "a socket"),
        (stat.S_ISBLK, "a block device"),
        (stat.S_ISFIFO, "a pipe"),
        (stat.S_ISCHR, "a device"),
    )
    return next((words for holds, words in kinds if holds(mode)), "no plain file")
