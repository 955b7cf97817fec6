"""Two cantilevers that collide softly, as decks made of their drawing.

Facts and figures of a published experiment: doi 10.25518/2684-6500.180 (drawings: doi 10.18419/darus-4501). Two steel
beams stand side by side on one base. The left one carries a plate and, near its tip, a cap nut. On the right one a thin
spring plate is clamped, whose free end faces the nut. It touches the nut once the gap is used up.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

LENGTH, BREADTH, HEIGHT = 392.5, 60.0, 6.0
E, RHO = 210e3, 7.72e-9
PLATE, FROM_TIP = 40.0, 62.5
"""Length of the plates along the beams, as broad; from their end to the tip, mm."""
TUNING, TUNING_MASS = 1.0, 42.7e-6
"""Plate on the left beam: thickness, mm; mass with its bolts, t."""
NUT_MASS, NUT_AT = 13.3e-6, 11.5
"""Cap nut on the left beam: mass, t; from the tip, mm."""
CLAMP = (5.0 + 1.0, 7.5)
"""Plates that clamp the spring plate, one on each side of the right beam (the spring plate under the first), mm."""
CLAMP_MASS = (30.7 * 40.0 / 97.0 + 60.6 + 54.3 + 81.9) * 1e-6
"""With screws, washers and nuts, t."""
SPRING, SPRING_THICK, SPRING_MASS = 57.0, 1.0, 30.7e-6 * 57.0 / 97.0
"""Free length of the spring plate towards the tip, thickness, mm; mass of the free length, t."""
GAP = 0.17
LEFT, RIGHT = np.array([30.95, 199.04, 556.82, 1085.93]), np.array([28.2, 205.54, 277.74, 594.98, 1168.62])
"""Measured, Hz; the third of the right beam is that of the spring plate."""


def one_section(*plates: tuple[float, float]) -> float:
    """Second moment of area, mm^4, of the beam with plates on it (parallel axes).

    Parameters
    ----------
    plates : side (1 or -1) and thickness, mm.
    """
    areas = np.array([BREADTH * HEIGHT, *(PLATE * t for _, t in plates)])
    heights = np.array([0.0, *(side * 0.5 * (HEIGHT + t) for side, t in plates)])
    own = np.array([BREADTH * HEIGHT**3, *(PLATE * t**3 for _, t in plates)]) / 12.0
    return float((own + areas * (heights - areas @ heights / areas.sum()) ** 2).sum())


BARE = BREADTH * HEIGHT**3 / 12.0
TUNED = one_section((1, TUNING))
CLAMPED = one_section((1, CLAMP[0]), (-1, CLAMP[1]))
LOOSE = BARE + PLATE * sum(t**3 for t in CLAMP) / 12.0
"""mm^4: plates that bend with the beam and carry no shear between them."""


@dataclass(frozen=True)
class Right:
    """What of the right beam the drawing does not fix."""

    clamp: float = CLAMPED
    """Second moment of area of its clamping section, mm^4."""
    beam: float = 1.0
    """Factor on the stiffness of the beam outside it."""
    spring: float = 1.0
    """Factor on that of the spring plate."""


EQUIVALENT = BREADTH * (HEIGHT + (sum(CLAMP)) * PLATE / BREADTH) ** 3 / 12.0
FITTED = Right(clamp=0.1 * 1.08 * EQUIVALENT, beam=1.08, spring=1.07)
"""The authors' own model: three factors that they set to match the measured frequencies; their clamping section is one
of the same breadth and cross section."""


class Deck:
    """Beams along x that bend about y alone."""

    def __init__(self) -> None:
        self.nodes: list[float] = []
        self.lines: list[str] = []
        self.sets: list[str] = []
        self.elements = 0

    def beam(self, knots: list[tuple[float, int]], start: int | None = None) -> list[int]:
        """Nodes from knot to knot (place, elements up to it); `start` is a node that the first one is."""
        x = [knots[0][0]]
        for (a, _), (b, n) in pairwise(knots):
            x += np.linspace(a, b, n + 1)[1:].tolist()
        first = len(self.nodes) + 1
        self.nodes += x[1:] if start else x
        return [start, *range(first, first + len(x) - 1)] if start else list(range(first, first + len(x)))

    def section(self, name: str, nodes: list[int], inertia: float, area: float, density: float) -> None:
        self.lines.append(f"*ELEMENT, TYPE=B33, ELSET={name}")
        for a, b in pairwise(nodes):
            self.elements += 1
            self.lines.append(f"{self.elements}, {a}, {b}")
        self.lines += [
            f"*BEAM GENERAL SECTION, ELSET={name}, SECTION=GENERAL, DENSITY={density:.9g}",
            f"{area}, {inertia:.9g}, 0., {100.0 * inertia:.9g}, {4.0 * inertia:.9g}",
            "0., 1., 0.",
            f"{E}, {E / 2.6:.9g}",
        ]

    def text(self, base: list[int], *, shaken: bool = False) -> str:
        count = len(self.nodes)
        lines = [
            "*NODE",
            *(f"{k}, {x:.9g}, 0., 0." for k, x in enumerate(self.nodes, start=1)),
            *self.lines,
            *self.sets,
        ]
        lines += [f"*NSET, NSET=ALL, GENERATE\n1, {count}, 1", f"*NSET, NSET=BASE\n{', '.join(map(str, base))}"]
        held = ["BASE, 1, 2", "BASE, 4, 6"] if shaken else ["BASE, 1, 6"]
        lines += ["*BOUNDARY", *held, *(f"ALL, {dof}, {dof}" for dof in (1, 2, 4, 6))]
        return "\n".join(lines) + "\n"

    def left(self) -> list[int]:
        """The left beam; the nut is the set NUT."""
        start, end, nut = LENGTH - FROM_TIP - PLATE, LENGTH - FROM_TIP, LENGTH - NUT_AT
        nodes = self.beam([(0.0, 0), (start, 40), (end, 7), (nut, 9), (LENGTH, 3)])
        area = BREADTH * HEIGHT
        self.section("LEFT", nodes[:41], BARE, area, RHO)
        # Bolts hold the plate to three quarters of one section: the authors' figure, which the drawing does not say.
        self.section("TUNED", nodes[40:48], 0.75 * TUNED, area, RHO + TUNING_MASS / PLATE / area)
        self.section("LEFT_END", nodes[47:], BARE, area, RHO)
        self.lines.append(f"*ELEMENT, TYPE=MASS, ELSET=NUTS\n90000, {nodes[56]}\n*MASS, ELSET=NUTS\n{NUT_MASS}")
        self.sets.append(f"*NSET, NSET=NUT\n{nodes[56]}")
        return nodes

    def right(self, made: Right) -> list[int]:
        """The right beam with its spring plate; SPRING is the plate where it faces the nut, RIGHT the beam beside it."""
        start, end, nut = LENGTH - FROM_TIP - PLATE, LENGTH - FROM_TIP, LENGTH - NUT_AT
        nodes = self.beam([(0.0, 0), (start, 40), (end, 7), (nut, 9), (LENGTH, 3)])
        area = BREADTH * HEIGHT
        self.section("RIGHT", nodes[:41], made.beam * BARE, area, RHO)
        self.section("CLAMP", nodes[40:48], made.clamp, area, RHO + CLAMP_MASS / PLATE / area)
        self.section("RIGHT_END", nodes[47:], made.beam * BARE, area, RHO)
        plate = self.beam([(end, 0), (nut, 10), (end + SPRING, 2)], start=nodes[47])
        thin = PLATE * SPRING_THICK
        self.section("SPRINGS", plate, made.spring * PLATE * SPRING_THICK**3 / 12.0, thin, SPRING_MASS / SPRING / thin)
        self.sets.append(f"*NSET, NSET=SPRING\n{plate[10]}\n*NSET, NSET=TIP\n{nodes[56]}")
        return nodes


def left_deck() -> str:
    """The left beam alone."""
    deck = Deck()
    return deck.text(deck.left()[:1])


def right_deck(made: Right) -> str:
    """The right beam alone."""
    deck = Deck()
    return deck.text(deck.right(made)[:1])


def both_deck(made: Right) -> str:
    """Both on one base."""
    deck = Deck()
    return deck.text([deck.left()[0], deck.right(made)[0]], shaken=True)
