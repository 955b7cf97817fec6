"""Matrices for other programs: of a deck, parts joined and supports held, and of a superelement."""

from __future__ import annotations

from dataclasses import replace
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


def deck_matrices(model: Model) -> tuple[Superelement, str]:
    """K, M and C (None without damping) of all independent, free dofs, with node label, dof and place of each row, and
    a note of numbers that nodes get where instances share labels.

    Raises
    ------
    InputError : nothing is free to move.
    """
    common = common_rayleigh(model)
    parts = [part_system(model, i, common) for i in range(len(model.parts))]
    loose = loose_system(model, common)
    system = couple([*parts, loose] if loose else parts, model, Driven({}), common)
    if not system.n:
        raise InputError("nothing is free to move: the matrices are empty", where=model.source, fix="Free some dofs.")
    numbered, note = model, ""
    if np.unique(model.nodes.ids).size < model.nodes.count:
        numbered, note = _by_instance(model)
    return named_rows(system, Path(model.source).stem, numbered), note


def _by_instance(model: Model) -> tuple[Model, str]:
    """Nodes whose labels instances share, numbered by instance and label; and a note that tells how."""
    nodes = model.nodes
    block = 10 ** len(str(int(nodes.ids.max())))
    told = ", ".join(f"{block * (k + 1):,} + label are of {name}" for k, name in enumerate(nodes.instance))
    ids = nodes.ids + block * (nodes.instance_idx + 1)
    return replace(model, nodes=replace(nodes, ids=ids)), f"instances share labels, so nodes have numbers: {told}"


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
