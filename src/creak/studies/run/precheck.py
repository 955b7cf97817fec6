"""The linear pre-check: which contact channels can close at all (thesis 3.3.2)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.damping import Damping
from creak.assembly.part import damps_by_itself
from creak.assembly.system import Supports, System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.history import History
from creak.dynamics.scheme import Scheme
from creak.linalg.diagonal import Diagonal
from creak.progress import Progress
from creak.reduction.modal import modal_system, modal_values
from creak.studies.models.reduced import WHOLE
from creak.studies.models.reference import ReferenceModel, build_reference, static_shapes
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.start_check import figure_warnings, nothing_closes
from creak.studies.run.foretold import closed_in
from creak.studies.run.integrate import linear_run, scheme_of
from creak.studies.run.kernels import needs_solver
from creak.studies.run.static_start import begin
from creak.studies.solved import digest_of_record, solved

SIDES = ("M_qs", "K_qs", "M_ss", "K_ss", "M_start")
"""Of the supports."""
WITHOUT_WHOLE = (
    "memory does not hold a factor of the whole model: the linear pre-check is that of its parts, reduced to what "
    "joins them, and modes of reduced and unreduced model are not compared"
)
MOST_RUNS = 3
"""Runs of a model until what closes must be among its channels; a red verdict says where it is not."""


def precheck(
    setup: Setup, reference: ReferenceModel, scheme: Scheme, progress: Progress
) -> tuple[GapOperator, list[str]]:
    """Contact channels whose gap falls to the margin in a linear run (thesis 3.3.2).

    The run uses the modes of the assembly on top of the quasi-static motion of its supports and loads.
    """
    return prechecked(setup, with_linear_gaps(setup, reference, scheme, progress))


def with_linear_gaps(setup: Setup, reference: ReferenceModel, scheme: Scheme, progress: Progress) -> ReferenceModel:
    """The same with the gaps of the linear run, where the study asks for a pre-check and the structure is held."""
    if not setup.study.config.precheck.enabled or setup.contacts.m == 0 or reference.stiffness is None:
        return reference
    gaps, closed = linear_course(setup, reference, scheme, progress)
    return replace(reference, linear_gaps=gaps, linear_closed=closed)


def prechecked(setup: Setup, reference: ReferenceModel) -> tuple[GapOperator, list[str]]:
    """Channels that the gaps of the linear run let close, and a note of it."""
    table, contacts = setup.study.config.precheck, setup.contacts
    if not table.enabled or contacts.m == 0:
        return contacts, []
    if reference.linear_gaps is None:
        return contacts, ["the pre-check was skipped: only contact holds the structure; all channels are kept"]
    keep = np.flatnonzero(reference.linear_gaps <= table.near(contacts.gap0))
    note = f"pre-check: {keep.size} of {contacts.m} channels kept (linear gap falls to {table.words()} or less)"
    return contacts.select(keep), [note] if keep.size else [
        note,
        nothing_closes(contacts, reference.linear_gaps, table.words()),
    ]


def linear_gaps(setup: Setup, reference: ReferenceModel, scheme: Scheme, progress: Progress) -> FloatArray:
    """(m,) smallest gap of every contact channel over a run without contact."""
    return linear_course(setup, reference, scheme, progress)[0]


def linear_course(
    setup: Setup, reference: ReferenceModel, scheme: Scheme, progress: Progress
) -> tuple[FloatArray, FloatArray]:
    """Of a run without contact: (m,) smallest gap of every channel, and (2,) how long and how many are closed."""

    def run() -> dict[str, FloatArray]:
        system = linear_system(setup, reference)
        history = linear_run(setup, system, scheme, lambda done, total: progress("linear pre-check", done, total))
        lowest = np.asarray((history.gap - setup.contacts.gap0).min(axis=0))
        return {"closes": lowest, "closed": closed_in(history.gap)}

    made_from = [] if reference.store is None else [*_made_from(setup, reference, scheme), "and how long"]
    found = solved(reference.store, "precheck", made_from, run)
    return setup.contacts.gap0 + found["closes"], found["closed"]


def _made_from(setup: Setup, reference: ReferenceModel, scheme: Scheme) -> list[str]:
    """All that the motion of the gaps without contact depends on; their size is not among it."""
    table, contacts, loads = setup.study.config.time, setup.contacts, setup.loads
    damping = [setup.rayleigh, setup.override_damping, setup.study.config.damping.modal]
    driven = [loads.time, loads.support, loads.force]
    asked = [contacts.G, repr(scheme), table.exact, table.substeps, needs_solver(setup)]
    return [*structure_of(setup, reference), *(digest_of_record(one) for one in (damping, driven, asked))]


def linear_system(setup: Setup, reference: ReferenceModel) -> System:
    """The small System of the pre-check: the modes of the assembly on the quasi-static motion of supports and forces.

    It is kept without damping, which is laid over it: other damping and other loads need no matrix of the whole.

    Where parts damp by themselves (dashpots, materials with other Rayleigh numbers), with all matrices of the whole.
    """
    own = any(s.damping.extra is not None for s in setup.superelements)
    if own or damps_by_itself(setup.model, setup.rayleigh, setup.override_damping):
        R = reference.support_shapes
        return modal_system(
            reference.system, reference.modes, R, static_shapes(setup.loads, reference, setup.reduction)
        )
    made_from = [] if reference.store is None else structure_of(setup, reference)
    kept = solved(reference.store, "linear", made_from, lambda: _undamped(setup, reference))
    return _damped(setup, reference, kept)


def structure_of(setup: Setup, reference: ReferenceModel) -> list[str]:
    """Digests of all that the System depends on but damping."""
    contacts = setup.contacts
    asked: list[object] = [reference.key, reference.modes.omega2, setup.loads.force_labels, contacts.labels]
    if reference.of_parts is not None:
        asked += [reference.of_parts, setup.connectors.labels, setup.watched]  # their motion is kept of the parts
    return [digest_of_record(asked)]


def _undamped(setup: Setup, reference: ReferenceModel) -> dict[str, FloatArray]:
    whole, found = reference.system, reference.modes
    none = replace(whole.supports, C_qs=np.zeros_like(whole.supports.C_qs), C_ss=np.zeros_like(whole.supports.C_ss))
    ones = Damping(modal_shapes=np.asarray(whole.M @ found.shapes), modal_values=np.ones(found.omega2.size))
    bare = replace(whole, damping=ones, supports=none)
    small = modal_system(bare, found, reference.support_shapes, static_shapes(setup.loads, reference, setup.reduction))
    rows, rows_s = small.rows(_seen(setup))
    assert small.damping.modal_shapes is not None
    numbers = {"m": small.M.diagonal(), "k": small.K.diagonal(), "velocity": small.velocity}
    shapes = {"W": small.damping.modal_shapes, "rows": rows, "rows_s": rows_s}
    return {**numbers, **shapes, **{name: np.asarray(getattr(small.supports, name)) for name in SIDES}}


def _seen(setup: Setup) -> IntArray:
    """Dofs whose motion is looked at (channels), or on which a force acts."""
    return np.unique(np.concatenate([setup.contacts.labels, *setup.loads.force_labels]))


def _damped(setup: Setup, reference: ReferenceModel, kept: dict[str, FloatArray]) -> System:
    n, names, labels = kept["m"].size, setup.driven.names, _seen(setup)
    zeta, damping = setup.study.config.damping.modal, Damping(setup.rayleigh.alpha, setup.rayleigh.beta)
    if zeta is not None:
        beta, d = modal_values(reference.modes.omega2, zeta, beyond=True)
        damping = Damping(0.0, beta, None, kept["W"][:, d > 0.0], d[d > 0.0])
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
    setup: Setup, progress: Progress, store: Path | None = None
) -> tuple[Setup, ReferenceModel, GapOperator, list[str]]:
    """The setup at its start, and what `prepare` gives; nothing holds the factor of the whole any longer.

    Parameters
    ----------
    store : folder of saved superelements, beside which what was solved is kept.
    """
    setup, built = begin(setup, progress, store)
    return (setup, *prepare(setup, progress, built))


def prepare(
    setup: Setup, progress: Progress, reference: ReferenceModel | None = None
) -> tuple[ReferenceModel, GapOperator, list[str]]:
    """The unreduced model, made here or by `begin`, the channels that the pre-check keeps (connectors last), notes."""
    reference = reference or build_reference(setup, progress)
    mass, units = reference.system.stats.mass, setup.study.config.model.units
    figures = figure_warnings(setup.model, units, mass, reference.modes.omega2)
    reference = with_linear_gaps(setup, reference, scheme_of(setup.study.config.time), progress)
    kept, notes = prechecked(setup, reference)
    if setup.study.config.reduction.method != WHOLE:
        reference.release()
    whole = [] if reference.of_parts is None else [WITHOUT_WHOLE]
    return reference, join([kept, setup.connectors]), [*figures, *whole, *notes]


def with_closed(setup: Setup, gaps: GapOperator, history: History) -> tuple[GapOperator, str] | None:
    """The channels with those dropped ones that came within the pre-check's margin, and a note; None: none closed."""
    seen = history.extremes
    if seen is None or not seen.silent or seen.gap.min() > 0.0:
        return None
    smallest = dict(zip(seen.silent, seen.gap, strict=True))
    enough = setup.study.config.precheck.near(setup.contacts.gap0)
    near = {name for name, at in zip(setup.contacts.names, enough, strict=True) if smallest.get(name, np.inf) <= at}
    kept = near | set(gaps.names)
    contacts = setup.contacts.select(np.flatnonzero([name in kept for name in setup.contacts.names]))
    k = int(seen.gap.argmin())
    note = (
        f"pre-check: {int((seen.gap <= 0.0).sum())} channel(s) that the linear run let stay open closed in the "
        f"nonlinear one, farthest {seen.silent[k]}, by {-seen.gap[k]:.3g} at t = {seen.gap_at[k]:.4g} s; the run was "
        f"made again with {len(near)} more kept"
    )
    return join([contacts, setup.connectors]), note
