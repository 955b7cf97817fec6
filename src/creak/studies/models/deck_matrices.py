"""Matrices for other programs: of a deck, parts joined and supports held, and of a superelement."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from creak.assembly.coupling import Driven, couple
from creak.assembly.part import common_rayleigh, loose_system, part_system
from creak.assembly.system import System
from creak.errors import InputError
from creak.model.dofs import nodes_of
from creak.model.mesh import Model
from creak.model.superelement import Superelement
from creak.studies.models.dof_names import row_names


def deck_matrices(model: Model) -> Superelement:
    """K, M and C (None without damping) of all independent, free dofs, with node label, dof and place of each row.

    Raises
    ------
    InputError : two nodes (of different instances) have one label; nothing is free to move.
    """
    common = common_rayleigh(model)
    parts = [part_system(model, i, common) for i in range(len(model.parts))]
    loose = loose_system(model, common)
    system = couple([*parts, loose] if loose else parts, model, Driven({}), common)
    if not system.n:
        raise InputError("nothing is free to move: the matrices are empty", where=model.source, fix="Free some dofs.")
    found = named_rows(system, Path(model.source).stem, model)
    if np.unique(np.stack([found.node_ids, found.dofs]), axis=1).shape[1] < found.dofs.size:
        raise InputError(
            "nodes of different instances have one label, so that the rows of the matrices could not be told apart",
            where=model.source,
            fix="Renumber the nodes of one of them.",
        )
    return found


def named_rows(system: System, name: str, model: Model) -> Superelement:
    """A System for other programs: matrices with all damping, node labels and places."""
    ids, dofs = row_names(system, model)
    d, C = system.damping, system.damping.extra
    if d.alpha or d.beta:
        rayleigh = d.alpha * system.M + d.beta * system.K
        C = rayleigh if C is None else C + rayleigh
    nodes = np.unique(nodes_of(system.coordinates[system.coordinates >= 0]))
    places = {int(model.nodes.ids[k]): model.nodes.coords[k] for k in nodes}
    return Superelement(name, ids, dofs, system.K, system.M, C, places, model.source)
