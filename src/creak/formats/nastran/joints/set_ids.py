"""Which sets of SPC and MPC cards act."""

from __future__ import annotations

from creak.errors import InputError
from creak.formats.nastran.text.bulk_data import id_list
from creak.formats.nastran.text.deck import Deck
from creak.model.mesh import Unread

_CARDS = {"SPC": ("SPC", "SPC1"), "MPC": ("MPC",)}


def selected(deck: Deck, what: str, chosen: int) -> int:
    """The set that acts: the case control's; in a deck without case control the only one there is.

    Raises
    ------
    InputError : the case control names a set that no card has.
    """
    cards = list(deck.cards(*_CARDS[what], f"{what}ADD"))
    there = sorted({card.integer(0) for card in cards})
    if chosen and not there:
        why = f"{what} = {chosen} in the case control, but the deck has no {what} cards: nothing is held by them"
        entry = Unread(f"{what} = {chosen}", deck.case.where, False, why)
        deck.unread += [] if entry in deck.unread else [entry]
        return 0
    if chosen:
        if chosen not in there:
            raise InputError(
                f"{what} = {chosen} in the case control, but no card has this set",
                where=deck.case.where,
                expected=f"one of {there}",
            )
        return chosen
    if not there:
        return 0
    alone = sorted({card.integer(0) for card in deck.cards(*_CARDS[what])})
    if not deck.case.given and len(alone) == 1:
        deck.note(cards[0], f"the deck has no case control: its only {what} set {alone[0]} is taken", changes=False)
        return alone[0]
    why = f"the case control takes no {what} set (there are {', '.join(map(str, there))})"
    deck.note(cards[0], why, changes=not deck.case.given)
    return 0


def combined(deck: Deck, adding: str, chosen: int) -> set[int]:
    """The set itself and those that SPCADD or MPCADD put together."""
    found, left = set(), [chosen]
    while left:
        one = left.pop()
        if one in found:
            continue
        found.add(one)
        for card in deck.cards(adding):
            if card.integer(0) == one:
                left += list(id_list(card, 1))
    return found - {0}
