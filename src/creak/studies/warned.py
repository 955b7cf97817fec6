"""Notes that ask the user to do something."""

from __future__ import annotations

from collections.abc import Iterable


class Warned(str):
    """A note of a study that the user should act on; it goes wherever notes go."""

    __slots__ = ()


def warnings_of(notes: Iterable[str]) -> list[str]:
    """The notes that warn, as plain sentences, each once."""
    return list(dict.fromkeys(str(n) for n in notes if isinstance(n, Warned)))


def plain_notes(notes: Iterable[str]) -> list[str]:
    """The other notes."""
    return [n for n in notes if not isinstance(n, Warned)]
