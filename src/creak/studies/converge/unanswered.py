"""Runs that answer nothing: nothing in them could touch, or nothing came nearer."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.studies.run.compared import main_run
from creak.studies.run.job import StudyResult

MOVED = 1e-9
"""Share of its gap at rest by which a channel must close to have moved: above round-off, far below anything else."""


def unanswered(result: StudyResult) -> str | None:
    """Why a run says nothing of rattle, in a sentence; None: it does, whatever it says."""
    if why := result.setup.no_contact:
        return why
    run = main_run(result.runs)
    if run is None or run.history.force.any():
        return None
    h, linear = run.history, result.reference.linear_gaps
    closed = _closed(result.gaps.gap0, h.gap.min(axis=0, initial=np.inf))
    if not closed and linear is not None:
        closed = _closed(result.setup.contacts.gap0, linear)
    if closed:
        return None
    return (
        "no gap of its contacts and connectors becomes smaller than it is at rest, so nothing can rattle: what drives "
        "the model is zero, or does not reach them"
    )


def _closed(at_rest: FloatArray, smallest: FloatArray) -> bool:
    return bool((at_rest - smallest > MOVED * np.abs(at_rest)).any())
