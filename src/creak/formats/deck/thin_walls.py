"""Cross-sections of beams from straight thin walls, one after the other: open, or closed round one cell."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.cross_section import CrossSection

CLOSED = 1e-9
"""Share of the length of the walls within which the last point is the first."""


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
        shear_factor,
    )


def _moments(areas: FloatArray, f: FloatArray, g: FloatArray) -> FloatArray:
    """integral of f_i g_j over walls, of functions (n + 1, k) that are linear along each wall."""
    fa, fb, ga, gb = f[:-1], f[1:], g[:-1], g[1:]
    products = 2.0 * (np.einsum("ni,nj->nij", fa, ga) + np.einsum("ni,nj->nij", fb, gb))
    products += np.einsum("ni,nj->nij", fa, gb) + np.einsum("ni,nj->nij", fb, ga)
    return np.asarray((areas[:, None, None] * products).sum(axis=0) / 6.0)
