"""Node sets, element sets and regions of glue and contact (BSURF, BSURFS, BCPROP, BCPROPS; SURF, SET of OptiStruct)."""

from __future__ import annotations

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError
from creak.formats.deck.text import plain_name
from creak.formats.nastran.text.bulk_data import Card, id_ranges, ids_among
from creak.formats.nastran.text.case_control import EVERY
from creak.formats.nastran.text.deck import Deck
from creak.model.mesh import ElementBlock

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


_DOF_SETS = {
    "ASET": "ASET",
    "ASET1": "ASET",
    "BSET": "BSET",
    "BSET1": "BSET",
    "CSET": "CSET",
    "CSET1": "CSET",
    "SUPORT": "SUPORT",
    "SUPORT1": "SUPORT",
}
CARDS = ("BSURF", "BCPROP", "BCPROPS", "BSURFS")
Faces = dict[int, list[set[int]]]
"""Solid -> rows of some grids of each of its faces."""
Region = tuple[list[int], Faces]
"""Elements, of solids all free faces; and single faces."""


def node_sets(deck: Deck, names: dict[int, str]) -> dict[str, IntArray]:
    """ASET, BSET, CSET, SUPORT; SET_<id>, and the name in the comments, of SET1, SET3 (GRID) and case control SETs that
    hold grids."""
    found: dict[str, list[int]] = {}
    for card in deck.cards(*_DOF_SETS):
        rows = [deck.grids.row_of[i] for i in ids_among(_grids_of(card), deck.grids.row_of)]
        found.setdefault(_DOF_SETS[card.name], []).extend(rows)
    for identifier, ids in _id_sets(deck, ("GRID",)).items():
        found[f"SET_{identifier}"] = [deck.grids.row_of[i] for i in ids_among(ids, deck.grids.row_of)]
        if identifier in names:
            found[plain_name(names[identifier])] = found[f"SET_{identifier}"]
    return {name: np.array(list(dict.fromkeys(rows)), dtype=np.int64) for name, rows in found.items() if rows}


def untyped_sets(deck: Deck, names: dict[int, str]) -> list[str]:
    """SET_<id> and name of SET1 and case control SETs, whose numbers may be those of grids or of elements."""
    return [n for i in _id_sets(deck, ()) for n in (f"SET_{i}", plain_name(names[i]) if i in names else "") if n]


def _grids_of(card: Card) -> list[range]:
    """Ids of a dof set: pairs of grid and dofs, or (ASET1) dofs and a list; SUPORT1 after its set number."""
    if card.name in ("ASET1", "BSET1", "CSET1"):
        return list(id_ranges(card, 1))
    first = 1 if card.name == "SUPORT1" else 0
    ids = [card.integer(i) for i in range(first, len(card.fields), 2) if card.text(i)]
    return [range(i, i + 1) for i in ids]


def _id_sets(deck: Deck, kinds: tuple[str, ...]) -> dict[int, list[range]]:
    found = {identifier: list(ids) for identifier, ids in deck.case.sets.items()}
    for card in deck.cards("SET1"):
        found[card.integer(0)] = [*id_ranges(card, 2 if card.text(1).upper() == "SKIN" else 1)]
    for kind in kinds:
        found |= bulk_sets(deck, kind)
    for card in deck.cards("SET3"):
        if card.text(1).upper()[:4] in kinds:
            found[card.integer(0)] = [*id_ranges(card, 2)]
    return found


def element_sets(
    deck: Deck,
    blocks: tuple[ElementBlock, ...],
    names: dict[int, str],
    set_names: dict[int, str],
    regions: dict[str, Region],
) -> dict[str, IntArray]:
    """PID_<id> and name of every property; SET_<id> and name of sets that hold elements; regions by their names."""
    places: dict[int, list[tuple[int, int]]] = {}
    found: dict[str, list[tuple[int, int]]] = {}
    for b, block in enumerate(blocks):
        for k, identifier in enumerate(block.ids.tolist()):
            places.setdefault(deck.whole.get(identifier, identifier), []).append((b, k))
            pid = deck.property_of.get(identifier)
            if pid is not None:
                found.setdefault(f"PID_{pid}", []).append((b, k))
    for pid, name in names.items():
        if f"PID_{pid}" in found:
            found.setdefault(plain_name(name), found[f"PID_{pid}"])
    for name, (elements, faces) in regions.items():
        found[name] = [at for i in dict.fromkeys((*elements, *faces)) for at in places.get(i, ())]
    for identifier, ids in _id_sets(deck, ("ELEM",)).items():
        if EVERY in ids:
            continue  # the surface of all that there is meets nothing
        found[f"SET_{identifier}"] = [at for i in ids_among(ids, places) for at in places[i]]
        if identifier in set_names and found[f"SET_{identifier}"]:
            found[plain_name(set_names[identifier])] = found[f"SET_{identifier}"]
    return {name: np.array(rows, dtype=np.int64).reshape(-1, 2) for name, rows in found.items() if rows}


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
