"""*CONTACT_AUTOMATIC_... and its kin -> what a deck says of contact, for a study that is proposed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError
from creak.formats.deck.refusals import noted, referred
from creak.formats.lsdyna.mesh.sets import Sets
from creak.formats.lsdyna.sections.parts import Properties
from creak.formats.lsdyna.text.cards import Card
from creak.formats.lsdyna.text.deck import Deck, Named
from creak.formats.lsdyna.text.keywords import CONTACT_PAIRS, GENERAL_CONTACT
from creak.model.mesh import ElementBlock, Surface
from creak.model.shell_facets import SHELL_FACETS
from creak.model.steps import DeckContact, Interaction, SurfacePair

SIDES = {0: "SET_SEGMENT", 1: "SET_SHELL", 2: "SET_PART", 3: "PART", 4: "SET_NODE"}
"""What a side is by its type; a name of the model with its id."""
ALL = 5
"""The type of everything that the deck has."""
_OWN = "its stiffness, damping and search are creak's own"


def described_contact(
    deck: Deck, properties: Properties, sets: Sets, blocks: Sequence[ElementBlock], surfaces: Mapping[str, Surface]
) -> tuple[DeckContact | None, dict[str, Surface]]:
    """Pairs of surfaces that touch and contact of all parts, with their friction; and the surfaces that they need: of
    nodes, and (SET_SEGMENT_<id>.BOTH) both sides of segments that are shells, which automatic contact looks at.

    mu(v) = FD + (FS - FD) exp(-DC v). What is wrong with a contact, or not followed, stops nothing, but is told as a
    flaw.

    Parameters
    ----------
    surfaces : the model's.
    """
    pairs, laws = dict[tuple[str, str], SurfacePair](), dict[str, Interaction]()
    flaws, added, everywhere = list[str](), dict[str, Surface](), ""
    for named in deck.named(*CONTACT_PAIRS):
        with noted(flaws):
            cards = _cards(named)
            law = _law(cards, flaws)
            kinds = _kinds(cards[0], named)
            if not cards[0].integer(1) or ALL in kinds:
                everywhere = _all(named, cards[0], law, everywhere, flaws)
            else:
                sides = [_side(named, cards[0], i, kinds[i], surfaces, sets) for i in (0, 1)]
                if kinds[0] == 4:
                    rows = np.array(sets.nodes[cards[0].label(0, "s")], dtype=np.int64)
                    added[sides[0]] = _of_nodes(sides[0], rows, cards[0].where)
                    flaws += _thin(named, cards[0], rows, blocks)
                both = {name: found for name in sides if (found := _both_sides(named, name, blocks, surfaces))}
                added |= {found.name: found for found in both.values()}
                first, second = (both[name].name if name in both else name for name in sides)
                method = "node-to-surface" if "NODES" in named.block.name else "surface-to-surface"
                pairs[first, second] = SurfacePair(first, second, law.name, method, False, where=cards[0].where)
            laws[law.name] = law
            flaws += _unfollowed(named, cards)
            _note(deck, named)
    for named in deck.named(*GENERAL_CONTACT):
        with noted(flaws):
            cards = _cards(named)
            law = _law(cards, flaws)
            everywhere = _all(named, cards[0], law, everywhere, flaws)
            laws[law.name] = law
            flaws += [*_some_parts(named, cards[0], properties, sets), *_unfollowed(named, cards)]
            _note(deck, named)
    if not (pairs or everywhere or flaws):
        return None, {}
    return DeckContact(laws, tuple(pairs.values()), everywhere, tuple(flaws)), added


def _note(deck: Deck, named: Named) -> None:
    why = f"friction and sides are for `creak new`, {_OWN}; a run has the contact of its study"
    deck.note(named.block.where, f"*{named.block.name}", why, changes=False, used=True)


def _cards(named: Named) -> list[Card]:
    """The two sides, then friction, then thicknesses; blank lines are cards of defaults."""
    skip = int(bool(named.options & {"ID", "TITLE"}))
    if "MPP" in named.options:
        skip += 1 + any(line.text.startswith("&") for line in named.block.lines[skip + 1 : skip + 2])
    cards = [named.block.card(line) for line in named.block.filled[skip : skip + 3]]
    if not cards:
        raise named.block.cut_off("the two sides, friction, thicknesses")
    return cards


def _kinds(card: Card, named: Named) -> tuple[int, int]:
    return card.integer(2, 4 if "NODES" in named.block.name else 0), card.integer(3, 0)


def _side(named: Named, card: Card, i: int, kind: int, surfaces: Mapping[str, Surface], sets: Sets) -> str:
    if kind not in SIDES:
        raise card.wrong(i + 2, ", ".join(f"{k} (*{what})" for k, what in SIDES.items()))
    name = f"{SIDES[kind]}_{card.label(i, 'p' if kind == 3 else 's')}"
    if kind == 4 and i == 0:
        referred(sets.nodes, card.label(i, "s"), card, "node set", "*SET_NODE")
        return name
    if name not in surfaces:
        raise InputError(
            f"*{named.block.name} uses {name}, which has no shells or solids",
            where=card.where,
            expected="a part or set of elements that creak reads",
            fix="Correct its id, or the type of the side.",
        )
    return name


def _of_nodes(name: str, rows: IntArray, where: str) -> Surface:
    none = np.zeros((0, 2), dtype=np.int64)
    return Surface(name, none, none[:, 0], np.unique(rows), where)


def _thin(named: Named, card: Card, rows: IntArray, blocks: Sequence[ElementBlock]) -> Iterator[str]:
    """A sentence where nodes of shells are one side of automatic contact, which takes half their thickness off."""
    of_shells = any(np.isin(rows, b.nodes_idx).any() for b in blocks if b.kind in SHELL_FACETS)
    if "AUTOMATIC" in named.block.name and of_shells:
        yield (
            f"*{named.block.name} ({card.where}): nodes of SET_NODE_{card.text(0)} have no thickness in the study, "
            "where LS-DYNA takes half that of their shells off the gap; name their part or segments as secondary, or "
            "give the clearance"
        )


def _both_sides(
    named: Named, name: str, blocks: Sequence[ElementBlock], surfaces: Mapping[str, Surface]
) -> Surface | None:
    """Segments that are shells, seen from both sides; None where nothing changes by that."""
    surface = surfaces.get(name) if name.startswith("SET_SEGMENT_") and "AUTOMATIC" in named.block.name else None
    if surface is None:
        return None
    shells = np.array([blocks[b].kind in SHELL_FACETS for b in surface.facets[:, 0].tolist()], dtype=bool)
    return replace(surface, name=f"{name}.BOTH", side=np.where(shells, 0, surface.side)) if shells.any() else None


def _law(cards: list[Card], flaws: list[str]) -> Interaction:
    static, kinetic, decay = (cards[1].real(i) for i in range(3)) if len(cards) > 1 else (0.0, 0.0, 0.0)
    where = cards[0].where
    if static < 0.0 or kinetic < 0.0:
        flaws.append(f"{where}: FS = {static:g}, friction by part or table; it is 0 in the study")
        static = kinetic = 0.0
    elif kinetic > static and decay:
        flaws.append(
            f"{where}: friction that grows from FS = {static:g} to FD = {kinetic:g} as it slides; creak's falls: it is "
            f"{static:g} at any speed in the study"
        )
        decay = 0.0
    if not decay or kinetic == static:
        kinetic, decay = static, 0.0
    speed = float(f"{1.0 / decay:.6g}") if decay else 0.0
    name = f"friction {static:g} {kinetic:g} {decay:g}"
    return Interaction(name, friction=(static, kinetic, speed), where=where)


def _all(named: Named, card: Card, law: Interaction, before: str, flaws: list[str]) -> str:
    if before and before != law.name:
        flaws.append(f"*{named.block.name} ({card.where}) has other friction than a general contact before it")
        return before
    return law.name


def _some_parts(named: Named, card: Card, properties: Properties, sets: Sets) -> Iterator[str]:
    """A sentence where a general contact is one of some parts."""
    kind, identifier = card.integer(2, 0), card.integer(0)
    mine = set(sets.parts.get(card.label(0, "s"), [])) if kind == 2 else set[int]()
    if identifier and kind != ALL and not mine >= set(properties.parts):
        yield (
            f"*{named.block.name} ({card.where}) is one of some parts; its friction is that of all that is near in the "
            "study"
        )


def _unfollowed(named: Named, cards: list[Card]) -> Iterator[str]:
    """Boxes and other thicknesses than those of the shells, a sentence each."""
    where = f"*{named.block.name} ({cards[0].where})"
    if cards[0].integer(4) or cards[0].integer(5):
        yield f"{where} acts in a box; the study has it wherever the surfaces are near"
    if len(cards) > 2:
        fields = (("SST", 2, 0.0), ("MST", 3, 0.0), ("SFST", 4, 1.0), ("SFMT", 5, 1.0))
        other = [f"{name} = {x:g}" for name, i, usual in fields if (x := cards[2].real(i, usual)) not in (usual, 0.0)]
        if other:
            yield f"{where} has thicknesses of its own, {', '.join(other)}; gaps of the study are those of the shells"
