"""summary.json, `static`: what a run starts from."""

from __future__ import annotations

from typing import Any

import numpy as np

from creak.contact.gap_operator import join
from creak.model.dofs import dofs_of, node_dofs, nodes_of
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.static_loads import static_gravity

AXES = ("x", "y", "z", "rx", "ry", "rz")


def static_figures(setup: Setup) -> dict[str, Any] | None:
    """Sag of the watched nodes, channels that press, by contact, and the checks; None without a static start."""
    start = setup.static
    if start is None:
        return None
    state, nodes = start.state, setup.model.nodes
    u = start.at(node_dofs(setup.watched)).reshape(-1, 6)
    translations = np.flatnonzero(dofs_of(start.labels) <= 3)
    top = translations[np.argmax(np.abs(start.displacement[translations]))]
    groups = np.array(join([setup.contacts, setup.connectors]).group)
    contacts = {}
    for name in dict.fromkeys(groups.tolist()):
        mine = groups == name
        pressing = mine & (state.force > 0.0)
        contacts[name] = {
            "force": float(state.force[mine].sum()),
            "friction": float(np.linalg.norm(state.held[mine], axis=1).sum()),
            "channels": {start.names[k]: float(state.force[k]) for k in np.flatnonzero(pressing)},
            "gap_min": float(state.gap[mine].min()),
        }
    return {
        "gravity": static_gravity(setup.model, setup.study.driving).tolist(),
        "largest": {
            "node": nodes.label(int(nodes_of(start.labels[top]))),
            "dof": AXES[int(dofs_of(start.labels[top])) - 1],
            "displacement": float(start.displacement[top]),
        },
        "nodes": {
            nodes.label(int(n)): dict(zip(AXES, row, strict=True))
            for n, row in zip(setup.watched, u.tolist(), strict=True)
        },
        "contacts": contacts,
        "increments": state.increments,
        "residual": state.residual,
        "energy_error": state.energy_error,
        "strain_energy": state.strain,
        "contact_energy": state.contact,
    }
