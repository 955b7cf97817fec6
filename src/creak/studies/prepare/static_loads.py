"""The static loads of a study: their checks, and the state that a run starts from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.coupling import Driven, labels_of
from creak.assembly.elimination import fixed_equations
from creak.contact.gap_operator import GapOperator
from creak.dynamics.equilibrium import Equilibrium
from creak.errors import InputError
from creak.model.dofs import node_and_dof
from creak.model.mesh import Model
from creak.studies.design.supports import loads_taken
from creak.studies.file.case import Driving
from creak.studies.file.table import DOFS
from creak.studies.prepare.excitation import moved_before
from creak.studies.prepare.unit_check import SYSTEMS
from creak.studies.warned import Warned

EARTH = 9.81
"""m/s^2"""
UNUSUAL = 30.0
"""Times the earth's gravity, or that part of it, at which a unit may be wrong."""


@dataclass(frozen=True)
class StaticStart:
    """The equilibrium that a run starts from."""

    state: Equilibrium
    labels: IntArray
    """(n_label,) sorted physical dof labels."""
    displacement: FloatArray
    """(n_label,) their motion from the deck's geometry."""
    names: tuple[str, ...]
    """(m,) channels, contacts first, connectors after."""
    before: tuple[GapOperator, GapOperator]
    """Contacts and connectors as they are without the loads."""

    def at(self, labels: IntArray) -> FloatArray:
        """Motion (k,) at some labels; 0 where nothing is known of one."""
        row = np.minimum(np.searchsorted(self.labels, labels), self.labels.size - 1)
        return np.where(self.labels[row] == labels, self.displacement[row], 0.0)


def static_forces(model: Model, driving: Driving, *, spread: bool = True) -> list[tuple[str, IntArray, float]]:
    """Where it stands, physical dof labels and value of each static force; those of a pressure where `spread`."""
    found = []
    for k, t in enumerate(driving.statics):
        if t.force is not None:
            nodes = model.node_set(t.node_set or "", where=driving.places.where("static", k, "node_set"))
            found.append((driving.places.where("static", k), labels_of(nodes, DOFS.index(t.dof or "x") + 1), t.force))
    for _, loads in loads_taken(model, driving):
        mine = [p for p in loads.forces if p.value and (spread or not p.spread)]
        found += [(p.where, labels_of(p.nodes_idx, p.dof), p.value) for p in mine]
    return found


def static_gravity(model: Model, driving: Driving) -> FloatArray:
    """(3,) sum of the accelerations of gravity."""
    of_deck = [loads.gravity for _, loads in loads_taken(model, driving)]
    own = [t.gravity for t in driving.statics if t.gravity is not None]
    return np.array([*own, *of_deck]).reshape(-1, 3).sum(axis=0)


def static_supports(model: Model, driving: Driving, driven: Driven) -> FloatArray:
    """(n_support,) static displacement of the prescribed coordinates."""
    s = np.zeros(len(driven.names))
    for moved in moved_before(model, driving):
        name = moved.name
        if name not in driven.labels:
            own = np.sort(moved.labels)
            name = next(n for n, x in driven.labels.items() if np.array_equal(np.sort(x), own))
        s[driven.names.index(name)] += moved.value
    return s


def check_static(model: Model, driving: Driving, driven: Driven) -> None:
    """Raise InputError for static loads that do nothing or contradict the supports."""
    held = {label for f in model.fixed for e in fixed_equations(f) for label in e.labels}
    moved = {int(x) for labels in driven.labels.values() for x in labels}
    for where, labels, _ in static_forces(model, driving, spread=False):
        if all(int(x) in held | moved for x in labels):
            raise InputError(
                "this static force acts where the model is held or its motion prescribed: it loads nothing",
                where=where,
                expected="nodes that are free to move",
                fix="Name other nodes, or another dof.",
            )
    before: dict[int, str] = {}
    for motion in moved_before(model, driving):
        twice = [x for x in motion.labels.tolist() if before.setdefault(x, motion.where) != motion.where]
        if twice:
            node, dof = node_and_dof(twice[0])
            raise InputError(
                f"two static displacements move node {model.nodes.label(node)} {DOFS[dof - 1]}",
                where=motion.where,
                expected=f"one, as it is moved and held there; the other stands at {before[twice[0]]}",
                fix="Give their sum once, or name other nodes.",
            )
        taken = [int(x) for x in motion.labels if int(x) in held]
        if taken:
            node, dof = node_and_dof(taken[0])
            nodes = f'nodes = "{motion.node_set}"' if motion.node_set else "a node set of them as nodes"
            raise InputError(
                f"a static displacement moves node {model.nodes.label(node)} {DOFS[dof - 1]}, which the deck holds",
                where=motion.where,
                expected="nodes that the deck does not hold in this dof",
                fix=f'Free them: [support.NAME] with {nodes} and free = ["{DOFS[dof - 1]}"]. '
                "The displacement holds them.",
            )


def gravity_warnings(model: Model, driving: Driving) -> list[str]:
    """Gravity far from the earth's, as in a wrong unit."""
    size = float(np.linalg.norm(static_gravity(model, driving)))
    system = SYSTEMS[driving.units]
    usual = EARTH / system.length
    if not size or usual / UNUSUAL <= size <= usual * UNUSUAL:
        return []
    unit = system.words[0]
    return [
        Warned(
            f"[[static]] gravity of {size:g} {unit}/s2 is {size / usual:.2g} times the earth's, which is {usual:g} "
            f"{unit}/s2: is its unit as [model] units says?"
        )
    ]


def press_fit_warnings(driving: Driving, contacts: GapOperator, connectors: GapOperator) -> list[str]:
    """A press fit without anything that overlaps."""
    where = next((driving.places.where("static", k) for k, t in enumerate(driving.statics) if t.press_fit), None)
    if where is None or min(contacts.gap0.min(initial=0.0), connectors.gap0.min(initial=0.0)) < 0.0:
        return []
    return [Warned(f"{where} press_fit: no surfaces overlap and no stop is squeezed, so nothing is pressed apart")]
