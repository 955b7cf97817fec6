"""What OptiStruct's decks have of their own: sets of the bulk data and surfaces of element faces."""

from __future__ import annotations

from creak.errors import InputError
from creak.formats.nastran.text.bulk_data import Card, id_ranges, ids_among
from creak.formats.nastran.text.deck import Deck

KINDS = ("ELFACE", "ELEM")
ROW = 8
"""Fields of a line of a card."""


def bulk_sets(deck: Deck, kind: str) -> dict[int, list[range]]:
    """SET cards of a TYPE (GRID or ELEM) and SUBTYPE LIST: identifier -> ids."""
    found: dict[int, list[range]] = {}
    for card in deck.cards("SET"):
        if card.text(1).upper() == kind and card.text(2).upper() in ("", "LIST"):
            found[card.integer(0)] = list(id_ranges(card, ROW))
    return found


def surfaces_of(deck: Deck) -> dict[int, Card]:
    """SURF cards by their number."""
    return {card.integer(0): card for card in deck.cards("SURF")}


def named_surfaces(deck: Deck) -> list[int]:
    """Numbers of the surfaces that a study can name; others are listed."""
    found = []
    for identifier, card in surfaces_of(deck).items():
        if card.text(1).upper() in KINDS:
            found.append(identifier)
        else:
            deck.note(card, "creak's surfaces are faces of elements: ELFACE or ELEM", changes=False)
    return found


def surface_elements(deck: Deck, identifier: int) -> tuple[list[int], dict[int, list[set[int]]]]:
    """Elements of a SURF or SET, and of its solids with faces of their own element -> node rows on each of these.

    ELFACE lines hold an element and, of solids, one or two grids of the face; ELEM lists elements, of solids all free
    faces.

    Raises
    ------
    InputError : a surface of facets (FACE) or of another kind, or none of this number.
    """
    card = surfaces_of(deck).get(identifier)
    if card is None:
        sets = bulk_sets(deck, "ELEM")
        if identifier in sets:
            return ids_among(sets[identifier], deck.element_at), {}
        raise InputError(
            f"there is no surface {identifier}",
            where=next(deck.cards("TIE", "CONTACT")).where,
            expected="SURF, or SET of TYPE ELEM with this number",
            fix="Add the card, or name one of those that there are.",
        )
    kind = card.text(1).upper()
    if kind == "ELEM":
        return ids_among(id_ranges(card, ROW), deck.element_at), {}
    if kind not in KINDS:
        raise card.error(f"SURF {identifier} is of type {kind or 'blank'}", expected="ELFACE or ELEM")
    elements: list[int] = []
    faces: dict[int, list[set[int]]] = {}
    for i in range(ROW, len(card.fields), ROW):
        if not card.text(i):
            continue
        element = card.integer(i)
        named = {deck.grids.row(card.integer(i + k), card) for k in (1, 2) if card.text(i + k)}
        if named:
            faces.setdefault(element, []).append(named)
        else:
            elements.append(element)
    return elements, faces
