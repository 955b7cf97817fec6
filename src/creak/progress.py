"""How work reports how far it is: a call, and whoever shows it decides how."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""What is being done, how many steps are done, how many there are."""
Steps = Callable[[int, int], None]
"""The same of one piece of work, which needs no name."""


def silent(*_: object) -> None:
    """No progress."""
