"""How work reports how far it is: a call, and whoever shows it decides how."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock

from creak.errors import InputError

Progress = Callable[[str, int, int], None]
"""What is being done, how many steps are done, how many there are."""
Steps = Callable[[int, int], None]
"""The same of one piece of work, which needs no name."""


class Sentence(str):
    """What is to be told at once, in place of the name of a phase; with it 1 of 1 step is done."""

    __slots__ = ()


def silent(*_: object) -> None:
    """No progress."""


def told_to(progress: Callable[..., None] | None, of: str = "(stage, done, total)") -> Callable[..., None]:
    """What a program gave to be told of progress; None: nobody is.

    Parameters
    ----------
    of : what it is called with.

    Raises
    ------
    InputError : it cannot be called.
    """
    if progress is not None and not callable(progress):
        raise InputError(f"progress is of type {type(progress).__name__}", expected=f"a function of {of}, or None")
    return silent if progress is None else progress


class Shared:
    """Progress of works that go on side by side, told one at a time. After `halt` the next call of each ends it."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._lock, self._halted = progress, Lock(), False

    def halt(self) -> None:
        self._halted = True

    def __call__(self, stage: str, done: int, total: int) -> None:
        if self._halted:
            raise KeyboardInterrupt
        with self._lock:
            self._progress(stage, done, total)
