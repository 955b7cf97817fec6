"""The answer of a run as the last lines of the terminal."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from creak.errors import shortened
from creak.report.words.answer import SHOWN, Answer, Place, answer, band_words, sones
from creak.report.words.text import number

WIDTH, LINES = 80, 8
"""Columns and lines of the terminal's answer."""


def answer_lines(summary: Mapping[str, Any]) -> list[str]:
    """Lines of at most `WIDTH` columns for the end of the terminal: `LINES` at most, and one for each limit.

    Long texts go on in further lines as long as there are such left; what does not fit is left out from a semicolon on.
    """
    found = answer(summary)
    first = textwrap.wrap(f"{found.light.upper()}: {found.headline}", WIDTH, subsequent_indent="  ", max_lines=2)
    texts = list(_texts(found))
    lines = [*first, *_place_lines(found.places, found.beside)]
    spare = max(LINES - len(lines) - len(texts), 0)
    for text in texts:
        own = _fitting(text, 1 + spare)
        spare -= len(own) - 1
        lines += own
    return lines


def _fitting(text: str, most: int) -> list[str]:
    clauses = text.split("; ")
    for n in range(len(clauses), 0, -1):
        lines = textwrap.wrap("; ".join(clauses[:n]), WIDTH, subsequent_indent="  ")
        if len(lines) <= most:
            return lines
    return textwrap.wrap(text, WIDTH, subsequent_indent="  ", max_lines=most)


def _place_lines(places: Sequence[Place], beside: bool) -> list[str]:
    """A line for each of the first places, and one for the others; two for a single one that has a long name."""
    shown = places if len(places) <= SHOWN else places[: SHOWN - 1]
    n5, n_max = ("adds", "adds up to") if beside else ("N5", "Nmax")
    lines = []
    for p in shown:
        heard = "" if p.n5 is None else f", {n_max} {sones(p.n_max)}" if p.is_rare else f", {n5} {sones(p.n5)}"
        often = f"{number(p.rate, 2)} a second" + (f" ({number(p.squeak, 2)} slips in a squeak)" if p.squeak else "")
        told = f" {p.does}, {often}, {number(p.force, 3)} N{heard}"
        name = p.name if len(shown) == 1 else shortened(p.name, WIDTH - 2 - len(told))
        lines += textwrap.wrap(name + told, WIDTH, initial_indent="  ", subsequent_indent="    ", max_lines=2)
    return lines if len(shown) == len(places) else [*lines, f"  and {len(places) - len(shown)} more places"]


def _texts(found: Answer) -> Iterator[str]:
    worst = next((p for p in found.places if p.cause), None)
    if worst is not None:
        yield f"cause: {worst.cause}"
        if worst.helps:
            yield f"would help: {worst.helps}"
    if found.places and found.before:
        yield found.before
    yield from found.limits
    own = [] if found.limits else [f"why {found.light.upper()}: {found.why}"]
    band = [] if found.band is None else [f"loudness {band_words(found)}"]
    if found.computed is None and own and band:
        yield f"{own[0]}; {band[0]}"
    else:
        yield from (*own, *band)
