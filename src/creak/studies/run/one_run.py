"""One run: a model marched through its loads, with its events and its cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History, Interrupted, Stopped
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.record.thinning import spacing_words
from creak.model.dofs import node_dofs
from creak.progress import Progress, Steps
from creak.studies.models.reduced import ReducedModel
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.marching import Marching, Observed, field_steps, output_every
from creak.studies.run.checkpoint import Checkpoint
from creak.studies.run.compared import Meter, RunBase
from creak.studies.run.elines import LineMotion, line_steps, measured
from creak.studies.run.integrate import integrate
from creak.studies.run.motion import NO_STEPS, AtContact, Recording, at_contact, at_steps, recorded, recorded_steps
from creak.studies.run.static_start import with_static
from creak.verify.elines import PointMeasures
from creak.verify.events import find_events
from creak.verify.slips import find_slips, find_squeaks


@dataclass(frozen=True)
class Run(RunBase):
    """One time integration."""

    system: System
    gaps: GapOperator
    """Its channels."""
    history: History
    recording: Recording | None = None
    """Motion around the hardest events; None where nobody asked for it."""
    at_contact: AtContact | None = None
    """All coordinates while something touches; None where nobody asked for them, or they are not there."""
    lines: PointMeasures | None = None
    """At the points of the E-lines; None where nobody asked for them."""
    line_motion: LineMotion | None = None
    """Over time, with `lines`."""
    notes: tuple[str, ...] = ()
    """What should be known of it: instants that were not kept, a run that was taken from another case."""
    interrupted: bool = False
    """Whether Ctrl-C is why it ended early."""
    places_known: dict[tuple[float, float], Any] = field(default_factory=dict, init=False, compare=False, repr=False)
    """Window -> what `studies.findings.places` found, so that it looks once."""


def march_run(
    name: str,
    marching: Marching,
    observed: Observed,
    model: ReducedModel | ReferenceModel,
    gaps: GapOperator,
    progress: Progress,
    checkpoint: Callable[..., Checkpoint] | None = None,
) -> Run:
    """One run with its events and cost; one that stops early has them up to there.

    Parameters
    ----------
    checkpoint : gives that of a march (`Checkpoints.of`, its `origin` known).
    """
    meter, stopped, how, interrupted = Meter(), None, "", False
    system, seen, v = model.system, observed.seen, observed.verification
    fields, labels = field_steps(marching.course, marching.ends), node_dofs(observed.nodes)
    period = 1.0 / (marching.excited or v.mac_f_max)
    on_trial = recorded_steps(marching, period, system.n) if observed.record else NO_STEPS
    of_lines = line_steps(marching, system.n) if observed.lines.points.m else NO_STEPS
    whole_at = np.union1d(np.union1d(fields, on_trial), of_lines)
    report: Steps = partial(progress, f"{name} run")
    keeper = None
    if checkpoint is not None:
        channels = (gaps.names, () if seen is None else seen.silent.names)
        keeper = checkpoint(name, float(marching.loads.time[-1]), system.n, channels, (labels, whole_at))
        report = keeper.told(progress)
    asked = OutputRequest(labels, output_every(marching.course), whole_at, seen)
    try:
        history, system, how = integrate(marching, system, gaps, asked, report, keeper)
    except Stopped as error:
        history, stopped, interrupted = error.history, f"{name} run: {error}", isinstance(error, Interrupted)
    cost = meter.read() if keeper is None else keeper.cost
    system, history = with_static(observed.static, observed.nodes, system, history)
    events, slips = find_events(history, gaps, v.merge, v.f_max), tuple(find_slips(history, gaps, v.merge, v.f_max))
    size: dict[str, Any] = {}
    if isinstance(model, ReducedModel):
        size = {"retained": model.retained, "modes": model.modes}
        size |= {"offline_cpu_s": model.cpu_s, "offline_wall_s": model.wall_s}
    shown = at_steps(history, np.union1d(fields, on_trial))
    recording = recorded(marching, period, system, shown, events) if observed.record else None
    touching = at_contact(marching, system, shown, events) if observed.record else None
    found = measured(marching, observed.lines, system, history, of_lines, contact=True) if stopped is None else None
    squeaks = tuple(find_squeaks(history, gaps, marching.window))
    left, told = at_steps(history, fields), spacing_words(history.spacing)
    at_lines, moved = (None, None) if found is None else found
    return Run(
        system,
        gaps,
        left,
        **size,
        name=name,
        events=events,
        cost=cost,
        slips=slips,
        integrator=how,
        stopped=stopped,
        interrupted=interrupted,
        recording=recording,
        at_contact=touching,
        lines=at_lines,
        squeaks=squeaks,
        line_motion=moved,
        notes=told,
    )
