"""SDAMPING and TABDMP1: damping of the modes."""

from __future__ import annotations

from contextlib import suppress

from creak.errors import InputError
from creak.formats.deck.catalogue import same_share
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, unique_cards

CARD = "TABDMP1"
TYPES = {"G": 0.5, "": 0.5, "CRIT": 1.0}
"""Share of critical in one of its values; a quality Q is 1 / (2 share)."""


def damping_table(deck: Deck) -> Card | None:
    """The TABDMP1 that the case control takes; None: there is none."""
    chosen = deck.case.damping_table
    return unique_cards(deck.cards(CARD), "table").get(int(chosen)) if chosen.isdigit() else None


def share_of(table: Card) -> float | None:
    """Share of critical damping that a table gives all modes; None: it gives them several, or none below 1.

    Raises
    ------
    InputError : a value that is no number.
    """
    kind = table.text(1).upper()
    ends = [i for i in range(8, len(table.fields)) if table.text(i).upper() == "ENDT"]
    last = ends[0] if ends else len(table.fields)
    values = {table.real(i + 1) for i in range(8, last, 2) if i + 1 < last and table.text(i).upper() != "SKIP"}
    if len(values) != 1 or not min(values) > 0.0 or kind not in (*TYPES, "Q"):
        return None
    value = values.pop()
    share = 0.5 / value if kind == "Q" else TYPES[kind] * value
    return share if share < 1.0 else None


def list_damping(deck: Deck) -> bool:
    """List the share that a study may give instead; False: no table gives one."""
    table, share = None, None
    with suppress(InputError):  # of an analysis that is not run
        table = damping_table(deck)
        share = None if table is None else share_of(table)
    if table is None or share is None:
        return False
    deck.note(table, same_share(share), changes=False, what=CARD, damps=True, share=share)
    return True
