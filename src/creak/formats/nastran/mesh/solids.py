"""CHEXA, CPENTA, CTETRA -> solid elements."""

from __future__ import annotations

from creak.arrays import FloatArray
from creak.formats.deck.coordinate_systems import axes_at
from creak.formats.deck.refusals import referred
from creak.formats.nastran.sections.materials import Materials
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, rows_with_middles, unique_cards
from creak.model.dofs import TRANSLATIONS
from creak.model.faces import HEX20, MIDDLES
from creak.model.materials import AnisotropicMaterial, SheetMaterial, SolidSection

_KINDS = {
    "CHEXA": (("hex8", 8), ("hex20s", 20)),
    "CPENTA": (("wedge6", 6), ("wedge15", 15)),
    "CPYRAM": (("pyramid5", 5), ("", 13)),
    "CPYRA": (("pyramid5", 5), ("", 13)),
    "CTETRA": (("tet4", 4), ("tet10", 10)),
}
"""First- and second-order element and number of grids."""
CARD_OF = {kind: card for card, kinds in reversed(_KINDS.items()) for kind, _ in kinds} | dict.fromkeys(HEX20, "CHEXA")
"""The card that a kind is written as."""
ORDER = {
    **{kind: [*range(12), *range(16, 20), *range(12, 16)] for kind in HEX20},
    "wedge15": [*range(9), *range(12, 15), *range(9, 12)],
}
"""Nastran's mid-side grids between the two faces come before those of the second face; creak's, as Abaqus's, after.
The same order leads there and back."""
NETWORKS: dict[str, tuple[int, int] | None] = {"hex20": (3, 1), "hex20r": (2, 1), "hex20s": None}
"""IN and ISOP of a PSOLID that give a CHEXA of 20 grids this kind; None where they are blank."""

LUMPED = (
    "creak scales the diagonal of the consistent mass, Nastran lumps in its own way: coarse meshes differ "
    "(PARAM,COUPMASS,1: consistent)"
)
FLUID = "PSOLID, PFLUID"


def read_solids(deck: Deck, materials: Materials) -> None:
    """Add all solids to the deck's groups.

    Raises
    ------
    InputError : unknown grid, property or material, an id twice, a pyramid with mid-side grids.
    """
    properties = unique_cards(deck.cards("PSOLID"), "property")
    fluid = {pid for pid, card in properties.items() if card.text(6).upper() in ("PFLUID", "FFLUID", "FLUID")}
    for pid in fluid:
        deck.note(properties[pid], "creak has no fluid elements: the structure is read alone", changes=True, what=FLUID)
    sections = {pid: _section(card, materials) for pid, card in properties.items() if pid not in fluid}
    for name in _KINDS:
        for card in deck.cards(name):
            pid = card.integer(1, card.integer(0))
            owner = referred(properties, pid, card, "property", "PSOLID")
            if pid in fluid:
                continue
            identifier = deck.new_element(card, pid)
            kind, nodes = _grids(deck, card, owner)
            if kind == "tet10" and deck.param("COUPMASS", -1.0) <= 0.0:
                deck.note(card, LUMPED, changes=False, what="CTETRA of 10 grids, lumped mass")
            own = _axes(deck, owner, nodes) if isinstance(sections[pid].material, AnisotropicMaterial) else {}
            deck.add((pid,), kind, sections[pid], identifier, nodes, card, **own)


def _section(card: Card, materials: Materials) -> SolidSection:
    material = materials.of(card.integer(1), card).material
    if isinstance(material, SheetMaterial):
        raise card.error(f"PSOLID {card.integer(0)} uses {material.name}", expected="MAT1 or MAT9")
    return SolidSection(f"PSOLID {card.integer(0)}", material)


def _grids(deck: Deck, card: Card, owner: Card) -> tuple[str, list[int]]:
    """Kind and node rows, in creak's order."""
    (first, n), (second, more) = _KINDS[card.name]
    if not second:
        given = sum(card.text(i) not in ("", "0") for i in range(2 + n, 2 + more))
        if given:
            raise card.error(
                f"{card.title} has {n + given} grids", expected=f"{n} grids", fix="Export the mesh in first order."
            )
        return first, deck.nodes(card, range(2, 2 + n))
    sides = MIDDLES[second]
    nodes = rows_with_middles(deck, card, sides, ORDER.get(second, range(more)), TRANSLATIONS)
    if len(nodes) == n:
        return first, nodes
    return _network(owner) if card.name == "CHEXA" else second, nodes


def _network(owner: Card) -> str:
    """How a CHEXA of 20 grids is integrated: IN and ISOP of its PSOLID."""
    if owner.text(3).upper() in ("2", "TWO"):
        return "hex20r"
    return "hex20" if owner.text(5).upper() in ("1", "FULL") else "hex20s"


def _axes(deck: Deck, owner: Card, nodes: list[int]) -> dict[str, FloatArray]:
    """Material axes of a MAT9: those of CORDM at the middle of the element; -1 (the element's own) is not read."""
    if owner.integer(2, 0) == -1:
        deck.note(owner, "creak takes the material axes of the basic system", changes=True, what="PSOLID, CORDM = -1")
        return {}
    place = sum((deck.grids.place(row) for row in nodes), start=0.0 * deck.grids.place(nodes[0])) / len(nodes)
    axes = axes_at(deck.system(owner.integer(2, 0), owner), place)
    return {"axis1": axes[:, 0], "axis2": axes[:, 1]}
