"""The linear pre-check: which contact channels can close at all (thesis 3.3.2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.scheme import Scheme
from creak.progress import Progress
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.start_check import nothing_closes
from creak.studies.run.integrate import linear_run
from creak.studies.run.kernels import needs_solver
from creak.studies.run.linear_model import linear_system, structure_of
from creak.studies.solved import digest_of_record, solved


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
        system = linear_system(setup, reference)
        history = linear_run(setup, system, scheme, lambda done, total: progress("linear pre-check", done, total))
        return {"closes": np.asarray((history.gap - setup.contacts.gap0).min(axis=0))}

    made_from = [] if reference.store is None else _made_from(setup, reference, scheme)
    return np.asarray(setup.contacts.gap0 + solved(reference.store, "precheck", made_from, run)["closes"])


def _made_from(setup: Setup, reference: ReferenceModel, scheme: Scheme) -> list[str]:
    """All that the motion of the gaps without contact depends on; their size is not among it."""
    table, contacts, loads = setup.study.config.time, setup.contacts, setup.loads
    damping = [setup.rayleigh, setup.override_damping, setup.study.config.damping.modal]
    driven = [loads.time, loads.support, loads.force]
    asked = [contacts.G, repr(scheme), table.exact, table.substeps, needs_solver(setup)]
    return [*structure_of(setup, reference), *(digest_of_record(one) for one in (damping, driven, asked))]
