"""What one command reads, and what it may write over: never a file that it has read, nor one that is not creak's.

A plain file that is there gives way to an output where nothing is in it, or where it is of the kind that is written:
what an earlier command wrote. The rule holds between `one_command` and its end, so for every command and none of
Python's functions.
"""

from __future__ import annotations

import difflib
import errno
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from creak.errors import InputError

ALIKE = 0.75
"""Likeness of two names from which one may be meant by the other: one letter off in four."""
HEAD = 4096
"""Bytes in which the kind of a file is looked for."""
KINDS = {
    "results or superelements of creak": rb"creak sha256 ",
    "a page of creak": rb"\s*<!DOCTYPE html>.{0,3000}<title>[^<]*creak",
    "a schema of the study file": rb'\{\s*"\$schema": "[^"]*",\s*"title": "creak study file"',
    "a summary of creak": rb'\{\s*"(creak|study)": ',
    "modes in JSON": rb'\{\s*"frequencies": \[',
    "an update in JSON": rb'\{\s*"update_of": "',
    "robust.json of creak": rb'\{\s*"title": .{0,2000}"units": "[^"]*",\s*"draws": ',
    "a table of convergence": rb"contact,channel,t_start,",
    "a table of draws": rb"run,block,",
    "a table of a sweep": rb"case,([^\n]*,)?seed,status,error",
    "a table of E-lines": rb"line,node,x_",
    "a table of histories": rb"time \[s\],[^\n]* (X|gap) \[",
    "a table of degrees of freedom": rb"node,dof,",
    "the background of the example": rb"frequency,level\r?\n25,62\r?\n31\.5,60\r?\n",
    "sound of creak": rb"RIFF.{4}WAVE.{0,400}ISFT.{4}creak",
    "a picture of creak": rb"\x89PNG.{0,300}Software\0creak",
    "a deck that creak wrote": rb"\*HEADING\s.{0,600}written by creak",
    "a Nastran deck that creak wrote": rb"\$ written by creak",
    "a study that creak wrote": rb"(#[^\n]*\n)*#[^\n]*written by creak",
    "a series for ParaView": rb'<\?xml [^>]*>\s*<VTKFile type="Collection"',
    "a VTU file": rb'<\?xml [^>]*>\s*<VTKFile type="UnstructuredGrid"',
    "a universal file": rb"\s*-1\s+164\s",
    "a punch file of creak": rb"\$TITLE   =[^\n]*\n\$SUBTITLE=written by creak",
    "a Matrix Market file": rb"%%MatrixMarket",
    "a matrix of Abaqus": rb"\*\*\s*\n\*\* GENERATION OF SUBSTRUCTURE|(-?\d+,-?\d+, ){2}[-+.\dE]+\s",
    "bulk data of matrices": rb"(\$[^\n]*\n)*(GRID\*|SPOINT|DMIG)",
    "bulk data of a superelement": rb"\$ Bulk data of an external superelement",
    "an .npz file": rb"PK\x03\x04",
    "an .op4 file": rb"\x18\0\0\0.{16}[KMB]",
    "an outcome of the thesis": rb'\{\s*"key": \{',
    "the record of a case": rb'\{\s*"id": "[0-9a-f]*",\s*"run_id": ',
    "records of creak": rb'\{[^\n]*"creak_records": 1',
}
"""Kinds of files that commands write, and how each begins."""
NOTHING = "nothing"
"""The kind of a file of blanks and brackets alone: there is nothing in it to be lost."""


class _Files:
    """Of the command under way: what it has read, what it wrote itself, what may be replaced and by which option."""

    def __init__(self) -> None:
        self.read: set[tuple[int, int]] = set()
        self.written: set[tuple[int, int]] = set()
        self.option, self.foreign = "", False


_now: _Files | None = None


@contextmanager
def one_command() -> Iterator[None]:
    """From here to its end all that is read and written is of one command."""
    global _now
    before, _now = _now, _Files()
    try:
        yield
    finally:
        _now = before


def replace_foreign(option: str, given: bool) -> None:
    """Let the command under way replace files that are not creak's where its option for that was given."""
    if _now is not None:
        _now.option, _now.foreign = option, given


def plain_file(path: Path, where: object = "", *, is_input: bool = True) -> Path:
    """A file that is to be read: looked at before it is opened, for a pipe waits and a device may have no end.

    Parameters
    ----------
    where : what names it, for the message. is_input : no output may replace it; not so of what creak keeps for itself.

    Raises
    ------
    InputError : it is a pipe, a device or a socket. OSError : it is not there, a folder, or may not be read.
    """
    try:
        found = path.stat()
    except ValueError as error:
        raise InputError(f"no file can be called {str(path)!r}", where=where, fix="Check the path.") from error
    if stat.S_ISDIR(found.st_mode):
        raise _os_error(errno.EISDIR, path)
    if not stat.S_ISREG(found.st_mode):
        kind = "a socket" if stat.S_ISSOCK(found.st_mode) else "a pipe or a device"
        raise InputError(f"{path} is {kind}", expected="a plain file", where=where, fix="Name another file.")
    if not os.access(path, os.R_OK):
        raise _os_error(errno.EACCES, path)
    if is_input and _now is not None and _key(found) not in _now.written:
        _now.read.add(_key(found))
    return path


def file_meant(path: Path) -> str:
    """Which file of the folder was probably meant by a name that none has; empty: none is like it."""
    names = {p.stem: p.name for p in path.parent.glob(f"*{path.suffix}")}
    close = difflib.get_close_matches(path.stem, names, n=1, cutoff=ALIKE)
    return f"Did you mean {names[close[0]]!r}?" if close else ""


def will_read(*paths: Path) -> None:
    """Note files that the command under way is to read, where they are there: its outputs are looked at before.

    Raises
    ------
    InputError : a pipe, a device or a socket.
    """
    for path in paths:
        with suppress(OSError):
            plain_file(path)


def refuse_to_replace(path: Path, *, by: Path | None = None, kept: bool = False) -> None:
    """Check that an output of the command under way may take the place of what is at `path`.

    Parameters
    ----------
    by : the new file, once it is written: the old one has to be of its kind. kept : what creak keeps for itself, which
        replaces a damaged one as well.

    Raises
    ------
    InputError : the command has read it, or it is not creak's.
    """
    if _now is None or not path.is_file():
        return
    found = path.stat()
    if _key(found) in _now.read:
        raise InputError(
            f"cannot write {path}: it is the same file as an input of this command", fix="Name another output."
        )
    if kept or _now.foreign or _key(found) in _now.written:
        return
    kind, new = _kind(path), None if by is None else _kind(by)
    if kind != NOTHING and (kind == "" or new not in (None, kind)):
        what = "no file that creak wrote" if kind == "" else kind
        option = f", or add {_now.option}" if _now.option else ""
        raise InputError(
            f"cannot write {path}: what is there is {what}",
            expected="no file, or one of the same kind from an earlier command",
            fix=f"Name another output{option}, or move that file away.",
        )


def has_written(path: Path) -> None:
    """Note a file that the command under way wrote: it may write it again, whatever it has read of it meanwhile."""
    if _now is not None:
        key = _key(path.stat())
        _now.written.add(key)
        _now.read.discard(key)


def _os_error(number: int, path: Path) -> OSError:
    return OSError(number, os.strerror(number), str(path))


def _kind(path: Path) -> str:
    with path.open("rb") as file:
        head = file.read(HEAD)
    if not head.strip(b" \t\r\n[]{}"):
        return NOTHING
    return next((kind for kind, begin in KINDS.items() if re.match(begin, head, re.S | re.I)), "")


def _key(found: os.stat_result) -> tuple[int, int]:
    return found.st_dev, found.st_ino
