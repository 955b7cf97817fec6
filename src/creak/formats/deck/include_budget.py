"""What a deck may include: so many files, and so many bytes of those that come again."""

from __future__ import annotations

from pathlib import Path

from creak.errors import InputError

MOST_FILES = 10_000
"""INCLUDE lines followed in a deck."""
MOST_AGAIN = 1 << 30
"""Bytes of files that were included before."""


class IncludeBudget:
    """Counts the files of one deck."""

    def __init__(self) -> None:
        self._files = self._again = 0
        self._seen: set[Path] = set()

    def count(self, path: Path, included_at: str) -> None:
        """One more file: a deck, or one that it includes at a place.

        Raises
        ------
        InputError : too many files. OSError : it is not there.
        """
        self._files += 1
        if path in self._seen:
            self._again += path.stat().st_size
        self._seen.add(path)
        if self._files > MOST_FILES or self._again > MOST_AGAIN:
            most = f"{MOST_FILES:,} files" if self._files > MOST_FILES else f"{MOST_AGAIN >> 30} GB of files met before"
            raise InputError(
                f"the deck includes more than {most}",
                where=included_at,
                expected="each file included once",
                fix="Look for files that include the same file twice.",
            )
