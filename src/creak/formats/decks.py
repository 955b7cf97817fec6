"""The formats of decks that creak reads: the one place that knows them all."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from creak.formats import endings
from creak.formats.deck.membranes import with_held_membranes
from creak.model.mesh import Model
from creak.model.steps import DeckRun


@dataclass(frozen=True)
class DeckFormat:
    """What creak can do with decks of one format."""

    read: Callable[[Path], Model]
    """The model data."""
    read_run: Callable[[Path], tuple[Model, DeckRun]]
    """Model and the analysis that the deck itself asks for."""
    files: Callable[[Path], list[Path]]
    """The deck and what it includes, in reading order."""


@cache
def _abaqus() -> DeckFormat:
    from creak.formats.abaqus.reader import read_deck, read_deck_run  # a tenth of a second, as Nastran's
    from creak.formats.abaqus.text.lexer import abaqus_files

    return DeckFormat(read_deck, read_deck_run, abaqus_files)


@cache
def _nastran() -> DeckFormat:
    from creak.formats.nastran.reader import read_nastran, read_nastran_run
    from creak.formats.nastran.text.deck_file import nastran_files

    return DeckFormat(read_nastran, read_nastran_run, nastran_files)


FORMATS = (((endings.ABAQUS,), _abaqus), (endings.NASTRAN, _nastran))
"""Endings, and what reads such decks."""
LOOKED_AT = 1 << 16
"""Bytes of a deck of an unknown ending in which its format is looked for."""


def format_of(path: Path) -> DeckFormat:
    """By the ending; of decks with any other ending by their first words."""
    known = next((of for known, of in FORMATS if path.suffix.lower() in known), None)
    return known() if known is not None else _nastran() if _is_nastran(path) else _abaqus()


def _is_nastran(path: Path) -> bool:
    """Whether the beginning of a file holds a line that only Nastran's decks have; keywords with a star come first in
    Abaqus's."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            head = file.read(LOOKED_AT)
    except OSError:  # the reader says what is wrong with it
        return False
    first = re.search(rb"(?im)^[ \t]*(\*[ \t]*[a-z]{3}|CEND\b|BEGIN[ \t]+BULK\b|SOL[ \t]+[a-z0-9]|GRID[*, \t])", head)
    return first is not None and not first.group(1).startswith(b"*")


def read_model(path: Path) -> Model:
    """Read a deck by its ending.

    Raises
    ------
    InputError : a deck that is wrong, with file and line.
    """
    return with_held_membranes(format_of(path).read(path))
