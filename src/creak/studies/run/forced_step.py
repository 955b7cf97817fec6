"""Contact springs that a forced step can carry, and events that it cannot follow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.condensed import step_limited_stiffness
from creak.studies.prepare.marching import Marching
from creak.verify.events import Event

SHARE = 0.1
"""Longest step as a share of the shortest event."""


def limited(
    marching: Marching, coords: FloatArray, system: System, unit: str, gaps: GapOperator
) -> tuple[GapOperator, list[str]]:
    """Channels with automatic penalties lowered to what a forced step resolves, and a note of it.

    Parameters
    ----------
    coords : (n_node, 3). system : of the unreduced model. unit : of stiffness.
    """
    if marching.table.exact:
        return gaps, []
    positions, step = coords[gaps.nodes_idx], marching.loads.step
    stiffness = step_limited_stiffness(system, gaps, positions, marching.scheme, step)
    return gaps.with_stiffness(stiffness), _note_of_limit(gaps, stiffness, step, unit)


def _note_of_limit(gaps: GapOperator, stiffness: FloatArray, step: float, unit: str) -> list[str]:
    lowered = np.flatnonzero(stiffness < gaps.stiffness)
    if not lowered.size:
        return []
    before, after = (float(np.median(k[lowered])) for k in (gaps.stiffness, stiffness))
    return [
        f"automatic contact stiffness: {lowered.size} of {gaps.m} channels lowered to what a step of {step:g} s "
        f"resolves (median {before:.3g} to {after:.3g} {unit}); a shorter step gives harder contact and less "
        "penetration"
    ]


def step_warnings(marching: Marching, events: Sequence[Event]) -> list[str]:
    """A step longer than a tenth of the shortest contact event cannot follow its force."""
    step = marching.loads.step
    if marching.table.exact:
        return []
    short = min(events, key=lambda e: e.t_end - e.t_start, default=None)
    if short is None or step <= SHARE * (short.t_end - short.t_start):
        return []
    return [
        f"the step near contact, {step:g} s, is longer than a tenth of the shortest event "
        f"({short.t_end - short.t_start:.3g} s at {short.channel}, t = {short.t_start:.4g} s): its force is not "
        f"resolved; set [time] substeps, or compare with `creak run --converge`"
    ]
