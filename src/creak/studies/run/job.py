"""The main job: a study in, two runs and their comparison out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.contact.small_sliding import slip_warnings, turn_warnings
from creak.contact.step_problem import compile_kernels
from creak.dynamics.flow_march import compile_flow
from creak.dynamics.history import History
from creak.dynamics.stopped import Stopped
from creak.formats.run_identity import RunIdentity
from creak.reduction.health import Health
from creak.signals.spectra import spectrum
from creak.studies.file.identity import new_identity
from creak.studies.models.health import checked
from creak.studies.models.reduced import WHOLE, ReducedModel, reduce_model, reduced_modes
from creak.studies.models.reference import ReferenceModel, build_reference, observed_labels
from creak.studies.prepare.output_steps import field_steps, output_every, shown_window
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.start_check import figure_warnings, never_closed
from creak.studies.prepare.watched import watched
from creak.studies.run.compared import compare_events, compared_setup
from creak.studies.run.costs import Cost, Meter
from creak.studies.run.dropped import MOST_RUNS, with_closed
from creak.studies.run.forced_step import limited
from creak.studies.run.integrate import integrate, output_times, scheme_of
from creak.studies.run.motion import NO_STEPS, Recording, at_steps, recorded, recorded_steps
from creak.studies.run.precheck import prechecked, with_linear_gaps
from creak.studies.run.static_start import begin, with_static
from creak.studies.unraised import none_ignored
from creak.studies.warned import Warned
from creak.verify.events import Event, find_events
from creak.verify.mac import ModePairs, pair_modes
from creak.verify.matching import EventMatch
from creak.verify.nrmse import nrmse_by_axis
from creak.verify.reliability import UNRELIABLE, reasons_against
from creak.verify.slips import SlipEvent, find_slips

COMPILE = "compile kernels (first run: a minute)"
"""A phase of its own: slow once, then kept on disk."""
STILL = 1e-9
"""Share of the largest motion of the compared nodes below which a mode is not seen there."""
SHARE = 0.1
"""Longest step as a share of the shortest event."""

Progress = Callable[[str, int, int], None]
ReferenceRun = Callable[[Setup, ReferenceModel, GapOperator, Progress], "Run"]


@dataclass(frozen=True)
class Run:
    """One time integration."""

    name: str
    system: System
    history: History
    events: list[Event]
    cost: Cost
    retained: int
    modes: int
    offline_cpu_s: float
    offline_wall_s: float
    slips: tuple[SlipEvent, ...] = ()
    """Stick-slip events of the pairs that rub."""
    integrator: str = ""
    """In a few words."""
    stopped: str | None = None
    """Why the run ended early; None: it did not."""
    recording: Recording | None = None
    """Motion around the hardest events; None where nobody asked for it."""


@dataclass(frozen=True)
class ModeComparison:
    """Modes of the reference and the reduced model up to the verification's mac_f_max."""

    pairs: ModePairs
    freq_reference: FloatArray
    freq_reduced: FloatArray


@dataclass(frozen=True)
class SpectraComparison:
    """Relative motion of the verification pairs over the window, by frequency."""

    freq: FloatArray
    spectra: dict[str, ComplexArray]
    """Run -> (n_freq, n_pair, 3)."""
    nrmse: dict[str, float | None]
    """Fit by axis x, y, z, and all; None where nothing moves."""


@dataclass(frozen=True)
class StudyResult:
    """Everything that a study found."""

    setup: Setup
    gaps: GapOperator
    """Channels that were kept, contacts first, connectors after."""
    runs: dict[str, Run]
    reference: ReferenceModel
    reduced: ReducedModel | None
    modes: ModeComparison | None
    spectra: SpectraComparison | None
    events: EventMatch | None
    window: tuple[float, float]
    notes: list[str]
    health: dict[str, Health]
    """Of each superelement, by name."""
    identity: RunIdentity
    stopped: str | None = None
    """Why the study ended early; None: it did not."""
    closed_later: int = 0
    """Contact channels that the pre-check dropped and that were kept after all, as one closed in the run."""


@none_ignored()
def run_study(
    setup: Setup,
    progress: Progress,
    store: Path | None = None,
    reference_run: ReferenceRun | None = None,
    *,
    record: bool = False,
) -> StudyResult:
    """Pre-check, reduction, both runs, verification.

    A run that stops early keeps what it has and ends the study: `StudyResult.stopped` says why.

    Parameters
    ----------
    store : folder of saved superelements; those that still fit are used instead of being made again.
    reference_run : makes the run of the unreduced model, or takes a saved one of the same model, channels and loads.
    record : keep the motion around the hardest events of the reduced run, or of the only one (`studies.motion`).
    """
    c = setup.study.config
    progress(COMPILE, 0, 1)
    compile_kernels()
    if c.time.exact:
        compile_flow()
    progress(COMPILE, 1, 1)
    setup, built = begin(setup, progress)
    reference, gaps, notes = prepare(setup, progress, built)
    runs: dict[str, Run] = {}
    kept = gaps.m
    reduced, health, stopped = None, {}, None
    if c.reduction.method != "none":
        gaps, reduced, runs["reduced"], more = _reduced_run(setup, reference, gaps, progress, store, record)
        notes += [*more, *reduced.notes]
        try:
            health = checked(setup, reduced, progress)
        except KeyboardInterrupt:
            stopped = "stopped while the superelements were checked"
        notes += [Warned(f"superelement {name}: {text}") for name, h in health.items() for text in h.findings.warnings]
    stopped = next((r.stopped for r in runs.values() if r.stopped), stopped)
    if stopped is None and (c.reference.run or reduced is None):
        if reduced is None:
            gaps, runs["reference"], more = _only_run(setup, reference, gaps, progress, reference_run, record)
            notes += more
        else:
            runs["reference"] = (reference_run or unreduced_run)(compared_setup(setup), reference, gaps, progress)
        stopped = runs["reference"].stopped
    if gaps.m == 0 and (setup.contacts.m or setup.connectors.m):
        notes.append("no channel can close under this load: both runs are linear")
    notes += run_warnings(setup, gaps, runs)
    if runs and gaps.m and not any(run.history.force.any() for run in runs.values()):
        notes.append(never_closed(gaps, next(iter(runs.values())).history))
    window = shown_window(setup.study, output_times(setup))
    whole = {} if stopped else runs
    return StudyResult(
        setup,
        gaps,
        runs,
        reference,
        reduced,
        compare_modes(setup, reference, reduced, gaps),
        compare_spectra(setup, whole, window),
        compare_events(whole, setup.study.config.verification.event_tolerance, window),
        window,
        [*setup.notes, *notes],
        health,
        new_identity(setup.study, setup.deck_sha256),
        stopped,
        gaps.m - kept,
    )


def _reduced_run(
    setup: Setup, reference: ReferenceModel, gaps: GapOperator, progress: Progress, store: Path | None, record: bool
) -> tuple[GapOperator, ReducedModel, Run, list[str]]:
    """The reduced model and its run, again with those dropped channels that close in it."""
    notes: list[str] = []
    for left in reversed(range(MOST_RUNS)):
        gaps, more = limited(setup, reference, gaps)
        reduced = reduce_model(setup, reference, gaps, progress, store)
        run = march_run("reduced", setup, reduced.system, gaps, progress, reduced, record=record, watch=True)
        closed = with_closed(setup, gaps, run.history) if left and run.stopped is None else None
        if closed is None:
            break
        gaps = closed[0]
        notes.append(closed[1])
    return gaps, reduced, run, [*notes, *more]


def _only_run(
    setup: Setup,
    reference: ReferenceModel,
    gaps: GapOperator,
    progress: Progress,
    reference_run: ReferenceRun | None,
    record: bool,
) -> tuple[GapOperator, Run, list[str]]:
    """The run of the unreduced model where there is no other, as `_reduced_run`."""
    notes: list[str] = []
    for left in reversed(range(MOST_RUNS)):
        gaps, more = limited(setup, reference, gaps)
        if record or reference_run is None:
            run = march_run("reference", setup, reference.system, gaps, progress, None, record=record, watch=True)
        else:
            run = reference_run(compared_setup(setup), reference, gaps, progress)
        closed = with_closed(setup, gaps, run.history) if left and run.stopped is None else None
        if closed is None:
            break
        gaps = closed[0]
        notes.append(closed[1])
    return gaps, run, [*notes, *more]


def _large_motions(gaps: GapOperator, history: History) -> list[str]:
    """Slip and rotations for which contact and kinematics do not hold, seen at every step."""
    seen = history.extremes
    if seen is None:
        return []
    return [*slip_warnings(gaps, seen.slip, seen.slip_at), *turn_warnings(seen.turn_names, seen.turn, seen.turn_at)]


def run_warnings(setup: Setup, gaps: GapOperator, runs: dict[str, Run]) -> list[Warned]:
    """What the user should know of each run; where it is the same of both, once."""
    said = {
        name: [
            *(f"{UNRELIABLE}: {reason}" for reason in reasons_against(run.history)),
            *_large_motions(gaps, run.history),
            *step_warnings(setup, run),
        ]
        for name, run in runs.items()
    }
    every = dict.fromkeys(text for texts in said.values() for text in texts)
    return [Warned(f"{' and '.join(n for n in said if text in said[n])} run: {text}") for text in every]


def step_warnings(setup: Setup, run: Run) -> list[str]:
    """A step longer than a tenth of the shortest contact event cannot follow its force."""
    table, step = setup.study.config.time, setup.loads.step
    if table.exact:
        return []
    short = min(run.events, key=lambda e: e.t_end - e.t_start, default=None)
    if short is None or step <= SHARE * (short.t_end - short.t_start):
        return []
    key = "substeps" if table.integrator != "massless-boundary" else "step"
    return [
        f"the step near contact, {step:g} s, is longer than a tenth of the shortest event "
        f"({short.t_end - short.t_start:.3g} s at {short.channel}, t = {short.t_start:.4g} s): its force is not "
        f"resolved; set [time] {key}, or compare with `creak run --converge`"
    ]


def prepare(
    setup: Setup, progress: Progress, reference: ReferenceModel | None = None
) -> tuple[ReferenceModel, GapOperator, list[str]]:
    """The unreduced model, made here or by `begin`, the channels that the pre-check keeps (connectors last), notes."""
    reference = reference or build_reference(setup, progress)
    mass, units = float(reference.system.stats["mass"]), setup.study.config.model.units
    figures = figure_warnings(setup.model, units, mass, reference.modes.omega2)
    reference = with_linear_gaps(setup, reference, scheme_of(setup.study.config.time), progress)
    kept, notes = prechecked(setup, reference)
    if setup.study.config.reduction.method not in WHOLE:
        reference = reference.without_factor()
    return reference, join([kept, setup.connectors]), [*figures, *notes]


def march_run(
    name: str,
    setup: Setup,
    system: System,
    gaps: GapOperator,
    progress: Progress,
    reduced: ReducedModel | None,
    *,
    record: bool = False,
    watch: bool = False,
) -> Run:
    """One run with its events and cost; one that stops early has them up to there.

    Parameters
    ----------
    record : keep the motion around the hardest events. watch : look at what `prepare.watched` says at every step.
    """
    meter, stopped, how = Meter(), None, ""
    field = field_steps(setup.study, output_times(setup))
    on_trial = recorded_steps(setup, system.n) if record else NO_STEPS
    try:
        history, system, how = integrate(
            setup,
            system,
            gaps,
            observed=observed_labels(setup.watched),
            output_every=output_every(setup.study),
            whole_at=np.union1d(field, on_trial),
            progress=lambda done, total: progress(f"{name} run", done, total),
            watched=watched(setup, gaps) if watch else None,
        )
    except Stopped as error:
        history, stopped = error.history, f"{name} run: {error}"
    cost = meter.read()
    system, history = with_static(setup, system, history)
    v = setup.study.config.verification
    events, slips = find_events(history, gaps, v.merge, v.f_max), tuple(find_slips(history, gaps, v.merge))
    size = (0, 0, 0.0, 0.0) if reduced is None else (reduced.retained, reduced.modes, reduced.cpu_s, reduced.wall_s)
    recording = recorded(setup, system, history, events) if record else None
    return Run(name, system, at_steps(history, field), events, cost, *size, slips, how, stopped, recording)


def unreduced_run(setup: Setup, reference: ReferenceModel, gaps: GapOperator, progress: Progress) -> Run:
    """The run of the unreduced model."""
    return march_run("reference", setup, reference.system, gaps, progress, None, watch=True)


def compare_modes(
    setup: Setup, reference: ReferenceModel, reduced: ReducedModel | None, gaps: GapOperator
) -> ModeComparison | None:
    """MAC at the verification pairs, or at the watched and channel nodes where the study names no pairs.

    Modes that do not move these nodes are left out.
    """
    if reduced is None:
        return None
    f_max = setup.study.config.verification.mac_f_max
    nodes = np.unique(setup.pairs) if setup.pairs.size else np.union1d(setup.watched, gaps.retained_nodes)
    if nodes.size == 0:
        return None
    labels = (6 * nodes[:, None] + np.arange(3)).ravel().astype(np.int64)
    freq = reference.modes.frequencies
    below = freq <= f_max
    other = reduced_modes(reduced.system, 1.2 * f_max)
    shapes = np.asarray(reference.system.rows(labels)[0] @ reference.modes.shapes[:, below])
    shapes_reduced = np.asarray(reduced.system.rows(labels)[0] @ other.shapes)
    size = np.linalg.norm(shapes, axis=0)
    seen = size > STILL * size.max(initial=0.0)
    pairs = pair_modes(freq[below][seen], shapes[:, seen], other.frequencies, shapes_reduced)
    return ModeComparison(pairs, freq[below][seen], other.frequencies)


def compare_spectra(setup: Setup, runs: dict[str, Run], window: tuple[float, float]) -> SpectraComparison | None:
    if not setup.pairs.size or not runs:
        return None
    spectra: dict[str, ComplexArray] = {}
    freq = np.zeros(0)
    for name, run in runs.items():
        relative, step = _relative_motion(setup, run.history, window)
        freq, spectra[name] = spectrum(relative, step, setup.study.config.verification.f_max)
    both = "reference" in spectra and "reduced" in spectra
    fit = nrmse_by_axis(spectra["reference"], spectra["reduced"]) if both else {}
    return SpectraComparison(freq, spectra, fit)


def _relative_motion(setup: Setup, history: History, window: tuple[float, float]) -> tuple[FloatArray, float]:
    """(n_out in the window, n_pair, 3) secondary minus main, and the output step."""
    row = {int(n): i for i, n in enumerate(setup.watched)}
    u = history.displacement.reshape(history.displacement.shape[0], -1, 6)[:, :, :3]
    main, secondary = ([row[int(n)] for n in setup.pairs[:, k]] for k in (0, 1))
    time = history.time[history.output_index]
    step = float(time[1] - time[0])
    end = int(np.searchsorted(time, window[1] + 0.5 * step))
    n = round((window[1] - window[0]) / step)
    return (u[:, secondary] - u[:, main])[end - n : end], step


def events_in(events: Sequence[Event], window: tuple[float, float]) -> list[Event]:
    """Events that start inside a time window."""
    return [e for e in events if window[0] <= e.t_start <= window[1]]
