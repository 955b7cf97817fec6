"""Pairs of regions that are glued or touch: BGSET and BCTSET of NX, BCTABLE and BCTABL1 of MSC, TIE and CONTACT of
OptiStruct."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

from creak.errors import InputError
from creak.formats.deck.refusals import noted, referred
from creak.formats.nastran.mesh.sets import region_name
from creak.formats.nastran.text.bulk_data import Card, id_list
from creak.formats.nastran.text.deck import Deck, unique_cards
from creak.model.steps import DeckContact, Interaction, SurfacePair

SEARCH = 10.0
"""Default of SDIST."""
WITH_MOMENTS = {3, 4, -3, -4}
"""IGLUE that carries moments; BGSET does as well."""
_OF_BODIES = ("BCTABLE", "BCONECT")
_FIRST, _SECOND = ("SECN", "SLAV"), ("PRIM", "MAST")
"""How words of MSC begin, new and old ones."""


@dataclass(frozen=True)
class RegionPair:
    """Two regions: the body of MSC, the surface of NX and OptiStruct."""

    card: Card
    first: int
    second: int
    glued: bool
    reach: float | None = None
    """Of glue, the largest distance; None: 5 % of the mean edge length."""
    rotations: bool = False
    follows: bool = False
    """Whether the first region follows the second; else the one with more nodes in reach follows the other."""
    friction: tuple[Card, int] | None = None
    """The field that has it; None: there is none of the pair."""
    clearance: tuple[Card, int] | None = None

    @property
    def name(self) -> str:
        return f"{self.card.name} {self.card.text(0)}"

    def rubs(self, deck: Deck) -> list[tuple[Card, int]]:
        """The fields of which the mean is the coefficient of friction: its own, or those of both bodies."""
        if self.friction is not None or self.card.name not in _OF_BODIES:
            return [] if self.friction is None else [self.friction]
        of_bodies = unique_cards(deck.cards("BCBDPRP"), "BCBDPRP")
        found = []
        for body in (self._body(deck, i) for i in (self.first, self.second)):
            card = body if body.name == "BCBODY" else of_bodies.get(body.integer(1, 0), body)
            found.append((card, 5 if card.name == "BCBODY" else values(card).get("FRIC", len(card.fields))))
        return found

    def _body(self, deck: Deck, identifier: int) -> Card:
        bodies = unique_cards(deck.cards("BCBODY", "BCBODY1"), "contact body")
        return referred(bodies, identifier, self.card, "contact body", "BCBODY or BCBODY1")

    def surface(self, deck: Deck, identifier: int) -> int:
        """The region's number that its surface has: that of the body's.

        Raises
        ------
        InputError : there is no such body, or it is rigid.
        """
        if self.card.name not in _OF_BODIES:
            return identifier
        body = self._body(deck, identifier)
        at = 1 if body.name == "BCBODY" else 2
        if body.text(at + 1).upper()[:5] not in ("", "DEFOR"):
            raise InputError(
                f"{self.name} uses body {identifier}, which is {body.text(at + 1)}",
                where=body.where,
                expected="a deformable body",
                fix="Hold the grids with SPC1 instead, or take the pair out.",
            )
        return body.integer(at + 2)


def glued_pairs(deck: Deck) -> Iterator[RegionPair]:
    """Those that the case control takes (BGSET, BCONTACT), or those of the only set of a deck without."""
    sets = _with_added(deck, {_chosen(deck, deck.case.glue, ("BGSET", "BGADD"))}, "BGADD")
    yield from (p for p in _of_sets(deck, "BGSET") if p.card.integer(0) in sets)
    yield from (p for p in _optistruct(deck) if p.glued)
    yield from _of_msc(deck, {_chosen(deck, deck.case.contact, ("BCTABLE", "BCTABL1"))}, glued=True)


def touching_pairs(deck: Deck) -> Iterator[RegionPair]:
    """Those of the contact sets that the case control takes (BCSET, BCONTACT), or of all where it names none."""
    wanted = deck.case.contact_set
    sets = _with_added(deck, {int(wanted)}, "BCTADD") if wanted.isdigit() else None
    yield from (p for p in _of_sets(deck, "BCTSET") if sets is None or p.card.integer(0) in sets)
    yield from (p for p in _optistruct(deck) if not p.glued)
    yield from _of_msc(deck, {0, int(deck.case.contact)} if deck.case.contact.isdigit() else None, glued=False)


def values(card: Card) -> dict[str, int]:
    """Word -> number of the field behind it, of cards of words and values."""
    return {text.upper(): i + 1 for i, text in enumerate(card.fields) if text[:1].isalpha()}


def _chosen(deck: Deck, command: str, names: tuple[str, ...]) -> int:
    """The set that the case control takes; in a deck without case control the only one; -1: none."""
    there = sorted({card.integer(0) for card in deck.cards(*names)})
    if command.isdigit():
        return int(command)
    return there[0] if not deck.case.given and len(there) == 1 else -1


def _with_added(deck: Deck, sets: set[int], name: str) -> set[int]:
    """Sets with those that cards of sums (BGADD, BCTADD) add to them."""
    left, done = list(sets), set[int]()
    while left:
        done.add(left[-1])
        more = [i for card in deck.cards(name) if card.integer(0) == left[-1] for i in id_list(card, 1)]
        left = [i for i in (*left[:-1], *more) if i not in done]
    return done


def _of_sets(deck: Deck, name: str) -> Iterator[RegionPair]:
    glued = name == "BGSET"
    for card in deck.cards(name):
        for i in range(1, len(card.fields), 8):
            if card.text(i) or card.text(i + 1):
                pair = RegionPair(card, card.integer(i), card.integer(i + 1), glued, rotations=glued)
                yield replace(pair, reach=card.real(i + 2, SEARCH)) if glued else replace(pair, friction=(card, i + 2))


def _optistruct(deck: Deck) -> Iterator[RegionPair]:
    """TIE and CONTACT: the secondary side stands first; it follows, in translations unless DOF of TIE has more."""
    for card in deck.cards("TIE"):
        moments = bool({4, 5, 6} & set(card.components(4, "123")))
        reach = card.real(5, 0.0) or None
        yield RegionPair(card, card.integer(2), card.integer(3), True, reach, moments, follows=True)
    properties = unique_cards(deck.cards("PCONT"), "PCONT")
    for card in deck.cards("CONTACT"):
        if card.text(1).upper() == "AUTO":
            deck.note(card, "contact of all that is near, which `creak new` looks for by itself", changes=False)
            continue
        pair = RegionPair(card, card.integer(2), card.integer(3), card.text(1).upper() == "FREEZE")
        if pair.glued:
            yield replace(pair, reach=card.real(5, 0.0) or None, follows=True)
            continue
        law = properties.get(card.integer(1)) if card.is_integer(1) else None
        own = (card, 1) if card.text(1).upper() not in ("", "SLIDE") and law is None else None
        gap = (card, 7) if card.text(7) else (law, 5) if law is not None and law.text(5) else None
        yield replace(pair, friction=own if law is None else (law, 3), clearance=gap)


def _of_msc(deck: Deck, chosen: set[int] | None, *, glued: bool) -> Iterator[RegionPair]:
    """BCTABLE, and BCTABL1 or BCONECT, of some numbers; None: of all."""
    for card in deck.cards("BCTABLE"):
        if chosen is None or card.integer(0) in chosen:
            yield from (p for p in _of_table(card) if p.glued is glued)
    geometry, physics = (unique_cards(deck.cards(name), name) for name in ("BCONPRG", "BCONPRP"))
    connections = unique_cards(deck.cards("BCONECT"), "BCONECT")
    tables = [c for c in deck.cards("BCTABL1") if chosen is None or c.integer(0) in chosen]
    for card in tables:
        for i in id_list(card, 1):
            connection = referred(connections, i, card, "contact pair", "BCONECT")
            # IGLUE and ERROR of the BCONPRG, FRIC of the BCONPRP that a BCONECT names.
            form, law = geometry.get(connection.integer(1, 0)), physics.get(connection.integer(2, 0))
            at = values(form) if form is not None else {}
            flag = form.integer(at["IGLUE"], 0) if form is not None and "IGLUE" in at else 0
            reach = form.real(at["ERROR"], 0.0) if form is not None and "ERROR" in at else 0.0
            friction = (law, values(law)["FRIC"]) if law is not None and "FRIC" in values(law) else None
            pair = RegionPair(connection, 0, 0, bool(flag), reach or None, flag in WITH_MOMENTS, friction=friction)
            if pair.glued is glued:
                for first in _bodies(connection, 3, _FIRST):
                    yield from (replace(pair, first=first, second=b) for b in _bodies(connection, 4, _SECOND))


def _of_table(card: Card) -> Iterator[RegionPair]:
    """SECNDRY (SLAVE) lines, each with the bodies of its PRIMARY (MASTERS) lines."""
    pair, primary = RegionPair(card, 0, 0, False), False
    for at in range(8, len(card.fields), 8):
        word = card.text(at).upper()[:4]
        if word in _FIRST:
            flag = card.integer(at + 6, 0)
            friction = (card, at + 4) if card.text(at + 4) else None
            pair = RegionPair(card, card.integer(at + 1), 0, bool(flag), friction=friction)
            pair = replace(pair, reach=card.real(at + 2, 0.0) or None, rotations=flag in WITH_MOMENTS)
        primary = word in _SECOND or (primary and not word)
        for i in range(at + 1, at + 8) if pair.first and primary else ():
            if card.text(i):
                yield replace(pair, second=card.integer(i))


def _bodies(card: Card, field: int, words: tuple[str, ...]) -> list[int]:
    """IDs of one side of a BCONECT: a field of its own, or a list after a word."""
    if card.text(field):
        return [card.integer(field)]
    found: list[int] = []
    inside = False
    for at in range(8, len(card.fields), 8):
        if card.text(at):
            inside = card.text(at).upper()[:4] in words
        found += [card.integer(i) for i in range(at + 1, at + 8) if inside and card.text(i)]
    return found


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
