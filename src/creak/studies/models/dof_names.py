"""Names of dofs in messages and files."""

from __future__ import annotations

import numpy as np

from creak.arrays import IntArray
from creak.assembly.system import System
from creak.model.dofs import dofs_of, node_and_dof, nodes_of
from creak.model.mesh import Model


def dof_name(model: Model, label: int) -> str:
    """`node 17 RZ of part FRAME`."""
    parts = [p.name for p in model.parts if np.isin(node_and_dof(label)[0], p.nodes_idx)]
    return model.nodes.dof_name(label) + (f" of part {parts[0]}" if parts else "")


def row_names(system: System, model: Model) -> tuple[IntArray, IntArray]:
    """Node label and dof of each coordinate, 0 for generalised ones."""
    c = system.coordinates
    ids = np.where(c >= 0, model.nodes.ids[nodes_of(np.maximum(c, 0))], 0)
    return ids.astype(np.int64), np.where(c >= 0, dofs_of(np.maximum(c, 0)), 0).astype(np.int64)
