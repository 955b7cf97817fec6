"""Runs that ended early, with what they had computed until then."""

from __future__ import annotations

from creak.dynamics.history import History
from creak.errors import NumericalError

GROWS = "look for loads that grow without bound, and for damping or springs below zero that give energy"
"""What to do where creak chose the steps."""


class Stopped(NumericalError):
    """A run did not reach its end; `history` is what it has."""

    def __init__(self, why: str, history: History) -> None:
        self.history = history
        super().__init__(why)


class Diverged(Stopped):
    """The motion is no longer finite; `forced`: its steps were given, not chosen by creak."""

    def __init__(self, time: float, history: History, *, forced: bool = False) -> None:
        remedy = "shorten the step or lower the contact stiffness" if forced else GROWS
        super().__init__(f"the motion is no longer finite at t = {time:.6g} s: {remedy}", history)


class Interrupted(Stopped):
    """Ctrl-C."""

    def __init__(self, history: History) -> None:
        super().__init__(f"stopped at t = {history.time[-1]:.6g} s", history)
