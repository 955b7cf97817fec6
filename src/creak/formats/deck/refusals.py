"""What every reader and writer of decks says of what it cannot take."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar, Protocol, TypeVar

import numpy as np

from creak.errors import InputError

K = TypeVar("K", int, str)
T = TypeVar("T")


class _HasPlace(Protocol):
    @property
    def where(self) -> str: ...


class _Titled(_HasPlace, Protocol):
    kind: ClassVar[str]

    @property
    def title(self) -> str: ...


class Placed:
    """What stands at a place of a deck, `where`: a card, a keyword with its lines."""

    kind: ClassVar[str] = ""
    """What messages call it behind its name."""

    def error(self: _HasPlace, what: str, *, expected: str = "", fix: str = "") -> InputError:
        """What is wrong with it."""
        return InputError(what, expected=expected, where=self.where, fix=fix)

    def twice(self: _HasPlace, what: str, first: str, fix: str = "Give one of them another id.") -> InputError:
        """It defines what is defined already, at `first`."""
        return InputError(f"{what} is defined twice, first at {first}", where=self.where, fix=fix)


def referred(found: Mapping[K, T], identifier: K, user: _Titled, what: str, of: str) -> T:
    """What stands under this id, that `user` refers to; it is made by a card or keyword `of`.

    Raises
    ------
    InputError : there is none.
    """
    if identifier not in found:
        raise InputError(
            f"{user.title} uses {what} {identifier}, which is not defined",
            expected=f"a {of}{user.kind} with this id",
            where=user.where,
            fix="Add it or correct the id.",
        )
    return found[identifier]


@contextmanager
def reading(path: str | Path, looks_wrong: Callable[[], str]) -> Iterator[None]:
    """Turn what goes wrong with the numbers of a deck into an `InputError`, and add a hint to its errors.

    Parameters
    ----------
    looks_wrong : a sentence about a keyword that may have caused an error, or nothing.
    """
    try:
        with np.errstate(all="ignore"):
            yield
    except (OverflowError, np.linalg.LinAlgError):
        raise InputError(
            "a number of the deck is too large or too small to compute with",
            where=path,
            fix="Check the sections, properties, materials and coordinates.",
        ) from None
    except InputError as error:
        fix = f"{error.fix} {looks_wrong()}".strip()
        raise InputError(error.what, expected=error.expected, where=error.where or path, fix=fix) from None


@contextmanager
def noted(flaws: list[str] | None) -> Iterator[None]:
    """What is wrong inside, as one more flaw; an error where nobody takes flaws."""
    try:
        yield
    except InputError as error:
        if flaws is None:
            raise
        flaws.append(str(error))


def unwritable(what: str, why: str) -> InputError:
    """What a deck of this format, as creak reads it, cannot say."""
    return InputError(
        f"{what} cannot be written to a deck of this format: {why}",
        fix="Take it out of the model, or keep the deck as it is.",
    )
