"""Relative motion at the points of E-lines, out of a run with contact and out of one without."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray, SingleArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.channels import channel_matrices
from creak.dynamics.history import History
from creak.dynamics.stopped import Stopped
from creak.reduction.modal import modal_system
from creak.studies.models.reference import ReferenceModel, static_shapes
from creak.studies.prepare.elines import Eline
from creak.studies.prepare.excitation import highest_frequency
from creak.studies.prepare.output_steps import output_every, shown_window
from creak.studies.prepare.setup import Setup
from creak.studies.run.integrate import integrate, output_times
from creak.studies.run.motion import NO_STEPS
from creak.verify.elines import PointMeasures, joined, measure

MEMORY = 800_000_000
"""Bytes of coordinates that a run keeps for its E-lines."""
AT_ONCE = 64_000_000
"""Bytes of relative motion at a time."""
PER_PERIOD = 10.0
"""Fewest instants kept of a period of the excitation."""

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class LineFindings:
    """What a study found at its E-lines, point by point."""

    lines: tuple[Eline, ...]
    line_of: IntArray
    """(p,) row in `lines`."""
    nodes_idx: IntArray
    """(p,) node row on the secondary side."""
    position: FloatArray
    """(p, 3) of that node."""
    frames: FloatArray
    """(p, 3, 3) rows x, y, z of the local frame."""
    gap0: FloatArray
    """(p,) gap at rest."""
    percentile: float
    linear: PointMeasures | None
    """Of the run without contact; None: there is none."""
    contact: PointMeasures | None
    """Of the run with contact."""
    touched: BoolArray | None
    """(p,) the point pressed in the window of that run."""
    without: str
    """What the linear run was of, in a few words."""
    why: str
    """Why a run is missing; empty: none is."""


@dataclass(frozen=True)
class LineMotion:
    """Relative motion at all points over the verification window."""

    time: FloatArray
    """(k,) s, evenly spaced."""
    motion: SingleArray
    """(k, p, 3) of the secondary side along x, y, z of each point, length; z opens the gap."""


def line_steps(setup: Setup, n: int) -> IntArray:
    """Whole steps of the verification window at which a run of n coordinates keeps them for its E-lines.

    Every one, or as many as fit into `MEMORY`; none where that would not follow the motion.
    """
    if not setup.elines.points.m:
        return NO_STEPS
    time = output_times(setup)
    start, end = shown_window(setup.study.course, time)
    step = float(time[1] - time[0])
    inside = np.flatnonzero((time >= start - 0.5 * step) & (time <= end + 0.5 * step))
    every = max(1, -(-8 * n * inside.size // MEMORY))
    highest = highest_frequency(setup.study.driving)
    slowest = max(output_every(setup.study.course) * step, 1.0 / (PER_PERIOD * highest) if highest else 0.0)
    if every > 1 and every * step > slowest * (1.0 + 1e-9):
        return NO_STEPS
    return inside[::every].astype(np.int64)


def measured(
    setup: Setup, system: System, history: History, steps: IntArray
) -> tuple[PointMeasures, LineMotion] | None:
    """Measures of all points out of the coordinates that a run has kept; None where it has not kept them.

    The motion beside them is at the instants of the output interval, or at all that were kept where those are fewer.
    """
    keep = np.isin(history.whole_at, steps)
    if not steps.size or system.n != history.coordinates.shape[0] or np.count_nonzero(keep) < 2:
        return None
    parts = setup.study.config.time.substeps
    q = np.ascontiguousarray(history.coordinates[:, keep])
    s = setup.loads.support[0, parts * history.whole_at[keep]].T
    points, percentile = setup.elines.points, setup.study.config.limit.percentile
    at_once = int(np.clip(AT_ONCE // (24 * q.shape[1]), 1, 512))
    shown = slice(None, None, max(1, output_every(setup.study.course) // int(steps[1] - steps[0])))
    time = output_times(setup)[history.whole_at[keep]][shown]
    kept = np.zeros((time.size, points.m, 3), dtype=np.float32)
    pieces = []
    for start in range(0, points.m, at_once):
        some = points.select(np.arange(start, min(start + at_once, points.m)))
        motion = relative_motion(system, some, q, s)
        kept[:, start : start + some.m] = motion[shown]
        pieces.append(measure(motion, percentile))
    return joined(pieces), LineMotion(time, kept)


def relative_motion(system: System, points: GapOperator, q: FloatArray, s: FloatArray) -> FloatArray:
    """(k, p, 3) displacement of the secondary side relative to the main one along x, y, z of each point.

    Parameters
    ----------
    q : (n, k) coordinates. s : (n_support, k) prescribed motion.
    """
    on = channel_matrices(system, points)
    return np.stack([np.asarray(A @ q + A_s @ s).T for A, A_s in (*on.tangents, (on.G, on.G_s))], axis=2)


def without_contact(setup: Setup, system: System, progress: Progress, name: str) -> PointMeasures | None:
    """Measures of all points in a run of a System in which nothing ever presses."""
    steps = line_steps(setup, system.n)
    if not steps.size:
        return None
    history, marched, _ = integrate(
        setup,
        system,
        join([]),
        observed=NO_STEPS,
        output_every=setup.loads.n_step // setup.study.config.time.substeps,
        whole_at=steps,
        progress=lambda done, total: progress(name, done, total),
    )
    found = measured(setup, marched, history, steps)
    return None if found is None else found[0]


def modal_measures(setup: Setup, reference: ReferenceModel, progress: Progress) -> PointMeasures | None:
    """The same of the modes of the assembly, on top of the quasi-static motion of its supports and loads."""
    R = reference.support_shapes
    system = modal_system(reference.system, reference.modes, R, static_shapes(setup.loads, reference, setup.reduction))
    return without_contact(setup, system, progress, "motion of the E-lines from modes")


def touched_points(setup: Setup, gaps: GapOperator, history: History) -> BoolArray:
    """(p,) points of contacts that pressed in the verification window."""
    start, end = shown_window(setup.study.course, output_times(setup))
    inside = (history.time >= start) & (history.time <= end)
    pressed = {gaps.names[j] for j in np.flatnonzero((history.force[inside] > 0.0).any(axis=0)).tolist()}
    return np.array([name in pressed for name in setup.elines.points.names], dtype=bool)


def findings(
    setup: Setup,
    linear: PointMeasures | None,
    contact: PointMeasures | None,
    touched: BoolArray | None,
    without: str,
    why: str,
) -> LineFindings:
    """What was measured, with what it was measured at."""
    e = setup.elines
    return LineFindings(
        e.lines,
        e.line_of,
        e.points.nodes_idx,
        setup.model.nodes.coords[e.points.nodes_idx],
        e.frames,
        e.points.gap0,
        setup.study.config.limit.percentile,
        linear,
        contact,
        touched,
        without,
        why,
    )


def compare_lines(
    setup: Setup,
    reference: ReferenceModel,
    reduced: System | None,
    gaps: GapOperator,
    run: tuple[PointMeasures | None, History] | None,
    progress: Progress,
) -> LineFindings | None:
    """Measures of the run with contact beside those of the same model without; None where there are no lines.

    Parameters
    ----------
    reduced : the reduced model; None: the modes of the assembly are run without contact.
    run : measures and history of the run with contact.
    """
    if not setup.elines.points.m or run is None:
        return None
    contact, history = run
    linear, why = None, ""
    name = (
        "reduced model" if reduced is not None else f"modes up to {reference.modes.frequencies.max(initial=0.0):.4g} Hz"
    )
    try:
        if reduced is not None:
            linear = without_contact(setup, reduced, progress, "run without contact for the E-lines")
        elif reference.stiffness is not None:
            linear = modal_measures(setup, reference, progress)
            reference.release()
    except Stopped as error:
        why = f"the run without contact ended early: {error}"
    if contact is None:
        why = f"the run with contact kept no motion for its E-lines (at most {MEMORY // 1_000_000} MB of it are kept)"
    elif linear is None and not why:
        why = "only contact holds the structure: there is no linear run without it"
    return findings(setup, linear, contact, touched_points(setup, gaps, history), name, why)
