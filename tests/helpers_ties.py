"""Decks of two sheets that meet over meshes of their own and are tied."""

from __future__ import annotations

from helpers_decks import STEEL, patch


def sheet(
    name: str, first: int, n: tuple[int, int], origin: tuple[float, float, float], size: tuple[float, float]
) -> str:
    """A rectangle of n = (along x, along y) S4; surfaces <name>_FACE, edges <name>_X0 and <name>_X1 at its ends."""
    n_x, n_y = n
    sides = (size[0], 0.0, 0.0), (0.0, size[1], 0.0)
    lines = [patch(first, name, origin, *sides, n, nodes=f"*NODE, NSET={name}_NODES", digits=9).rstrip()]
    for end, column, edge in (("X0", 0, "E4"), ("X1", n_x - 1, "E2")):
        labels = [str(first + j * n_x + column) for j in range(n_y)]
        lines += [f"*ELSET, ELSET={name}_{end}_ELEMENTS", *labels]
        lines += [f"*SURFACE, NAME={name}_{end}", f"{name}_{end}_ELEMENTS, {edge}"]
    return "\n".join([*lines, f"*SURFACE, NAME={name}_FACE", name, ""])


def sections(*names: str, thickness: float = 1.0) -> str:
    return STEEL + "".join(f"*SHELL SECTION, ELSET={n}, MATERIAL=STEEL\n{thickness:g}\n" for n in names)


def cut_plate(
    left: tuple[int, int],
    right: tuple[int, int],
    tie: str = "*TIE, NAME=SEAM\nRIGHT_X0, LEFT_X1\n",
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> str:
    """A plate of 120 x 80 mm cut at x = 60; its right half is moved by `shift`."""
    return (
        "*HEADING\ncut plate\n"
        + sheet("LEFT", 1, left, (0.0, 0.0, 0.0), (60.0, 80.0))
        + sheet("RIGHT", 100_001, right, (60.0 + shift[0], shift[1], shift[2]), (60.0, 80.0))
        + sections("LEFT", "RIGHT")
        + tie
    )
