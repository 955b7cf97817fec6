"""Node sets, element sets and surfaces that a study can name."""

from __future__ import annotations

import numpy as np

from creak.arrays import BoolArray, IntArray
from creak.formats.nastran.joints.set_ids import plain_name
from creak.formats.nastran.mesh.optistruct import bulk_sets, named_surfaces, surface_elements
from creak.formats.nastran.text.bulk_data import Card, id_ranges, ids_among
from creak.formats.nastran.text.case_control import EVERY
from creak.formats.nastran.text.deck import Deck
from creak.model.mesh import ElementBlock, Surface
from creak.model.shell_facets import SHELL_FACETS
from creak.model.solid_faces import FACES, faces_of, free_faces

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
    deck: Deck, blocks: tuple[ElementBlock, ...], names: dict[int, str], set_names: dict[int, str]
) -> dict[str, IntArray]:
    """PID_<id> and name of every property; SET_<id> and name of sets that hold elements; SURF_<id> of OptiStruct."""
    place = {int(i): (b, k) for b, block in enumerate(blocks) for k, i in enumerate(block.ids.tolist())}
    found: dict[str, list[tuple[int, int]]] = {}
    for identifier, at in place.items():
        pid = deck.property_of.get(identifier)
        if pid is not None:
            found.setdefault(f"PID_{pid}", []).append(at)
    for pid, name in names.items():
        if f"PID_{pid}" in found:
            found.setdefault(plain_name(name), found[f"PID_{pid}"])
    for identifier in named_surfaces(deck):
        elements, faces = surface_elements(deck, identifier)
        found[f"SURF_{identifier}"] = [place[i] for i in (*elements, *faces) if i in place]
    for identifier, ids in _id_sets(deck, ("ELEM",)).items():
        if EVERY in ids:
            continue  # the surface of all that there is meets nothing
        found[f"SET_{identifier}"] = [place[i] for i in ids_among(ids, place)]
        if identifier in set_names and found[f"SET_{identifier}"]:
            found[plain_name(set_names[identifier])] = found[f"SET_{identifier}"]
    return {name: np.array(rows, dtype=np.int64).reshape(-1, 2) for name, rows in found.items() if rows}


def surfaces(blocks: tuple[ElementBlock, ...], sets: dict[str, IntArray]) -> dict[str, Surface]:
    """For every element set with shells or solids: its name (both sides of shells, free faces of solids), and of shells
    <name>.SPOS and <name>.SNEG, the sides of the positive and negative normal."""
    found: dict[str, Surface] = {}
    free: dict[bytes, tuple[IntArray, IntArray]] = {}
    free_of = _free_of(blocks)
    of_shells = np.array([b.kind in SHELL_FACETS for b in blocks], dtype=bool)
    for name, places in sets.items():
        shells = places[of_shells[places[:, 0]]]
        key = places.tobytes()  # a property is there under its number and under its name
        if key not in free:
            free[key] = _free(places, free_of)
        facets, sides = free[key]
        both = np.concatenate([shells, facets])
        if not both.size:
            continue
        side = np.concatenate([np.zeros(len(shells), dtype=np.int64), sides])
        where = blocks[int(both[0, 0])].where
        found[name] = Surface(name, both, side, _nodes(blocks, shells, facets, sides), where)
        for suffix, value in ((".SPOS", 1), (".SNEG", -1)) if len(shells) and not len(facets) else ():
            found[name + suffix] = Surface(
                name + suffix, shells, np.full(len(shells), value, dtype=np.int64), found[name].nodes_idx, where
            )
    return found


def _free_of(blocks: tuple[ElementBlock, ...]) -> dict[int, BoolArray]:
    """(n, k) of each block of solids: which faces of its elements no other solid shares."""
    faces = {i: faces_of(b.kind, b.nodes_idx) for i, b in enumerate(blocks) if b.kind in FACES}
    if not faces:
        return {}
    every = np.concatenate([f.reshape(-1, 4) for f in faces.values()])
    alone = np.zeros(len(every), dtype=bool)
    alone[free_faces(every, [every])] = True
    ends = np.cumsum([f.shape[0] * f.shape[1] for f in faces.values()])[:-1]
    return {i: part.reshape(f.shape[:2]) for (i, f), part in zip(faces.items(), np.split(alone, ends), strict=True)}


def _free(places: IntArray, free_of: dict[int, BoolArray]) -> tuple[IntArray, IntArray]:
    """(n, 2) places and (n,) numbers of the faces of solids that no other solid shares."""
    facets, sides = [np.zeros((0, 2), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for b in np.unique(places[:, 0]).tolist():
        if b in free_of:
            rows = places[places[:, 0] == b, 1]
            element, face = np.nonzero(free_of[b][rows])
            facets.append(np.column_stack([np.full(element.size, b), rows[element]]))
            sides.append(face + 1)
    return np.concatenate(facets), np.concatenate(sides)


def _nodes(blocks: tuple[ElementBlock, ...], shells: IntArray, facets: IntArray, sides: IntArray) -> IntArray:
    found = [blocks[b].nodes_idx[shells[shells[:, 0] == b, 1]].ravel() for b in np.unique(shells[:, 0]).tolist()]
    for (b, k), side in zip(facets.tolist(), sides.tolist(), strict=True):
        found.append(blocks[b].nodes_idx[k][list(FACES[blocks[b].kind][side - 1])])
    return np.unique(np.concatenate(found)).astype(np.int64)
