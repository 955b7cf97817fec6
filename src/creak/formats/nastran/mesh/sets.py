"""Node sets and element sets that a study can name."""

from __future__ import annotations

import numpy as np

from creak.arrays import IntArray
from creak.formats.deck.text import plain_name
from creak.formats.nastran.mesh.optistruct import bulk_sets
from creak.formats.nastran.mesh.regions import Region
from creak.formats.nastran.text.bulk_data import Card, id_ranges, ids_among
from creak.formats.nastran.text.case_control import EVERY
from creak.formats.nastran.text.deck import Deck
from creak.model.mesh import ElementBlock

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
