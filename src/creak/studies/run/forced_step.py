"""Contact springs that a forced step can carry."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.condensed import step_limited_stiffness
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.setup import Setup
from creak.studies.run.integrate import scheme_of


def limited(setup: Setup, reference: ReferenceModel, gaps: GapOperator) -> tuple[GapOperator, list[str]]:
    """Channels with automatic penalties lowered to what a forced step resolves, and a note of it."""
    if setup.study.config.time.exact:
        return gaps, []
    positions, step = setup.model.nodes.coords[gaps.nodes_idx], setup.loads.step
    stiffness = step_limited_stiffness(reference.system, gaps, positions, scheme_of(setup.study.config.time), step)
    return gaps.with_stiffness(stiffness), _note_of_limit(gaps, stiffness, step)


def _note_of_limit(gaps: GapOperator, stiffness: FloatArray, step: float) -> list[str]:
    lowered = np.flatnonzero(stiffness < gaps.stiffness)
    if not lowered.size:
        return []
    before, after = (float(np.median(k[lowered])) for k in (gaps.stiffness, stiffness))
    return [
        f"automatic contact stiffness: {lowered.size} of {gaps.m} channels lowered to what a step of {step:g} s "
        f"resolves (median {before:.3g} to {after:.3g}); a shorter step gives harder contact and less penetration"
    ]
