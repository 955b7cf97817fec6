"""Notes that ask the user to do something, and what fails after a run as one of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from creak.errors import CreakError, unforeseen
from creak.words import listed

T = TypeVar("T")


class Warned(str):
    """A note of a study that the user should act on; it goes wherever notes go."""

    __slots__ = ()


def warnings_of(notes: Iterable[str]) -> list[str]:
    """The notes that warn, as plain sentences, each once."""
    return list(dict.fromkeys(str(n) for n in notes if isinstance(n, Warned)))


def add_warnings(notes: list[str], more: Iterable[str]) -> None:
    """Those of more that warn join the notes, each once."""
    notes += [n for n in more if isinstance(n, Warned) and n not in notes]


def plain_notes(notes: Iterable[str]) -> list[str]:
    """The other notes."""
    return [n for n in notes if not isinstance(n, Warned)]


class _ByCtrlC(Warned):
    """What Ctrl-C left out; nothing more is attempted where this is among the notes."""

    __slots__ = ("names",)
    names: tuple[str, ...]

    def __new__(cls, names: tuple[str, ...]) -> _ByCtrlC:
        whole = "" if REST in names else ". The run itself is complete"
        note = super().__new__(cls, f"{listed(names)}: left out, stopped by Ctrl-C{whole}")
        note.names = names
        return note

    def __getnewargs__(self) -> tuple[tuple[str, ...]]:  # type: ignore[override]
        return (self.names,)


REST = "the rest of the run"


def is_asked_to_end(notes: Iterable[str]) -> bool:
    """Whether Ctrl-C left something out."""
    return any(isinstance(n, _ByCtrlC) for n in notes)


def left_by_ctrl_c(what: str, notes: list[str]) -> None:
    """Note that Ctrl-C left it out, in one sentence with what it left out before."""
    before = next((n for n in notes if isinstance(n, _ByCtrlC)), None)
    if before is None:
        notes.append(_ByCtrlC((what,)))
    else:
        notes[notes.index(before)] = _ByCtrlC(tuple(dict.fromkeys((*before.names, what))))


def attempted(what: str, make: Callable[[], T], nothing: T, notes: list[str], *, ctrl_c: bool = True) -> T:
    """What is told of a run that is there already, or `nothing` and a note why: a failure costs no run.

    Who presses Ctrl-C wants the program to end: after it nothing more is tried.

    Parameters
    ----------
    notes : of the run; the note is added to them.
    ctrl_c : whether Ctrl-C is such a failure; else it goes on to the caller.
    """
    if is_asked_to_end(notes):
        left_by_ctrl_c(what, notes)
        return nothing
    try:
        return make()
    except KeyboardInterrupt:
        if not ctrl_c:
            raise
        left_by_ctrl_c(what, notes)
        return nothing
    except CreakError as error:
        why = str(error)
    except MemoryError:
        why = "memory did not hold what it takes"
    except Exception as error:
        why = f"{unforeseen(error)}; this is a fault of creak, please report it"
    notes.append(Warned(f"{what}: left out, {why.rstrip('.')}. The run itself is complete"))
    return nothing
