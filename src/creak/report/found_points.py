"""Where lines and places of a run are, and what was found there, as points for ParaView."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.report.figures.scene import node_impulses
from creak.studies.findings.elines import point_columns
from creak.studies.findings.summary import summary_of
from creak.studies.findings.tree import Findings

OF_PLACE = ("events", "force", "impulse", "n5", "n_max", "level")
"""Figures of a place in summary.json."""


def found_points(found: Findings) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Coordinates (p, 3) and figures (p,): points of the E-lines first, then contact nodes that are on none.

    `node` is the label of the deck, `eline` the row of its line (-1: none) with the columns of the page's CSV; `place`
    the number of the place (0: none) with its figures; `impulse` that of the node over the run. What is not known of a
    point is nan.
    """
    lines, nodes = found.elines, found.setup.model.nodes
    on_lines = np.zeros(0, dtype=np.int64) if lines is None else lines.nodes_idx
    others = np.setdiff1d(found.gaps.nodes_idx, on_lines)
    rows = np.concatenate([on_lines, others])
    arrays = {"node": nodes.ids[rows].astype(np.float64), "eline": np.full(rows.size, -1.0)}
    if lines is not None:
        count = on_lines.size
        arrays["eline"][:count] = lines.line_of
        own = {"gap": lines.gap0, "tolerance": lines.tolerance, **point_columns(lines)}
        arrays |= {name: np.concatenate([x, np.full(others.size, np.nan)]) for name, x in own.items()}
    return nodes.coords[rows], arrays | _of_places(found, rows)


def _of_places(found: Findings, rows: np.ndarray) -> dict[str, FloatArray]:
    run, number = found.main, np.zeros(rows.size)
    arrays = {f"place_{name}": np.full(rows.size, np.nan) for name in OF_PLACE}
    if run is None:
        return {"place": number}
    told = summary_of(found)["runs"][run.name]["places"]
    for place, figures in zip(found.places, told, strict=True):
        here = np.isin(rows, place.nodes_idx)
        number[here] = place.number
        for name in OF_PLACE:
            arrays[f"place_{name}"][here] = np.nan if figures[name] is None else figures[name]
    nodes, sums = node_impulses(found, run, (-np.inf, np.inf))
    at = np.minimum(np.searchsorted(nodes, rows), max(nodes.size - 1, 0))
    known = nodes[at] == rows if nodes.size else np.zeros(rows.size, dtype=bool)
    impulse = np.where(known, sums[at] if nodes.size else 0.0, np.nan)
    return {"place": number, **arrays, "impulse": impulse}
