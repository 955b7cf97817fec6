"""Channels that the linear pre-check dropped and the nonlinear run closes: the run is made again with them."""

from __future__ import annotations

import numpy as np

from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.history import History
from creak.studies.prepare.setup import Setup

MOST_RUNS = 3
"""Runs of a model until what closes must be among its channels; a red verdict says where it is not."""


def with_closed(setup: Setup, gaps: GapOperator, history: History) -> tuple[GapOperator, str] | None:
    """The channels with those dropped ones that came within the pre-check's margin, and a note; None: none closed."""
    seen = history.extremes
    if seen is None or not seen.silent or seen.gap.min() > 0.0:
        return None
    near = {name for name, gap in zip(seen.silent, seen.gap, strict=True) if gap <= setup.study.config.precheck.margin}
    kept = near | set(gaps.names)
    contacts = setup.contacts.select(np.flatnonzero([name in kept for name in setup.contacts.names]))
    k = int(seen.gap.argmin())
    note = (
        f"pre-check: {int((seen.gap <= 0.0).sum())} channel(s) that the linear run let stay open closed in the "
        f"nonlinear one, farthest {seen.silent[k]}, by {-seen.gap[k]:.3g} at t = {seen.gap_at[k]:.4g} s; the run was "
        f"made again with {len(near)} more kept"
    )
    return join([contacts, setup.connectors]), note
