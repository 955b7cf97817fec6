"""Regions of glue and contact: BSURF, BSURFS, BCPROP, BCPROPS of NX and MSC; SURF and SET of OptiStruct."""

from __future__ import annotations

from creak.errors import InputError
from creak.formats.nastran.mesh.optistruct import named_surfaces, surface_elements
from creak.formats.nastran.text.bulk_data import Card, id_ranges, ids_among
from creak.formats.nastran.text.deck import Deck

CARDS = ("BSURF", "BCPROP", "BCPROPS", "BSURFS")
Faces = dict[int, list[set[int]]]
"""Solid -> rows of some grids of each of its faces."""
Region = tuple[list[int], Faces]
"""Elements, of solids all free faces; and single faces."""


def region(deck: Deck, identifier: int) -> Region:
    """What the cards of a number hold together; nothing where there is none."""
    return _regions(deck, identifier).get(identifier, ("", ([], {})))[1]


def named_regions(deck: Deck) -> dict[str, Region]:
    """BSURF_<id>, BCPROP_<id>, ... after the first card of each number; SURF_<id>."""
    found = dict(_regions(deck).values())
    return found | {f"SURF_{i}": surface_elements(deck, i) for i in named_surfaces(deck)}


def region_name(deck: Deck, identifier: int) -> str:
    """As in `named_regions`; empty where there is none."""
    return next((f"{c.name}_{identifier}" for c in deck.cards(*CARDS) if c.text(0) == str(identifier)), "")


def _regions(deck: Deck, only: int | None = None) -> dict[int, tuple[str, Region]]:
    """By number. What is wrong with a card is an error where one region is asked for, else it is listed."""
    found, of_property = dict[int, tuple[str, Region]](), dict[int, list[int]]()
    for element, pid in deck.property_of.items() if next(deck.cards("BCPROP", "BCPROPS"), None) else ():
        of_property.setdefault(pid, []).append(element)
    for card in deck.cards(*CARDS):
        try:
            if only in (None, identifier := card.integer(0)):
                _, (elements, faces) = found.setdefault(identifier, (f"{card.name}_{identifier}", ([], {})))
                _take(deck, card, elements, faces, of_property)
        except InputError as error:
            if only is not None:
                raise
            deck.note(card, f"creak makes no surface of it: {error.what}", changes=False)
    return found


def _take(deck: Deck, card: Card, elements: list[int], faces: Faces, of_property: dict[int, list[int]]) -> None:
    """What a card adds to its region."""
    if card.name == "BSURFS":
        for i in range(4, len(card.fields), 4):
            if card.text(i):
                rows = {deck.grids.row(card.integer(i + k), card) for k in (1, 2, 3)}
                faces.setdefault(card.integer(i), []).append(rows)
    elif card.name == "BSURF":
        elements += ids_among(id_ranges(card, 1), deck.element_at)
    else:
        elements += [e for pid in ids_among(id_ranges(card, 1), of_property) for e in of_property[pid]]
