"""What of a deck went unread."""

from __future__ import annotations

from collections.abc import Iterable

from creak.model.mesh import Model, Unread


def first_unread(model: Model, ignore: Iterable[str]) -> Unread | None:
    """The first keyword that went unread although it changes the answer, but those of `ignore`; None: there is none."""
    accepted = {k.upper().lstrip("*") for k in ignore}
    found = (u for u in model.unread if u.changes_answer and u.keyword.upper().lstrip("*") not in accepted)
    return next(found, None)
