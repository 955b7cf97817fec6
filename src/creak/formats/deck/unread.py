"""What of a deck went unread."""

from __future__ import annotations

from collections.abc import Iterable

from creak.errors import InputError
from creak.model.mesh import Model


def stop_on_unread(model: Model, ignore: Iterable[str]) -> None:
    """Stop where the model was read without something that changes the answer, but the keywords of `ignore`.

    Raises
    ------
    InputError : there is such a keyword; the first one.
    """
    accepted = {k.upper().lstrip("*") for k in ignore}
    for unread in model.unread:
        if unread.changes_answer and unread.keyword.upper().lstrip("*") not in accepted:
            keyword = unread.keyword.lstrip("*")
            raise InputError(
                f"{unread.keyword} is not read by creak and would change the answer: {unread.why}",
                where=unread.where,
                fix=f"Remove it, or run with --ignore {keyword!r} to go on without it.",
            )
