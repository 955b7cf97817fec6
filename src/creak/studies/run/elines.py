"""Relative motion at the points of E-lines, out of a run with contact and out of one without."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray, SingleArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.channels import channel_matrices
from creak.dynamics.history import History, Stopped
from creak.dynamics.record.recorder import OutputRequest
from creak.studies.models.reference import ReferenceModel, in_modes
from creak.studies.prepare.elines import Eline, Elines
from creak.studies.prepare.marching import Marching, output_every
from creak.studies.prepare.reduction import Reduction
from creak.studies.run.integrate import integrate
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
    tolerance: FloatArray
    """(p,) what scatter may take of it, length."""
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


def line_steps(marching: Marching, n: int) -> IntArray:
    """Whole steps of the verification window at which a run of n coordinates keeps them for its E-lines.

    Every one, or as many as fit into `MEMORY`; none where that would not follow the motion.
    """
    time, (start, end) = marching.ends, marching.window
    step = float(time[1] - time[0])
    inside = np.flatnonzero((time >= start - 0.5 * step) & (time <= end + 0.5 * step))
    every = max(1, -(-8 * n * inside.size // MEMORY))
    highest = marching.excited
    slowest = max(output_every(marching.course) * step, 1.0 / (PER_PERIOD * highest) if highest else 0.0)
    if every > 1 and every * step > slowest * (1.0 + 1e-9):
        return NO_STEPS
    return inside[::every].astype(np.int64)


def measured(
    marching: Marching, lines: Elines, system: System, history: History, steps: IntArray, *, contact: bool
) -> tuple[PointMeasures, LineMotion] | None:
    """Measures of all points out of the coordinates that a run has kept; None where it has not kept them.

    The run moves about the static state with `contact` or without; measures are from the unloaded one.
    The motion beside them is at the instants of the output interval, or at all that were kept where those are fewer.
    """
    keep = np.isin(history.whole_at, steps)
    if not steps.size or system.n != history.coordinates.shape[0] or np.count_nonzero(keep) < 2:
        return None
    parts, every = marching.table.substeps, output_every(marching.course)
    q = np.ascontiguousarray(history.coordinates[:, keep])
    s = marching.loads.support[0, parts * history.whole_at[keep]].T
    points = lines.points
    at_once = int(np.clip(AT_ONCE // (24 * q.shape[1]), 1, 512))
    shown = slice(None, None, max(1, every // int(steps[1] - steps[0])))
    time = marching.ends[history.whole_at[keep]][shown]
    kept = np.zeros((time.size, points.m, 3), dtype=np.float32)
    pieces = []
    for start in range(0, points.m, at_once):
        some = points.select(np.arange(start, min(start + at_once, points.m)))
        motion = relative_motion(system, some, q, s)
        if lines.static is not None:
            motion += lines.static[0 if contact else 1][start : start + some.m]
        kept[:, start : start + some.m] = motion[shown]
        pieces.append(measure(motion, lines.percentile))
    return joined(pieces), LineMotion(time, kept)


def relative_motion(system: System, points: GapOperator, q: FloatArray, s: FloatArray) -> FloatArray:
    """(k, p, 3) displacement of the secondary side relative to the main one along x, y, z of each point.

    Parameters
    ----------
    q : (n, k) coordinates. s : (n_support, k) prescribed motion.
    """
    on = channel_matrices(system, points)
    return np.stack([np.asarray(A @ q + A_s @ s).T for A, A_s in (*on.tangents, (on.G, on.G_s))], axis=2)


def without_contact(
    marching: Marching, lines: Elines, system: System, progress: Progress, name: str
) -> PointMeasures | None:
    """Measures of all points in a run of a System in which nothing ever presses."""
    steps = line_steps(marching, system.n)
    if not steps.size:
        return None
    asked = OutputRequest(NO_STEPS, marching.ends.size - 1, steps)
    history, marched, _ = integrate(marching, system, join([]), asked, partial(progress, name))
    found = measured(marching, lines, marched, history, steps, contact=False)
    return None if found is None else found[0]


def modal_measures(
    marching: Marching, lines: Elines, reduction: Reduction, reference: ReferenceModel, progress: Progress
) -> PointMeasures | None:
    """The same of the modes of the assembly, on top of the quasi-static motion of its supports and loads."""
    system = in_modes(reference, reduction)
    return without_contact(marching, lines, system, progress, "motion of the E-lines from modes")


def touched_points(points: GapOperator, gaps: GapOperator, history: History, window: tuple[float, float]) -> BoolArray:
    """(p,) points of contacts that pressed in a window of time."""
    start, end = window
    inside = (history.time >= start) & (history.time <= end)
    pressed = {gaps.names[j] for j in np.flatnonzero((history.force[inside] > 0.0).any(axis=0)).tolist()}
    return np.array([name in pressed for name in points.names], dtype=bool)


def findings(
    lines: Elines,
    linear: PointMeasures | None,
    contact: PointMeasures | None,
    touched: BoolArray | None,
    without: str,
    why: str,
) -> LineFindings:
    """What was measured, with what it was measured at."""
    points = lines.points
    where = (points.nodes_idx, lines.positions, lines.frames)
    own = (lines.lines, lines.line_of, *where, points.gap0, lines.tolerance, lines.percentile)
    return LineFindings(*own, linear, contact, touched, without, why)


def compare_lines(
    marching: Marching,
    lines: Elines,
    reduction: Reduction,
    reference: ReferenceModel,
    reduced: System | None,
    run: tuple[PointMeasures | None, BoolArray],
    progress: Progress,
) -> LineFindings:
    """Measures of the run with contact beside those of the same model without.

    Parameters
    ----------
    reduced : the reduced model; None: the modes of the assembly are run without contact.
    run : with contact: its measures, and the points that were touched.
    """
    contact, touched = run
    if contact is not None and touched is not None:  # between its instants
        gap = lines.points.gap0
        contact = replace(contact, closing=np.where(touched, np.maximum(contact.closing, gap), contact.closing))
    linear, why = None, ""
    name = (
        "reduced model" if reduced is not None else f"modes up to {reference.modes.frequencies.max(initial=0.0):.4g} Hz"
    )
    try:
        if reduced is not None:
            linear = without_contact(marching, lines, reduced, progress, "run without contact for the E-lines")
        elif reference.stiffness is not None:
            linear = modal_measures(marching, lines, reduction, reference, progress)
            reference.release()
    except Stopped as error:
        why = f"the run without contact ended early: {error}"
    if contact is None:
        why = f"the run with contact kept no motion for its E-lines (at most {MEMORY // 1_000_000} MB of it are kept)"
    elif linear is None and not why:
        why = "only contact holds the structure: there is no linear run without it"
    return findings(lines, linear, contact, touched, name, why)
