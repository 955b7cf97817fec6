"""The linear pre-check: which contact channels can close at all (thesis 3.3.2)."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.damping import Damping
from creak.assembly.part import damps_by_itself, started_labels
from creak.assembly.system import Supports, System, rows_with_entries
from creak.contact.gap_operator import GapOperator, join
from creak.digest import digest
from creak.dynamics.history import History
from creak.linalg.diagonal import Diagonal
from creak.model.dofs import TRANSLATIONS, node_and_dof
from creak.model.mesh import Model
from creak.model.units import UNITS
from creak.progress import Progress
from creak.reduction.modal import modal_values
from creak.studies.file.config import PrecheckTable
from creak.studies.models.of_parts import reference_that_fits
from creak.studies.models.reduced import WHOLE
from creak.studies.models.reference import ReferenceModel, in_modes
from creak.studies.prepare.marching import Marching
from creak.studies.prepare.reduction import Exterior, Reduction
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.start_check import figure_warnings, nothing_closes
from creak.studies.prepare.structure import Structure
from creak.studies.prepare.watched import doubtful_channels
from creak.studies.run.foretold import closed_in
from creak.studies.run.integrate import linear_gaps
from creak.studies.run.kernels import Compiled
from creak.studies.run.one_run import Run
from creak.studies.run.static_start import started
from creak.studies.run.steady import growth
from creak.studies.solved import solved
from creak.studies.warned import Warned

T = TypeVar("T")
SIDES = ("M_qs", "K_qs", "M_ss", "K_ss", "M_start")
"""Of the supports."""
WITHOUT_WHOLE = (
    "memory does not hold a factor of the whole model: the linear pre-check is that of its parts, reduced to what "
    "joins them, and modes of reduced and unreduced model are not compared"
)
MOST_RUNS = 3
"""Runs of a model until what closes must be among its channels; a red verdict says where it is not."""
SAME = 1e-6
"""Share of the largest initial velocity from which on a node starts with another one than it was given."""


def prechecked(
    table: PrecheckTable, contacts: GapOperator, smallest: FloatArray | None, unit: str, tested: Container[str] = ()
) -> tuple[GapOperator, list[str]]:
    """Channels that the gaps (m,) of the linear run let close (thesis 3.3.2), and a note of it.

    Parameters
    ----------
    smallest : of each channel; None: there was no such run. unit : of length.
    tested : contacts, in small letters, whose gap or force is measured: where none of its channels closes all are kept.
    """
    if not table.enabled or contacts.m == 0:
        return contacts, []
    if smallest is None:
        return contacts, ["the pre-check was skipped: only contact holds the structure; all channels are kept"]
    closes = smallest <= table.near(contacts.gap0)
    closing = set(np.array(contacts.group)[closes].tolist())
    measured = np.array([name.lower() in tested and name not in closing for name in contacts.group], dtype=bool)
    margin = table.words(unit)
    notes = [f"pre-check: {closes.sum()} of {contacts.m} channels kept (linear gap falls to {margin} or less)"]
    if measured.any():
        notes.append(f"pre-check: {measured.sum()} channels that cannot close are kept: a test has their gap or force")
    if not closes.any():
        notes.append(nothing_closes(contacts, smallest, margin, unit))
    return contacts.select(np.flatnonzero(closes | measured)), notes


def with_linear_gaps(
    table: PrecheckTable, reduction: Reduction, marching: Marching, reference: ReferenceModel, progress: Progress
) -> ReferenceModel:
    """The same with the gaps of a run without contact, where the study asks for a pre-check and the structure is held.

    The run uses the modes of the assembly on top of the quasi-static motion of its supports and loads. A gap that
    still shrinks from period to period counts as what it comes to (`steady.growth`).
    """
    contacts, repeats = reduction.exterior.contacts, marching.course.repeats
    if not table.enabled or contacts.m == 0 or reference.stiffness is None:
        return reference

    def run() -> dict[str, FloatArray]:
        system = linear_system(reduction, reference)
        silent = linear_gaps(marching, contacts, system, lambda done, total: progress("linear pre-check", done, total))
        lowest, on = silent.lowest - contacts.gap0, growth(marching.ends, silent.at, repeats)
        if on is not None:
            lowest = np.minimum(lowest, on.in_the_end - contacts.gap0)
        return {"closes": lowest, "closed": closed_in(silent.at)}

    made_from: list[str] = []
    if reference.store is not None:
        of_structure = digest_of_structure(reduction.exterior, reference)
        made_from = [of_structure, *_made_from(reduction.structure, marching, contacts), repr(repeats)]
    found = solved(reference.store, "precheck", made_from, run)
    return replace(reference, linear_gaps=contacts.gap0 + found["closes"], linear_closed=found["closed"])


def _made_from(structure: Structure, marching: Marching, contacts: GapOperator) -> list[str]:
    """What the motion of the gaps without contact depends on beside the structure; their size is not among it."""
    table, loads = marching.table, marching.loads
    damping = [structure.rayleigh, structure.override_damping, structure.modal]
    driven = [loads.time, loads.support, loads.force]
    asked = [contacts.G, repr(marching.scheme), table.exact, table.substeps]
    return [digest(one) for one in (damping, driven, asked)]


def linear_system(reduction: Reduction, reference: ReferenceModel) -> System:
    """The small System of the pre-check: the modes of the assembly on the quasi-static motion of supports and forces.

    It is kept without damping, which is laid over it: other damping and other loads need no matrix of the whole.

    Where parts damp by themselves (dashpots, materials with other Rayleigh numbers), with all matrices of the whole.
    """
    structure, exterior = reduction.structure, reduction.exterior
    own = any(s.damping.extra is not None for s in structure.superelements)
    if own or damps_by_itself(structure.model, structure.rayleigh, structure.override_damping):
        return in_modes(reference, reduction)
    made_from = [] if reference.store is None else [digest_of_structure(exterior, reference)]
    at = np.unique(np.concatenate([exterior.contacts.labels, *exterior.forces]))
    kept = solved(reference.store, "linear", made_from, lambda: _undamped(reference, reduction, at))
    return _damped(structure, reference.modes.omega2, kept, at)


def digest_of_structure(exterior: Exterior, reference: ReferenceModel) -> str:
    """Of all that the System depends on but damping."""
    asked: list[object] = [reference.key, reference.modes.omega2, exterior.forces, exterior.contacts.labels]
    if reference.of_parts is not None:
        asked += [reference.of_parts, exterior.connectors, exterior.watch.nodes]  # their motion is kept of the parts
    return digest(asked)


def _undamped(reference: ReferenceModel, reduction: Reduction, at: IntArray) -> dict[str, FloatArray]:
    """The numbers of the System, its motion at some dofs."""
    whole, found = reference.system, reference.modes
    none = replace(whole.supports, C_qs=np.zeros_like(whole.supports.C_qs), C_ss=np.zeros_like(whole.supports.C_ss))
    ones = Damping(modal_shapes=np.asarray(whole.M @ found.shapes), modal_values=np.ones(found.omega2.size))
    small = in_modes(reference, reduction, replace(whole, damping=ones, supports=none))
    rows, rows_s = small.rows(at)
    assert small.damping.modal_shapes is not None
    numbers = {"m": small.M.diagonal(), "k": small.K.diagonal(), "velocity": small.velocity}
    shapes = {"W": small.damping.modal_shapes, "rows": rows, "rows_s": rows_s}
    return {**numbers, **shapes, **{name: np.asarray(getattr(small.supports, name)) for name in SIDES}}


def _damped(structure: Structure, omega2: FloatArray, kept: dict[str, FloatArray], labels: IntArray) -> System:
    """The System of these numbers with the damping of the study.

    Parameters
    ----------
    omega2 : of the modes of the assembly. labels : dofs at which its motion is kept.
    """
    n, names = kept["m"].size, structure.driven.names
    zeta, damping = structure.modal, Damping(structure.rayleigh.alpha, structure.rayleigh.beta)
    if zeta is not None:
        beta, d = modal_values(omega2, zeta, beyond=True)
        damping = Damping(0.0, beta, None, kept["W"][:, d != 0.0], d[d != 0.0])
    side = {name: kept[name] for name in SIDES}
    still = {"C_qs": np.zeros((n, len(names))), "C_ss": np.zeros((len(names), len(names)))}

    def rows(wanted: IntArray) -> tuple[FloatArray, FloatArray]:
        at = np.searchsorted(labels, wanted)
        assert np.array_equal(labels[at], wanted), "neither at a channel nor under a force"
        return kept["rows"][at], kept["rows_s"][at]

    return System(
        "pre-check",
        Diagonal(kept["m"]),
        Diagonal(kept["k"]),
        damping,
        rows,
        Supports(names, **side, **still),
        np.full(n, -1, dtype=np.int64),
        kept["velocity"],
        labels=labels,
    )


def ready(
    setup: Setup, progress: Progress, store: Path | None = None, compiled: Compiled | None = None
) -> tuple[Setup, ReferenceModel, GapOperator, list[str]]:
    """The setup at its start, the unreduced model, the channels that the pre-check keeps (connectors last), notes.

    Nothing holds the factor of the whole any longer.

    Parameters
    ----------
    store : folder of saved superelements, beside which what was solved is kept.
    compiled : waits for the kernels of the state at rest, and of forced steps.

    Raises
    ------
    OutOfMemory : memory holds neither a factor of the whole model nor those of its parts, or the study needs the whole.
    """
    reference = reference_that_fits(setup.reduction, setup.takes_whole, progress, store)
    if compiled is not None and (setup.solves_rest or not setup.study.config.time.exact):
        compiled(progress, steps=setup.solves_rest)
    setup = started(setup, reference, progress)
    c, mass = setup.study.config, reference.system.stats.mass
    figures = figure_warnings(setup.model, c.model.units, mass, reference.modes.omega2)
    reference = with_linear_gaps(c.precheck, setup.reduction, setup.marching, reference, progress)
    tested = frozenset[str]().union(*(test.contacts for test in setup.tests))
    kept, notes = prechecked(c.precheck, setup.contacts, reference.linear_gaps, UNITS[c.model.units].length, tested)
    if c.reduction.method != WHOLE:
        reference.release()
    whole = [] if reference.of_parts is None else [WITHOUT_WHOLE]
    started_so = velocity_warnings(setup.model, reference.system, UNITS[c.model.units].speed)
    return setup, reference, join([kept, setup.connectors]), [*figures, *started_so, *whole, *notes]


def with_closed(
    table: PrecheckTable,
    contacts: GapOperator,
    connectors: GapOperator,
    unit: str,
    gaps: GapOperator,
    history: History,
) -> tuple[GapOperator, str] | None:
    """The channels with those dropped ones that came within the pre-check's margin, and a note; None: none closed.

    Parameters
    ----------
    contacts, connectors : all channels. unit : of length. gaps : those of the run.
    """
    seen = history.extremes
    if seen is None or not seen.silent or seen.gap.min() > 0.0:
        return None
    smallest = dict(zip(seen.silent, seen.gap, strict=True))
    enough = table.near(contacts.gap0)
    near = {name for name, at in zip(contacts.names, enough, strict=True) if smallest.get(name, np.inf) <= at}
    kept = near | set(gaps.names)
    contacts = contacts.select(np.flatnonzero([name in kept for name in contacts.names]))
    k = int(seen.gap.argmin())
    note = (
        f"pre-check: {int((seen.gap <= 0.0).sum())} channel(s) that the linear run let stay open closed in the "
        f"nonlinear one, farthest {seen.silent[k]}, by {-seen.gap[k]:.3g} {unit} at t = {seen.gap_at[k]:.4g} s; the "
        f"run was made again with {len(near)} more kept"
    )
    return join([contacts, connectors]), note


def may_have_rung(dropped: GapOperator) -> str:
    """What is said of channels whose run is made again."""
    return (
        f"contact makes parts ring so that {dropped.m} gap(s) which the pre-check dropped may have closed between two "
        "steps: the run is made again with them"
    )


def sure_of_dropped(contacts: GapOperator, run: Run, again: Callable[[GapOperator], Run]) -> Run:
    """A run that knows whether the dropped channels closed that its modes may have rung shut between two steps.

    Parameters
    ----------
    contacts : all channels. again : the run of the same model, these channels with those of its own.
    """
    seen = run.history.extremes
    if seen is None or run.stopped is not None:
        return run
    maybe = doubtful_channels(contacts, seen)
    if not maybe.m:
        return run
    more = again(maybe)
    if more.stopped is not None:
        return replace(run, stopped=more.stopped)
    h, gap, gap_at, least = more.history, seen.gap.copy(), seen.gap_at.copy(), seen.least.copy()
    for k, name in zip(seen.doubtful, maybe.names, strict=True):
        own = more.gaps.names.index(name)
        lowest = int(h.gap[:, own].argmin())
        if h.gap[lowest, own] < gap[k]:
            gap[k], gap_at[k] = h.gap[lowest, own], h.time[lowest]
        least[k] = gap[k]
    extremes = replace(seen, gap=gap, gap_at=gap_at, least=least)
    return replace(run, history=replace(run.history, extremes=extremes))


def run_with_closed(
    gaps: GapOperator,
    limit: Callable[[GapOperator], tuple[GapOperator, list[str]]],
    closed: Callable[[GapOperator, History], tuple[GapOperator, str] | None],
    make: Callable[[GapOperator, bool], tuple[T, Run]],
) -> tuple[GapOperator, T, list[str]]:
    """A run of some channels, again with those dropped ones that close in it: the channels, what was found, notes.

    Parameters
    ----------
    limit : of stiffness, as `integrate.limited`. closed : as `with_closed`.
    make : what is found with channels, and its run; it is told whether that is the last one.
    """
    notes: list[str] = []
    for left in reversed(range(MOST_RUNS)):
        gaps, more = limit(gaps)
        found, run = make(gaps, not left)
        again = closed(gaps, run.history) if left and run.stopped is None else None
        if again is None:
            break
        gaps = again[0]
        notes.append(again[1])
    return gaps, found, [*notes, *more]


def velocity_warnings(model: Model, system: System, unit: str) -> list[str]:
    """Dofs that follow others and start with another velocity than the deck gives them; unit : of speed."""
    labels, at = np.unique(started_labels(model)[::-1], return_index=True)  # the last one given counts
    if not labels.size:
        return []
    given = np.array([value for _, _, value in model.initial_velocity])[::-1][at]
    rows = system.rows(labels)[0]
    found = np.asarray(rows @ system.velocity)
    off = (np.abs(found - given) > SAME * np.abs(given).max()) & rows_with_entries(rows)
    if not off.any():
        return []
    k = int(np.argmax(np.where(off, np.abs(found - given), -1.0)))
    unit = unit if node_and_dof(int(labels[k]))[1] in TRANSLATIONS else "rad/s"
    others = f" and {off.sum() - 1} more dofs" if off.sum() > 1 else ""
    return [
        Warned(
            f"{model.dof_name(int(labels[k]))}{others} cannot have the initial velocity of the deck beside those of "
            f"the nodes that it is linked to: it starts with {found[k]:.4g} instead of {given[k]:.4g} {unit}, so that "
            "the momentum is that of the deck; give all linked nodes velocities that fit together"
        )
    ]
