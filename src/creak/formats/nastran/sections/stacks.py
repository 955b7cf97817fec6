"""PCOMPP with STACK and PLY of OptiStruct: laminates made of plies that each lie on sets of elements."""

from __future__ import annotations

from collections.abc import Collection

from creak.errors import InputError
from creak.formats.nastran.mesh.optistruct import ROW, bulk_sets
from creak.formats.nastran.text.bulk_data import Card, ids_among
from creak.formats.nastran.text.deck import Deck

Layers = tuple[Card, ...]
"""A STACK and then its PLYs that lie on an element, from the bottom up."""


def layers_of(deck: Deck, elements: Collection[int]) -> dict[int, Layers]:
    """The layers of each of these elements; those that no ply lies on are not there.

    Raises
    ------
    InputError : a ply that is not defined, or draped, or on a set that is not there; a stack of substacks; an element
        in two stacks.
    """
    plies = {card.text(0): card for card in deck.cards("PLY")}
    sets, wanted = bulk_sets(deck, "ELEM"), dict.fromkeys(elements)
    found: dict[int, Layers] = {}
    for stack in deck.cards("STACK"):
        here: dict[int, Layers] = {}
        for i, name in enumerate(stack.fields[2:], start=2):
            if name:
                ply = _ply(stack, i, plies)
                for element in ids_among([ids for s in _sets_of(ply, sets) for ids in sets[s]], wanted):
                    here[element] = (*here.get(element, (stack,)), ply)
        twice = found.keys() & here.keys()
        if twice:
            raise InputError(
                f"element {min(twice)} lies in two stacks, {found[min(twice)][0].text(0)} and {stack.text(0)}",
                where=stack.where,
                expected="one STACK for an element",
                fix="Take its plies out of one of them.",
            )
        found.update(here)
    return found


def as_pcomp(owner: Card, element: Card, layers: Layers) -> Card:
    """The PCOMPP of an element as the PCOMP that it stands for: LAM of the stack, MID, T and THETA of the plies.

    Raises
    ------
    InputError : no ply lies on the element.
    """
    if not layers:
        raise InputError(
            f"no PLY of a STACK lies on {element.name} {element.text(0)}, whose property is PCOMPP {owner.text(0)}",
            where=element.where,
            expected="PLYs on sets (SET, TYPE ELEM) that hold it, in a STACK",
            fix="Add it to a set, or give it a PCOMP.",
        )
    stack, *plies = layers
    head = [*owner.fields[:7], *[""] * 7][:7]
    rows = [text for ply in plies for text in (ply.text(1), ply.text(2), ply.text(3), "")]
    return Card(owner.name, (*head, stack.text(1), *rows), owner.where)


def _ply(stack: Card, i: int, plies: dict[str, Card]) -> Card:
    name = stack.text(i)
    if name.upper() in ("SUB", "INT"):
        raise InputError(
            f"STACK {stack.text(0)} has substacks ({name.upper()})",
            where=stack.place(i),
            expected="one row of plies from the bottom up",
            fix="Have the preprocessor write PCOMP or PCOMPG cards (realize the laminate by zones).",
        )
    if name not in plies:
        raise stack.wrong(i, "the number of a PLY that there is")
    if plies[name].text(6):
        raise InputError(
            f"PLY {name} is draped (DRAPE {plies[name].text(6)}): its thickness and angle vary from element to element",
            where=plies[name].where,
            expected="a ply of one thickness and angle",
            fix="Have the preprocessor write PCOMP or PCOMPG cards (realize the laminate by zones).",
        )
    return plies[name]


def _sets_of(ply: Card, sets: dict[int, list[range]]) -> list[int]:
    """Numbers of the element sets that a ply lies on."""
    fields = [i for i in range(ROW, len(ply.fields)) if ply.text(i)]
    for i in fields:
        if ply.integer(i) not in sets:
            raise ply.wrong(i, "a SET of TYPE ELEM and SUBTYPE LIST", "Add the set.")
    return [ply.integer(i) for i in fields]
