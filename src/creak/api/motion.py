"""Loads and time integration of any System."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from creak.api.matrices import A_SYSTEM, known_labels
from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import Scheme
from creak.dynamics.simulate import simulate as by_scheme
from creak.errors import InputError, shortened
from creak.given import of_kind, pairs_of, row_of, whole
from creak.progress import told_to
from creak.signals.signal import Motion, Signal
from creak.signals.sources import A_SIGNAL
from creak.studies.run.integrate import simulate_settled

Forces: TypeAlias = Sequence[tuple[ArrayLike, Signal | ArrayLike]]
CHANNELS = "channels of creak.gap_channels, or a list of them; [] gives linear motion"
EVEN = 1e-6
"""Share of the step by which sampling may be uneven."""


def make_loads(
    system: System, time: ArrayLike, *, motion: Mapping[str, Signal | Motion] | None = None, forces: Forces = ()
) -> Loads:
    """What drives a run, sampled at its steps.

    Parameters
    ----------
    time : (n_time,) s, evenly spaced from 0: the steps of the run.
    motion : name -> displacement of each prescribed coordinate of the System (`couple(..., driven=...)`): a signal,
        or a `Motion` with displacement, velocity and acceleration at `time`.
    forces : (labels, signal or samples) each: a signal or samples (n_time,) act on every label with their full value;
        samples (n_time, n_label) hold a force for each label.

    Raises
    ------
    InputError : times that are uneven, do not start at 0 or are no numbers; motion that is missing or of an unknown
        name, an unknown label, samples of another size.
    """
    of_kind(system, System, "system", A_SYSTEM)
    t = _checked_times(time)
    motion = {} if motion is None else motion
    of_kind(motion, Mapping, "motion", 'a mapping, as {"base": creak.Sine(20.0, 0.1)}')
    support = _support(system, t, motion)
    columns: list[FloatArray] = []
    labels: list[IntArray] = []
    for where, what in pairs_of(forces, "forces", "(labels, signal)"):
        found = known_labels(where, system.labels, "forces")
        F = _samples(what, t, found.size)
        each = [found] if F.shape[1] == 1 else [found[[j]] for j in range(found.size)]
        columns, labels = [*columns, F], [*labels, *each]
    force = np.hstack(columns) if columns else np.zeros((t.size, 0))
    return Loads(t, support, force, tuple(labels))


def simulate(
    system: System,
    gaps: GapOperator | Sequence[GapOperator],
    loads: Loads,
    scheme: Scheme | None = None,
    *,
    observed: ArrayLike | None = None,
    output_every: int = 1,
    substeps: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> History:
    """March a System, full or reduced, through its loads with contact in the gap channels.

    M a + C v + K u = f + G' p(g, g'). Without a scheme at the default accuracy, whatever the step of the loads:
    diagonal Systems (`diagonalise`, `gap_modes`) by exact motion between contacts, others by collocation of order 5;
    contact in short steps of its own. Loads follow a cubic spline through their samples, which must resolve them (ten
    in a period). With a scheme as it is, contact condensed to the channels: one factorisation, no global iteration.

    Parameters
    ----------
    gaps : channels; several operators are joined; an empty list gives linear motion.
    scheme : `HHT(alpha)` or `generalised_alpha(rho_inf)`, for those who insist; None: the default accuracy.
    observed : labels whose motion is kept every `output_every` steps; default: those that the channels touch.
    substeps : with a scheme: a step is so many samples of the loads long, and divided into as many near contact.

    Returns
    -------
    History: time, gap and force (n_time, m), displacement (n_out, n_observed), energy balance.

    Raises
    ------
    InputError : a label that the System does not have, loads of another System, what is no scheme.
    NumericalError : the motion is no longer finite, or a step matrix is singular. Stopped early, it carries the
        `history` so far.

    With alpha = 0 and stiff penalties contact chatters and can create energy: look at `History.energy_created`.
    """
    told_to(progress, "(done, total)")
    of_kind(system, System, "system", A_SYSTEM)
    of_kind(loads, Loads, "loads", "Loads: creak.make_loads(system, time) makes them")
    channels = _joined(gaps)
    known_labels(channels.labels, system.labels, "gaps")
    kept = channels.labels if observed is None else known_labels(observed, system.labels, "observed")
    if loads.support.shape[2] != system.supports.count:
        raise InputError(
            f"loads for {loads.support.shape[2]} prescribed coordinates",
            expected=f"{system.supports.count}",
            fix="Make the loads for this System.",
        )
    for x in loads.force_labels:
        known_labels(x, system.labels, "forces")
    output_every, substeps = whole(output_every, "output_every", 1), whole(substeps, "substeps", 1)
    if loads.n_step < substeps:
        raise InputError(f"substeps = {substeps}", expected=f"no more than the loads have steps, {loads.n_step}")
    if scheme is not None and not isinstance(scheme, Scheme):
        raise InputError(
            f"scheme = {getattr(scheme, '__name__', repr(scheme))}, which is no scheme",
            expected="creak.HHT(alpha), creak.generalised_alpha(rho_inf), or None for the default accuracy",
            fix="Call one of them: scheme=creak.HHT().",
        )
    if scheme is None and substeps > 1:
        raise InputError(
            f"substeps = {substeps} without a scheme",
            expected="a scheme whose steps are divided",
            fix="Give creak.HHT() or creak.generalised_alpha(), or leave out substeps.",
        )
    asked = OutputRequest(kept, output_every)
    if scheme is None:
        return simulate_settled(system, channels, loads, asked, progress)
    return by_scheme(system, channels, loads, scheme, asked, substeps=substeps, progress=progress)


def _joined(gaps: GapOperator | Sequence[GapOperator]) -> GapOperator:
    """All channels."""
    if isinstance(gaps, GapOperator):
        return gaps
    of_kind(gaps, Iterable, "gaps", CHANNELS)
    each = list(gaps)
    for one in each:
        of_kind(one, GapOperator, "one of the gaps", CHANNELS)
    return join(each)


def _checked_times(time: ArrayLike) -> FloatArray:
    expected = "evenly spaced times from 0: step * numpy.arange(n)"
    try:
        t = np.asarray(time, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"times that are no numbers: {error}", expected=expected) from error
    if t.ndim != 1 or t.size < 2:
        raise InputError(f"times of shape {t.shape}", expected=f"{expected}, two or more")
    if not np.isfinite(t).all():
        raise InputError(f"the time {t[~np.isfinite(t)][0]} among them", expected=expected)
    step = np.diff(t)
    if step.min() <= 0.0 or np.ptp(step) > EVEN * step.mean():
        raise InputError("uneven or falling times", expected=expected)
    if abs(t[0]) > EVEN * step.mean():
        raise InputError(f"times that start at {t[0]:g} s", expected=expected, fix="Give time - time[0].")
    return t


def _support(system: System, t: FloatArray, motion: Mapping[str, Signal | Motion]) -> FloatArray:
    names = system.supports.names
    if set(motion) != set(names):
        raise InputError(
            f"motion for {', '.join(map(repr, motion)) or 'nothing'}",
            expected=f"one for each prescribed coordinate: {', '.join(map(repr, names)) or 'there is none'}",
        )
    support = np.zeros((3, t.size, len(names)))
    for j, name in enumerate(names):
        given = motion[name]
        if not isinstance(given, Motion):
            of_kind(given, Signal, f"motion {name!r}", f"{A_SIGNAL}, or a creak.Motion")
        found = given if isinstance(given, Motion) else given.motion(t, 0)
        for k, x in enumerate((found.displacement, found.velocity, found.acceleration)):
            if np.shape(x) != t.shape:
                raise InputError(f"motion {name!r} has shape {np.shape(x)}", expected=f"{t.shape}, as the times")
            support[k, :, j] = row_of(x, f"motion {name!r}")
    return support


def _samples(what: Any, t: FloatArray, n_label: int) -> FloatArray:
    if isinstance(what, Signal):
        return what.values(t)[:, None]
    try:
        F = np.asarray(what, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"a force is {shortened(repr(what))}", expected=f"{A_SIGNAL}, or samples") from error
    if F.shape not in ((t.size,), (t.size, n_label)) or not np.isfinite(F).all():
        raise InputError(f"forces of shape {F.shape}", expected=f"({t.size},) or ({t.size}, {n_label}) finite numbers")
    return F.reshape(t.size, -1)
