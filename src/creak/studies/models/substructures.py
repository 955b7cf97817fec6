"""Which elements become substructures, and which of their dofs are retained."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import IntArray, Matrix
from creak.assembly.elimination import fixed_equations, linear_equations
from creak.assembly.part import split_constraints
from creak.assembly.partition import Pieces, cut, shared_nodes
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.errors import InputError
from creak.given import indices_of, of_kind, positive
from creak.model.dofs import node_dofs, nodes_of
from creak.model.mesh import Model
from creak.reduction.interface.characteristic import second_level
from creak.studies.file.config import InterfaceTable
from creak.studies.file.places import Places
from creak.studies.models.interface import Line, thinned
from creak.studies.models.reference import Marks, ReferenceModel
from creak.studies.prepare.reduction import Exterior, Reduction, reduction_set
from creak.studies.prepare.structure import Structure
from creak.studies.warned import Warned

UNREDUCED = "{part} (unreduced)"


@dataclass(frozen=True)
class Substructure:
    """A part to be reduced, or to stay as it is."""

    part: System
    boundary: IntArray
    """(n_b,) sorted coordinates that are retained."""
    shape: Matrix | None
    """P (n_b, n_xi) where the interface is reduced beforehand."""
    line: IntArray
    """Labels among the boundary that make up the interface, for interface modes."""
    stays: bool
    """Unreduced elements."""
    marks: Marks | None = None
    """Of a part whose matrices may not be there yet."""
    freed: int = 0
    """Dofs that it shares with another part and is not joined at."""


@dataclass(frozen=True)
class Partition:
    """The model as it will be reduced."""

    model: Model
    substructures: tuple[Substructure, ...]


@dataclass(frozen=True)
class _Retained:
    """Physical dofs that stay or may stay, of all parts."""

    must: IntArray
    """All six of a node that parts share: they are joined at what both retain."""
    contact: IntArray
    """Translations at channels and watched nodes."""
    shared: IntArray
    """Nodes that parts share."""
    outside: IntArray
    """Dofs at which something else than another part acts."""


def partition(reduction: Reduction, reference: ReferenceModel, gaps: GapOperator) -> Partition:
    """Cut the parts, find the retained dofs of each, thin the interface.

    Raises
    ------
    InputError : a set that does not exist, an interface without nodes, a retained dof that is not free.
    """
    table, exterior, pieces = reduction.table, reduction.exterior, _cut(reduction, gaps)
    last = len(table.substructures) + 1
    must, shared = required_labels(reduction, pieces.model), shared_nodes(pieces.model)
    whole = node_dofs(np.intersect1d(nodes_of(must), shared))  # of which the interface has nothing
    retained = _Retained(
        np.union1d(must, whole),
        _contact_labels(exterior.watch.nodes, gaps),
        shared,
        _outside(reduction.structure, exterior, pieces.model),
    )
    _check_interface(table.interface, retained, reduction.driving.places)
    out = []
    for k, group in enumerate(pieces.group):
        part, marks = _full_part(reduction.structure, reference, pieces, k)
        if group == last or not part.n:  # nothing is left of a part that was cut out as a whole
            every = np.arange(part.n, dtype=np.int64)
            out.append(Substructure(part, every, None, every[:0], True))
        else:
            sub = _substructure(reduction, reference, part, marks, pieces.model, k, retained)
            out.append(replace(sub, marks=marks))
    return Partition(pieces.model, tuple(out))


def _cut(reduction: Reduction, gaps: GapOperator) -> Pieces:
    """Element sets become parts of their own; elements near the contact become unreduced parts."""
    model, table, places = reduction.structure.model, reduction.table, reduction.driving.places
    groups = [np.zeros(b.ids.size, dtype=np.int64) for b in model.blocks]
    last = len(table.substructures) + 1
    chosen = [*enumerate(table.substructures, start=1), *((last, name) for name in table.unreduced)]
    for k, name in chosen:
        where = "unreduced" if k == last else "substructures"
        for block, row in reduction_set(model, where, name, places).tolist():
            groups[block][row] = k
    if table.keep_out > 0.0 and gaps.m:
        for of, rows in zip(groups, near_elements(model, gaps.retained_nodes, table.keep_out), strict=True):
            of[rows] = last
    if not any(g.any() for g in groups):
        return Pieces(model, (0,) * len(model.parts))
    return cut(model, groups, [*(n.upper() for n in table.substructures), UNREDUCED])


def reach_of_keep_out(reduction: Reduction, gaps: GapOperator) -> list[str]:
    """A warning where keep_out leaves none of the elements, or all of them, unreduced."""
    model, distance = reduction.structure.model, reduction.table.keep_out
    if not (distance > 0.0 and gaps.m):
        return []
    left = sum(rows.size for rows in near_elements(model, gaps.retained_nodes, distance))
    if 0 < left < sum(b.ids.size for b in model.blocks if b.part >= 0):
        return []
    how = "every element lies within it, so nothing is reduced: lower it" if left else "no element lies within it"
    return [Warned(f"[reduction] keep_out = {distance:g}: {how}{'' if left else ': raise it, or leave it out'}")]


def near_elements(model: Model, nodes: IntArray, distance: float) -> list[IntArray]:
    """Rows of the elements of each block whose nodes all lie within `distance` of `nodes`: keep_out leaves them.

    Raises
    ------
    InputError : no model, rows of no nodes, a distance that is no positive number.
    """
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    of_kind(model, Model, "model", "a Model, as creak.read_deck makes one")
    coords, limit = model.nodes.coords, 1.000001 * positive(distance, "distance")
    away, _ = cKDTree(coords[indices_of(nodes, "nodes", len(coords))]).query(coords, distance_upper_bound=limit)
    near, none = np.isfinite(away), np.zeros(0, dtype=np.int64)
    return [np.flatnonzero(near[b.nodes_idx].all(axis=1)) if b.part >= 0 and b.ids.size else none for b in model.blocks]


def _full_part(structure: Structure, reference: ReferenceModel, pieces: Pieces, k: int) -> tuple[System, Marks | None]:
    """The part's System; that of the reference where nothing was cut from it, with its marks."""
    if k < len(reference.parts):
        whole = pieces.model is structure.model or all(
            a.ids.size == sum(b.ids.size for b in pieces.model.blocks if b.where == a.where and b.part == k)
            for a in structure.model.blocks
            if a.part == k
        )
        if whole and pieces.model.parts[k].nodes_idx.size == structure.model.parts[k].nodes_idx.size:
            return reference.parts[k], reference.marks[k] if reference.marks else None
    return structure.part(k, pieces.model), None


def part_alone(reduction: Reduction, gaps: GapOperator, k: int) -> System:
    """Part k of the model as `partition` cuts it, without the other parts."""
    return reduction.structure.part(k, _cut(reduction, gaps).model)


def required(reduction: Reduction, model: Model) -> dict[str, IntArray]:
    """Why physical dofs of a model, as it is cut, always stay -> their labels, the strongest reason first."""
    structure, exterior, none = reduction.structure, reduction.exterior, np.zeros(0, dtype=np.int64)
    joined = [node_dofs(b.nodes_idx.ravel()) for b in model.blocks if b.part < 0]
    held = [x for f in model.fixed for e in fixed_equations(f) for x in e.labels]
    return {
        "links": np.concatenate([_link_labels(model), *joined]),
        "supports": np.array(held, dtype=np.int64),
        "loads": np.concatenate([none, *structure.driven.labels.values(), *exterior.forces]),
        "connectors": exterior.connectors,
        "imported parts": np.concatenate([none, *(s.joins for s in structure.superelements)]),
        "chosen": _chosen(structure.model, reduction.table.retained_sets, reduction.driving.places),
    }


def _link_labels(model: Model) -> IntArray:
    """Dofs of the links between parts."""
    links = [x for c in split_constraints(model)[1] for e in linear_equations(c, model.nodes.coords) for x in e.labels]
    return np.array(links, dtype=np.int64)


def required_labels(reduction: Reduction, model: Model) -> IntArray:
    """Physical dofs that always stay: links between parts, supports, loads, connectors, elements between parts, and
    the user's own choice."""
    return np.unique(np.concatenate([*required(reduction, model).values()])).astype(np.int64)


def _chosen(model: Model, names: Sequence[str], places: Places) -> IntArray:
    """All dofs of the node sets in [reduction] retain; they must be free."""
    where = places.where("reduction", "retain")
    sets = [model.node_set(n, where=where) for n in names]
    labels = node_dofs(np.concatenate([np.zeros(0, dtype=np.int64), *sets]))
    held = {label for f in model.fixed for e in fixed_equations(f) for label in e.labels}
    taken = [int(x) for x in labels if int(x) in held]
    if taken:
        raise InputError(
            f"cannot retain {model.dof_name(taken[0])}: a boundary condition holds it",
            where=where,
            expected="nodes that are free to move",
            fix="Take it out of the set; supports are retained by themselves.",
        )
    dependent = [x for c in model.constraints for e in linear_equations(c, model.nodes.coords) for x in e.labels[:1]]
    tied = np.intersect1d(labels, np.array(dependent, dtype=np.int64))
    if tied.size:
        raise InputError(
            f"cannot retain {model.dof_name(int(tied[0]))}: a coupling or equation makes it dependent",
            where=where,
            expected="independent nodes",
            fix="Retain the reference node that it follows.",
        )
    return labels


def _contact_labels(watched: IntArray, gaps: GapOperator) -> IntArray:
    """Translations at the channels and at the nodes whose motion is kept, and what else presses or rubs."""
    nodes = np.union1d(gaps.retained_nodes, watched)
    return np.union1d(node_dofs(nodes, (1, 2, 3)), gaps.labels).astype(np.int64)


def _outside(structure: Structure, exterior: Exterior, model: Model) -> IntArray:
    """Dofs of supports, loads, connectors and contacts."""
    held = [np.array(e.labels, dtype=np.int64) for f in model.fixed for e in fixed_equations(f)]
    moved = structure.driven.labels.values()
    return np.concatenate([exterior.connectors, exterior.contacts.labels, *moved, *exterior.forces, *held])


def _check_interface(table: InterfaceTable, retained: _Retained, places: Places) -> None:
    if table.type != "full" and retained.shared.size == 0 and retained.contact.size == 0:
        raise InputError(
            f"the interface has no node: type = {table.type!r} has nothing to work on",
            where=places.where("reduction", "interface"),
            expected="contact channels, or unreduced elements (keep_out), or substructures that share nodes",
            fix='Use interface = { type = "full" }, or check the contact and the pre-check\'s margin.',
        )


def _substructure(
    reduction: Reduction,
    reference: ReferenceModel,
    part: System,
    marks: Marks | None,
    model: Model,
    k: int,
    retained: _Retained,
) -> Substructure:
    """Boundary of one substructure: what must stay, and its interface, thinned as the study asks.

    The interface is where it meets unreduced elements or another substructure (all six dofs of each node); where
    there is none, it is the contact and output nodes (their translations), or for characteristic modes what links to
    other parts, less supports, loads and contact.
    """
    must = np.intersect1d(retained.must, part.labels)
    contact = np.intersect1d(retained.contact, part.labels)
    line_nodes = np.intersect1d(retained.shared, model.parts[k].nodes_idx)
    if line_nodes.size:
        must = np.union1d(must, contact[~np.isin(nodes_of(contact), line_nodes)])
        line = node_dofs(line_nodes)
    elif reduction.table.interface.type == "characteristic":
        line = np.setdiff1d(np.intersect1d(_link_labels(model), part.labels), retained.outside)
        return Substructure(part, touched(part, np.union1d(must, contact), marks), None, line, False)
    else:
        line = contact
    line = line[np.isin(line, part.coordinates) & ~np.isin(nodes_of(line), nodes_of(must))]
    must = np.union1d(must, contact[~np.isin(contact, line)])
    fixed = touched(part, must, marks)
    chosen = thinned(reduction, reference, Line(part.name, model, line), part)
    if chosen.shape is None:
        kept = _coordinates(part, chosen.labels)
        boundary = np.union1d(fixed, kept)
        freed = line.size - chosen.labels.size if line_nodes.size else 0
        return Substructure(part, boundary, None, chosen.labels, False, freed=freed)
    return _shaped(part, fixed, _coordinates(part, chosen.labels), chosen.shape)


def _coordinates(part: System, labels: IntArray) -> IntArray:
    """Coordinates of the part with these labels (each must be one)."""
    order = np.argsort(part.coordinates, kind="stable")
    at = order[np.searchsorted(part.coordinates[order], labels)]
    return np.asarray(at, dtype=np.int64)


def touched(part: System, labels: IntArray, marks: Marks | None = None) -> IntArray:
    """Coordinates of the part that the labels depend on, and those without stiffness (free point masses)."""
    rows, _ = part.rows(labels)
    loose = np.flatnonzero(part.K.diagonal() == 0.0) if marks is None else marks.loose
    return np.union1d(sp.csr_matrix(rows).indices, loose).astype(np.int64)


def _shaped(part: System, fixed: IntArray, line: IntArray, shape: Matrix) -> Substructure:
    """Boundary = fixed dofs as they are, interface dofs as shape times fewer."""
    boundary = np.union1d(fixed, line)
    own = np.setdiff1d(fixed, line)
    P = sp.lil_matrix((boundary.size, own.size + shape.shape[1]))
    P[np.searchsorted(boundary, own), np.arange(own.size)] = 1.0
    P = sp.csr_matrix(P) + sp.csr_matrix(
        (
            sp.coo_matrix(shape).data,
            (np.searchsorted(boundary, line)[sp.coo_matrix(shape).row], own.size + sp.coo_matrix(shape).col),
        ),
        shape=P.shape,
    )
    empty = np.zeros(0, dtype=np.int64)
    return Substructure(part, boundary, P, empty, False)


def own_interface(table: InterfaceTable, places: Places, cut: Partition, sub: Substructure, system: System) -> System:
    """The superelement with characteristic modes of its own interface, where the study asks for them."""
    if table.type != "characteristic" or table.level != "local" or not sub.line.size:
        return system
    others = [s.part.labels for s in cut.substructures if s.part.name != sub.part.name and not s.stays]
    if others and np.isin(sub.line, np.concatenate(others)).any():
        raise InputError(
            f"substructure {system.name} meets another one: local characteristic modes of the two do not fit together",
            where=places.where("reduction", "interface"),
            fix='Use level = "system".',
        )
    columns = np.flatnonzero(np.isin(system.coordinates, sub.line))
    return second_level(system, columns, count=_count(table, columns.size))


def shared_interface(table: InterfaceTable, cut: Partition, coupled: System) -> System:
    """The assembly with characteristic modes of all interfaces together, where the study asks for them."""
    if table.type != "characteristic" or table.level != "system":
        return coupled
    lines = [s.line for s in cut.substructures]
    columns = np.flatnonzero(np.isin(coupled.coordinates, np.concatenate(lines)))
    if not columns.size:
        return coupled
    return second_level(coupled, columns, count=_count(table, columns.size))


def _count(table: InterfaceTable, size: int) -> int:
    return min(int(table.n or size), size)
