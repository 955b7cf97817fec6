"""How work reports how far it is: a call, and whoever shows it decides how."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""What is being done, how many steps are done, how many there are."""
Steps = Callable[[int, int], None]
"""The same of one piece of work, which needs no name."""


class Sentence(str):
    """What is to be told at once, in place of the name of a phase; with it 1 of 1 step is done."""

    __slots__ = ()


def silent(*_: object) -> None:
    """No progress."""
