"""*ELEMENT_DISCRETE and *ELEMENT_MASS -> springs, dashpots and masses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.refusals import referred
from creak.formats.deck.stops import Gap, in_a_study, stops_of
from creak.formats.lsdyna.sections.parts import SPRINGS, PartCard, Properties
from creak.formats.lsdyna.text.deck import Card, Deck
from creak.model.materials import AxialSpring, NodalMatrices, PointMass
from creak.model.steps import Stop

SPRING_WIDTHS = (8, 8, 8, 8, 8, 16, 8, 16)
MASS_WIDTHS = (8, 8, 16, 8)


LIMITS = {"KD": 2, "FD": 5}
"""Of the first line of *SECTION_DISCRETE: stiffening with speed and where it breaks."""
TRAVEL = {"CDL": 0, "TDL": 1}
"""Of the second: the largest compression and extension."""


def read_points(deck: Deck, properties: Properties, directions: dict[int, FloatArray]) -> tuple[Stop, ...]:
    """Add springs, dashpots and masses to the deck's groups; springs with a clearance (CL) are stops instead.

    Such a spring acts in compression alone: (u_2 - u_1) . n stays above -CL, then K pushes back. Each group is listed
    with what a study must say of it.

    Parameters
    ----------
    directions : unit vectors of *DEFINE_SD_ORIENTATION by id.

    Raises
    ------
    InputError : an unknown node, part, material or orientation, an id twice, a spring without direction.
    """
    gaps = list[Gap]()
    for named in deck.named("ELEMENT_DISCRETE"):
        for card in named.cards(SPRING_WIDTHS):
            part = properties.part(card, 1)
            found = properties.section(part, "SECTION_DISCRETE")
            if found is not None:
                _list_limits(deck, part, found.cards)
                gaps += _add_spring(deck, card, part, found.cards[0], properties, directions)
    masses: dict[float, PointMass] = {}
    for named in deck.named("ELEMENT_MASS"):
        for card in named.cards(MASS_WIDTHS):
            value = card.real(2)
            if value < 0.0:
                raise card.wrong(2, "a mass of zero or more")
            section = masses.setdefault(value, PointMass(f"MASS {value:g}", value))
            deck.add("mass", card.label(3, "p"), "mass", section, card.defined(0, "e"), [deck.nodes.row(card, 1)], card)
    stops = stops_of(gaps)
    for stop in stops:
        deck.note(stop.where, "*SECTION_DISCRETE, CL", in_a_study(stop), changes=True)
    return stops


def _list_limits(deck: Deck, part: PartCard, cards: Sequence[Card]) -> None:
    """What of a section creak's springs do not have."""
    given = [name for name, i in LIMITS.items() if cards[0].real(i)]
    given += [name for name, i in TRAVEL.items() if cards[1].real(i)]
    if given:
        why = f"the springs of {part.name} are linear without end: {', '.join(given)} of their section do nothing"
        deck.note(cards[0].where, f"*SECTION_DISCRETE, {given[0]}", why, changes=True)


def _add_spring(
    deck: Deck,
    card: Card,
    part: PartCard,
    section: Card,
    properties: Properties,
    directions: dict[int, FloatArray],
) -> list[Gap]:
    """Along the line of its nodes, or along a vector; torsional about it (DRO 1). Returns the gap where it is one."""
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
    clearance = section.real(4)
    if not vector and not torsional and not clearance:
        deck.add("discrete", part.identifier, "axial2", AxialSpring(part.name, k, c), identifier, nodes, card)
        return []
    ends = deck.nodes.array[nodes]
    axis = (
        referred(directions, vector, card, "orientation", "*DEFINE_SD_ORIENTATION")
        if vector
        else (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    )
    if clearance and k > 0.0 and len(nodes) == 2 and not torsional:
        deck.take_id("discrete", identifier, part.identifier, card)
        return [Gap(str(part.identifier), (nodes[0], nodes[1]), axis, clearance, k, card.where)]
    if clearance:
        why = "creak reads the clearance of springs between two nodes along a line; this one acts without it"
        deck.note(card.where, "*SECTION_DISCRETE, CL", why, changes=True)
    g = np.zeros((len(nodes), 6))
    g[:, 3 * torsional : 3 * torsional + 3] = np.outer((1.0, -1.0)[: len(nodes)], axis)
    matrix = np.outer(g, g)
    matrices = NodalMatrices(part.name, k * matrix, 0.0 * matrix, c * matrix)
    deck.add("discrete", part.identifier, f"nodal{len(nodes)}", matrices, identifier, nodes, card)
    return []


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
