"""A plate and a shell with a rib over it, and other parts in doubtful places: decks for tests of what is found."""

from __future__ import annotations

from collections.abc import Sequence

from helpers_decks import STEEL, patch


def deck(patches: Sequence[tuple[str, str]], more: str = "") -> str:
    """(element set, its lines) as parts 2 mm thick."""
    sections = "".join(f"*SHELL SECTION, ELSET={name}, MATERIAL=STEEL\n2.0,\n" for name, _ in patches)
    return "*HEADING\nribs\n" + "".join(lines for _, lines in patches) + STEEL + sections + more


def rib_on_plate(height: float, more: str = "") -> str:
    """A rib along x, 20 mm high, whose lower edge (nodes 1001 to 1005) is drawn at a height over a plate's middle."""
    plate = patch(1, "PLATE", (0.0, 0.0, 0.0), (40.0, 0.0, 0.0), (0.0, 40.0, 0.0))
    rib = patch(1001, "RIB", (0.0, 21.0, height), (40.0, 0.0, 0.0), (0.0, 0.0, 20.0))
    held = "*NSET, NSET=FEET\n1, 5\n*NSET, NSET=TOP\n1021, 1025\n*BOUNDARY\nFEET, 1, 2\nFEET, 4, 6\nTOP, 1, 6\n"
    return deck([("PLATE", plate), ("RIB", rib)], held + more)


def bolted_bracket(gap: float) -> str:
    """A bar of bricks 2 mm high whose first half lies on a plate, bolted, and whose second is drawn a gap above it."""
    plate = patch(1, "PLATE", (0.0, 0.0, 0.0), (60.0, 0.0, 0.0), (0.0, 30.0, 0.0), (6, 3))
    lines, elements = ["*NODE"], ["*ELEMENT, TYPE=C3D8, ELSET=BRACKET"]
    for k in range(2):
        for j in range(4):
            for i in range(13):
                z = 1.0 + (gap if i > 6 and k == 0 else 0.0) + 2.0 * k
                lines.append(f"{2001 + 100 * k + 13 * j + i}, {2.0 + 4.0 * i}, {5.0 + 5.0 * j}, {z}")
    for j in range(3):
        for i in range(12):
            a = 2001 + 13 * j + i
            low = [a, a + 1, a + 14, a + 13]
            elements.append(", ".join(str(n) for n in [len(elements), *low, *(n + 100 for n in low)]))
    elements[1:] = [f"{3000 + int(e.split(',')[0])}, {e.split(', ', 1)[1]}" for e in elements[1:]]
    solid = "\n".join([*lines, *elements]) + "\n*SOLID SECTION, ELSET=BRACKET, MATERIAL=STEEL\n"
    held = "*NSET, NSET=FEET\n1, 7, 22, 28\n*BOUNDARY\nFEET, 1, 2\nFEET, 4, 6\n*MPC\nBEAM, 2115, 9\nBEAM, 2118, 10\n"
    return deck([("PLATE", plate)], solid + held)
