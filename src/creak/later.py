"""Records of which some fields are known, and the others are made when somebody asks for one of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import cache, cached_property
from typing import Any, TypeVar, cast

T = TypeVar("T")


def later(kind: type[T], make: Callable[[], T], **known: Any) -> T:
    """A record of dataclass `kind` with the fields `known`; the first question for another one makes all of it, once.

    What is known must be what `make` would give.
    """
    found = object.__new__(_asking(cast(Any, kind)))
    found.__dict__.update(known, _make=make)
    return cast(T, found)


def is_made(record: object) -> bool:
    """Whether a record has all its fields."""
    return "_make" not in record.__dict__ or "_made" in record.__dict__


@cache
def _asking(kind: Any) -> type[Any]:
    """The same dataclass, whose fields ask for what was not given; what lies in the instance comes before them."""
    body: dict[str, Any] = {f.name: cached_property(_question(f.name)) for f in fields(kind)}
    return type(f"Later{kind.__name__}", (kind,), {**body, "_made": cached_property(lambda self: self._make())})


def _question(name: str) -> Callable[[Any], Any]:
    return lambda record: getattr(record._made, name)
