"""The histories of a run as results.h5 stores them."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.recovery import by_node, recovered
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import ENERGIES, History
from creak.formats.stored.results import ContactRecord, Field, LineRecord, RunRecord
from creak.model.mesh import Nodes
from creak.signals.resampling import cell_means, cell_peaks
from creak.studies.prepare.marching import Marching
from creak.studies.prepare.reduction import Watch
from creak.studies.run.one_run import Run

UNASKED = 32_000_000
"""Bytes that the motion of all nodes may take where the study does not ask for it; fewer instants then."""
MARGIN = 4
"""Instants before and after a touch that are stored with it."""


def record_of(run: Run, nodes: Nodes, watch: Watch, marching: Marching) -> RunRecord:
    """What is stored of a run: most of it at its output times."""
    h, gaps, watched = run.history, run.gaps, watch.nodes
    at, friction = h.output_index, gaps.friction
    rubbing = np.zeros(0, dtype=np.int64) if friction is None else friction.channels
    touched = np.flatnonzero((h.force > 0.0).any(axis=0))
    return RunRecord(
        time=h.time[at],
        gap=h.gap[at],
        normal_force=cell_means(h.time, h.force, h.time[at]),
        peak_force=cell_peaks(h.time, h.force, h.time[at]),
        slip=h.slip,
        friction_force=_means(h, h.tangential),
        slip_speed=_means(h, h.sliding),
        contact=ContactRecord(_near_contact(h), h.time, touched, h.gap, h.force, rubbing, h.tangential, h.sliding),
        displacement=h.displacement.reshape(at.size, watched.size, 6),
        node_ids=nodes.ids[watched].astype(np.int64),
        node_names=[nodes.label(int(i)) for i in watched],
        channels=gaps.names,
        channel_nodes=nodes.ids[gaps.nodes_idx].astype(np.int64),
        energy=h.energy[at],
        energy_terms=ENERGIES,
        field=_field(run, nodes, marching),
        elines=_lines(run, watch.lines.points, nodes),
    )


def _lines(run: Run, points: GapOperator, nodes: Nodes) -> LineRecord | None:
    moved = run.line_motion
    if moved is None:
        return None
    return LineRecord(moved.time, moved.motion, points.names, nodes.ids[points.nodes_idx].astype(np.int64))


def _means(h: History, x: FloatArray) -> FloatArray:
    """Means over the output intervals of what only rubbing channels have."""
    return cell_means(h.time, x, h.time[h.output_index]) if x.size else np.zeros((h.output_index.size, 0))


def _near_contact(h: History) -> IntArray:
    """Instants at which anything presses, and `MARGIN` before and after."""
    pressed = np.asarray((h.force > 0.0).any(axis=1))
    near = np.convolve(pressed, np.ones(2 * MARGIN + 1), mode="full")[MARGIN : MARGIN + pressed.size] > 0.5
    return np.flatnonzero(near)


def _field(run: Run, nodes: Nodes, marching: Marching) -> Field | None:
    """The motion of all nodes as the study asks for it; where it does not, around the hardest event."""
    h = run.history
    if h.whole_at.size:
        time, q = marching.ends[h.whole_at], h.coordinates
        s = marching.loads.support[0, marching.table.substeps * h.whole_at].T
    elif run.recording is not None and run.recording.motions:
        m = run.recording.motions[0]
        every = max(1, -(-m.time.size * 24 * nodes.count // UNASKED))
        time, q, s = m.time[::every], m.coordinates[:, ::every], m.supports[:, ::every]
    else:
        return None
    labels = run.system.labels
    blocks = ((here, by_node(u, labels, nodes.count)) for here, u in recovered(run.system, q, s))
    return Field(time, blocks, nodes.ids.astype(np.int64), nodes.coords)
