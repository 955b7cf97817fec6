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


@cache
def _lsdyna() -> DeckFormat:
    from creak.formats.lsdyna.reader import read_lsdyna, read_lsdyna_run
    from creak.formats.lsdyna.text.lexer import lsdyna_files

    return DeckFormat(read_lsdyna, read_lsdyna_run, lsdyna_files)


FORMATS = (((endings.ABAQUS,), _abaqus), (endings.NASTRAN, _nastran), (endings.LSDYNA, _lsdyna))
"""Endings, and what reads such decks."""
LOOKED_AT = 1 << 16
"""Bytes of a deck of an unknown ending in which its format is looked for."""


def format_of(path: Path) -> DeckFormat:
    """By the ending; of decks with any other ending by their first words."""
    known = next((of for known, of in FORMATS if path.suffix.lower() in known), None)
    return known() if known is not None else _by_first_words(path)()


_FIRST = re.compile(rb"(?im)^[ \t]*(\*[ \t]*[a-z]{3}[a-z]*|CEND\b|BEGIN[ \t]+BULK\b|SOL[ \t]+[a-z0-9]|GRID[*, \t])")


def _by_first_words(path: Path) -> Callable[[], DeckFormat]:
    """*KEYWORD comes first in LS-DYNA's decks, another keyword with a star in Abaqus's; other lines that are found are
    such as only Nastran's have."""
    try:
        if not path.is_file():
            return _abaqus
        with path.open("rb") as file:
            head = file.read(LOOKED_AT)
    except OSError:  # the reader says what is wrong with it
        return _abaqus
    first = _FIRST.search(head)
    if first is None or first.group(1).upper() == b"*KEYWORD":
        return _abaqus if first is None else _lsdyna
    return _abaqus if first.group(1).startswith(b"*") else _nastran


def read_model(path: Path) -> Model:
    """Read a deck by its ending.

    Raises
    ------
    InputError : a deck that is wrong, with file and line.
    """
    return with_held_membranes(format_of(path).read(path))
