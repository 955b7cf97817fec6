"""Mesh of the frame: lower body with aperture, window posts, mirror triangle and returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak_thesis.arrays import FloatArray
from creak_thesis.door import geometry as geo
from creak_thesis.door.geometry import Outline, loop, loop_fraction
from creak_thesis.door.mesh import Grid, PartMesh, coarsen_band, divisions, glue, kept_columns, spread, structured_quads

WALL = ((0.0, 0.0), (4.0, 44.0), (15.0, 46.0), (20.0, 100.0), (34.0, 100.0))
"""Section of the outer return: (outwards, depth) of its folds, mm; the last piece is the hem."""
RETURN = ((0.0, 0.0), (3.0, 30.0), (15.0, 30.0))
"""Section of the return around the window opening: (towards the opening, depth), mm."""


@dataclass(frozen=True)
class Spacing:
    """Fractions along the sides of the frame at which there are nodes."""

    bottom: FloatArray
    rear: FloatArray
    belt: FloatArray
    front: FloatArray
    rear_post: FloatArray
    header: FloatArray
    front_post: FloatArray
    across_post: FloatArray
    n_sail: int
    sill: FloatArray
    opening_post: FloatArray


def spacing(mesh_size: float) -> Spacing:
    """Place the nodes along the sides of the frame."""
    window, belt_length = geo.WINDOW, geo.BODY.length(2)
    rear_belt = geo.BODY.corners[2]
    stops = [np.linalg.norm(p - rear_belt) / belt_length for p in (window.corners[1], geo.SAIL_SILL, window.corners[0])]
    n_foot = divisions(100.0, mesh_size, 3)
    n_sail = divisions(175.0, mesh_size, 3)
    n_sill = divisions(float(stops[1] - stops[0]) * belt_length, mesh_size)
    post_length = window.length(3)
    n_post = divisions(float(np.linalg.norm(geo.SAIL_POST - window.corners[3])), mesh_size)
    split = 1.0 - float(np.linalg.norm(geo.SAIL_POST - window.corners[0])) / post_length

    def even(outline: Outline, side: int) -> FloatArray:
        return np.linspace(0.0, 1.0, divisions(outline.length(side), mesh_size) + 1)

    return Spacing(
        bottom=even(geo.BODY, 0),
        rear=even(geo.BODY, 1),
        belt=spread([0.0, *map(float, stops), 1.0], [n_foot, n_sill, n_sail, n_foot]),
        front=even(geo.BODY, 3),
        rear_post=even(geo.PERIMETER, 2),
        header=even(geo.PERIMETER, 3),
        front_post=spread([0.0, split, 1.0], [n_post, n_sail]),
        across_post=np.linspace(0.0, 1.0, n_foot + 1),
        n_sail=n_sail,
        sill=np.linspace(0.0, 1.0, n_sill + 1),
        opening_post=np.linspace(0.0, 1.0, n_post + 1),
    )


def frame_mesh(mesh_size: float, coarsen: int = 1) -> PartMesh:
    """Mesh the frame; its normals point into the cabin (+y on the faces).

    coarsen : number of elements of the flange merged into one along the contact line.
    """
    s = spacing(mesh_size)
    around = [s.bottom, s.rear, s.rear_post, s.header, s.front_post, s.front]
    opening = [s.sill, s.rear_post, s.header, s.opening_post, np.linspace(0.0, 1.0, s.n_sail + 1)]
    outer = _fold(geo.PERIMETER, around, [(-o, d) for o, d in WALL], mesh_size, beads=True)
    inner = _fold(geo.OPENING, opening, list(RETURN), mesh_size, beads=False)
    frame = glue("FRAME", [_body(s, mesh_size), _posts(s), _sail(s.n_sail), outer, inner])
    if coarsen == 1:
        return frame
    n_rim, n_flange, _ = body_rows(mesh_size)
    lines = frame.nodes["FLANGE_LINES"].reshape(n_rim + n_flange + 1, -1)
    return coarsen_band(frame, "FRAME_FLANGE", lines, kept_columns(flange_segments(s), coarsen))


def flange_segments(s: Spacing) -> list[int]:
    """Number of elements along each piece of the flange: bottom, rear, four pieces of the belt, front."""
    foot = s.across_post.size - 1
    return [s.bottom.size - 1, s.rear.size - 1, foot, s.sill.size - 1, s.n_sail, foot, s.front.size - 1]


def body_rows(mesh_size: float) -> tuple[int, int, int]:
    """Rows of elements outside the panel's edge line, over the rest of the flange, and inside it."""
    rest = geo.FLANGE_WIDTH - geo.EDGE_INSET
    return divisions(geo.EDGE_INSET, mesh_size), divisions(rest, mesh_size), divisions(205.0, mesh_size)


def _body(s: Spacing, mesh_size: float) -> Grid:
    """Ring between the outline of the lower body and the aperture, rows parallel to the outline."""
    fractions = [s.bottom, s.rear, s.belt, s.front]
    n_rim, n_flange, n_ring = body_rows(mesh_size)
    insets = spread([0.0, geo.EDGE_INSET, geo.FLANGE_WIDTH], [n_rim, n_flange])
    along = loop_fraction(geo.BODY, fractions)
    flange = [loop(geo.BODY.offset(float(d)), fractions) for d in insets]
    across = np.linspace(0.0, 1.0, n_ring + 1)[1:, None]
    rim = loop(geo.APERTURE, fractions)
    ring = flange[-1] + across[:, :, None] * (rim - flange[-1])
    relief = geo.body_relief(across, along[None, :])
    coords = np.concatenate([geo.lift(np.array(flange), 0.0), geo.lift(ring, relief)])
    n_rows, n = n_rim + n_flange + n_ring + 1, along.size
    quads = structured_quads(n_rows, n, closed=True, flip=True)
    tag = np.arange(quads.shape[0]) < (n_rim + n_flange) * n
    lines = np.arange((n_rim + n_flange + 1) * n)
    return Grid(coords, quads, tags={"FRAME_FLANGE": tag}, nodes={"FLANGE_LINES": lines})


def _posts(s: Spacing) -> Grid:
    """Strip from the rear belt corner over the header to the front belt corner."""
    sides = list(zip((2, 3, 4), (1, 2, 3), (s.rear_post, s.header, s.front_post), strict=True))
    outer = np.concatenate([geo.PERIMETER.point(k, u[1 if i else 0 :]) for i, (k, _, u) in enumerate(sides)])
    inner = np.concatenate([geo.WINDOW.point(k, u[1 if i else 0 :]) for i, (_, k, u) in enumerate(sides)])
    across = s.across_post[:, None, None]
    xz = outer + across * (inner - outer)
    coords = geo.lift(xz, geo.post_relief(across[:, :, 0], xz[..., 1]))
    return Grid(coords, structured_quads(across.size, outer.shape[0], closed=False, flip=True))


def _sail(n: int) -> Grid:
    """Mirror triangle between belt and front post: quads, and triangles along its free edge."""
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    inside = i + j <= n
    row = np.full((n + 1, n + 1), -1, dtype=np.int64)
    row[inside] = np.arange(int(inside.sum()))
    a, b = i[inside][:, None] / n, j[inside][:, None] / n
    corner = geo.WINDOW.corners[0]
    xz = corner + a * (geo.SAIL_SILL - corner) + b * (geo.SAIL_POST - corner)
    bulge = 27 * 8.0 * (a * b * (1 - a - b))[:, 0]
    p, q = i[i + j <= n - 2], j[i + j <= n - 2]
    quads = np.stack([row[p, q], row[p, q + 1], row[p + 1, q + 1], row[p + 1, q]], axis=1)
    p = np.arange(n)
    q = n - 1 - p
    tris = np.stack([row[p, q], row[p, q + 1], row[p + 1, q]], axis=1)
    return Grid(geo.lift(xz, bulge), quads, tris)


def _fold(
    outline: Outline,
    fractions: list[FloatArray],
    section: list[tuple[float, float]],
    mesh_size: float,
    *,
    beads: bool,
) -> Grid:
    """Sheet folded back (-y) along a closed outline, rows from the fold to the free edge."""
    inset, depth, share = fold_rows(section, mesh_size)
    top = loop(outline, fractions)
    along = loop_fraction(outline, fractions)
    height = geo.base(top[:, 0], top[:, 1])
    rows = []
    for d, deep, t in zip(inset, depth, share, strict=True):
        swell = geo.wall_bead(np.array(t), along) if beads else np.zeros_like(along)
        near, far = loop(outline.offset(float(d)), fractions), loop(outline.offset(float(d) - 1.0), fractions)
        xz = near + swell[:, None] * (far - near)
        rows.append(np.stack([geo.bow(xz[:, 0], xz[:, 1]), height - deep, xz[:, 1]], axis=1))
    quads = structured_quads(len(rows), top.shape[0], closed=True, flip=section[-1][0] > 0)
    return Grid(np.concatenate(rows), quads)


def fold_rows(section: list[tuple[float, float]], mesh_size: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Inset, depth and share of the wall (0..1 up to the hem, then 1) of every row of a return."""
    knots = np.array(section)
    lengths = np.linalg.norm(np.diff(knots, axis=0), axis=1)
    counts = [divisions(float(n), mesh_size) for n in lengths]
    index = spread([float(k) for k in range(len(section))], counts)
    at = np.arange(len(section))
    inset, depth = np.interp(index, at, knots[:, 0]), np.interp(index, at, knots[:, 1])
    return inset, depth, np.clip(index / (len(section) - 2), 0.0, 1.0)
