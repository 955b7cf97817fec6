"""PLOAD, PLOAD2, PLOAD4: pressure on shells and faces of solids."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.deck.coordinate_systems import axes_at
from creak.formats.deck.pressure import Pressed, nodal_forces
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck
from creak.model.faces import FACES, N_CORNER, SHELL_FACETS, FaceShapes, face_numbers, face_shapes, faces_of, joined

CARDS = ("PLOAD", "PLOAD2", "PLOAD4")
_NORMAL = (np.nan, np.nan, np.nan)
Piece = tuple[FaceShapes, FloatArray, Sequence[float]]
"""Facets (n,), pressures (n, w) at the nodes of their faces, direction."""

_Face = tuple[str, list[int], IntArray]
"""Kind and nodes of an element, its facets."""


def pressure_forces(deck: Deck, cards: Sequence[tuple[Card, float]]) -> tuple[IntArray, FloatArray]:
    """Node rows and forces (k, 3) of cards, each with a factor.

    On shells positive pressure acts along the normal (of PLOAD: by the order of its grids), on solids into them.

    Raises
    ------
    InputError : an element that is neither a shell nor a solid, or not there; a face that the grids do not name; a
        pressure that varies over the face of a solid, or beyond the surface (LDIR, SORL).
    """
    elements = {e: (g.kind, nodes) for g in deck.groups.values() for e, nodes in zip(g.ids, g.nodes, strict=True)}
    with_middles = _with_middles(deck) if any(card.name == "PLOAD" for card, _ in cards) else {}
    pieces: list[Piece] = []
    for card, factor in cards:
        if card.name == "PLOAD":
            pieces.append(_on_grids(deck, card, factor, with_middles))
            continue
        for element in _elements(card, elements):
            pieces.append(_of_element(deck, card, factor, *elements[element]))
    coords = np.array([deck.grids.place(row) for row in range(len(deck.grids.ids))])
    ends = np.cumsum([0, *(len(faces.nodes) for faces, _, _ in pieces)])
    rows = [np.arange(a, b) for a, b in pairwise(ends.tolist())]
    faces = joined([(mine, faces) for mine, (faces, _, _) in zip(rows, pieces, strict=True)], int(ends[-1]))
    pressure, along = np.zeros(faces.nodes.shape), np.zeros((len(faces.nodes), 3))
    for mine, (_, given, direction) in zip(rows, pieces, strict=True):
        pressure[mine, : given.shape[1]], along[mine] = given, direction
    return nodal_forces(Pressed(faces, pressure, along), coords)


def _with_middles(deck: Deck) -> dict[tuple[int, ...], _Face]:
    """The faces that have middle nodes, by their sorted corners."""
    found: dict[tuple[int, ...], _Face] = {}
    for group in deck.groups.values():
        if group.kind not in (*FACES, *SHELL_FACETS):
            continue
        of_face = face_numbers(group.kind) if group.kind in FACES else np.ones(len(SHELL_FACETS[group.kind]))
        for face in np.unique(of_face):
            number = np.flatnonzero(of_face == face)
            whole = face_shapes(
                group.kind, np.array(group.nodes, dtype=np.int64), np.repeat(number[:1], len(group.ids))
            )
            if whole.sides.any():
                corners = np.sort(whole.nodes[:, : whole.sides[0]], axis=1)
                found |= {tuple(c): (group.kind, n, number) for c, n in zip(corners.tolist(), group.nodes, strict=True)}
    return found


def _facets(kind: str, nodes: Sequence[int] | IntArray, number: IntArray) -> FaceShapes:
    """Facets `number` (n,) of one element."""
    return face_shapes(kind, np.broadcast_to(np.array(nodes, dtype=np.int64), (number.size, len(nodes))), number)


def _on_grids(deck: Deck, card: Card, factor: float, with_middles: dict[tuple[int, ...], _Face]) -> Piece:
    """PLOAD: on the face with middle nodes whose corners its grids are, else on the grids alone."""
    rows = [deck.grids.row(card.integer(i), card) for i in range(2, 6) if card.text(i)]
    if len(rows) not in (3, 4):
        raise card.error(f"PLOAD with {len(rows)} grids", expected="three or four")
    plain: _Face = ("quad4" if len(rows) == 4 else "tri3", rows, np.zeros(1, dtype=np.int64))
    pressure, faces = factor * card.real(1), _facets(*with_middles.get(tuple(sorted(rows)), plain))
    if faces.sides[0]:
        around = faces.nodes[0, : len(rows)].tolist()
        pressure *= 1.0 if around[(around.index(rows[0]) + 1) % len(rows)] == rows[1] else -1.0
    return faces, np.full(faces.nodes.shape, pressure), _NORMAL


def _elements(card: Card, known: dict[int, tuple[str, list[int]]]) -> list[int]:
    """The elements of a PLOAD2 or PLOAD4, of a range (THRU) those that there are."""
    at = 2 if card.name == "PLOAD2" else 1
    thru = 3 if card.name == "PLOAD2" else 6
    if card.text(thru).upper() == "THRU":
        first, last = card.integer(at), card.integer(thru + 1)
        found = [e for e in known if first <= e <= last]
    else:
        named = range(2, len(card.fields)) if card.name == "PLOAD2" else [1]
        found = [card.integer(i) for i in named if card.text(i)]
    missing = [e for e in found if e not in known]
    if missing or not found:
        gone = missing[0] if missing else card.text(at)
        raise card.error(f"{card.title} presses element {gone}, which is not there", expected="shells or solids")
    return found


def _of_element(deck: Deck, card: Card, factor: float, kind: str, nodes: list[int]) -> Piece:
    along = _direction(deck, card)
    if kind in SHELL_FACETS:
        n = N_CORNER[kind]
        p = _pressures(card, n)
        p += [0.5 * (p[i] + p[(i + 1) % n]) for i in range(len(nodes) - n)]
        number = np.arange(len(SHELL_FACETS[kind]))
        places = _facets(kind, range(len(nodes)), number).nodes
        return _facets(kind, nodes, number), factor * np.array(p)[places], along
    if kind not in FACES or card.name != "PLOAD4":
        raise card.error(
            f"{card.title} presses an element without such a surface", expected="a shell, or with PLOAD4 a solid"
        )
    p = _pressures(card, 4)
    if len(set(p)) > 1:
        raise card.error(f"PLOAD4 {card.text(0)} varies over the face of a solid", expected="P1 alone")
    inward = -1.0 if np.isnan(along[0]) else 1.0
    faces = _facets(kind, nodes, _face(deck, card, kind, nodes))
    return faces, np.full(faces.nodes.shape, factor * inward * p[0]), along


def _face(deck: Deck, card: Card, kind: str, nodes: list[int]) -> IntArray:
    """Numbers of the facets of the face that G1 and G3 (on it, at opposite corners; of CTETRA G4, not on it) name."""
    named = [deck.grids.row(card.integer(i), card) for i in (6, 7) if card.text(i)]
    every, number = faces_of(kind, np.array([nodes], dtype=np.int64))[0], face_numbers(kind)
    fits = []
    for face in range(1, int(number.max()) + 1):
        mine = every[number == face]
        inside = [row in mine for row in named]
        wanted = [True, False] if kind.startswith("tet") else [True] * len(named)
        is_triangle = bool((mine[:, 2] == mine[:, 3]).all())
        if named and inside == wanted[: len(named)] and (len(named) > 1 or is_triangle):
            fits.append(np.flatnonzero(number == face))
    if len(fits) != 1:
        raise card.error(
            f"G1 and G3 of PLOAD4 {card.text(0)} name {len(fits)} faces of element {card.text(1)}",
            expected="a corner of the face and the one opposite (CTETRA: the one that is not on the face)",
        )
    return np.asarray(fits[0], dtype=np.int64)


def _pressures(card: Card, n: int) -> list[float]:
    """At the corners: P1, where the others are blank."""
    if card.name == "PLOAD2":
        return [card.real(1)] * n
    first = card.real(2)
    return [card.real(2 + i, first) for i in range(n)]


def _direction(deck: Deck, card: Card) -> Sequence[float]:
    """N1, N2, N3 of a PLOAD4 as a unit vector; NaN: none."""
    if card.name != "PLOAD4":
        return _NORMAL
    if any(card.text(i).upper() not in ("", word) for i, word in ((12, "SURF"), (13, "NORM"))):
        raise card.error(f"PLOAD4 {card.text(0)} has SORL or LDIR", expected="SURF and NORM", fix="Leave them out.")
    vector = np.array([card.real(i, 0.0) for i in (9, 10, 11)])
    if not vector.any():
        return _NORMAL
    axes = axes_at(deck.system(card.integer(8, 0), card), np.zeros(3))
    return list((axes @ (vector / np.linalg.norm(vector))).tolist())
