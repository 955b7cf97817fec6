"""Cross-sections of *BEAM SECTION by name; the first dimension lies along axis 1."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.cross_section import (
    CrossSection,
    box,
    composed,
    hexagon,
    rectangle,
    rectangle_torsion,
    trapezoid,
    tube,
)

OF_NODE = {"I": 0, "TRAPEZOID": 3}
"""Which dimension is the height of the node above the bottom, and may be anything."""
WALL = 3
"""Numbers of each further wall of an ARBITRARY section; the first one has their count and a point besides."""
WIDTHS: dict[str, Callable[[Sequence[float]], tuple[float, float]]] = {
    "RECT": lambda size: (size[0], size[1]),
    "CIRC": lambda size: (2.0 * size[0], 2.0 * size[0]),
    "PIPE": lambda size: (2.0 * size[0], 2.0 * size[0]),
    "BOX": lambda size: (size[0], size[1]),
}
"""Extent along axes 1 and 2 of the shapes that CalculiX knows."""
CLOSED = 1e-9
"""Share of the length of the walls within which the last point is the first."""


def _rect(size: Sequence[float]) -> CrossSection:
    a, b = size
    return rectangle(a, b, rectangle_torsion(a, b), 0.85)


def _circ(size: Sequence[float]) -> CrossSection:
    return tube(size[0], 0.0, 0.89)


def ellipse(a: float, b: float) -> CrossSection:
    """CIRC of CalculiX: diameters along axes 1 and 2. J = pi a^3 b^3 / (16 (a^2 + b^2)) (Timoshenko, Goodier, Theory of
    Elasticity, art. 104)."""
    quarter = 0.25 * math.pi * a * b
    torsion, radius = 0.25 * quarter * a * a * b * b / (a * a + b * b), 0.5 * min(a, b)
    i11, i22 = quarter * b * b / 16.0, quarter * a * a / 16.0
    return CrossSection(quarter, i11, i22, 0.0, torsion, shear_factors=(0.89, 0.89), radius=radius)


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


def _hex(size: Sequence[float]) -> CrossSection:
    """Radius to the outer corners, wall."""
    outer, wall = size
    if 2.0 * wall >= math.sqrt(3.0) * outer:
        raise ValueError(f"HEX with wall {wall:g} that leaves no hole in a radius of {outer:g}")
    return hexagon(outer, wall, 0.53)


def _l(size: Sequence[float]) -> CrossSection:
    """Leg a along axis 1 of thickness t1, b along axis 2 of t2; the node where their middle lines cross: the shear
    centre."""
    a, b, t1, t2 = size
    if t2 >= a or t1 >= b:
        raise ValueError(f"L of {a:g} x {b:g} has legs thicker than they are long")
    parts = [(0.5 * (a - t2), 0.0, a, t1), (0.0, 0.5 * b, t2, b - t1)]
    torsion = ((a - 0.5 * t2) * t1**3 + (b - 0.5 * t1) * t2**3) / 3.0
    return composed(parts, torsion, 1.0, (0.0, 0.0), 0.5 * min(t1, t2))


def _trapezoid(size: Sequence[float]) -> CrossSection:
    """Width at the bottom, height, width at the top, height of the node above the bottom."""
    a, b, c, d = size
    return trapezoid(a, b, c, d, 0.822)


SHAPES: dict[str, tuple[int, Callable[[Sequence[float]], CrossSection]]] = {
    "RECT": (2, _rect),
    "CIRC": (1, _circ),
    "PIPE": (2, _pipe),
    "THICK PIPE": (2, _thick_pipe),
    "BOX": (6, _box),
    "I": (7, _i),
    "HEX": (2, _hex),
    "L": (4, _l),
    "TRAPEZOID": (4, _trapezoid),
}
"""Name -> number of dimensions, properties from them."""


def arbitrary(size: Sequence[float]) -> CrossSection:
    """Count of the walls; x1, x2 of two points, thickness; x1, x2 and thickness of each further point and wall."""
    points, walls = [(size[1], size[2]), (size[3], size[4])], [size[5]]
    for k in range(6, len(size), WALL):
        points.append((size[k], size[k + 1]))
        walls.append(size[k + 2])
    if not min(walls) > 0.0:
        raise ValueError(f"a wall of the section is {min(walls):g} thick")
    return thin_walled(points, walls, 1.0)


def shape_of(profile: str, size: Sequence[float]) -> CrossSection | None:
    """Of a name and its dimensions; None where these are those of no shape."""
    if profile == "ARBITRARY":
        return arbitrary(size)
    return SHAPES[profile][1](size) if profile in SHAPES else None


def thin_walled(points: Sequence[tuple[float, float]], walls: Sequence[float], shear_factor: float) -> CrossSection:
    """Of walls between points of the middle line, wall k from point k to k + 1; all mass lies on that line.

    With the sectorial coordinate w of the node, dw = x dy - y dx - psi ds/t, psi = 2 A/oint ds/t of a cell of area A
    and 0 of an open section, the shear centre e is where w - e_x y + e_y x stands orthogonal to x and y (Vlasov,
    Thin-walled elastic beams (1961), chapter 1). Torsion: sum l t^3/3 (open), of a cell also 4 A^2/oint ds/t (Bredt).
    Where warping is held, an open section is stiffer in torsion than this.

    A wall alone has no stiffness about its own line.

    Raises
    ------
    ValueError : walls of no length, or all on one line.
    """
    x, t = np.asarray(points, dtype=np.float64), np.asarray(walls, dtype=np.float64)
    length = np.linalg.norm(np.diff(x, axis=0), axis=1)
    if not (length > 0.0).all():
        raise ValueError("a wall of the section has no length")
    area = float((length * t).sum())
    centre = (0.5 * (x[:-1] + x[1:]) * (length * t)[:, None]).sum(axis=0) / area
    (i22, i12), (_, i11) = _moments(length * t, x - centre, x - centre)
    if not i11 * i22 - i12 * i12 > 1e-12 * (i11 + i22) ** 2:
        raise ValueError("the walls of the section lie on one line, about which they have no stiffness")
    swept = x[:-1, 0] * x[1:, 1] - x[1:, 0] * x[:-1, 1]
    torsion = float((length * t**3).sum()) / 3.0
    if math.dist(x[0], x[-1]) <= CLOSED * float(length.sum()):
        cell = 0.5 * float(swept.sum())
        psi = 2.0 * cell / float((length / t).sum())
        torsion += 2.0 * cell * psi
        swept = swept - psi * length / t
    sectorial = np.concatenate([[0.0], np.cumsum(swept)])
    wx, wy = _moments(length * t, sectorial[:, None], x - centre)[0]
    e = np.linalg.solve([[i12, -i22], [i11, -i12]], [wx, wy])
    return CrossSection(
        area,
        float(i11),
        float(i22),
        float(i12),
        torsion,
        (float(centre[0]), float(centre[1])),
        (float(e[0]), float(e[1])),
        shear_factors=2 * (shear_factor,),
    )


def _moments(areas: FloatArray, f: FloatArray, g: FloatArray) -> FloatArray:
    """integral of f_i g_j over walls, of functions (n + 1, k) that are linear along each wall."""
    fa, fb, ga, gb = f[:-1], f[1:], g[:-1], g[1:]
    products = 2.0 * (np.einsum("ni,nj->nij", fa, ga) + np.einsum("ni,nj->nij", fb, gb))
    products += np.einsum("ni,nj->nij", fa, gb) + np.einsum("ni,nj->nij", fb, ga)
    return np.asarray((areas[:, None, None] * products).sum(axis=0) / 6.0)
