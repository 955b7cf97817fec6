"""Which main facet lies opposite a point: a tree of bounding balls and projection onto bilinear facets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import Facets
from creak.model.faces import unit, vector_areas
from creak.model.projection import OVERHANG, meet_facets

LEAF = 4
"""Facets in a leaf of the tree."""
POINTS_AT_ONCE = 32768
"""Points sought at a time; bounds the memory."""
MARGIN = 1.0 + 4.0 * OVERHANG
"""Bounds are this much larger than the facets, so that what overhangs a little still counts."""
SAME = 1e-7
"""Share of a facet's diagonal by which two distances may differ and count as the same: a point over the edge of two
facets meets both."""
STEEP = 1e-6
"""Sine of the angle up to which a line lies in a facet, and share of its size up to which a facet is flat."""
CONVERGED = 1e-6
"""Largest miss of a meeting point, as a share of the facet's diagonal or the distance."""

Accept = Callable[[IntArray, IntArray, FloatArray, FloatArray], BoolArray]
"""Point rows, facet rows, signed distances, directions -> which meetings count."""


@dataclass(frozen=True)
class Projection:
    """Where points meet the main surface; rows with `found` False have no partner."""

    found: BoolArray
    facet: IntArray
    shape: FloatArray
    """(n, 4) shape functions of the facet's nodes at the meeting point."""
    distance: FloatArray
    """(n,) signed, along `direction` from the point to the facet."""
    direction: FloatArray
    """(n, 3) unit vectors."""

    @property
    def fields(self) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
        """All but `found`."""
        return self.facet, self.shape, self.distance, self.direction


Then = Callable[[Projection], Accept]
"""Where points have met the surface -> which of their other meetings count."""


@dataclass(frozen=True)
class _Level:
    """Balls round the facets of the k-th generation of a binary tree, and cones round their normals."""

    centre: FloatArray
    """(2^k, 3)"""
    radius: FloatArray
    axis: FloatArray
    """(2^k, 3) middle of the normals."""
    sine: FloatArray
    """(2^k,) of the cone's half angle; 1 for a right angle and more."""


@dataclass(frozen=True)
class FacetTree:
    """A balanced binary tree over facets, whatever their sizes and shapes."""

    order: IntArray
    """(n,) facets, leaf by leaf."""
    bounds: IntArray
    """(n_leaf + 1,) where the leaves begin in `order`."""
    levels: tuple[_Level, ...]


@dataclass(frozen=True)
class _Boxes:
    """A box round each facet, turned to its normal and its longer side."""

    centre: FloatArray
    """(n, 3)"""
    frame: FloatArray
    """(n, 3, 3) rows: along the longer side, across it, along the normal."""
    extent: FloatArray
    """(n, 3) of the corners from the centre, along the rows of `frame`."""
    cosine: FloatArray
    """(n,) between the normal and the corner normal farthest from it."""


def project_along(
    points: FloatArray, directions: FloatArray, main: Facets, limit: float, accept: Accept | None = None
) -> Projection:
    """Meet the main facets along given directions (both ways); the nearest that `accept` lets pass.

    Parameters
    ----------
    points, directions : (n, 3), directions of unit length.
    limit : farthest distance of a meeting.
    """
    return _project(points, main, limit, directions, accept)[0]


def project_twice(
    points: FloatArray, directions: FloatArray, main: Facets, limit: float, accept: Accept, then: Then
) -> tuple[Projection, Projection]:
    """`project_along`, and of the same meetings the nearest that `then` lets pass: points and lines are met once."""
    return _project(points, main, limit, directions, accept, then)


def project_closest(points: FloatArray, main: Facets, limit: float, accept: Accept | None = None) -> Projection:
    """Meet the main facets along their own normals; the nearest that `accept` lets pass."""
    return _project(points, main, limit, None, accept)[0]


def facet_tree(main: Facets) -> FacetTree:
    """Halve the facets at the median of their longest extent until `LEAF` of them are left."""
    n = main.count
    depth = max(0, int(np.ceil(np.log2(max(n, 1) / LEAF))))
    centre, order = main.coords.mean(axis=1), np.arange(n)
    for k in range(depth):
        order = _halved(centre, order, _bounds(n, k))
    x = main.coords[order]
    box, normal = (x.min(axis=1), x.max(axis=1)), _corner_directions(x)
    levels = tuple(_level(x, box, normal, _bounds(n, k)) for k in range(depth + 1))
    return FacetTree(order, _bounds(n, depth), levels)


def _bounds(n: int, depth: int) -> IntArray:
    """Where the 2^depth groups of n facets begin; each group holds its two halves."""
    bounds = np.array([0, n], dtype=np.int64)
    for _ in range(depth):
        middle = (bounds[1:] + bounds[:-1]) // 2
        bounds = np.append(np.column_stack([bounds[:-1], middle]).ravel(), n)
    return bounds


def _halved(centre: FloatArray, order: IntArray, bounds: IntArray) -> IntArray:
    """Facets sorted within each group along its longest extent."""
    x = centre[order]
    extent = np.maximum.reduceat(x, bounds[:-1]) - np.minimum.reduceat(x, bounds[:-1])
    group = np.repeat(np.arange(bounds.size - 1), np.diff(bounds))
    along = x[np.arange(order.size), np.argmax(extent, axis=1)[group]]
    return order[np.lexsort((along, group))]


def _level(x: FloatArray, box: tuple[FloatArray, FloatArray], normal: FloatArray, bounds: IntArray) -> _Level:
    start = bounds[:-1]
    group = np.repeat(np.arange(start.size), np.diff(bounds))
    centre = 0.5 * (np.minimum.reduceat(box[0], start) + np.maximum.reduceat(box[1], start))
    away = x - centre[group, None]
    square = np.einsum("njx,njx->nj", away, away).max(axis=1)
    axis = unit(np.add.reduceat(normal.sum(axis=1), start))
    cosine = np.minimum.reduceat(np.einsum("njx,nx->nj", normal, axis[group]).min(axis=1), start)
    sine = np.where(cosine > 0.0, np.sqrt(np.maximum(1.0 - cosine**2, 0.0)), 1.0)
    radius = MARGIN * np.sqrt(np.maximum.reduceat(square, start))
    return _Level(centre, radius, axis, np.minimum(sine + 1e-6, 1.0))


def _corner_directions(x: FloatArray) -> FloatArray:
    """(n, 4, 3) unit normals at the corners; the normals between them lie within their cone."""
    following, before = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
    normal = np.cross(following, before)
    mean = vector_areas(x)
    size = np.linalg.norm(normal, axis=2)
    flat = size <= 2e-9 * np.linalg.norm(mean, axis=1)[:, None]
    return unit(np.where(flat[:, :, None], mean[:, None], normal))


def _project(
    points: FloatArray,
    main: Facets,
    limit: float,
    directions: FloatArray | None,
    accept: Accept | None,
    then: Then | None = None,
) -> tuple[Projection, Projection]:
    n, tree, boxes = points.shape[0], facet_tree(main), _boxes(main.coords)
    first, second = _none(n), _none(n)
    for begin in range(0, n, POINTS_AT_ONCE):
        row, facet = _candidates(points, directions, boxes, tree, limit, begin, min(begin + POINTS_AT_ONCE, n))
        along = None if directions is None else directions[row]
        shape, distance, normal, inside = meet_facets(points[row], main.coords[facet], main.is_triangle[facet], along)
        good = inside & (np.abs(distance) <= limit) & _converged(points[row], main, facet, shape, distance, normal)
        met = Projection(good, facet, shape, distance, normal)
        _keep(first, main, row, met, None if accept is None else accept(row, facet, distance, normal))
        if then is not None:
            _keep(second, main, row, met, then(first)(row, facet, distance, normal))
    return first, second


def _keep(best: Projection, main: Facets, row: IntArray, met: Projection, counts: BoolArray | None) -> None:
    """Write the nearest meetings that count into `best`; None: all."""
    hit = np.flatnonzero(met.found if counts is None else met.found & counts)
    hit = _nearest(hit, row, met.facet, np.abs(met.distance), main)
    best.found[row[hit]] = True
    for kept, new in zip(best.fields, met.fields, strict=True):
        kept[row[hit]] = new[hit]


def _none(n: int) -> Projection:
    """Of n points that have met nothing yet."""
    none = np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64)
    return Projection(*none, np.zeros((n, 4)), np.full(n, np.inf), np.zeros((n, 3)))


def _nearest(hit: IntArray, row: IntArray, facet: IntArray, distance: FloatArray, main: Facets) -> IntArray:
    """Of the meetings `hit` the nearest of each point; of those as near up to round-off the one of the first facet."""
    x = main.coords[facet[hit]]
    size = np.linalg.norm(x[:, 2] - x[:, 0], axis=1)
    least = np.full(int(row.max(initial=-1)) + 1, np.inf)
    np.minimum.at(least, row[hit], distance[hit])
    hit = hit[distance[hit] <= least[row[hit]] + SAME * size]
    hit = hit[np.lexsort((facet[hit], row[hit]))]
    return np.asarray(hit[np.unique(row[hit], return_index=True)[1]], dtype=np.int64)


def _converged(
    points: FloatArray, main: Facets, facet: IntArray, shape: FloatArray, distance: FloatArray, direction: FloatArray
) -> BoolArray:
    """Does the line really end on the facet? Newton's steps need not converge far from a warped one."""
    x = main.coords[facet]
    miss = np.einsum("nj,njx->nx", shape, x) - points - distance[:, None] * direction
    size = np.linalg.norm(x[:, 2] - x[:, 0], axis=1)
    return np.asarray(np.linalg.norm(miss, axis=1) <= CONVERGED * np.maximum(size, np.abs(distance)))


def _candidates(
    points: FloatArray,
    directions: FloatArray | None,
    boxes: _Boxes,
    tree: FacetTree,
    limit: float,
    begin: int,
    end: int,
) -> tuple[IntArray, IntArray]:
    """Pairs of points and facets that may meet; none that does is left out."""
    row = np.arange(begin, end)
    node = np.zeros(row.size, dtype=np.int64)
    for k, level in enumerate(tree.levels):
        if k:
            row, node = np.repeat(row, 2), np.column_stack([2 * node, 2 * node + 1]).ravel()
        keep = _may_meet(points[row], None if directions is None else directions[row], level, node, limit)
        row, node = row[keep], node[keep]
    first, count = tree.bounds[node], tree.bounds[node + 1] - tree.bounds[node]
    inner = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    row, facet = np.repeat(row, count), tree.order[np.repeat(first, count) + inner]
    keep = _over(points[row], None if directions is None else directions[row], boxes, facet, limit)
    return row[keep], facet[keep]


def _may_meet(
    points: FloatArray, directions: FloatArray | None, level: _Level, node: IntArray, limit: float
) -> BoolArray:
    """Does the line through a point pass the ball, or could a normal of the cone do so?"""
    offset, radius = points - level.centre[node], level.radius[node]
    line = level.axis[node] if directions is None else directions
    along = np.einsum("nx,nx->n", offset, line)
    distance = np.sqrt(np.einsum("nx,nx->n", offset, offset))
    across = np.sqrt(np.maximum(distance**2 - along**2, 0.0))
    slack = 0.0 if directions is not None else np.minimum(distance + radius, limit) * level.sine[node]
    return np.asarray((distance <= limit + radius) & (across <= radius + slack + 1e-9 * distance))


def _boxes(x: FloatArray) -> _Boxes:
    """Boxes round facets with corners x (n, 4, 3)."""
    centre = x.mean(axis=1)
    normal = unit(vector_areas(x))
    sides = np.stack([x[:, 1] - x[:, 0] + x[:, 2] - x[:, 3], x[:, 2] - x[:, 1] + x[:, 3] - x[:, 0]], axis=1)
    length = np.einsum("nax,nax->na", sides, sides)
    first = unit(sides[np.arange(len(x)), np.argmax(length, axis=1)])
    first = unit(first - np.einsum("nx,nx->n", first, normal)[:, None] * normal)
    frame = np.stack([first, np.cross(normal, first), normal], axis=1)
    extent = np.abs(np.einsum("nax,njx->nja", frame, x - centre[:, None])).max(axis=1)
    cosine = np.einsum("njx,nx->nj", _corner_directions(x), normal).min(axis=1)
    return _Boxes(centre, frame, extent, cosine)


def _over(points: FloatArray, directions: FloatArray | None, boxes: _Boxes, facet: IntArray, limit: float) -> BoolArray:
    """Is the point over the facet's box, seen along the line?"""
    frame, extent = boxes.frame[facet], boxes.extent[facet]
    offset = np.einsum("nax,nx->na", frame, points - boxes.centre[facet])
    if directions is None:
        cosine = boxes.cosine[facet]
        steep = meets = cosine <= 0.0
        slack = np.sqrt(np.maximum(1.0 - cosine**2, 0.0)) * np.minimum(np.abs(offset[:, 2]) + extent[:, 2], limit)
        slack = slack / np.maximum(cosine, 1e-12)
        at = offset[:, :2]
    else:
        line = np.einsum("nax,nx->na", frame, directions)
        steep = np.abs(line[:, 2]) < STEEP
        slope = line[:, :2] / np.where(steep, 1.0, line[:, 2])[:, None]
        # A line along a flat facet never meets it: the sides of a solid that stands on a plate.
        meets = steep & (extent[:, 2] >= STEEP * extent[:, 0])
        at = offset[:, :2] - offset[:, 2:] * slope
        slack = extent[:, 2] * np.linalg.norm(slope, axis=1)
    bound = MARGIN * extent[:, :2] + slack[:, None] + 1e-9 * np.abs(offset).max(axis=1)[:, None]
    over = (np.abs(at) <= bound).all(axis=1)
    return np.asarray(meets | (over & ~steep))
