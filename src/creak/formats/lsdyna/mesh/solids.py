"""*ELEMENT_SOLID with *SECTION_SOLID -> solid elements."""

from __future__ import annotations

from creak.errors import InputError
from creak.formats.lsdyna.mesh.nodes import Transforms
from creak.formats.lsdyna.sections.parts import Properties
from creak.formats.lsdyna.text.deck import EIGHTS, Card, Deck, Named
from creak.model.materials import SolidSection

FORMULATIONS = {0, 1, -1, 2, -2, 3, 4, 9, 10, 13, 15, 16, 17, 18, 60, 99, 115}
"""ELFORM of structural solids."""
COLLAPSED = {
    (0, 1, 2, 3, 4, 5, 6, 7): ("hex8", (0, 1, 2, 3, 4, 5, 6, 7)),
    (0, 1, 2, 3, 4, 4, 6, 6): ("wedge6", (0, 4, 1, 3, 6, 2)),
    (0, 1, 2, 2, 4, 5, 6, 6): ("wedge6", (0, 1, 2, 4, 5, 6)),
    (0, 1, 2, 3, 4, 4, 4, 4): ("pyramid5", (0, 1, 2, 3, 4)),
    (0, 1, 2, 3, 3, 3, 3, 3): ("tet4", (0, 1, 2, 3)),
    (0, 1, 2, 2, 4, 4, 4, 4): ("tet4", (0, 1, 2, 4)),
}
"""Where each of the eight nodes first stands -> element, and its nodes among the eight."""
MIRRORED = {
    "hex8": (4, 5, 6, 7, 0, 1, 2, 3),
    "wedge6": (3, 4, 5, 0, 1, 2),
    "pyramid5": (0, 3, 2, 1, 4),
    "tet4": (0, 2, 1, 3),
    "tet10": (0, 2, 1, 3, 6, 5, 4, 7, 9, 8),
}
"""The nodes of an element that a reflection has turned inside out, right side out again."""


def read_solids(deck: Deck, properties: Properties, transforms: Transforms) -> None:
    """Add all solids to the deck's groups.

    Raises
    ------
    InputError : an unknown node, part or section, an id twice, nodes that collapse to no element that creak knows.
    """
    sections: dict[int, SolidSection] = {}
    for named in deck.named("ELEMENT_SOLID"):
        for card, nodes in _solids_of(named):
            part = properties.part(card, 1)
            found = properties.section(part, "SECTION_SOLID")
            if found is None:
                continue
            if found.cards[0].integer(1) not in FORMULATIONS:
                raise found.cards[0].wrong(1, "ELFORM of a structural solid (1, 2, -1, 10, 16, ...)")
            pid = part.identifier
            if pid not in sections:
                sections[pid] = SolidSection(part.name, properties.material(part))
            kind, rows = _shape(deck, card, nodes)
            if transforms.mirrors(card.shift):
                rows = [rows[k] for k in MIRRORED[kind]]
            deck.add("solid", pid, kind, sections[pid], card.defined(0, "e"), rows, card)


def _solids_of(named: Named) -> list[tuple[Card, Card]]:
    """The card with the ids, and that with the nodes alone: of one line, or of two."""
    block = named.block
    lines = [line for line in block.lines if line.text.strip()]
    found, i = [], 0
    while i < len(lines):
        card = block.card(lines[i], EIGHTS)
        if any(card.fields[2:]):
            found.append((card, Card(card.keyword, card.fields[2:], card.where, card.shift)))
            i += 1
            continue
        if i + 1 >= len(lines):
            raise block.cut_off("the nodes of every solid, after its ids or in the next line")
        found.append((card, block.card(lines[i + 1], EIGHTS)))
        i += 2
    return found


def _shape(deck: Deck, card: Card, nodes: Card) -> tuple[str, list[int]]:
    """Kind and node rows: ten nodes are a tetrahedron; hexahedra with repeated nodes are what they collapse to."""
    given = [nodes.integer(i) for i in range(10)]
    while given and not given[-1]:
        given.pop()
    if len(given) == 10 and all(given):
        return "tet10", [deck.nodes.row(nodes, i) for i in range(10)]
    if len(given) == 4:
        given += [given[-1]] * 4
    pattern = tuple(given.index(i) for i in given)
    if pattern not in COLLAPSED or not all(given):
        raise InputError(
            f"solid element {card.text(0)} has the nodes {' '.join(map(str, given))}",
            where=nodes.where,
            expected="8 nodes; n1 n2 n3 n4 n5 n5 n6 n6 (pentahedron), n1 n2 n3 n4 n5 n5 n5 n5 (pyramid), "
            "n1 n2 n3 n4 n4 n4 n4 n4 (tetrahedron); or 10 nodes",
            fix="Correct the element.",
        )
    kind, order = COLLAPSED[pattern]
    return kind, [deck.nodes.row(nodes, k) for k in order]
