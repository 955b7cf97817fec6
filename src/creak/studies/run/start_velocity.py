"""Initial velocities of a deck that its links do not let the structure have."""

from __future__ import annotations

import numpy as np

from creak.assembly.part import started_labels
from creak.assembly.system import System, rows_with_entries
from creak.model.mesh import Model
from creak.studies.models.dof_names import dof_name
from creak.studies.warned import Warned

SAME = 1e-6
"""Share of the largest initial velocity from which on a node starts with another one than it was given."""


def velocity_warnings(model: Model, system: System) -> list[str]:
    """Dofs that follow others and start with another velocity than the deck gives them."""
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
    others = f" and {off.sum() - 1} more dofs" if off.sum() > 1 else ""
    return [
        Warned(
            f"{dof_name(model, int(labels[k]))}{others} cannot have the initial velocity of the deck beside those of "
            f"the nodes that it is linked to: it starts with {found[k]:.4g} instead of {given[k]:.4g}, so that the "
            "momentum is that of the deck; give all linked nodes velocities that fit together"
        )
    ]
