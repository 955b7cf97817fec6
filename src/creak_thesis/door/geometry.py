"""The shape of the door: outlines in the (x, z) plane and the heights y(x, z) of its sheets.

x runs from the front edge (hinges) to the rear edge (latch), z upwards, y into the cabin. Lengths in mm.
Nothing here depends on the mesh size: every mesh samples the same surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak_thesis.arrays import FloatArray


@dataclass(frozen=True)
class Outline:
    """A convex polygon with rounded corners, counter-clockwise with x to the right and z up.

    Side k runs from the middle of the arc at corner k to the middle of the arc at corner k + 1.
    """

    corners: FloatArray
    """(n, 2) corners (x, z) before rounding, mm."""
    radii: tuple[float, ...]
    """(n,) corner radii, mm; 0 keeps the corner sharp."""

    @property
    def count(self) -> int:
        return len(self.radii)

    def offset(self, distance: float) -> Outline:
        """The parallel outline `distance` mm inside this one (negative: outside)."""
        direction = self._directions()
        inward = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
        before = np.roll(inward, 1, axis=0)
        # The two shifted lines meet where n_a . v = n_b . v = distance, v the move of the corner.
        cosine = np.sum(before * inward, axis=1, keepdims=True)
        move = distance * (before + inward) / (1.0 + cosine)
        radii = tuple(max(r - distance, 0.0) if r > 0 else 0.0 for r in self.radii)
        return Outline(self.corners + move, radii)

    def length(self, side: int) -> float:
        """Arc length of a side, mm."""
        return float(sum(self._pieces(side)))

    def point(self, side: int, fraction: FloatArray) -> FloatArray:
        """Points (m, 2) at the given fractions (m,) of the arc length of a side."""
        first, straight, last = self._pieces(side)
        s = np.asarray(fraction, dtype=float) * (first + straight + last)
        direction = self._directions()
        here, there = side % self.count, (side + 1) % self.count
        start = self._tangent_point(here, direction[here], +1.0)
        points = start + (s - first)[:, None] * direction[here]
        for corner, along, sign in ((here, s - first, -1.0), (there, s - first - straight, 1.0)):
            on_arc = along * sign > 0
            if self.radii[corner] > 0 and on_arc.any():
                points[on_arc] = self._arc(corner, direction[here], sign, along[on_arc])
        return points

    def walk(self, fractions: FloatArray) -> FloatArray:
        """Points (m, 2) at fractions of the whole length, from the start of side 0."""
        lengths = np.array([self.length(k) for k in range(self.count)])
        ends = np.cumsum(lengths)
        s = np.asarray(fractions, dtype=float) * ends[-1]
        side = np.minimum(np.searchsorted(ends, s, side="right"), self.count - 1)
        points = np.empty((s.size, 2))
        for k in range(self.count):
            mine = side == k
            points[mine] = self.point(k, (s[mine] - (ends[k] - lengths[k])) / lengths[k])
        return points

    def _directions(self) -> FloatArray:
        edge = np.roll(self.corners, -1, axis=0) - self.corners
        return edge / np.linalg.norm(edge, axis=1, keepdims=True)

    def _turn(self, corner: int) -> float:
        direction = self._directions()
        a, b = direction[corner - 1], direction[corner]
        return float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b))

    def _pieces(self, side: int) -> tuple[float, float, float]:
        """Length of half an arc, of the straight piece and of the other half arc."""
        here, there = side % self.count, (side + 1) % self.count
        turns = self._turn(here), self._turn(there)
        radii = self.radii[here], self.radii[there]
        edge = float(np.linalg.norm(self.corners[there] - self.corners[here]))
        cut = sum(r * np.tan(t / 2) for r, t in zip(radii, turns, strict=True))
        return radii[0] * turns[0] / 2, edge - cut, radii[1] * turns[1] / 2

    def _tangent_point(self, corner: int, direction: FloatArray, sign: float) -> FloatArray:
        cut = self.radii[corner] * np.tan(self._turn(corner) / 2)
        return self.corners[corner] + sign * cut * direction

    def _arc(self, corner: int, direction: FloatArray, sign: float, along: FloatArray) -> FloatArray:
        """Points on an arc, `along` mm past the tangent point of the side with this direction."""
        radius = self.radii[corner]
        inward = np.array([-direction[1], direction[0]])
        centre = self._tangent_point(corner, direction, -sign) + radius * inward
        angle = along / radius
        return centre + radius * (np.sin(angle)[:, None] * direction - np.cos(angle)[:, None] * inward)


def loop(outline: Outline, fractions: list[FloatArray]) -> FloatArray:
    """Points (n, 2) around a closed outline, no point twice."""
    return np.concatenate([outline.point(k, u[:-1]) for k, u in enumerate(fractions)])


def loop_fraction(outline: Outline, fractions: list[FloatArray]) -> FloatArray:
    """Fraction 0..1 of the whole length at the points of `loop`."""
    lengths = np.array([outline.length(k) for k in range(outline.count)])
    start = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    pieces = [a + u[:-1] * n for a, u, n in zip(start, fractions, lengths, strict=True)]
    return np.concatenate(pieces) / lengths.sum()


GAP = 3.7
"""Clear gap in y between the flange of the frame and the edge of the panel."""
FRAME_THICKNESS = 0.7
PANEL_THICKNESS = 1.8
CARRIER_THICKNESS = 1.8
PANEL_OFFSET = GAP + FRAME_THICKNESS / 2 + PANEL_THICKNESS / 2
"""Distance in y between the mid-surfaces of the frame's flange and of the panel's edge."""

EDGE_INSET = 22.0
"""Distance of the panel's edge from the outline of the frame's lower body."""
LIP_WIDTH = 20.0
"""Width of the flat lip along the panel's edge."""
FLANGE_WIDTH = 54.0
"""Width of the band without relief along the outline of the frame's lower body."""
SEAT_DEPTH = 18.0
"""How far the rim of the aperture lies behind the flange."""
CARRIER_GAP = 13.0
"""Distance of the carrier behind the rim of the aperture, mid-surface to mid-surface."""

BODY = Outline(np.array([[30.0, 0.0], [1140.0, 15.0], [1176.0, 768.0], [0.0, 748.0]]), (110.0, 90.0, 0.0, 0.0))
"""Lower body of the frame: bottom, rear side, belt (rear to front), front side."""
APERTURE = Outline(np.array([[305.0, 215.0], [885.0, 222.0], [900.0, 545.0], [290.0, 535.0]]), (75.0, 75.0, 75.0, 75.0))
"""Hole of the frame that the carrier closes."""
CARRIER = APERTURE.offset(-42.0)
SCREW_LINE = APERTURE.offset(-21.0)
"""The screws between carrier and frame sit on this line."""
PANEL = Outline(BODY.offset(EDGE_INSET).corners, (88.0, 68.0, 45.0, 45.0))
"""Edge of the panel."""
TRAY = (180.0, 590.0)
"""Ends in x of the tray below the window sill, where the panel stays as low as its lip."""
TRAY_DEPTH = 70.0
"""Width of the tray's floor, from the belt edge of the panel."""
CONTACT_AREA = (0.66, 0.76)
"""Where panel and frame touch: the free edge of the tray, as fractions of the length of `PANEL`."""

_TOP_REAR, _TOP_FRONT = (1122.0, 1160.0), (480.0, 1132.0)
PERIMETER = Outline(
    np.array([*BODY.corners[:3], _TOP_REAR, _TOP_FRONT, BODY.corners[3]]),
    (110.0, 90.0, 0.0, 75.0, 110.0, 0.0),
)
"""Outline of the whole frame: bottom, rear side, rear post, header, front post, front side."""
POST_WIDTHS = (80.0, 74.0, 84.0)
"""Widths of the rear post, the header and the front post."""
SAIL_LEG = 150.0
"""Length of the belt side of the mirror triangle between front post and belt."""


def _window() -> Outline:
    """Inner outline of the posts down to the belt: sill, rear post, header, front post."""
    corner = PERIMETER.corners
    a, b = corner[2:5], corner[3:6]
    direction = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    inward = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    start = a + np.array(POST_WIDTHS)[:, None] * inward
    belt_start, belt = corner[2], corner[5] - corner[2]
    lines = [(belt_start, belt), *zip(start, direction, strict=True), (belt_start, belt)]
    met = [_meet(*lines[k], *lines[k + 1]) for k in range(4)]
    return Outline(np.array([met[3], met[0], met[1], met[2]]), (0.0, 0.0, 45.0, 60.0))


def _meet(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
    """Where the line through p along u meets the line through q along v."""
    step = np.linalg.solve(np.stack([u, -v], axis=1), q - p)
    return p + step[0] * u


WINDOW = _window()
"""Window opening with the mirror triangle: sill, rear post, header, front post."""
SAIL_SILL = WINDOW.corners[0] + SAIL_LEG * (WINDOW.corners[1] - WINDOW.corners[0]) / np.linalg.norm(
    WINDOW.corners[1] - WINDOW.corners[0]
)
"""Corner of the mirror triangle on the belt."""
_POST_DIRECTION = WINDOW.corners[3] - WINDOW.corners[0]
SAIL_POST = WINDOW.corners[0] + (SAIL_SILL[0] - WINDOW.corners[0, 0]) * _POST_DIRECTION / _POST_DIRECTION[0]
"""Corner of the mirror triangle on the front post, straight above the one on the belt."""
OPENING = Outline(np.array([SAIL_SILL, *WINDOW.corners[1:], SAIL_POST]), (0.0, *WINDOW.radii[1:], 0.0))
"""Window opening without the mirror triangle: sill, rear post, header, front post, triangle."""


def step(x: FloatArray, start: float, end: float) -> FloatArray:
    """Smooth step from 0 at `start` to 1 at `end` (3 t^2 - 2 t^3)."""
    t = np.clip((np.asarray(x, dtype=float) - start) / (end - start), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def box(x: FloatArray, low: float, high: float, width: float) -> FloatArray:
    """Smooth plateau: 1 between `low` and `high`, 0 beyond `width` outside them."""
    return step(x, low - width, low) * (1.0 - step(x, high, high + width))


def base(x: FloatArray, z: FloatArray) -> FloatArray:
    """Overall curvature of the door: the top and the ends lean into the cabin."""
    return (z - 420.0) ** 2 / (2 * 2600.0) + (x - 590.0) ** 2 / (2 * 7000.0)


def bow(x: FloatArray, z: FloatArray) -> FloatArray:
    """Bow the sides of the door: template x to real x (the last step of every part)."""
    return x + 10.0 * np.sin(np.pi * z / 760.0) * (2.0 * x / 1176.0 - 1.0)


def lift(xz: FloatArray, height: FloatArray | float) -> FloatArray:
    """Points (..., 2) of the template and heights over the base surface -> (n, 3) coordinates."""
    x, z = xz[..., 0], xz[..., 1]
    y = base(x, z) + height
    return np.stack([bow(x, z), y, z], axis=-1).reshape(-1, 3)


def body_relief(across: FloatArray, along: FloatArray) -> FloatArray:
    """Pressed relief between flange (across = 0) and aperture (1); `along` is 0..1 around the ring."""
    beads = step(across, 0.05, 0.3) * (1.0 - step(across, 0.6, 0.82)) * np.cos(2 * np.pi * 22 * along)
    return -SEAT_DEPTH * step(across, 0.0, 0.35) + 11.0 * beads


def post_relief(across: FloatArray, z: FloatArray) -> FloatArray:
    """Hat profile across a post (0 outside, 1 at the window), fading out at the belt."""
    return 14.0 * np.sin(np.pi * across) ** 2 * step(z, 769.0, 845.0)


def wall_bead(across: FloatArray, along: FloatArray) -> FloatArray:
    """Outward beads of the return: `across` 0 at the fold and 1 at the hem, `along` 0..1."""
    return 3.0 * np.sin(np.pi * across) ** 2 * np.cos(2 * np.pi * 30 * along)


def panel_rise(inset: FloatArray) -> FloatArray:
    """0 on the lip of the panel, 1 on its main surface; `inset` is measured from the edge."""
    return step(inset, LIP_WIDTH, 64.0)


def tray(x: FloatArray, z: FloatArray) -> FloatArray:
    """1 on the floor of the tray below the window sill, 0 on the main surface of the panel.

    There the edge is a soft tongue of 1.8 mm plastic; along the rest of it the side wall of the panel stiffens it.
    """
    rear, front = PANEL.corners[2], PANEL.corners[3]
    along = (rear - front) / np.linalg.norm(rear - front)
    inset = (x - front[0]) * along[1] - (z - front[1]) * along[0]
    return box(x, *TRAY, 80.0) * (1.0 - step(inset, TRAY_DEPTH, TRAY_DEPTH + 60.0))


def panel_height(x: FloatArray, z: FloatArray, rise: FloatArray) -> FloatArray:
    """Height of the panel over its own edge: main surface, armrest, map pocket, speaker, swages, tray."""
    armrest = 60.0 * box(x, 330.0, 900.0, 70.0) * box(z, 395.0, 470.0, 65.0)
    pocket = -26.0 * box(x, 400.0, 930.0, 45.0) * box(z, 120.0, 230.0, 45.0)
    radius = np.hypot(x - 215.0, z - 215.0)
    speaker = 14.0 * (1.0 - step(radius, 45.0, 110.0))
    swages = 7.0 * np.cos(2 * np.pi * (z - 0.12 * x) / 150.0) * step(z, 500.0, 560.0)
    ribs = 5.0 * np.cos(2 * np.pi * x / 150.0) * (1.0 - step(z, 330.0, 390.0))
    return rise * (1.0 - tray(x, z)) * (72.0 + armrest + pocket + speaker + swages + ribs)


def carrier_height(x: FloatArray, z: FloatArray, inset: FloatArray) -> FloatArray:
    """Height of the carrier over its rim: a raised floor with cross ribs that stands in the aperture."""
    ribs = 7.0 * np.cos(2 * np.pi * (x - 590.0) / 150.0) * np.cos(2 * np.pi * (z - 370.0) / 150.0)
    return step(inset, 55.0, 95.0) * (22.0 + ribs)
