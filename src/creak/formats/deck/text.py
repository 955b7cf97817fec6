"""The files of a deck as lines of text, and how much it may include."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from creak.errors import InputError
from creak.formats.deck.command_files import file_meant, plain_file

DEPTH = 50
"""Files that may stand open inside one another."""
MOST_FILES = 10_000
"""INCLUDE lines followed in a deck."""
MOST_AGAIN = 1 << 30
"""Bytes of files that were included before."""


@dataclass(frozen=True)
class Line:
    """One line of a file."""

    text: str
    where: str
    """File and line."""


def read_bytes(path: Path, included_at: str = "", budget: IncludeBudget | None = None) -> bytes:
    """The bytes of a deck, or of a file that it includes at a place, within the budget of the deck.

    Raises
    ------
    InputError : no such file, unreadable, no plain file, or the deck includes too much.
    """
    what = "included file" if included_at else "deck"
    try:
        plain_file(path, included_at)
        if budget is not None:
            budget.count(path, included_at)
        return path.read_bytes()
    except FileNotFoundError:
        fix = "Give the path relative to the including file." if included_at else "Check the path."
        fix = file_meant(path) or fix
        raise InputError(f"there is no {what} {path}", where=included_at, fix=fix) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot read the {what} {path}: {reason}", where=included_at, fix="Check the path.") from None


def read_lines(
    path: Path, included_at: str, program: str, endings: str, budget: IncludeBudget | None = None
) -> list[str]:
    """Lines of a text file (UTF-8, else Latin-1), ended as on any system.

    Parameters
    ----------
    included_at : file and line that includes it; empty for the deck itself.
    program, endings : "an Abaqus", ".inp": whose deck is expected, for messages.

    Raises
    ------
    InputError : no such file, unreadable, or not text.
    """
    data = read_bytes(path, included_at, budget)
    if b"\0" in data:
        raise InputError(
            f"{path} is not a text file (it holds zero bytes)",
            expected=f"{program} deck in plain text (UTF-8 or Latin-1)",
            where=included_at,
            fix=f"Give the {endings} file, not a result or a zipped file.",
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return lines if lines[-1] else lines[:-1]


def refuse_loop(path: Path, above: Sequence[Path], included_at: str, line: str) -> None:
    """Refuse a file that stands open above itself; `line` is what includes it (*INCLUDE), `above` are absolute paths.

    Raises
    ------
    InputError : it does, or files are nested too deeply.
    """
    if path.absolute() in above or len(above) > DEPTH:
        raise InputError(f"{path} includes itself", where=included_at, fix=f"Remove this {line} line.")


def plain_name(name: str) -> str:
    """A name of comments or titles as a study can write it."""
    return re.sub(r"\s+", "_", name.upper())


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
