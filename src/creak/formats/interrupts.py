"""Ctrl-C put off while something must not be left halfway."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType


@dataclass
class Interrupts:
    """What came meanwhile."""

    came: bool = False

    def check(self) -> None:
        """Raise KeyboardInterrupt where Ctrl-C came."""
        if self.came:
            raise KeyboardInterrupt


@contextmanager
def interrupts_later() -> Iterator[Interrupts]:
    """Ctrl-C waits for `Interrupts.check`, at the latest for the end; it only ever comes to the main thread."""
    found = Interrupts()

    def remember(number: int, frame: FrameType | None) -> None:
        found.came = True

    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield found
        return
    signal.signal(signal.SIGINT, remember)
    try:
        yield found
    finally:
        signal.signal(signal.SIGINT, before)
    found.check()
