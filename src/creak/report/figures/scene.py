"""What the 3-D views of the report show: the surface, its marks, and the motion around events, in few bytes."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.plain_mesh import Mesh
from creak.model.units import Units
from creak.report.drawn import LIMIT, Drawn, Motions, ShortArray, ShownMotion
from creak.report.figures.axes import INSTANT, plain
from creak.report.figures.palette import PARTS, shares
from creak.report.figures.view import Surface, front, outward
from creak.report.words.text import fixed, number
from creak.studies.findings.places import Place, place_of
from creak.studies.findings.tree import Findings, FoundRun
from creak.verify.events import counted_instants

MODE_SIZE, MODE_FRAMES = 0.05, 24
"""Largest displacement of a mode over the size of the model, and frames of its period."""


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
    modes: tuple[dict[str, Any], ...] = ()
    """A period of each mode shape, as `shown`."""


def scene(result: Findings, drawn: Drawn) -> dict[str, Any] | None:
    """The surface with its marks, ready for JSON; None for a model without anything to draw."""
    surface, setup = drawn.surface, result.setup
    if surface is None:
        return None
    marks = {"contact": np.unique(result.gaps.nodes_idx), "held": setup.held, "driven": setup.driven}
    nodes = setup.model.nodes
    return {
        **drawn_surface(
            nodes.coords[surface.nodes_idx], nodes.ids[surface.nodes_idx], surface.triangles, surface.edges
        ),
        "parts": [part_of(setup.model, row) for row in surface.parts.tolist()],
        "view": front(nodes.coords, outward(setup.contacts, nodes.coords)).matrix.T.tolist(),
        "marks": {name: surface.rows(nodes).tolist() for name, nodes in marks.items() if nodes.size},
        "places": [_place(p, surface) for p in result.places],
        "impulse": _impulses(result, surface),
    }


def drawn_surface(xyz: FloatArray, ids: IntArray, triangles: IntArray, edges: IntArray) -> dict[str, Any]:
    """Points (n, 3) with their labels, and the triangles and edges on them, as the viewer takes them."""
    # Points as 16-bit numbers: centre + scale * number.
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    centre, scale = 0.5 * (low + high), float((high - low).max()) / (2 * LIMIT)
    points = np.round((xyz - centre) / scale).astype(np.int16)
    return {
        "points": _text(points),
        "centre": centre.tolist(),
        "scale": scale,
        "count": len(xyz),
        "ids": _text(ids.astype(np.int32)),
        "triangles": _text(triangles.astype(np.uint32)),
        "edges": _text(edges.astype(np.uint32)),
    }


def animations(result: Findings, drawn: Drawn, units: Units) -> Animations:
    """The motions around the hardest events, as many as fit into the bytes that they may take.

    Forces of contact nodes are 8-bit shares of the largest one.
    """
    run, surface, motions, modes = result.main, drawn.surface, drawn.motions, _modes(result, drawn)
    if run is None or surface is None or motions.why:
        return Animations([], 0, f"No motion around an event: {motions.why}.", modes=modes)
    shown: list[tuple[ShownMotion, dict[str, Any], int]] = []
    for motion in motions.shown:
        animation = _animation(run, result, surface, motion, units)
        size = len(animation["shapes"]) + len(animation["force"])
        if size + sum(other for _, _, other in shown) > motions.budget:
            break
        shown.append((motion, animation, size))
    shown.sort(key=lambda one: -one[0].event.force_place)
    used = sum(size for _, _, size in shown)
    spans = tuple((float(m.time[0]), float(m.time[-1])) for m, _, _ in shown)
    words = _words(len(shown), motions, used, surface)
    return Animations([one for _, one, _ in shown], used, words, spans, modes)


def _modes(result: Findings, drawn: Drawn) -> tuple[dict[str, Any], ...]:
    """One period of each mode, its largest displacement a share of the model's size."""
    found, surface = drawn.mode_shapes, drawn.surface
    if found is None or surface is None:
        return ()
    xyz = result.setup.model.nodes.coords[surface.nodes_idx]
    return tuple(
        period(f"mode {k} of the unreduced model, {number(float(f), 4)} Hz", float(f), shape, xyz)
        for k, (f, shape) in enumerate(zip(found.frequency, found.shapes, strict=True), start=1)
    )


def period(label: str, frequency: float, shape: ShortArray, xyz: FloatArray) -> dict[str, Any]:
    """A period of a mode, its largest displacement a share of the size of what is drawn.

    Parameters
    ----------
    shape : (3 n,) x, y, z of each point in turn, 16-bit shares of the largest. xyz : (n, 3)
    """
    largest = MODE_SIZE * float(np.ptp(xyz, axis=0).max())
    phase = np.arange(MODE_FRAMES + 1) / MODE_FRAMES
    return {
        "label": label,
        "mode": True,
        "time": (phase / frequency).tolist(),
        "largest": largest,
        "amplitudes": (np.cos(2.0 * np.pi * phase)[:, None] * (largest / LIMIT)).tolist(),
        "shapes": _text(shape),
        "nodes": [],
        "peak": 0.0,
        "force": "",
        "touch": 0.0,
    }


def _words(shown: int, motions: Motions, used: int, surface: Surface) -> str:
    budget = f"{motions.budget / 1e6:.3g} MB"
    if not shown:
        return (
            f"No animation: that of one event takes more than the {budget} that the report may spend on them "
            "(--animation-mb)."
        )
    text = f"{shown} of {motions.recorded} recorded events, {used / 1e6:.2g} MB of at most {budget}"
    if surface.coarsened:
        text += f"; drawn on {number(int(surface.nodes_idx.size))} nodes of the mesh, the others are left out"
    if motions.still:
        text += f"; {number(motions.still)} nodes have no recovered motion and are drawn at rest"
    return text + "."


def _animation(run: FoundRun, result: Findings, surface: Surface, motion: ShownMotion, units: Units) -> dict[str, Any]:
    nodes, force = _forces(run, result, motion)
    peak = float(force.max(initial=0.0))
    place = place_of(result.places, motion.event)
    where = f"place {place.number}" if place else f"node {result.setup.model.nodes.label(motion.event.node_idx)}"
    hit = f"{number(motion.event.force_place, 3)} {units.force} at {fixed(motion.event.t_start, 4)} s"
    return {
        "label": f"{hit}, {where}",
        "time": plain(motion.time, INSTANT),
        "largest": motion.largest,
        "amplitudes": motion.amplitudes.tolist(),
        "shapes": _text(motion.shapes),
        "nodes": surface.rows(nodes).tolist(),
        "peak": peak,
        "force": _text(shares(force)),
        "touch": motion.event.t_peak,
    }


def _forces(run: FoundRun, result: Findings, motion: ShownMotion) -> tuple[IntArray, FloatArray]:
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


def node_impulses(result: Findings, run: FoundRun, window: tuple[float, float]) -> tuple[IntArray, FloatArray]:
    """Contact nodes, and the impulse of each in a window."""
    h = run.history
    inside = counted_instants(h.time, run.events, window)
    nodes, row = np.unique(result.gaps.nodes_idx, return_inverse=True)
    return nodes, np.bincount(row.ravel(), (h.weights * inside) @ h.force, minlength=nodes.size).astype(np.float64)


def _impulses(result: Findings, surface: Surface) -> dict[str, Any] | None:
    """Impulse of the contact nodes of the main run in the window, 8-bit shares of the largest; None: none has any."""
    run = result.main
    if run is None:
        return None
    nodes, sums = node_impulses(result, run, result.window)
    pressed = np.flatnonzero(sums > 0.0)
    if not pressed.size:
        return None
    return {
        "nodes": surface.rows(nodes[pressed]).tolist(),
        "shares": _text(shares(sums[pressed])),
        "values": plain(sums[pressed]),
        "largest": float(sums[pressed].max()),
    }


def part_of(model: Mesh, row: list[int]) -> dict[str, Any]:
    """Name and colour of a row of `Surface.parts`, and what it draws."""
    name = model.parts[row[0]].name if row[0] >= 0 else "beams, springs, others"
    colour = PARTS[row[0] % len(PARTS)] if row[0] >= 0 else "#8a939c"
    return {"name": name, "colour": colour, "triangles": row[1:3], "edges": row[3:5]}


def _place(place: Place, surface: Surface) -> dict[str, Any]:
    return {
        "number": place.number,
        "contact": place.contact,
        "at": int(surface.rows(np.array([place.node_idx]))[0]),
        "nodes": surface.rows(place.nodes_idx).tolist(),
    }


def _text(values: Any) -> str:
    """Little-endian bytes as base64."""
    little = np.ascontiguousarray(values).astype(np.asarray(values).dtype.newbyteorder("<"))
    return base64.b64encode(little.tobytes()).decode("ascii")
