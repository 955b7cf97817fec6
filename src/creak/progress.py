"""How work reports how far it is: a call, and whoever shows it decides how."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock

Progress = Callable[[str, int, int], None]
"""What is being done, how many steps are done, how many there are."""
Steps = Callable[[int, int], None]
"""The same of one piece of work, which needs no name."""


class Sentence(str):
    """What is to be told at once, in place of the name of a phase; with it 1 of 1 step is done."""

    __slots__ = ()


def silent(*_: object) -> None:
    """No progress."""


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
