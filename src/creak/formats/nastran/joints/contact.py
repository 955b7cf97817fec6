"""What a deck says of contact, for a study that is proposed: pairs of regions with friction and clearance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator

from creak.errors import InputError
from creak.formats.deck.refusals import noted
from creak.formats.nastran.joints.region_pairs import RegionPair, touching_pairs, values
from creak.formats.nastran.mesh.sets import region_name
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck
from creak.model.steps import DeckContact, Interaction, SurfacePair

CARDS = {
    *("BCTSET", "BCTADD", "BCTPARM", "BCTPARA", "BCRPARA", "BSURF", "BSURFS", "BCPROP", "BCPROPS", "PCONT"),
    *("BCTABLE", "BCTABL1", "BCONECT", "BCONPRG", "BCONPRP", "BCBODY", "BCBODY1", "BCBDPRP"),
}
"""Read where a deck has contact pairs."""
SURFACES_MEET = "3"
"""INIPENE: gaps and penetrations count as none, or as GAPVAL."""
SIDES = {"TOP": ".SPOS", "BOT": ".SNEG", "BOTTOM": ".SNEG"}
UNUSED_REACH = "; MIND and MAXD are not used"
UNUSED = {
    "BCTPARM": "stiffness, tolerances, search and thickness",
    "BCTPARA": "stiffness, tolerances, search and thickness",
    "BCONPRG": "tolerances, search and interference",
    "BCONPRP": "limits and heat",
    "BCBDPRP": "limits and heat",
    "PCONT": "stiffness and padding (half of shells, whatever GPAD says)",
}


def described_contact(deck: Deck, surfaces: Collection[str]) -> DeckContact | None:
    """Pairs of surfaces that touch; what is wrong with them stops nothing, but is told as a flaw.

    Parameters
    ----------
    surfaces : names of the model's.
    """
    found, laws, flaws = dict[tuple[str, str], SurfacePair](), dict[str, Interaction](), list[str]()
    sides = {card.integer(0): SIDES.get(card.text(1).upper(), "") for card in deck.cards("BCRPARA")}
    counts = Counter[Card]()
    with noted(flaws):
        for pair in touching_pairs(deck):
            with noted(flaws):
                first, second = (_surface(deck, pair, i, sides, surfaces) for i in (pair.first, pair.second))
                static, kinetic = _friction(deck, pair, flaws)
                law, where = f"friction {static:g} {kinetic:g}", pair.card.where
                laws[law] = Interaction(law, friction=(static, kinetic, 0.0), where=where)
                gap = _clearance(deck, pair)
                found[first, second] = SurfacePair(first, second, law, "surface-to-surface", False, gap, where)
                counts[pair.card] += 1
    for card, count in counts.items():
        far = card.name == "BCTSET" and any(card.text(i) for k in (4, 5) for i in range(k, len(card.fields), 8))
        why = f"{count} contact pair(s) for `creak new`; a run has those of its study{UNUSED_REACH if far else ''}"
        deck.note(card, why, changes=False, what=card.title, used=True)
    flaws += _unfollowed(deck) if found else []
    return DeckContact(laws, tuple(found.values()), flaws=tuple(flaws)) if found or flaws else None


def _surface(deck: Deck, pair: RegionPair, identifier: int, sides: dict[int, str], surfaces: Collection[str]) -> str:
    number = pair.surface(deck, identifier)
    name = next((n for n in (region_name(deck, number), f"SURF_{number}", f"SET_{number}") if n in surfaces), "")
    if not name:
        raise InputError(
            f"{pair.name} uses region {number}, which has no shells or solids",
            where=pair.card.where,
            expected="BSURF, BSURFS, BCPROP, BCPROPS or SURF with elements that creak reads",
        )
    side = name + sides.get(number, "")
    return side if side in surfaces else name


def _friction(deck: Deck, pair: RegionPair, flaws: list[str]) -> tuple[float, float]:
    """Static and kinetic coefficient: of the pair, or the mean of both bodies."""
    found = []
    for card, i in pair.rubs(deck):
        if card.is_integer(i) or card.text(i)[:1].isalpha():
            with noted(flaws):
                raise card.wrong(i, "a coefficient of friction; it is 0 in the study")
            return 0.0, 0.0
        static = card.real(i, 0.0)
        kinetic = card.real(i + 1, static) if card.name == "PCONT" else static
        if not 0.0 <= kinetic <= static:
            raise card.wrong(i, "a coefficient of friction, and a kinetic one that is not above it")
        found.append((static, kinetic))
    static, kinetic = (sum(of) / max(len(found), 1) for of in zip((0.0, 0.0), *found, strict=True))
    return float(f"{static:.6g}"), float(f"{kinetic:.6g}")


def _clearance(deck: Deck, pair: RegionPair) -> float | None:
    """Instead of the drawn gap."""
    if pair.clearance is not None:
        card, i = pair.clearance
        return card.real(i)
    for card in deck.cards("BCTPARM", "BCTPARA") if pair.card.name == "BCTSET" else ():
        at = values(card)
        if card.integer(0) == pair.card.integer(0) and card.text(at.get("INIPENE", 0)) == SURFACES_MEET:
            return card.real(at["GAPVAL"]) if "GAPVAL" in at else 0.0
    return None


def _unfollowed(deck: Deck) -> Iterator[str]:
    """Offsets and rigid regions, a sentence each; other parameters are listed with the deck's cards."""
    for card in deck.cards("BCRPARA"):
        if card.text(2) and card.real(2):
            said = f"BCRPARA {card.text(0)} ({card.where}): OFFSET {card.text(2)}"
            yield f"{said}; give the drawn gap less the offset as clearance"
        if card.text(3).upper() == "RIGID":
            yield f"BCRPARA {card.text(0)} ({card.where}): RIGID; creak's surfaces are as stiff as their elements"
    for name, what in UNUSED.items():
        for card in deck.cards(name):
            words = [w for w in values(card) if w not in ("INIPENE", "GAPVAL", "IGLUE", "ERROR", "FRIC")]
            if name == "PCONT":
                words = [w for w, i in {"GPAD": 1, "STIFF": 2, "SEPARATION": 6}.items() if card.text(i)]
            if words:
                deck.note(card, f"{what} of contact are creak's own ({', '.join(words)})", changes=False)
