"""Measured points over the shapes of the model, for the 3-D view."""

from __future__ import annotations

from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.report.figures.motions import LIMIT
from creak.report.figures.scene import drawn_surface, part_of, period
from creak.report.figures.surface import Surface, surface_of
from creak.report.figures.view import front
from creak.studies.models.correlation import Correlation
from creak.verify.mode_fit import ModePair

MOST_NODES = 8000
"""Of the model that are drawn: each pair takes 8 bytes for each."""
MOST_PAIRS = 40
LINES, BESIDE = "lines of the test", "the test beside the model"
APART = 1.15
"""Of the model's width: how far to the right the test is drawn once more."""
COLOUR = "#d55e00"


def correlated_scene(found: Correlation) -> tuple[dict[str, Any] | None, list[dict[str, Any]]]:
    """The surface of the model with the measured points behind its nodes, these once more beside it, and a period of
    each pair of modes.

    A measured point has the smallest motion that gives what its directions measured, in the scale and the sign that
    fit the mode of the model best. None where the model has nothing that can be drawn.
    """
    model = found.found.model
    surface = surface_of(model, np.zeros(0, dtype=np.int64), MOST_NODES)
    if surface is None:
        return None, []
    names, first = np.unique(found.measured.sensors, return_index=True)
    row_of = {str(name): len(surface.nodes_idx) + k for k, name in enumerate(names)}
    of = np.array([row_of[name] for name in found.measured.sensors])
    xyz = np.concatenate([model.nodes.coords[surface.nodes_idx], found.sensors.points[first]])
    ids = np.concatenate([model.nodes.ids[surface.nodes_idx], model.nodes.ids[found.sensors.nodes_idx[first]]])
    view = front(model.nodes.coords, np.zeros(3)).matrix
    right = APART * float(np.ptp(model.nodes.coords @ view[:, 0])) * view[:, 0]
    xyz, ids = np.concatenate([xyz, found.sensors.points[first] + right]), np.concatenate([ids, ids[-names.size :]])
    joined = [(row_of[a], row_of[b]) for a, b in found.measured.lines if a in row_of and b in row_of]
    lines = np.array(joined, dtype=np.int64).reshape(-1, 2)
    edges = np.concatenate([surface.edges, lines, lines + names.size])
    parts = [part_of(model, row) for row in surface.parts.tolist()]
    for k, name in enumerate((LINES, BESIDE) if joined else ()):
        ends, drawn = [len(surface.triangles), 0], [len(surface.edges) + k * len(joined), len(joined)]
        parts.append({"name": name, "colour": COLOUR, "triangles": ends, "edges": drawn})
    shape = {
        **drawn_surface(xyz, ids, surface.triangles, edges),
        "parts": parts,
        "view": view.T.tolist(),
        "marks": {"measured": [*row_of.values(), *(row + names.size for row in row_of.values())]},
        "places": [],
        "impulse": None,
    }
    return shape, _motions(found, surface, xyz, of)


def _motions(found: Correlation, surface: Surface, xyz: FloatArray, of: IntArray) -> list[dict[str, Any]]:
    shown: dict[int, ModePair] = {p.model: p for p in found.pairs[:MOST_PAIRS]}
    made = {}
    for k, u in enumerate(found.found.translations()):
        if k in shown:
            p = shown[k]
            moved = np.zeros((len(xyz), 3))
            moved[: len(surface.nodes_idx)] = u[surface.nodes_idx]
            along = p.scale * found.test_shapes[:, p.test]
            for row in np.unique(of):
                own = np.linalg.pinv(found.measured.directions[of == row]) @ along[of == row]
                moved[[row, row + len(np.unique(of))]] = own
            largest = float(np.abs(moved).max()) or 1.0
            label = f"{p.frequency_test:g} Hz measured, {p.frequency_model:.6g} Hz in the model, MAC {p.mac:.3f}"
            short = np.round(moved.ravel() * (LIMIT / largest)).astype(np.int16)
            made[k] = period(label, p.frequency_test, short, xyz)
    return [made[p.model] for p in found.pairs[:MOST_PAIRS]]
