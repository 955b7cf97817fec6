"""*ELEMENT_DISCRETE and *ELEMENT_MASS -> springs, dashpots and masses."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.lsdyna.sections.materials import SPRINGS
from creak.formats.lsdyna.sections.parts import PartCard, Properties
from creak.formats.lsdyna.text.cards import Card
from creak.formats.lsdyna.text.deck import Deck, referred
from creak.model.materials import AxialSpring, NodalMatrices, PointMass

SPRING_WIDTHS = (8, 8, 8, 8, 8, 16, 8, 16)
MASS_WIDTHS = (8, 8, 16, 8)


def read_points(deck: Deck, properties: Properties, directions: dict[int, FloatArray]) -> None:
    """Add springs, dashpots and masses to the deck's groups.

    Parameters
    ----------
    directions : unit vectors of *DEFINE_SD_ORIENTATION by id.

    Raises
    ------
    InputError : an unknown node, part, material or orientation, an id twice, a spring without direction.
    """
    for named in deck.named("ELEMENT_DISCRETE"):
        for card in named.cards(SPRING_WIDTHS):
            part = properties.part(card, 1)
            found = properties.section(part, "SECTION_DISCRETE")
            if found is not None:
                _add_spring(deck, card, part, found.cards[0], properties, directions)
    masses: dict[float, PointMass] = {}
    for named in deck.named("ELEMENT_MASS"):
        for card in named.cards(MASS_WIDTHS):
            value = card.real(2)
            if value < 0.0:
                raise card.wrong(2, "a mass of zero or more")
            section = masses.setdefault(value, PointMass(f"MASS {value:g}", value))
            deck.add("mass", card.label(3, "p"), "mass", section, card.defined(0, "e"), [deck.nodes.row(card, 1)], card)


def _add_spring(
    deck: Deck,
    card: Card,
    part: PartCard,
    section: Card,
    properties: Properties,
    directions: dict[int, FloatArray],
) -> None:
    """Along the line of its nodes, or along a vector; torsional about it (DRO 1)."""
    k, c = _stiffness(part, properties)
    factor = card.real(5, 1.0) or 1.0
    k, c = factor * k, factor * c
    nodes = [deck.nodes.row(card, i) for i in ((2, 3) if card.integer(3) else (2,))]
    identifier, vector, torsional = card.defined(0, "e"), card.label(4, "d"), section.integer(1) == 1
    line = np.ptp(deck.nodes.array[nodes], axis=0)
    if not vector and not line.any():
        raise card.error(
            f"discrete element {identifier} has no direction",
            expected="two nodes that lie apart, or VID",
            fix="Give its direction by *DEFINE_SD_ORIENTATION.",
        )
    if not vector and not torsional:
        deck.add("discrete", part.identifier, "axial2", AxialSpring(part.name, k, c), identifier, nodes, card)
        return
    ends = deck.nodes.array[nodes]
    axis = (
        referred(directions, vector, card, "orientation", "*DEFINE_SD_ORIENTATION")
        if vector
        else (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    )
    g = np.zeros((len(nodes), 6))
    g[:, 3 * torsional : 3 * torsional + 3] = np.outer((1.0, -1.0)[: len(nodes)], axis)
    matrix = np.outer(g, g)
    matrices = NodalMatrices(part.name, k * matrix, 0.0 * matrix, c * matrix)
    deck.add("discrete", part.identifier, f"nodal{len(nodes)}", matrices, identifier, nodes, card)


def _stiffness(part: PartCard, properties: Properties) -> tuple[float, float]:
    """K and DC of the material of a part.

    Raises
    ------
    InputError : it is not that of springs.
    """
    law = properties.law(part)
    if law.keyword not in SPRINGS:
        raise InputError(
            f"{part.name} of discrete elements has a *{law.keyword}",
            where=part.card.where,
            expected="*MAT_SPRING_ELASTIC or *MAT_DAMPER_VISCOUS",
        )
    value = law.card.real(1)
    return (value, 0.0) if law.keyword == SPRINGS[0] else (0.0, value)
