"""Where an output goes: a plain file is replaced, a pipe or a device is written into, anything else is refused."""

from __future__ import annotations

import os
import re
import stat
from dataclasses import dataclass
from pathlib import Path

from creak.errors import InputError
from creak.formats.deck.command_files import refuse_to_replace

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
