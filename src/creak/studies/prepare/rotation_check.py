"""What acts on rotations of nodes that have none, as those of solids: it would be lost without a word."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.arrays import BoolArray, IntArray
from creak.assembly.coupling import Driven, labels_of
from creak.assembly.elimination import linear_equations
from creak.assembly.system import System
from creak.contact.play import Play, nodes_of_ends
from creak.errors import InputError
from creak.model.dofs import dofs_of, node_and_dof, nodes_of
from creak.model.materials import AxialSpring, PointMass, Section, SolidSection, Spring, TrussSection
from creak.model.mesh import Model
from creak.studies.file.case import Driving
from creak.studies.file.table import DOFS
from creak.studies.prepare.excitation import moved_before
from creak.studies.prepare.static_loads import static_forces

FIRST = 4
"""Number of the first dof that is a rotation."""


def check_rotations(
    model: Model,
    driving: Driving,
    driven: Driven,
    plays: Sequence[tuple[Play, str]],
    superelements: Sequence[System],
) -> None:
    """Raise InputError for an excitation, a static load or a connector on rotations that its nodes do not have."""
    asked = [(what, where, labels[dofs_of(labels) >= FIRST]) for what, where, labels in _asked(model, driving, driven)]
    asked += [("a connector", where, _turned(model, p, where)) for p, where in plays if p.dof >= FIRST]
    asked = [one for one in asked if one[2].size]
    if not asked:
        return
    turns = _turning(model, superelements)
    for what, where, labels in asked:
        still = labels[~turns[nodes_of(labels)]]
        if still.size:
            node, dof = node_and_dof(int(still[0]))
            raise InputError(
                f"{what} acts on {DOFS[dof - 1]} of node {model.nodes.label(node)}, which has no rotations: only "
                "solids, trusses, springs along axes or point masses without inertia are there",
                where=where,
                expected="nodes of shells or beams, or ones that a rigid body or a coupling turns",
                fix="Act on translations of several nodes, or on the reference node of a *COUPLING or an RBE2.",
            )


def _asked(model: Model, driving: Driving, driven: Driven) -> Iterator[tuple[str, str, IntArray]]:
    """What acts, where it stands, and on which labels."""
    places = driving.places
    for name, table in driving.forcing.items():
        nodes = model.node_set(table.node_set, where=places.where("excitation", name, "node_set"))
        yield "a moment", places.where("excitation", name, "dof"), labels_of(nodes, DOFS.index(table.dof) + 1)
    for name in driving.moving:
        yield "a prescribed rotation", places.where("excitation", name, "dof"), driven.labels[name]
    for where, labels, _ in static_forces(model, driving, spread=False):
        yield "a static moment", where, labels
    for motion in moved_before(model, driving):
        yield "a static rotation", motion.where, motion.labels


def _turned(model: Model, p: Play, where: str) -> IntArray:
    return labels_of(np.concatenate(nodes_of_ends(model, p.nodes, where)), p.dof)


def _turning(model: Model, superelements: Sequence[System]) -> BoolArray:
    """(n_node,) nodes whose rotations anything resists, ties or carries."""
    turns = np.zeros(model.nodes.count, dtype=bool)
    for block in model.blocks:
        if not _straight(block.section):
            turns[block.nodes_idx.ravel()] = True
    for c in model.constraints:
        tied = np.array([x for e in linear_equations(c, model.nodes.coords) for x in e.labels], dtype=np.int64)
        turns[nodes_of(tied[dofs_of(tied) >= FIRST])] = True
    for s in superelements:
        turns[nodes_of(s.labels[dofs_of(s.labels) >= FIRST])] = True
    return turns


def _straight(section: Section) -> bool:
    """Whether elements of a section give nothing to rotations."""
    if isinstance(section, PointMass):
        return not any((*section.inertia, *section.offset))
    if isinstance(section, Spring):
        return max(section.dof1, section.dof2) < FIRST
    return isinstance(section, SolidSection | TrussSection | AxialSpring)
