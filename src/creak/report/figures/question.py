"""A small picture of two parts that may touch: where they come near each other, and a section through the place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.model.mesh import Model, Nodes
from creak.model.plain_mesh import PlainMesh
from creak.report.figures.palette import CONTACT, INK, PARTS
from creak.report.figures.picture import Marks, Panel, panels_picture
from creak.report.figures.view import Facets, View, facets_of, front, three_quarter
from creak.studies.propose.opposite import Skin, skin_of

CLOSE = 4.0
"""The section reaches this many times the thickness and the gap to either side, and shows a good part of a facet."""
OUTLINE = 0.012
"""Of that reach: width of the line that a face of a solid is drawn as."""
ASIDE = 0.2
"""Of a facet: how far the section lies beside the place, so that it does not run along the edges of elements."""


def question_picture(
    model: Model, parts: tuple[str, str], nodes: Sequence[int], at: FloatArray, toward: FloatArray, gap: float
) -> bytes:
    """PNG of two parts from three-quarters, and of a section where they are nearest, shells as thick as they are.

    Parameters
    ----------
    nodes : rows of the near nodes, which are marked.
    at : (3,) where they are nearest, length.
    toward : (3,) direction from one part to the other there, of unit length.
    gap : between the surfaces there, length.
    """
    every = facets_of(model)
    index = [next(i for i, p in enumerate(model.parts) if p.name == name) for name in parts]
    mine = np.isin(every.part, index)
    facets = Facets(every.nodes_idx[mine], (every.part[mine] == index[1]).astype(np.int64))
    coords, rows = model.nodes.coords, np.array(nodes, dtype=np.int64)
    nearest = rows[[int(np.linalg.norm(coords[rows] - at, axis=1).argmin())]]
    marks = [Marks("near", rows, CONTACT, "o", 9.0), Marks("nearest", nearest, INK, "D", 34.0)]
    view = three_quarter(front(coords[np.unique(facets.nodes_idx)], toward))
    legend = list(zip(PARTS, parts, strict=False))
    section = _section(model, index, coords[rows], at, toward, gap)
    return panels_picture([Panel("both parts", model, facets, PARTS, view, marks), section], legend)


def _section(
    model: Model, index: Sequence[int], near: FloatArray, at: FloatArray, toward: FloatArray, gap: float
) -> Panel:
    """The plane through the place across the line of the near nodes."""
    coords, skins = model.nodes.coords, [skin_of(model, i) for i in index]
    size = min(float(np.linalg.norm(np.ptp(coords[s.facets], axis=1), axis=1).mean()) for s in skins)
    view = _along(near, toward)
    line = view.matrix[:, 2]
    inward = float(np.sign((near.mean(axis=0) - at) @ line)) or 1.0
    middle = at + ASIDE * size * inward * line
    reach = max(CLOSE * (abs(gap) + 2.0 * max(float(s.half.max(initial=0.0)) for s in skins)), 0.6 * size)
    pieces = [_cut(coords, s, middle, line, OUTLINE * reach) for s in skins]
    pieces[1] = pieces[1] + reach * line  # painted over the first, where they overlap
    part = np.repeat([0, 1], [len(p) for p in pieces])
    points = np.concatenate(pieces).reshape(-1, 3)
    drawn = PlainMesh(Nodes(np.arange(1, 1 + len(points)), points), (), ())
    place = view.flat(at[None])[0]
    window = np.array([place - [1.4 * reach, reach], place + [1.4 * reach, reach]])
    facets = Facets(np.arange(len(points), dtype=np.int64).reshape(-1, 4), part)
    words = f"section there, {gap:.3g} apart" if gap >= 0.0 else f"section there, {-gap:.3g} inside each other"
    return Panel(words, drawn, facets, PARTS, view, (), window)


def _along(near: FloatArray, toward: FloatArray) -> View:
    """A look along the near nodes, the direction between the parts upright."""
    spread = near - near.mean(axis=0)
    line = np.linalg.svd(spread - np.outer(spread @ toward, toward), full_matrices=False)[2][0]
    line = line - (line @ toward) * toward
    if np.linalg.norm(line) < 0.5:
        line = np.cross(toward, np.eye(3)[np.argmin(np.abs(toward))])
    line /= np.linalg.norm(line)
    up = toward if toward[np.abs(toward).argmax()] > 0.0 else -toward
    return View(np.column_stack([np.cross(up, line), up, line]))


def _cut(coords: FloatArray, skin: Skin, middle: FloatArray, line: FloatArray, width: float) -> FloatArray:
    """(n, 4, 3) where a plane cuts the facets: strips as thick as the shells, lines of the faces of solids."""
    x = coords[skin.facets]
    s = (x - middle) @ line
    after, s_after = np.roll(x, -1, axis=1), np.roll(s, -1, axis=1)
    crosses = (s > 0.0) != (s_after > 0.0)
    rows = np.flatnonzero(crosses.sum(axis=1) == 2)
    share = s / np.where(crosses, s - s_after, 1.0)
    met = (x + share[:, :, None] * (after - x))[rows][crosses[rows]].reshape(-1, 2, 3)
    across = np.cross(line, met[:, 1] - met[:, 0])
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
    offset = np.maximum(skin.half[rows], 0.5 * width)[:, None] * across
    return np.stack([met[:, 0] + offset, met[:, 1] + offset, met[:, 1] - offset, met[:, 0] - offset], axis=1)
