"""The linear pre-check: which contact channels can close at all (thesis 3.3.2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.scheme import Scheme
from creak.progress import Progress
from creak.reduction.modal import modal_system
from creak.studies.models.reference import ReferenceModel, force_columns, static_shapes
from creak.studies.models.solved import digest_of, solved
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.start_check import nothing_closes
from creak.studies.run.integrate import linear_run


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
    return replace(reference, linear_gaps=linear_gaps(setup, reference, scheme, progress))


def prechecked(setup: Setup, reference: ReferenceModel) -> tuple[GapOperator, list[str]]:
    """Channels that the gaps of the linear run let close, and a note of it."""
    table, contacts = setup.study.config.precheck, setup.contacts
    if not table.enabled or contacts.m == 0:
        return contacts, []
    if reference.linear_gaps is None:
        return contacts, ["the pre-check was skipped: only contact holds the structure; all channels are kept"]
    keep = np.flatnonzero(reference.linear_gaps <= table.margin)
    note = f"pre-check: {keep.size} of {contacts.m} channels kept (linear gap falls to {table.margin:g} or less)"
    return contacts.select(keep), [note] if keep.size else [
        note,
        nothing_closes(contacts, reference.linear_gaps, table.margin),
    ]


def linear_gaps(setup: Setup, reference: ReferenceModel, scheme: Scheme, progress: Progress) -> FloatArray:
    """(m,) smallest gap of every contact channel over a run without contact."""

    def run() -> dict[str, FloatArray]:
        R = reference.support_shapes
        assert reference.stiffness is not None
        system = modal_system(reference.system, reference.modes, R, static_shapes(setup, reference))
        history = linear_run(setup, system, scheme, lambda done, total: progress("linear pre-check", done, total))
        return {"closes": np.asarray((history.gap - setup.contacts.gap0).min(axis=0))}

    made_from = [] if reference.store is None else _made_from(setup, reference, scheme)
    return np.asarray(setup.contacts.gap0 + solved(reference.store, "precheck", made_from, run)["closes"])


def _made_from(setup: Setup, reference: ReferenceModel, scheme: Scheme) -> list[str]:
    """All that the motion of the gaps without contact depends on; their size is not among it."""
    system, loads, found, table = reference.system, setup.loads, reference.modes, setup.study.config.time
    d, s, contacts = system.damping, system.supports, setup.contacts
    matrices = [system.K, system.M, d.extra, d.modal_shapes, d.modal_values, s.M_qs, s.K_qs, s.C_qs, s.M_ss, s.K_ss]
    matrices += [s.C_ss, s.M_start, system.velocity, found.omega2, found.shapes, reference.support_shapes]
    matrices += [*system.combined(contacts.G, contacts.labels), force_columns(setup, system)]
    matrices += [loads.time, loads.support, loads.force]
    words = [repr(scheme), f"{d.alpha!r} {d.beta!r} {table.exact} {table.substeps} {contacts.m}"]
    return [*words, *("" if A is None else f"{A.shape} {digest_of(A)}" for A in matrices)]
