"""The terminal: what names and files hold is shown as it is, never taken for markup, emoji or control sequences."""

from __future__ import annotations

import os
import sys
import unicodedata
from typing import Any, TextIO

from rich.console import Console

LAYOUT = "\n\t"
UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""Unicode categories that do something to a terminal, or cannot be written: controls, directions, halves of pairs."""


def printable(text: str) -> str:
    r"""A text with \x1b and its like for characters that a terminal would act on."""
    if text.isascii() and text.replace("\n", "").replace("\t", "").isprintable():
        return text
    return "".join(c if c in LAYOUT or unicodedata.category(c) not in UNSEEN else _escaped(c) for c in text)


def _escaped(char: str) -> str:
    return char.encode("unicode_escape").decode("ascii")


def drop(stream: TextIO) -> None:
    """Nothing more is written there, not at the end of the process either."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class Terminal(Console):
    """A rich console whose strings are plain text; tables and bars get theirs from `printable`.

    Where stderr cannot be written, what it was to tell is lost: it costs no run, and no exit status.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, highlight=False, **options)

    def print(self, *objects: Any, **options: Any) -> None:
        """As rich's, without markup."""
        try:
            super().print(*(printable(o) if isinstance(o, str) else o for o in objects), **{**options, "markup": False})
        except OSError:
            if not self.stderr:
                raise
            drop(sys.stderr)
