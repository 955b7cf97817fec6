"""Closed outlines in the (x, z) plane: polygons with rounded corners that can be offset."""

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
