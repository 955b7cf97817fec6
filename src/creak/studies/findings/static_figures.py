"""summary.json, `static`: what a run starts from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.dofs import dofs_of, node_dofs, nodes_of
from creak.model.mesh import Nodes
from creak.studies.prepare.static_loads import StaticStart

AXES = ("x", "y", "z", "rx", "ry", "rz")


def static_figures(
    start: StaticStart, nodes: Nodes, watched: IntArray, groups: Sequence[str], gravity: FloatArray
) -> dict[str, Any]:
    """Sag of the watched nodes, channels that press, by contact, and the checks.

    Parameters
    ----------
    groups : contact or connector of each channel. gravity : (3,) length/time^2.
    """
    state = start.state
    u = start.at(node_dofs(watched)).reshape(-1, 6)
    translations = np.flatnonzero(dofs_of(start.labels) <= 3)
    top = translations[np.argmax(np.abs(start.displacement[translations]))]
    contacts, every = {}, np.array(groups)
    for name in dict.fromkeys(groups):
        mine = every == name
        pressing = mine & (state.force > 0.0)
        contacts[name] = {
            "force": float(state.force[mine].sum()),
            "friction": float(np.linalg.norm(state.held[mine], axis=1).sum()),
            "channels": {start.names[k]: float(state.force[k]) for k in np.flatnonzero(pressing)},
            "gap_min": float(state.gap[mine].min()),
        }
    return {
        "gravity": gravity.tolist(),
        "largest": {
            "node": nodes.label(int(nodes_of(start.labels[top]))),
            "dof": AXES[int(dofs_of(start.labels[top])) - 1],
            "displacement": float(start.displacement[top]),
        },
        "nodes": {
            nodes.label(int(n)): dict(zip(AXES, row, strict=True)) for n, row in zip(watched, u.tolist(), strict=True)
        },
        "contacts": contacts,
        "increments": state.increments,
        "residual": state.residual,
        "energy_error": state.energy_error,
        "strain_energy": state.strain,
        "contact_energy": state.contact,
    }
