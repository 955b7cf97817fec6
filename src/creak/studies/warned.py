"""Notes that ask the user to do something, and what fails after a run as one of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from creak.errors import CreakError, unforeseen

T = TypeVar("T")


class Warned(str):
    """A note of a study that the user should act on; it goes wherever notes go."""

    __slots__ = ()


def warnings_of(notes: Iterable[str]) -> list[str]:
    """The notes that warn, as plain sentences, each once."""
    return list(dict.fromkeys(str(n) for n in notes if isinstance(n, Warned)))


def plain_notes(notes: Iterable[str]) -> list[str]:
    """The other notes."""
    return [n for n in notes if not isinstance(n, Warned)]


def attempted(what: str, make: Callable[[], T], nothing: T, notes: list[str], *, ctrl_c: bool = True) -> T:
    """What is told of a run that is there already, or `nothing` and a note why: a failure costs no run.

    Parameters
    ----------
    ctrl_c : whether Ctrl-C is such a failure; else it goes on to the caller.
    """
    try:
        return make()
    except KeyboardInterrupt:
        if not ctrl_c:
            raise
        why = "stopped by Ctrl-C"
    except CreakError as error:
        why = str(error)
    except MemoryError:
        why = "memory did not hold what it takes"
    except Exception as error:
        why = f"{unforeseen(error)}; this is a fault of creak, please report it"
    notes.append(Warned(f"{what}: left out, {why.rstrip('.')}. The run itself is complete"))
    return nothing
