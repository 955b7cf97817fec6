"""*DAMPING_GLOBAL, *DAMPING_PART_MASS, *DAMPING_PART_STIFFNESS -> alpha and beta of materials and masses."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from functools import partial

from creak.formats.lsdyna.mesh.sets import Sets
from creak.formats.lsdyna.text.deck import Block, Card, Deck, Named
from creak.model.materials import (
    BeamSection,
    PointMass,
    Section,
    ShellSection,
    SolidSection,
    TrussSection,
    has_stiffness,
)

POINT_WIDTHS = (20, 20)
"""Abscissa and ordinate of *DEFINE_CURVE."""
DAMPED = (ShellSection, SolidSection, BeamSection, TrussSection)
"""Sections that have a material."""
Record = tuple[Card, float | None]
"""The card that names a part or part set, and its number; None: it is no such number, which was listed."""


def read_damping(deck: Deck, sets: Sets, parts: Collection[int]) -> list[Block]:
    """Give all materials and masses of the deck's groups their alpha (1/s) and beta (s): C = alpha M + beta K.

    alpha is VALDMP of *DAMPING_GLOBAL, or SF times the curve of *DAMPING_PART_MASS, for the elements of its parts;
    beta is -COEF of *DAMPING_PART_STIFFNESS where COEF is below 0. Curves have to be constant, and all directions
    damped alike. What is no such number is listed as unread.

    Parameters
    ----------
    parts : ids of the parts of the deck.

    Returns
    -------
    The *DEFINE_CURVEs that none of these uses.

    Raises
    ------
    InputError : a damping below 0, a second line that is missing.
    """
    used: set[int] = set()
    everywhere = _of_all(deck, used)
    alphas = _by_part(deck, sets, parts, "DAMPING_PART_MASS", partial(_masses, used=used))
    betas = _by_part(deck, sets, parts, "DAMPING_PART_STIFFNESS", _stiffnesses)
    if everywhere and any(alpha != everywhere for alpha in alphas.values()):
        where = next(deck.named("DAMPING_PART_MASS")).block.where
        _leave(deck, where, "DAMPING_PART_MASS", "creak takes *DAMPING_GLOBAL alone where the deck has both")
    made: dict[tuple[Section, float, float], Section] = {}
    for (_, pid, *_), group in deck.groups.items():
        assert isinstance(pid, int)
        key = group.section, everywhere or alphas.get(pid, 0.0), betas.get(pid, 0.0)
        if key not in made:
            made[key] = _damped(*key)
        if key[2] and not isinstance(group.section, DAMPED) and has_stiffness(group.section):
            where = next(deck.named("DAMPING_PART_STIFFNESS")).block.where
            _leave(deck, where, "DAMPING_PART_STIFFNESS", f"creak gives none to the discrete elements of part {pid}")
        group.section = made[key]
    return [named.block for named in deck.named("DEFINE_CURVE") if id(named.block) not in used]


def _damped(section: Section, alpha: float, beta: float) -> Section:
    if isinstance(section, PointMass):
        return replace(section, alpha=alpha)
    if not isinstance(section, DAMPED) or not (alpha or beta):
        return section
    material = replace(section.material, alpha=alpha, beta=beta)
    return replace(section, material=material)  # type: ignore[arg-type]


def _leave(deck: Deck, where: str, keyword: str, why: str) -> None:
    deck.note(where, f"*{keyword}", f"{why}; [damping] in a study stands in its place", changes=True, damps=True)


def _of_all(deck: Deck, used: set[int]) -> float:
    """LCID, VALDMP, then factors of the directions, of which none is that all are 1."""
    found: list[float] = []
    for named in deck.named("DAMPING_GLOBAL"):
        for card in named.cards()[:1]:
            value = _constant(deck, card, 0, used) if card.integer(0) else card.real(1)
            factors = [card.real(i) for i in range(2, 8)]
            value = _alike(deck, card, value, factors if any(factors) else [1.0])
            if value is not None:
                found.append(_positive(card, 1, value))
    if len(set(found)) > 1:
        where = next(deck.named("DAMPING_GLOBAL")).block.where
        _leave(deck, where, "DAMPING_GLOBAL", "it is there more than once, with other numbers")
        return 0.0
    return found[0] if found else 0.0


def _masses(deck: Deck, named: Named, used: set[int]) -> Iterator[Record]:
    """PID or PSID, LCID, SF, FLAG; with FLAG 1 a line of factors of the directions."""
    cards = [named.block.card(line) for line in named.block.filled]
    i = 0
    while i < len(named.block.lines):
        card, factors = cards[i], [1.0]
        if card.integer(3):
            i += 1
            if i >= len(cards):
                raise named.block.cut_off("a line of STX, STY, STZ, SRX, SRY, SRZ after one with FLAG 1")
            factors = [cards[i].real(k) for k in range(6)]
        i += 1
        value = _constant(deck, card, 1, used)
        value = _alike(deck, card, None if value is None else (card.real(2) or 1.0) * value, factors)
        yield card, None if value is None else _positive(card, 2, value)


def _stiffnesses(deck: Deck, named: Named) -> Iterator[Record]:
    """PID or PSID, COEF."""
    for card in named.cards():
        coefficient = card.real(1)
        if coefficient > 0.0:
            why = "COEF above 0 is a share of critical damping at high frequencies, which no beta is (COEF = -beta is)"
            _leave(deck, card.where, named.block.name, why)
        yield card, None if coefficient > 0.0 else abs(coefficient)


def _by_part(
    deck: Deck,
    sets: Sets,
    parts: Collection[int],
    keyword: str,
    records: Callable[[Deck, Named], Iterator[Record]],
) -> dict[int, float]:
    """Part id -> number, of parts and part sets."""
    found: dict[int, float] = {}
    for named in deck.named(keyword):
        for card, value in records(deck, named):
            name, of_set = named.block.name, "SET" in named.options
            members = sets.parts.get(card.label(0, "s"), []) if of_set else [card.label(0, "p")]
            known = [pid for pid in members if pid in parts]
            if value is None:
                continue
            if not known:
                _leave(deck, card.where, name, f"{'part set' if of_set else 'part'} {card.text(0)} is not defined")
            for pid in known:
                if found.setdefault(pid, value) != value:
                    _leave(deck, card.where, name, f"part {pid} has it twice, with other numbers")
    return found


def _alike(deck: Deck, card: Card, value: float | None, factors: list[float]) -> float | None:
    """The number times the factor that all directions have."""
    if value is None:
        return None
    if len(set(factors)) == 1 and factors[0]:
        return value * factors[0]
    _leave(deck, card.where, card.keyword, "its directions (STX to SRZ) are not damped alike")
    return None


def _positive(card: Card, i: int, value: float) -> float:
    if value < 0.0:
        raise card.wrong(i, "a damping of zero or more")
    return value


def _constant(deck: Deck, card: Card, i: int, used: set[int]) -> float | None:
    """The ordinate of the curve in field i, where it has only one: SFO (ordinate + OFFO); adds the curve to `used`."""
    wanted = card.label(i, "f")
    for named in deck.named("DEFINE_CURVE") if wanted else ():
        head = next(iter(named.cards()), None)
        if head is None or head.label(0, "f") != wanted:
            continue
        used.add(id(named.block))
        lines = [line for line in named.lines if line.text.strip()]
        points = [named.block.card(line, POINT_WIDTHS) for line in lines[1:]]
        ordinates = {(head.real(3) or 1.0) * (p.real(1) + head.real(5)) for p in points}
        if len(ordinates) == 1:
            return ordinates.pop()
        _leave(deck, card.where, card.keyword, f"its curve {wanted} is not constant")
        return None
    why = f"its curve {wanted} is no *DEFINE_CURVE of the deck" if wanted else "it has no curve (LCID)"
    _leave(deck, card.where, card.keyword, why)
    return None
