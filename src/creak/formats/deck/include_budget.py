"""What a deck may include: plain files, so many of them, and so many bytes of those that come again."""

from __future__ import annotations

import stat
from pathlib import Path

from creak.errors import InputError

MOST_FILES = 10_000
"""INCLUDE lines followed in a deck."""
MOST_AGAIN = 1 << 30
"""Bytes of files that were included before."""


class IncludeBudget:
    """Reads the files of one deck."""

    def __init__(self) -> None:
        self._files = self._again = 0
        self._seen: set[Path] = set()

    def read(self, path: Path, included_at: str) -> bytes:
        """The bytes of a deck, or of a file that it includes at a place.

        Raises
        ------
        InputError : it is a device, or an included pipe or folder; too many files. OSError : it cannot be read.
        """
        found = path.stat()
        is_pipe = stat.S_ISFIFO(found.st_mode) and not included_at
        if not (stat.S_ISREG(found.st_mode) or stat.S_ISDIR(found.st_mode) or is_pipe):
            raise InputError(
                f"{path} is a pipe or a device", expected="a plain file", where=included_at, fix="Name another file."
            )
        self._files += 1
        if path in self._seen:
            self._again += found.st_size
        self._seen.add(path)
        if self._files > MOST_FILES or self._again > MOST_AGAIN:
            most = f"{MOST_FILES:,} files" if self._files > MOST_FILES else f"{MOST_AGAIN >> 30} GB of files met before"
            raise InputError(
                f"the deck includes more than {most}",
                where=included_at,
                expected="each file included once",
                fix="Look for files that include the same file twice.",
            )
        return path.read_bytes()
