"""SDAMPING and TABDMP1: damping of the modes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from creak.errors import InputError
from creak.formats.deck.catalogue import same_share
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, unique_cards

CARD = "TABDMP1"
TYPES = {"G": 0.5, "": 0.5, "CRIT": 1.0}
"""Share of critical in one of its values; a quality Q is 1 / (2 share)."""
NEARLY = 1.0 - 1e-6
"""Share of critical at which a line that rises ends: at critical damping a mode swings no more."""

Point = tuple[float, float]


def damping_table(deck: Deck) -> Card | None:
    """The TABDMP1 that the case control takes; None: there is none."""
    chosen = deck.case.damping_table
    return unique_cards(deck.cards(CARD), "table").get(int(chosen)) if chosen.isdigit() else None


def points_of(table: Card) -> tuple[tuple[float, float], ...]:
    """Hz, rising from 0 on, and share of critical damping of a table; empty: of one that creak does not follow.

    Nastran goes on along the first and the last line of the table. So does this, down to no damping and up to critical
    damping; from there on the share stays.

    Raises
    ------
    InputError : a value that is no number.
    """
    kind = table.text(1).upper()
    ends = [i for i in range(8, len(table.fields)) if table.text(i).upper() == "ENDT"]
    at = [i for i in range(8, ends[0] if ends else len(table.fields), 2) if table.text(i) or table.text(i + 1)]
    at = [i for i in at if "SKIP" not in (table.text(i).upper(), table.text(i + 1).upper())]
    freq, value = (np.array([table.real(i + k) for i in at]) for k in (0, 1))
    same = value.size > 0 and value.min() == value.max() > 0.0
    if kind in TYPES:
        share = TYPES[kind] * value
    elif kind == "Q" and same:
        share = 0.5 / value
    else:
        return ()
    if not (share.size and share.min() >= 0.0 and 0.0 < share.max() < 1.0):
        return ()
    if same:
        return ((0.0, float(share[0])),)
    rise = np.diff(freq)
    if not (np.all(rise > 0.0) or np.all(rise < 0.0)):
        return ()
    order = np.argsort(freq)
    points = list(zip(freq[order].tolist(), share[order].tolist(), strict=True))
    return tuple(sorted([*_on(points[1], points[0], 0.0), *points, *_on(points[-2], points[-1], np.inf)]))


def _on(a: Point, b: Point, end: float) -> Iterator[Point]:
    """Where the line from a to b, gone on past b, ends: at a frequency, or before it at a share of 0 or 1."""
    slope = (b[1] - a[1]) / (b[0] - a[0])
    way = np.sign(b[0] - a[0])
    bound = b[0] + ((NEARLY if slope * way > 0.0 else 0.0) - b[1]) / slope if slope else end
    last = bound if abs(bound - b[0]) < abs(end - b[0]) else end
    if way * (last - b[0]) > 0.0 and np.isfinite(last):
        yield last, min(max(b[1] + slope * (last - b[0]), 0.0), NEARLY)


def share_of(table: Card) -> float | None:
    """Share of critical damping that a table gives all modes; None: it gives them several, or none below 1."""
    points = points_of(table)
    return points[0][1] if len(points) == 1 else None


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
