"""What a page draws of model and motion, as few shapes times amplitudes: made from a result, stored in results.h5, read
back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import h5py
import numpy as np
from numpy.typing import NDArray

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System, by_node, recovered
from creak.formats.stored.tree import read_tree, write_tree
from creak.linalg.modes import Modes
from creak.model.dofs import nodes_of
from creak.report.figures.view import Surface, surface_of
from creak.studies.findings.tree import Findings
from creak.studies.models.reference import ReferenceModel
from creak.studies.run.motion import Motion
from creak.studies.run.one_run import Run
from creak.verify.events import Event

MOST_ANIMATIONS = 8
LIMIT = 32767
"""Largest 16-bit number."""
MOST_MODES, MODE_BYTES = 8, 2_000_000
"""Mode shapes of a report, and characters that they may take."""
RIGID = 1e-4
"""Of the highest frequency computed, below which a mode is rigid motion."""
LEFT_OUT = 0.01
"""Share of the largest displacement that the shapes of an animation may leave out anywhere."""
ShortArray = NDArray[np.int16]


@dataclass(frozen=True)
class ShownMotion:
    """The motion around one event: amplitudes @ shapes."""

    event: Event
    time: FloatArray
    """(k,) s"""
    largest: float
    """Largest component of a displacement, length."""
    amplitudes: FloatArray
    """(k, r)"""
    shapes: ShortArray
    """(r, 3 n) x, y, z of each node of the surface in turn."""


@dataclass(frozen=True)
class Motions:
    """The hardest events first, as many as may fit into the report."""

    shown: tuple[ShownMotion, ...]
    recorded: int
    """Events that the run has recorded."""
    budget: int
    """Bytes that they may take of the report."""
    still: int
    """Nodes of the surface without recovered motion."""
    why: str = ""
    """Why there are none."""


def recorded_motions(run: Run | None, n_node: int, surface: Surface | None, budget: int) -> Motions:
    """The motion around as many of the hardest events as `budget` bytes of a report may hold.

    A motion is a sum of as many shapes times amplitudes as leave out `LEFT_OUT` of it (proper orthogonal
    decomposition). Shapes are 16-bit shares of their largest displacement.
    """
    recording = None if run is None else run.recording
    if budget <= 0:
        return _none("the report was asked to hold none (--animation-mb 0)")
    if run is None or recording is None:
        return _none("the run did not keep the motion around its events (sweeps do not)")
    if surface is None:
        return _none("the model has no surface or lines to draw")
    if not recording.motions:
        return _none(recording.why)
    still = int((~np.isin(surface.nodes_idx, np.unique(nodes_of(run.system.labels)))).sum())
    if still == surface.nodes_idx.size:
        return _none("the motion of the parts drawn cannot be recovered from this model")
    shown: list[ShownMotion] = []
    left = budget
    for motion in recording.motions[:MOST_ANIMATIONS]:
        u = np.concatenate(list(_frames(run, n_node, surface.nodes_idx, motion)))
        largest = float(np.abs(u).max()) or 1.0
        amplitudes, shapes = shapes_of(u.reshape(len(u), -1), LEFT_OUT * largest)
        one = ShownMotion(motion.event, motion.time, largest, amplitudes, shapes)
        left -= base64_size(one.shapes.nbytes)
        if left < 0:
            break
        shown.append(one)
    return Motions(tuple(shown), len(recording.motions), budget, still)


@dataclass(frozen=True)
class ModeShapes:
    """The first elastic modes of the unreduced model on the nodes that are drawn."""

    frequency: FloatArray
    """(k,) Hz"""
    shapes: ShortArray
    """(k, 3 n) x, y, z of each node of the surface in turn, 16-bit shares of the largest."""


def mode_shapes(system: System, modes: Modes, n_node: int, surface: Surface | None) -> ModeShapes | None:
    """As many as `MOST_MODES`, and as fit into `MODE_BYTES` of a report; None: there are none, or nothing is drawn."""
    if surface is None:
        return None
    elastic = np.flatnonzero(modes.frequencies > RIGID * modes.frequencies.max(initial=0.0))
    most = min(MOST_MODES, MODE_BYTES // base64_size(6 * surface.nodes_idx.size))
    chosen = elastic[:most]
    if not chosen.size:
        return None
    still = np.zeros((system.supports.count, chosen.size))
    u = [
        by_node(x, system.labels, n_node)[:, surface.nodes_idx]
        for _, x in recovered(system, np.asarray(modes.shapes[:, chosen]), still, block=4)
    ]
    flat = np.concatenate(u).reshape(chosen.size, -1)
    largest = np.abs(flat).max(axis=1, keepdims=True)
    shapes = np.round(flat * (LIMIT / np.where(largest > 0.0, largest, 1.0))).astype(np.int16)
    return ModeShapes(modes.frequencies[chosen], shapes)


def base64_size(size: int) -> int:
    """Characters that so many bytes take as base64."""
    return 4 * -(-size // 3)


def _none(why: str) -> Motions:
    return Motions((), 0, 0, 0, why)


def _frames(run: Run, n_node: int, nodes_idx: IntArray, motion: Motion) -> Iterator[FloatArray]:
    """(k, n, 3) motion of the nodes drawn, some instants at a time."""
    for _, u in recovered(run.system, motion.coordinates, motion.supports, block=16):
        yield by_node(u, run.system.labels, n_node)[:, nodes_idx]


def shapes_of(u: FloatArray, left_out: float) -> tuple[FloatArray, ShortArray]:
    """Amplitudes a (k, r) and 16-bit shapes s (r, n) with a s = u (k, n) but for `left_out` anywhere, and rounding.

    The shapes are those of the proper orthogonal decomposition, from the eigenvectors of u u' (Sirovich, Q. Appl. Math.
    45, 1987); r is as small as that allows.
    """
    vectors = np.linalg.eigh(u @ u.T)[1][:, ::-1]
    left = u.copy()
    amplitudes: list[FloatArray] = []
    shapes: list[ShortArray] = []
    for v in vectors.T:
        if np.abs(left).max(initial=0.0) <= left_out and shapes:
            break
        shape = v @ u
        largest = float(np.abs(shape).max(initial=0.0)) or 1.0
        shapes.append(np.round(shape * (LIMIT / largest)).astype(np.int16))
        amplitudes.append(v * (largest / LIMIT))
        left -= np.outer(v, shape)
    return np.column_stack(amplitudes), np.stack(shapes)


ANIMATION_BYTES = 5_000_000
"""What the motion around events may take of a report."""


@dataclass(frozen=True)
class Drawn:
    """The model as a page shows it, and how it moves."""

    surface: Surface | None
    """None: nothing can be drawn."""
    motions: Motions
    mode_shapes: ModeShapes | None
    """Of the unreduced model; None: there are none to draw."""


def drawn_of(
    run: Run | None, reference: ReferenceModel, findings: Findings, animation_bytes: int = ANIMATION_BYTES
) -> Drawn:
    """The surface of the model, and motion on it.

    Parameters
    ----------
    animation_bytes : what the motion around the hardest events may take of the report.
    """
    surface, n_node = _surface(findings), findings.setup.model.nodes.count
    motions = recorded_motions(run, n_node, surface, animation_bytes)
    shapes = mode_shapes(reference.system, reference.modes, n_node, surface) if animation_bytes > 0 else None
    return Drawn(surface, motions, shapes)


def _surface(findings: Findings) -> Surface | None:
    """What is drawn of the model, with all marks; None where that has no extent."""
    setup = findings.setup
    marked: list[IntArray] = [findings.gaps.nodes_idx, setup.held, setup.driven]
    needed = np.unique(np.concatenate([*marked, *(p.nodes_idx for p in findings.places)]))
    surface = surface_of(setup.model, needed)
    if surface is None or float(np.ptp(setup.model.nodes.coords[surface.nodes_idx], axis=0).max()) == 0.0:
        return None
    return surface


def write_drawn(file: h5py.File, drawn: Drawn) -> None:
    """Add the group `drawn` to a results.h5."""
    write_tree(file.create_group("drawn"), drawn)


def read_drawn(file: h5py.File) -> Drawn:
    """What `write_drawn` wrote.

    Raises
    ------
    KeyError, TypeError, ValueError : the file does not hold it.
    """
    return read_tree(Drawn, file["drawn"])
