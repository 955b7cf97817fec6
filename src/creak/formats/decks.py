"""The formats of decks that creak reads: the one place that knows them all."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from creak.errors import InputError
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
    """By the ending; of decks with any other ending by their first words.

    Raises
    ------
    InputError : a study; a deck whose first words are those of another format than its ending says.
    """
    if path.suffix.lower() == ".toml":
        raise InputError(f"{path} is a study", expected="a deck", fix="Give the deck that its [model] names.")
    _check_first_words(path)
    known = next((of for known, of in FORMATS if path.suffix.lower() in known), None)
    return known() if known is not None else _by_first_words(path)()


_FIRST = re.compile(rb"(?im)^[ \t]*(\*[ \t]*[a-z]{3}[a-z]*|CEND\b|BEGIN[ \t]+BULK\b|SOL[ \t]+[a-z0-9]|GRID[*, \t])")


_STARRED = re.compile(rb"(?i)\*(KEYWORD|HEADING|NODE|PARAMETER|PREPRINT|PART|MATERIAL|INCLUDE)$")
"""What no line of a Nastran deck is likely to begin with: names of its continuations begin with a star too."""


def _check_first_words(path: Path) -> None:
    """Raise InputError for a deck with a name of another format: an .inp that is a Nastran deck, or the reverse."""
    ending, word = path.suffix.lower(), _first_word(path)
    starred = _STARRED.match(word) is not None
    told = None
    if ending == endings.ABAQUS and ((starred and word.upper() == b"*KEYWORD") or (word and not word.startswith(b"*"))):
        told = ("an LS-DYNA", endings.LSDYNA[0]) if starred else ("a Nastran", endings.NASTRAN[0])
    elif ending in endings.NASTRAN and starred:
        told = ("an LS-DYNA", endings.LSDYNA[0]) if word.upper() == b"*KEYWORD" else ("an Abaqus", endings.ABAQUS)
    if told is not None:
        raise InputError(
            f"{path} begins with {word.decode().strip()}, as {told[0]} deck does",
            expected="a deck of the format that its ending stands for",
            fix=f"Rename it to {path.stem}{told[1]}.",
        )


def _by_first_words(path: Path) -> Callable[[], DeckFormat]:
    """*KEYWORD comes first in LS-DYNA's decks, another keyword with a star in Abaqus's; other lines that are found are
    such as only Nastran's have."""
    word = _first_word(path)
    if word.upper() == b"*KEYWORD":
        return _lsdyna
    return _nastran if word and not word.startswith(b"*") else _abaqus


def _first_word(path: Path) -> bytes:
    """The first word that tells a format; empty where there is none, or no file that can be read."""
    try:
        if not path.is_file():
            return b""
        with path.open("rb") as file:
            head = file.read(LOOKED_AT)
    except OSError:  # the reader says what is wrong with it
        return b""
    first = _FIRST.search(head)
    return b"" if first is None else first.group(1)


def read_model(path: Path) -> Model:
    """Read a deck by its ending.

    Raises
    ------
    InputError : a deck that is wrong, with file and line.
    """
    return with_held_membranes(format_of(path).read(path))
