"""A file to which finished records of numbers are added one by one: what was added is there after any kind of end."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from creak.arrays import FloatArray
from creak.digest import digest
from creak.formats.deck.command_files import plain_file
from creak.formats.destination import destination

HEAD = struct.Struct("<IQ")
"""CRC-32 of number and values, number of the record."""


def log_path(folder: Path, stem: str, made_from: Mapping[str, Any], width: int) -> Path:
    """`STEM-1A2B3C4D.bin`: a file of its own for all that records are made from, so that none replaces another."""
    return folder / f"{stem}-{digest([width, made_from], 4)}.bin"


def read_records(path: Path, made_from: Mapping[str, Any], width: int) -> tuple[dict[int, FloatArray], int]:
    """Number -> values (width,) of the records that are whole, and the bytes that they take.

    None, and no bytes, where there is no such file or it was made from something else; what follows a record that was
    cut short or damaged does not count.
    """
    try:
        data = plain_file(path, is_input=False).read_bytes()
    except FileNotFoundError:
        return {}, 0
    line, _, rest = data.partition(b"\n")
    if line != _first_line(made_from, width):
        return {}, 0
    found, used, size = {}, len(line) + 1, HEAD.size + 8 * width
    for at in range(0, len(rest) - size + 1, size):
        crc, number = HEAD.unpack_from(rest, at)
        if zlib.crc32(rest[at + 4 : at + size]) != crc:
            break
        found[number] = np.frombuffer(rest, "<f8", width, at + HEAD.size).astype(np.float64)
        used += size
    return found, used


@contextmanager
def record_log(path: Path, made_from: Mapping[str, Any], width: int, used: int) -> Iterator[RecordLog]:
    """The file, to add records behind its first `used` bytes; 0: anew."""
    path.parent.mkdir(parents=True, exist_ok=True)
    destination(path, stream=False)
    with open(path, "r+b" if used else "wb") as file:
        if used:
            file.truncate(used)
            file.seek(used)
        else:
            file.write(_first_line(made_from, width) + b"\n")
            file.flush()
        yield RecordLog(file, width)


class RecordLog:
    """An open file of records."""

    def __init__(self, file: BinaryIO, width: int) -> None:
        self._file, self._width = file, width

    def add(self, number: int, values: FloatArray) -> None:
        """One record; it is in the file when this returns."""
        if values.shape != (self._width,):
            raise ValueError(f"a record of {values.shape}, expected {self._width}")
        body = struct.pack("<Q", number) + values.astype("<f8").tobytes()
        self._file.write(struct.pack("<I", zlib.crc32(body)) + body)
        self._file.flush()


def _first_line(made_from: Mapping[str, Any], width: int) -> bytes:
    return json.dumps({"creak_records": 1, "width": width, **made_from}, sort_keys=True).encode()
