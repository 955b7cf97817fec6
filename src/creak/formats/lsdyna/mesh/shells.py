"""*ELEMENT_SHELL with *SECTION_SHELL -> shell elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.text import Line
from creak.formats.lsdyna.mesh.nodes import Transforms
from creak.formats.lsdyna.sections.parts import PartCard, Properties
from creak.formats.lsdyna.text.deck import EIGHTS, Block, Card, Deck, Named
from creak.model.faces import N_CORNER, normals_at_nodes
from creak.model.materials import ShellSection

FORMULATIONS = {0, 1, 2, 3, 4, 6, 7, 8, 10, 11, 16, -16, 17, 18, 20, 21, 23, 24, 25, 26, 27, 98, 99}
"""ELFORM of structural shells with bending."""
OWN_WIDTHS = (16,) * 5
"""THIC1 to THIC4 and BETA, or OFFSET."""
LAYERED = {"THICKNESS", "BETA", "MCID"}
"""Options with a line of thicknesses and an angle."""
REISSNER = 5.0 / 6.0


@dataclass(frozen=True)
class _Shell:
    """One element with the lines of its options."""

    card: Card
    own: Card | None
    """Thicknesses at the corners."""
    middle: Card | None
    """Thicknesses at the middle nodes."""
    offset: float


def read_shells(deck: Deck, properties: Properties, transforms: Transforms) -> None:
    """Add all shells to the deck's groups.

    Raises
    ------
    InputError : an unknown node, part or section, an id twice, a thickness that is not positive.
    """
    sections: dict[tuple[int, float], ShellSection] = {}
    for named in deck.named("ELEMENT_SHELL"):
        for shell in _shells_of(named):
            part = properties.part(shell.card, 1)
            found = properties.section(part, "SECTION_SHELL")
            if found is None:
                continue
            _check(deck, found.cards)
            _add(deck, shell, part, found.cards, sections, properties)
            if transforms.mirrors(shell.card.shift) and (shell.offset or found.cards[1].real(4)):
                why = "mirrored shells keep the order of their nodes, and so lie on the side of their new normal"
                deck.note(shell.card.where, "*INCLUDE_TRANSFORM, MIRROR", why, changes=True)


def _shells_of(named: Named) -> list[_Shell]:
    """Elements, each on a line that those of the options follow."""
    block, options = named.block, named.options
    lines = [line for line in block.lines if line.text.strip()] if not options else list(block.filled)
    found, i = [], 0
    while i < (len(block.lines) if options else len(lines)):
        card = block.card(lines[i], EIGHTS)
        i += 1
        own = middle = None
        if options & LAYERED:
            own = _line(block, lines, i)
            i += 1
            if any(card.integer(k) for k in range(6, 10)):
                middle = _line(block, lines, i)
                i += 1
        offset = 0.0
        if "OFFSET" in options:
            offset = _line(block, lines, i).real(0)
            i += 1
        found.append(_Shell(card, own, middle, offset))
    return found


def _line(block: Block, lines: list[Line], i: int) -> Card:
    if i >= len(lines):
        raise block.cut_off("a line for each option of every element")
    return block.card(lines[i], OWN_WIDTHS)


def _check(deck: Deck, cards: tuple[Card, ...]) -> None:
    """What of a *SECTION_SHELL creak's shells cannot follow."""
    first = cards[0]
    if first.integer(1) not in FORMULATIONS:
        raise first.wrong(
            1, "ELFORM of a shell with bending (1, 2, 16, ...)", "Membranes and plane elements are not read."
        )
    if first.real(3) == 1.0:
        why = "one layer of integration points has no bending stiffness; creak's shells have it"
        deck.note(first.where, "*SECTION_SHELL, NIP=1", why, changes=True)
    if first.real(5) < 0.0:
        why = "creak does not read *INTEGRATION_SHELL: the section is of one material"
        deck.note(first.where, "*SECTION_SHELL, IRID", why, changes=True)
    shear = first.real(2)
    if shear and abs(shear - REISSNER) > 1e-2:
        why = f"creak's shells take 5/6 of the thickness in transverse shear, not {shear:g}"
        deck.note(first.where, "*SECTION_SHELL, SHRF", why, changes=False)


def _add(
    deck: Deck,
    shell: _Shell,
    part: PartCard,
    cards: tuple[Card, ...],
    sections: dict[tuple[int, float], ShellSection],
    properties: Properties,
) -> None:
    kind, nodes = _nodes(deck, shell.card)
    thickness, base = _thicknesses(shell, cards[1], kind)
    key = (part.identifier, base)
    if key not in sections:
        material, added = properties.material(part), cards[1].real(5)
        if added < 0.0:
            raise cards[1].wrong(5, "MAREA, a mass per area of zero or more")
        sections[key] = ShellSection(part.name, material, base, added)
    own: dict[str, FloatArray] = {}
    if not (thickness == base).all():
        own["thickness"] = thickness / base
    height = shell.offset - 0.5 * cards[1].real(4) * float(thickness[: N_CORNER[kind]].mean())
    if height:
        rows = np.arange(len(nodes))[None]
        own["arms"] = height * normals_at_nodes(kind, rows, deck.nodes.array[nodes])[0]
    deck.add("shell", part.identifier, kind, sections[key], shell.card.defined(0, "e"), nodes, shell.card, **own)


def _nodes(deck: Deck, card: Card) -> tuple[str, list[int]]:
    """Kind and node rows: a triangle repeats its third node or leaves the fourth blank."""
    given = [card.integer(i) for i in range(2, 10)]
    if any(given[4:]):
        if not all(given):
            raise card.error(
                f"shell element {card.text(0)} has some middle nodes and not all",
                expected="3, 4 or 8 nodes",
                fix="Export the mesh in first order.",
            )
        return "quad8", [deck.nodes.row(card, i) for i in range(2, 10)]
    n = 3 if given[3] in (0, given[2]) else 4
    return {3: "tri3", 4: "quad4"}[n], [deck.nodes.row(card, i) for i in range(2, 2 + n)]


def _thicknesses(shell: _Shell, section: Card, kind: str) -> tuple[FloatArray, float]:
    """At the nodes, and that of the section: T1, or the mean where it gives none.

    Raises
    ------
    InputError : neither the element nor the section has it.
    """
    n = N_CORNER[kind]
    of_section = [section.real(i) or section.real(0) for i in range(n)]
    own, middle = shell.own, shell.middle
    t = np.array([(own.real(i) if own else 0.0) or of_section[i] for i in range(n)])
    if kind == "quad8":
        between = 0.5 * (t + np.roll(t, -1))
        t = np.append(t, [(middle.real(i) if own and middle else 0.0) or between[i] for i in range(n)])
    if not (t > 0.0).all():
        raise InputError(
            f"shell element {shell.card.text(0)} has thickness {t.min():g}",
            where=shell.card.where,
            expected="T1 of its *SECTION_SHELL, or THIC1 to THIC4, above 0",
        )
    return t, section.real(0) or float(t.mean())
