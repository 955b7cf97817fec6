"""*MAT_ELASTIC and the elastic side of other laws -> materials."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from creak.formats.deck.text import Line
from creak.formats.lsdyna.text.cards import Block, Card
from creak.formats.lsdyna.text.deck import Deck, once
from creak.model.materials import Material

ELASTIC = {
    "MAT_ELASTIC": 1,
    "MAT_PLASTIC_KINEMATIC": 2,
    "MAT_RIGID": 3,
    "MAT_PIECEWISE_LINEAR_PLASTICITY": 4,
    "MAT_SPOTWELD": 2,
}
"""Materials that begin with MID, RO, E, PR, and their number of lines."""
SPRINGS = ("MAT_SPRING_ELASTIC", "MAT_DAMPER_VISCOUS")
"""MID and the stiffness, or the damping, of discrete elements."""
BEYOND = {
    "MAT_PLASTIC_KINEMATIC": "plasticity",
    "MAT_PIECEWISE_LINEAR_PLASTICITY": "plasticity",
    "MAT_SPOTWELD": "plasticity and failure",
}
"""What creak leaves out of a law."""


@dataclass(frozen=True)
class Law:
    """One material as the deck has it."""

    keyword: str
    card: Card
    """Its first line."""
    second: Card | None
    title: str

    @property
    def is_rigid(self) -> bool:
        return self.keyword == "MAT_RIGID"


def read_laws(deck: Deck) -> dict[int, Law]:
    """Every material that creak reads, by id.

    Raises
    ------
    InputError : an id twice, or lines that are missing.
    """
    found: dict[int, Law] = {}
    for keyword, n_lines in (*ELASTIC.items(), *((name, 1) for name in SPRINGS)):
        for named in deck.named(keyword):
            for title, lines in records(named.block, n_lines, titled=named.titled):
                cards = [named.block.card(line) for line in lines[:2]]
                identifier = cards[0].defined(0, "m")
                once(
                    found, identifier, "material", found[identifier].card.where if identifier in found else "", cards[0]
                )
                found[identifier] = Law(keyword, cards[0], cards[1] if len(cards) > 1 else None, title)
            if keyword in BEYOND:
                why = f"creak takes its elastic constants, which hold at small strain, and no {BEYOND[keyword]}"
                deck.note(named.block.where, f"*{named.block.name}", why, changes=False)
    return found


def records(block: Block, n_lines: int, *, titled: bool) -> Iterator[tuple[str, tuple[Line, ...]]]:
    """Title and lines of each record of a keyword that may hold several; the last lines of a single one may be missing.

    Raises
    ------
    InputError : no data, or a number of lines that makes no whole records.
    """
    size = n_lines + titled
    lines = f"{size} lines" if size > 1 else "a line"
    expected = f"{lines} for each of them{', the title first' if titled else ''}"
    single = titled < len(block.lines) <= size
    for chunk in [block.filled[:size]] if single else block.records(size, expected):
        yield (chunk[0].text.strip() if titled else ""), chunk[titled:]


def elastic(law: Law, identifier: int) -> Material:
    """RO, E and PR of a material.

    Raises
    ------
    InputError : they are those of no elastic body, or the material is that of springs.
    """
    card = law.card
    if law.keyword in SPRINGS:
        raise card.error(
            f"material {identifier} is a *{law.keyword}",
            expected="a material of solids, shells or beams",
            fix="*ELEMENT_DISCRETE alone takes it.",
        )
    density, youngs, poisson = card.real(1), card.real(2), card.real(3)
    if not youngs > 0.0:
        raise card.wrong(2, "E > 0")
    if not -1.0 < poisson < 0.5:
        raise card.wrong(3, "Poisson's ratio above -1 and below 0.5")
    if density < 0.0:
        raise card.wrong(1, "a density of zero or more")
    return Material(law.title or f"MAT {identifier}", youngs, poisson, density)
