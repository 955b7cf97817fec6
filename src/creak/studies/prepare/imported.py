"""Superelements from other solvers as Systems."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix, to_dense
from creak.assembly.damping import Damping
from creak.assembly.elimination import LinearEquation
from creak.assembly.part import Rayleigh
from creak.assembly.system import Stats, System, no_supports
from creak.errors import InputError, suggest
from creak.model.dofs import dof_label
from creak.model.mesh import Model, rigid_vectors
from creak.model.superelement import Superelement
from creak.studies.file.config import SuperelementTable
from creak.studies.file.places import Places
from creak.words import first_few

PLACE = 1e-3
"""A node may lie this share of the model's size from where the superelement says it is."""
FAR = 10.0
"""Of nodes with one number another lies elsewhere where it is this many times as far from there as the nearest,"""
ROUND_OFF = 1e-9
"""and farther than this share of the model's size."""


def imported_superelements(
    model: Model, tables: Mapping[str, SuperelementTable], places: Places, common: Rayleigh, override: bool
) -> tuple[tuple[System, ...], list[str]]:
    """Every [superelement.NAME] of the study, joined to the deck at the nodes with the same labels, and notes.

    Parameters
    ----------
    common, override : Rayleigh numbers of the assembly; a superelement brings its own damping instead unless they
        replace all damping.

    Raises
    ------
    InputError : a file that cannot be read, or a node that the deck does not have, has elsewhere, or has more
        than once.
    """
    if not tables:
        return (), []
    from creak.formats.matrices.superelements import read_superelement

    out, notes = list[System](), list[str]()
    for name, table in tables.items():
        where = places.where("superelement", name)
        map_file = places.sibling(table.map) if table.map else None
        superelement = read_superelement(places.sibling(table.file), map_file)
        superelement, turned = in_global_axes(superelement, model, where, table.instance)
        if turned:
            notes.append(
                f"superelement {name}: its rows of {len(turned)} grid(s) ({first_few(turned)}) are along the "
                "displacement frames (CD) of the deck, as its file has no GRID cards for them"
            )
        if override and superelement.C is not None:
            notes.append(f"superelement {name}: its own damping is left out, as [damping] of the study replaces all")
        damping = _own_damping(superelement, common, override)
        out.append(superelement_system(superelement, model, name, damping, where, table.instance))
    return tuple(out), notes


def _own_damping(superelement: Superelement, common: Rayleigh, override: bool) -> Damping:
    """The common Rayleigh numbers and, unless they replace all damping, the matrix that makes up for them."""
    if override:
        return Damping(common.alpha, common.beta)
    C = None if superelement.C is None else to_dense(superelement.C)
    if common.alpha or common.beta:
        excess = common.alpha * to_dense(superelement.M) + common.beta * to_dense(superelement.K)
        C = -excess if C is None else C - excess
    return Damping(common.alpha, common.beta, C)


def in_global_axes(
    superelement: Superelement, model: Model, where: str, instance: str | None = None
) -> tuple[Superelement, list[int]]:
    """The superelement with all rows along global axes, and the labels of the nodes whose rows were turned.

    A_global = R A R', R (3, n) of a node its directions in the deck's frame. Where the superelement has only some of
    three translations or rotations of a node, forces along these alone act along all global axes that they have a
    part of.
    """
    joined = _joined(superelement, model, instance, where) if superelement.in_deck_frames and model.frames else {}
    frames = {
        i: model.frames[row] for i, row in joined.items() if i in superelement.in_deck_frames and row in model.frames
    }
    if not frames:
        return superelement, []
    place: dict[tuple[int, int], int] = {}
    entries: list[tuple[int, int, float]] = []
    for k, (node, dof) in enumerate(zip(superelement.node_ids.tolist(), superelement.dofs.tolist(), strict=True)):
        if node not in frames:
            entries.append((place.setdefault((node, dof) if node else (0, -k), len(place)), k, 1.0))
            continue
        first = dof - (dof - 1) % 3
        for i, share in enumerate(frames[node][:, dof - first].tolist()):
            if abs(share) > ROUND_OFF:
                entries.append((place.setdefault((node, first + i), len(place)), k, share))
    at, of, shares = (np.array(column) for column in zip(*entries, strict=True))
    R = sp.csr_array((shares, (at, of)), shape=(len(place), superelement.n))
    turned = (None if A is None else R @ A @ R.T for A in (superelement.K, superelement.M, superelement.C))
    K, M, C = (None if A is None else 0.5 * (A + A.T) for A in turned)
    rows = np.array([(node, max(dof, 0)) for node, dof in place], dtype=np.int64)
    made = replace(superelement, node_ids=rows[:, 0], dofs=rows[:, 1], K=K, M=M, C=C, in_deck_frames=frozenset())
    return made, list(frames)


def superelement_system(
    superelement: Superelement, model: Model, name: str, damping: Damping, where: str, instance: str | None = None
) -> System:
    """The matrices as a System in the dofs of the deck's nodes."""
    coordinates = _labels(superelement, model, instance, where)
    known = np.flatnonzero(coordinates >= 0)
    order = known[np.argsort(coordinates[known])]
    labels = coordinates[order]
    n = superelement.n

    def rows(wanted: IntArray) -> tuple[Matrix, Matrix]:
        at = np.minimum(np.searchsorted(labels, wanted), labels.size - 1)
        own = np.flatnonzero(labels[at] == wanted)
        pick = sp.csr_matrix((np.ones(own.size), (own, order[at[own]])), shape=(wanted.size, n))
        return pick, np.zeros((wanted.size, 0))

    return System(
        name,
        superelement.M,
        superelement.K,
        damping,
        rows,
        no_supports(n),
        coordinates,
        np.zeros(n),
        stats=Stats(_mass(superelement, coordinates, model), retained=labels.size, modes=n - labels.size),
        labels=labels,
        interface=labels,
    )


def _labels(superelement: Superelement, model: Model, instance: str | None, where: str) -> IntArray:
    """(n,) labels of the dofs of the nodes that it joins, -1 for generalised coordinates."""
    row = _joined(superelement, model, instance, where)
    return np.array(
        [
            dof_label(row[int(i)], int(d)) if i else -1
            for i, d in zip(superelement.node_ids, superelement.dofs, strict=True)
        ],
        dtype=np.int64,
    )


def _joined(superelement: Superelement, model: Model, instance: str | None, where: str) -> dict[int, int]:
    """Node number of the superelement -> row of the node that it joins: of the instance, or at the place it tells."""
    wanted, nodes = np.unique(superelement.node_ids[superelement.node_ids > 0]), model.nodes
    rows = np.flatnonzero(np.isin(nodes.ids, wanted) & _of_instance(model, instance, where))
    found: dict[int, list[int]] = {int(label): [] for label in wanted}
    for r in rows.tolist():
        found[int(nodes.ids[r])].append(r)
    missing = [label for label, at in found.items() if not at]
    if missing:
        owner = f"instance {instance}" if instance else "the deck"
        raise InputError(
            f"superelement {superelement.name!r} ends at node {missing[0]}, which {owner} does not have "
            f"({len(missing)} such node(s))",
            where=where,
            expected="nodes of the deck with the same labels",
            fix="Add the nodes to the deck (*NODE), at the same places.",
        )
    return {label: _one(superelement, model, label, np.array(at), where) for label, at in found.items()}


def _of_instance(model: Model, instance: str | None, where: str) -> BoolArray:
    """(n_node,) the nodes that the superelement may join."""
    nodes = model.nodes
    if instance is None:
        return np.ones(nodes.count, dtype=np.bool_)
    names = [name.upper() for name in nodes.instance]
    if instance.upper() not in names:
        raise InputError(f"unknown instance {instance!r}", where=where, fix=suggest(instance, nodes.instance))
    return nodes.instance_idx == names.index(instance.upper())


def _one(superelement: Superelement, model: Model, label: int, rows: IntArray, where: str) -> int:
    """The one of some rows with this label that lies where the superelement says, or the only one."""
    nodes, place = model.nodes, superelement.positions.get(label)
    names = ", ".join(nodes.label(r) for r in rows.tolist())
    near = rows
    if place is not None:
        size = float(np.ptp(nodes.coords, axis=0).max(initial=0.0))
        away = np.linalg.norm(nodes.coords[rows] - place, axis=1)
        if away.min() > PLACE * size:
            at = int(rows[away.argmin()])
            raise InputError(
                f"node {nodes.label(at)} lies at {nodes.coords[at].tolist()} in the deck and at "
                f"{np.asarray(place).tolist()} in superelement {superelement.name!r}",
                where=where,
                expected="the same place",
                fix="Check units and the node's number." + (f" None of {names} lies there." if rows.size > 1 else ""),
            )
        near = rows[away <= max(FAR * away.min(), ROUND_OFF * size)]
    if near.size > 1:
        told = "does not say where it lies" if place is None else "has more than one of them at its place"
        raise InputError(
            f"superelement {superelement.name!r} ends at node {label}, of which the deck has {rows.size} ({names}), "
            f"and {told}",
            where=where,
            expected="one node of the deck to join",
            fix='Name the instance that it joins, as instance = "'
            f'{nodes.label(int(near[0])).rpartition(".")[0]}", or give a file with the places of its nodes.',
        )
    return int(near[0])


def _mass(superelement: Superelement, coordinates: IntArray, model: Model) -> float:
    """Mass felt when all nodes move along x."""
    x, known = np.zeros(superelement.n), coordinates >= 0
    x[known] = rigid_vectors(coordinates[known], model.nodes, np.zeros(3))[:, 0]
    return float(x @ (superelement.M @ x))


def resistance(system: System) -> Iterator[LinearEquation]:
    """Which motions of its nodes the superelement resists: the rows of its stiffness, condensed to the nodes.

    Used to find out what is held: a motion of the nodes is free where all these combinations vanish.
    """
    K = to_dense(system.K)
    b, i = np.flatnonzero(system.coordinates >= 0), np.flatnonzero(system.coordinates < 0)
    K_b: FloatArray = K[np.ix_(b, b)]
    if i.size:
        K_b = K_b - K[np.ix_(b, i)] @ np.linalg.pinv(K[np.ix_(i, i)]) @ K[np.ix_(i, b)]
    values, shapes = np.linalg.eigh(K_b)
    labels = system.coordinates[b].tolist()
    for value, shape in zip(values, shapes.T, strict=True):
        if value > 1e-9 * values[-1]:
            yield LinearEquation(labels, shape.tolist())
