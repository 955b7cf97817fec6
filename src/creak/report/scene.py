"""What the 3-D views of the report show: the surface, its marks, and the motion around events, in few bytes."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.recovery import by_node, recovered
from creak.report.palette import PARTS
from creak.report.places import Place, place_of
from creak.report.surface import Surface, surface_of
from creak.report.text import Units, fixed, number
from creak.report.verdict import main_run
from creak.report.view import front, outward
from creak.studies.motion import Motion
from creak.studies.run import Run, StudyResult

MOST_ANIMATIONS = 8
LIMIT = 32767
"""Largest 16-bit number."""
LEFT_OUT = 0.01
"""Share of the largest displacement that the shapes of an animation may leave out anywhere."""


@dataclass(frozen=True)
class Animations:
    """The motions that go into a report, ready for JSON, and what to say about them."""

    shown: list[dict[str, Any]]
    size: int
    """Bytes in the report."""
    words: str
    """How much there is, or why nothing."""
    spans: tuple[tuple[float, float], ...] = ()
    """First and last instant of each, s."""


def scene(result: StudyResult, places: Sequence[Place]) -> tuple[Surface, dict[str, Any]] | None:
    """The surface, and it with its marks ready for JSON; None for a model without anything to draw."""
    model, setup = result.setup.model, result.setup
    driven = [a // 6 for a in (*setup.driven.labels.values(), *setup.loads.force_labels)]
    marks = {
        "contact": np.unique(result.gaps.nodes_idx),
        "held": _nodes([f.nodes_idx for f in model.fixed]),
        "driven": _nodes(driven),
    }
    needed = np.unique(np.concatenate([*marks.values(), *(p.nodes_idx for p in places)])).astype(np.int64)
    surface = surface_of(model, needed)
    xyz = model.nodes.coords
    if surface is None or float(np.ptp(xyz[surface.nodes_idx], axis=0).max()) == 0.0:
        return None
    points, centre, scale = _quantised(xyz[surface.nodes_idx])
    return surface, {
        "points": _text(points), "centre": centre.tolist(), "scale": scale, "count": surface.nodes_idx.size,
        "triangles": _text(surface.triangles.astype(np.uint32)), "edges": _text(surface.edges.astype(np.uint32)),
        "parts": [_part(result, row) for row in surface.parts.tolist()],
        "view": front(xyz, outward(setup.contacts, xyz)).matrix.T.tolist(),
        "marks": {name: surface.rows(nodes).tolist() for name, nodes in marks.items() if nodes.size},
        "places": [_place(p, surface) for p in places],
    }  # fmt: skip


def animations(
    result: StudyResult, surface: Surface | None, places: tuple[Place, ...], units: Units, budget: int
) -> Animations:
    """The motion around as many of the hardest events as fit into `budget` bytes.

    A motion is a sum of as many shapes times amplitudes as leave out `LEFT_OUT` of it (proper orthogonal
    decomposition). Shapes are 16-bit shares of their largest displacement, forces of contact nodes 8-bit shares.
    """
    run = main_run(result)
    recording = None if run is None else run.recording
    if budget <= 0:
        return Animations([], 0, "No animation: the report was asked to hold none (--animation-mb 0).")
    if run is None or recording is None:
        return Animations([], 0, "No animation: the run did not keep the motion around its events (sweeps do not).")
    if surface is None:
        return Animations([], 0, "No animation: the model has no surface or lines to draw.")
    if not recording.motions:
        return Animations([], 0, f"No animation: {recording.why}.")
    moving = np.unique(run.system.labels // 6)
    if not np.isin(surface.nodes_idx, moving).any():
        return Animations([], 0, "No animation: the motion of the parts drawn cannot be recovered from this model.")
    shown: list[tuple[Motion, dict[str, Any], int]] = []
    for motion in recording.motions[:MOST_ANIMATIONS]:
        animation = _animation(run, result, surface, motion, places, units)
        size = len(animation["shapes"]) + len(animation["force"])
        if size + sum(other for _, _, other in shown) > budget:
            break
        shown.append((motion, animation, size))
    shown.sort(key=lambda one: -one[0].event.force_peak_filtered)
    used = sum(size for _, _, size in shown)
    spans = tuple((float(m.time[0]), float(m.time[-1])) for m, _, _ in shown)
    words = _words(len(shown), len(recording.motions), used, budget, surface, moving)
    return Animations([one for _, one, _ in shown], used, words, spans)


def _words(shown: int, events: int, used: int, budget: int, surface: Surface, moving: IntArray) -> str:
    if not shown:
        return (
            f"No animation: that of one event takes more than the {budget / 1e6:.3g} MB that the report may spend on "
            "them (--animation-mb)."
        )
    text = f"{shown} of {events} recorded events, {used / 1e6:.2g} MB of at most {budget / 1e6:.3g} MB"
    if surface.coarsened:
        text += f"; drawn on {number(int(surface.nodes_idx.size))} nodes of the mesh, the others are left out"
    still = int((~np.isin(surface.nodes_idx, moving)).sum())
    if still:
        text += f"; {number(still)} nodes have no recovered motion and are drawn at rest"
    return text + "."


def _animation(
    run: Run, result: StudyResult, surface: Surface, motion: Motion, places: tuple[Place, ...], units: Units
) -> dict[str, Any]:
    u = np.concatenate(list(_frames(run, result.setup.model.nodes.count, surface, motion)))
    largest = float(np.abs(u).max()) or 1.0
    amplitudes, shapes = shapes_of(u.reshape(len(u), -1), LEFT_OUT * largest)
    nodes, force = _forces(run, result, motion)
    peak = float(force.max(initial=0.0))
    place = place_of(places, motion.event)
    where = f"place {place.number}" if place else f"node {result.setup.model.nodes.label(motion.event.node_idx)}"
    hit = f"{number(motion.event.force_peak_filtered, 3)} {units.force} at {fixed(motion.event.t_start, 4)} s"
    return {
        "label": f"{hit}, {where}", "time": np.round(motion.time, 9).tolist(), "largest": largest,
        "amplitudes": amplitudes.tolist(), "shapes": _text(shapes),
        "nodes": surface.rows(nodes).tolist(), "peak": peak,
        "force": _text(np.minimum(np.ceil(force * (255.0 / (peak or 1.0))), 255.0).astype(np.uint8)),
        "touch": motion.event.t_peak,
    }  # fmt: skip


def shapes_of(u: FloatArray, left_out: float) -> tuple[FloatArray, IntArray]:
    """Amplitudes a (k, r) and 16-bit shapes s (r, n) with a s = u (k, n) but for `left_out` anywhere, and rounding.

    The shapes are those of the proper orthogonal decomposition, from the eigenvectors of u u' (Sirovich, Q. Appl. Math.
    45, 1987); r is as small as that allows.
    """
    vectors = np.linalg.eigh(u @ u.T)[1][:, ::-1]
    left = u.copy()
    amplitudes: list[FloatArray] = []
    shapes: list[IntArray] = []
    for v in vectors.T:
        if np.abs(left).max(initial=0.0) <= left_out and shapes:
            break
        shape = v @ u
        largest = float(np.abs(shape).max(initial=0.0)) or 1.0
        shapes.append(np.round(shape * (LIMIT / largest)).astype(np.int16))
        amplitudes.append(v * (largest / LIMIT))
        left -= np.outer(v, shape)
    return np.column_stack(amplitudes), np.stack(shapes)


def _frames(run: Run, n_node: int, surface: Surface, motion: Motion) -> Iterator[FloatArray]:
    """(k, n, 3) motion of the nodes drawn, some instants at a time."""
    for _, u in recovered(run.system, motion.coordinates, motion.supports, block=16):
        yield by_node(u, run.system.labels, n_node)[:, surface.nodes_idx]


def _forces(run: Run, result: StudyResult, motion: Motion) -> tuple[IntArray, FloatArray]:
    """Nodes that press in an animation, and the largest force of each (k, n) around each instant."""
    h, ends = run.history, motion.time
    middle = 0.5 * (ends[1:] + ends[:-1])
    at = np.concatenate([[ends[0]], middle, [ends[-1]]])
    rows = np.searchsorted(h.time, at + 1e-12)
    rows[-1] += 1
    part = h.force[rows[0] : rows[-1]]
    active = np.flatnonzero((part > 0.0).any(axis=0))
    nodes, column = np.unique(result.gaps.nodes_idx[active], return_inverse=True)
    force = np.zeros((ends.size, nodes.size))
    for k in range(ends.size):
        here = h.force[rows[k] : max(rows[k + 1], rows[k] + 1), :][:, active].max(axis=0, initial=0.0)
        np.maximum.at(force[k], column, here)
    return nodes, force


def _part(result: StudyResult, row: list[int]) -> dict[str, Any]:
    model = result.setup.model
    name = model.parts[row[0]].name if row[0] >= 0 else "beams, springs, others"
    colour = PARTS[row[0] % len(PARTS)] if row[0] >= 0 else "#8a939c"
    return {"name": name, "colour": colour, "triangles": row[1:3], "edges": row[3:5]}


def _place(place: Place, surface: Surface) -> dict[str, Any]:
    return {
        "number": place.number, "contact": place.contact,
        "at": int(surface.rows(np.array([place.node_idx]))[0]), "nodes": surface.rows(place.nodes_idx).tolist(),
    }  # fmt: skip


def _quantised(xyz: FloatArray) -> tuple[IntArray, FloatArray, float]:
    """Points as 16-bit numbers: centre + scale * number."""
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    centre, scale = 0.5 * (low + high), float((high - low).max()) / (2 * LIMIT)
    return np.round((xyz - centre) / scale).astype(np.int16), centre, scale


def _text(values: Any) -> str:
    """Little-endian bytes as base64."""
    little = np.ascontiguousarray(values).astype(np.asarray(values).dtype.newbyteorder("<"))
    return base64.b64encode(little.tobytes()).decode("ascii")


def _nodes(rows: list[IntArray]) -> IntArray:
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *rows]))
