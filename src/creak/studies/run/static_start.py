"""The static start of a study: equilibrium of the unreduced model under its [[static]] loads, with contact.

The run is then that of the motion u - u_static. Channels start from their static gaps, and what they carry is balanced
by the loads that hold them there, so neither model, reduced or not, has to carry the static shape: the reduction keeps
its boundary as it is, and at the boundary alone the channels act.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.part import Rayleigh, assemble_blocks
from creak.assembly.system import System
from creak.contact.gap_operator import join
from creak.dynamics.equilibrium import Equilibrium, equilibrium, rigid_load
from creak.dynamics.history import ENERGIES, History
from creak.errors import InputError
from creak.model.dofs import node_dofs
from creak.progress import Progress
from creak.studies.design.heat import heat_forces, heat_of
from creak.studies.file.case import Driving
from creak.studies.file.places import Places
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.static_loads import StaticStart, static_forces, static_gravity, static_supports
from creak.studies.prepare.structure import Structure
from creak.studies.run.elines import relative_motion

STAGE = "static start"


def started(setup: Setup, reference: ReferenceModel, progress: Progress) -> Setup:
    """The setup whose channels start from the static equilibrium; itself where the study asks for none.

    Raises
    ------
    InputError : parts that only contact holds, or gravity on matrices that do not say how they move as a rigid body.
    NumericalError : no equilibrium was found.
    """
    if not setup.study.config.static or setup.static is not None:
        return setup
    if reference.stiffness is None:
        raise InputError(
            "a static load on a model that can move freely: supports, links and springs do not hold every part; "
            "contact and stops with play alone do not count",
            where=setup.study.places.where("static"),
            expected="supports, links or springs that hold every part",
            fix="Hold it, by a weak spring if need be, or leave out [[static]].",
        )
    progress(STAGE, 0, 1)
    given = setup.contacts, setup.connectors
    gaps = join(given)
    found = equilibrium(
        reference.system,
        reference.stiffness,
        gaps,
        _load(setup.structure, setup.study.driving, reference),
        static_supports(setup.model, setup.study.driving, setup.structure.driven),
    )
    progress(STAGE, 1, 1)
    system = reference.system
    start = StaticStart(found, system.labels, system.recover(found.q, found.support), gaps.names, given)
    now, m = found.on(gaps), setup.contacts.m
    contacts, connectors = (now.select(np.arange(a, b)) for a, b in ((0, m), (m, gaps.m)))
    lines, s = setup.watch.lines, found.support[:, None]
    shares = (relative_motion(system, lines.points, q[:, None], s)[0] for q in (found.q, found.free))
    lines = replace(lines, static=tuple(shares)) if lines.points.m else lines
    watch, notes = replace(setup.watch, lines=lines), [*setup.notes, _note(found)]
    return replace(setup, contacts=contacts, connectors=connectors, static=start, watch=watch, notes=notes)


def _load(structure: Structure, driving: Driving, reference: ReferenceModel) -> FloatArray:
    """(n,) forces of the static loads on the coordinates of the unreduced model."""
    system, model = reference.system, structure.model
    f = np.zeros(system.n)
    gravity = static_gravity(model, driving)
    if gravity.any():
        for labels, M in _carriers(structure, driving.places, reference):
            f += np.asarray(system.rows(labels)[0].T @ rigid_load(labels, M, model.nodes, gravity)).ravel()
    acting = static_forces(model, driving)
    if acting:
        labels, at = np.unique(np.concatenate([labels for _, labels, _ in acting]), return_inverse=True)
        values = np.repeat([value for _, _, value in acting], [labels.size for _, labels, _ in acting])
        total = np.bincount(at.reshape(-1), weights=values, minlength=labels.size)
        f += np.asarray(system.rows(labels)[0].T @ total).ravel()
    heat = heat_of(model, driving)
    if heat is not None:
        forces = heat_forces(model, heat)
        labels = np.flatnonzero(forces)
        f += np.asarray(system.rows(~labels)[0].T @ forces[labels]).ravel()
    return f


def _carriers(structure: Structure, places: Places, reference: ReferenceModel) -> Iterator[tuple[IntArray, Matrix]]:
    """Labels and mass of all parts, and of the elements between them."""
    for given in structure.superelements:
        if (given.coordinates < 0).any():
            raise InputError(
                f"gravity on superelement {given.name!r}: its matrices have generalised coordinates, and do not say "
                "how they take part in a uniform acceleration",
                where=places.where("superelement", given.name),
                expected="matrices on physical dofs alone",
                fix="Export it without modes, or give its weight as [[static]] forces.",
            )
    loose = [] if reference.loose is None else [reference.loose]
    yield from ((part.coordinates, part.M) for part in (*reference.parts, *loose, *structure.superelements))
    blocks = [b for b in structure.model.blocks if b.part < 0]
    if blocks:
        labels = node_dofs(np.unique(np.concatenate([b.nodes_idx.ravel() for b in blocks])))
        yield labels, assemble_blocks(structure.model, blocks, labels, Rayleigh(0.0, 0.0), override=True).M


def _note(found: Equilibrium) -> str:
    pressing = int(np.count_nonzero(found.force))
    with_friction = f" in {found.increments} increments" if found.increments > 1 else ""
    return (
        f"static start: equilibrium of the unreduced model{with_friction}, {pressing} of {found.gap.size} channels "
        f"press, forces balance to {found.residual:.1g}; the reduction needs no more for it, as the run moves about "
        "this state"
    )


def with_static(start: StaticStart | None, nodes: IntArray, system: System, history: History) -> tuple[System, History]:
    """A run whose displacements hold the static share, and the System that recovers it.

    Its strain energy is that of the static state and that of the motion about it; their cross term is work of the
    static loads.

    Parameters
    ----------
    nodes : rows of those whose motion is kept.
    """
    if start is None:
        return system, history
    kept = history.displacement + start.at(node_dofs(nodes))
    energy = history.energy.copy()
    energy[:, ENERGIES.index("strain")] += start.state.strain
    u = start.at(system.labels)

    def whole(q: FloatArray, s: FloatArray, at: IntArray | None) -> FloatArray:
        return system.recover(q, s, at) + (u if at is None else u[at])[:, None]

    return replace(system, whole=whole), replace(history, displacement=kept, energy=energy)
