"""Dofs in messages."""

from __future__ import annotations

import numpy as np

from creak.model.dofs import AXES, node_and_dof
from creak.model.mesh import Model


def dof_name(model: Model, label: int) -> str:
    """`node 17 RZ of part FRAME`."""
    node, dof = node_and_dof(label)
    parts = [p.name for p in model.parts if np.isin(node, p.nodes_idx)]
    of = f" of part {parts[0]}" if parts else ""
    return f"node {model.nodes.label(node)} {AXES[dof - 1]}{of}"
