"""The ways a creak call can fail: the input is wrong, the analysis failed, or a file cannot be written."""

from __future__ import annotations

import difflib
import traceback
from collections.abc import Iterable, Sequence
from itertools import zip_longest
from pathlib import Path

LONGEST = 600
"""Characters of each piece of a message: what it quotes may be a whole file."""


def shortened(text: str, most: int = LONGEST) -> str:
    """A text of at most so many characters: its start, and its end where it is cut."""
    if len(text) <= most:
        return text
    end = most // 3
    return f"{text[: most - end - 5]} ... {text[-end:]}"


def told_apart(names: Sequence[str], most: int | Sequence[int] = LONGEST) -> list[str]:
    """Names that stand below each other, each of at most so many characters: as `shortened`, but what would look alike
    shows where it differs, and is whole where that does not do."""
    room = [most] * len(names) if isinstance(most, int) else list(most)
    short = [shortened(name, n) for name, n in zip(names, room, strict=True)]
    looks: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        if short[i] != name:
            looks.setdefault(shortened(name, min(room)), []).append(i)
    for alike in looks.values():
        different = {names[i] for i in alike}
        if len(different) < 2:
            continue
        at = next(k for k, letters in enumerate(zip_longest(*different)) if len(set(letters)) > 1)
        for i in alike:
            end = max(room[i] // 3, 1)
            begin = max(at - end // 2, 0)
            rest = names[i][begin : begin + end] + (" ..." if begin + end < len(names[i]) else "")
            short[i] = f"{names[i][: max(room[i] - len(rest) - 5, 1)]} ... {rest}"
        if len({short[i] for i in alike}) < len(different):
            for i in alike:
                short[i] = names[i]
    return short


class CreakError(Exception):
    """Base of all errors that creak raises on purpose."""


class InputError(CreakError):
    """The user's input is wrong: one message that says what, where and what to do.

    Parameters
    ----------
    what : what is wrong, with the value that was found.
    expected : what would have been right.
    where : file and line, node, element, set or key.
    fix : what to do about it.
    """

    def __init__(self, what: str, *, expected: str = "", where: object = "", fix: str = "") -> None:
        what, expected, fix = (shortened(text) for text in (what, expected, fix))
        self.what, self.expected, self.where, self.fix = what, expected, shortened(str(where)), fix
        text = f"{self.where}: {what}" if self.where else what
        if expected:
            text += f"; expected {expected}"
        if fix:
            text += f"{'' if text.endswith(('.', '?')) else '.'} {fix}"
        super().__init__(text)


class NumericalError(CreakError):
    """The analysis failed on valid input; the message names the place and the likely cause."""


class Unreliable(NumericalError):
    """The analysis went through and its results are written, but they are worth nothing."""


class WriteError(CreakError):
    """A file could not be written, for instance because the disk is full; what was there before is as it was."""


def unforeseen(problem: BaseException) -> str:
    """What an error that nobody raised on purpose is, and where in the code it came up."""
    at = traceback.extract_tb(problem.__traceback__)[-1]
    return f"{type(problem).__name__}: {problem} ({Path(at.filename).name}:{at.lineno})"


def suggest(name: str, known: Iterable[str]) -> str:
    """Say which known name was probably meant, or list what there is."""
    names = sorted({str(k) for k in known})
    by_upper = {k.upper(): k for k in names}
    close = difflib.get_close_matches(name.upper(), list(by_upper), n=1, cutoff=0.6)
    if close:
        return f"Did you mean {by_upper[close[0]]!r}?"
    if not names:
        return "There are none."
    shown = ", ".join(names[:12])
    return f"There are: {shown}{', ...' if len(names) > 12 else ''}."
