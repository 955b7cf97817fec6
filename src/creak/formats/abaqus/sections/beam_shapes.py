"""Cross-sections of *BEAM SECTION by name; the first dimension lies along axis 1."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from creak.formats.deck.cross_section import CrossSection, box, composed, rectangle, rectangle_torsion, tube


def _rect(size: Sequence[float]) -> CrossSection:
    a, b = size
    return rectangle(a, b, rectangle_torsion(a, b), 0.85)


def _circ(size: Sequence[float]) -> CrossSection:
    return tube(size[0], 0.0, 0.89)


def _pipe(size: Sequence[float]) -> CrossSection:
    outer, wall = size
    if wall > outer:
        raise ValueError(f"PIPE with wall {wall:g} thicker than its radius {outer:g}")
    return tube(outer, outer - wall, 0.53)


def _thick_pipe(size: Sequence[float]) -> CrossSection:
    outer, wall = size
    if wall > outer:
        raise ValueError(f"THICK PIPE with wall {wall:g} thicker than its radius {outer:g}")
    return tube(outer, outer - wall, 0.89)


def _box(size: Sequence[float]) -> CrossSection:
    """a along axis 1, b along axis 2; walls t1 = t3 at the sides, t2 = t4 above and below."""
    a, b, right, top, left, bottom = size
    if right != left or top != bottom:
        raise ValueError("BOX with opposite walls of different thickness; give its properties with SECTION=GENERAL")
    if right + left >= a or top + bottom >= b:
        raise ValueError(f"BOX of {a:g} x {b:g} has walls that leave no hole")
    return box(a, b, (right, top, left, bottom), 0.44)


def _i(size: Sequence[float]) -> CrossSection:
    """l from the bottom to the node, h, bottom width b1, top width b2, thickness t1, t2, web t3."""
    below, h, b1, b2, t1, t2, t3 = size
    if t1 + t2 >= h:
        raise ValueError(f"I of height {h:g} has flanges that leave no web")
    web = h - t1 - t2
    parts = [
        (0.0, 0.5 * t1 - below, b1, t1),
        (0.0, h - 0.5 * t2 - below, b2, t2),
        (0.0, t1 + 0.5 * web - below, t3, web),
    ]
    torsion = (b1 * t1**3 + b2 * t2**3 + web * t3**3) / 3.0
    low, high = t1 * b1**3, t2 * b2**3
    centre = 0.5 * t1 - below + (h - 0.5 * (t1 + t2)) * high / (low + high)
    return composed(parts, torsion, 0.44, (0.0, centre))


SHAPES: dict[str, tuple[int, Callable[[Sequence[float]], CrossSection]]] = {
    "RECT": (2, _rect),
    "CIRC": (1, _circ),
    "PIPE": (2, _pipe),
    "THICK PIPE": (2, _thick_pipe),
    "BOX": (6, _box),
    "I": (7, _i),
}
"""Name -> number of dimensions, properties from them."""
