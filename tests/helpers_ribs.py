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
