"""The interface of a substructure, thinned as the study asks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.system import System
from creak.formats.decks import read_model
from creak.model.dofs import PER_NODE, dofs_of, node_dofs, nodes_of
from creak.model.mesh import Model
from creak.reduction.interface.coarse_mesh import coarse_basis
from creak.reduction.interface.interpolation import interpolation
from creak.reduction.interface.participation import participating
from creak.reduction.interface.spacing import every_nth, interface_graph
from creak.studies.file.case import Driving
from creak.studies.file.config import InterfaceTable
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.excitation import driven_dofs, highest_frequency
from creak.studies.prepare.reduction import Reduction

COARSE_BAND = 5.0
"""Modes of the coarse model up to this multiple of the excitation span its interface."""


@dataclass(frozen=True)
class Line:
    """Interface dofs of one substructure."""

    name: str
    model: Model
    labels: IntArray
    """(n,) sorted physical dof labels, each a coordinate of the part."""

    @property
    def nodes(self) -> IntArray:
        return np.unique(nodes_of(self.labels))


@dataclass(frozen=True)
class Chosen:
    """What is left of an interface."""

    labels: IntArray
    """Physical dof labels on the boundary."""
    shape: Matrix | None
    """(n_label, n_xi): the labels follow fewer coordinates; None: each is its own."""


def thinned(reduction: Reduction, reference: ReferenceModel, line: Line, part: System) -> Chosen:
    """Apply [reduction.interface] to one interface."""
    table = reduction.table.interface
    if line.labels.size == 0 or table.type in ("full", "characteristic"):
        return Chosen(line.labels, None)
    if table.type == "spacing":
        kept = line.nodes[every_nth(interface_graph(line.model, line.nodes), int(table.n or 1))]
        return Chosen(line.labels[np.isin(nodes_of(line.labels), kept)], None)
    if table.type == "participation":
        taking_part = _participating(reduction.band.excited, reference, line, float(table.eta or 0.0))
        return Chosen(line.labels[taking_part], None)
    full = np.intersect1d(node_dofs(line.nodes), part.coordinates)
    if table.type == "interpolation":
        return Chosen(full, _interpolated(line, full, int(table.n or 1)))
    return Chosen(full, _coarse(table, reduction.driving, line, full))


def _participating(highest: float, reference: ReferenceModel, line: Line, eta: float) -> IntArray:
    """Positions of the dofs that take part in the modes of the assembly within the excitation (thesis 3.5.1)."""
    band = reference.modes.frequencies <= highest
    shapes = np.asarray(reference.system.rows(line.labels)[0] @ reference.modes.shapes[:, band])
    return np.flatnonzero(participating(shapes, eta, dofs=dofs_of(line.labels)))


def _interpolated(line: Line, labels: IntArray, n: int) -> Matrix:
    graph = interface_graph(line.model, line.nodes)
    P = sp.csr_matrix(interpolation(graph, line.model.nodes.coords[line.nodes], every_nth(graph, n)))
    return _used(P[np.isin(node_dofs(line.nodes), labels)])


def _coarse(table: InterfaceTable, driving: Driving, line: Line, labels: IntArray) -> Matrix:
    coarse = read_model(driving.places.sibling(str(table.deck)))
    shapes = coarse_modes(driving, coarse)
    quads = [b.nodes_idx for b in coarse.blocks if b.kind == "quad4"]
    tris = [np.column_stack([b.nodes_idx, np.full(b.ids.size, -1)]) for b in coarse.blocks if b.kind == "tri3"]
    facets = np.vstack([np.zeros((0, 4), dtype=np.int64), *quads, *tris])
    P = coarse_basis(coarse.nodes.coords, facets, shapes, line.model.nodes.coords[line.nodes], count=table.n)
    return _used(sp.csr_matrix(P[np.isin(node_dofs(line.nodes), labels)]))


def coarse_modes(driving: Driving, coarse: Model) -> FloatArray:
    """(6 n_node, n_mode) modes of the coarse assembly, held and linked like the fine one."""
    from creak.studies.models.deck_modes import model_modes  # full interfaces do without

    band = COARSE_BAND * highest_frequency(driving)
    system, found = model_modes(coarse, driven_dofs(coarse, driving), f_max=band)
    out = np.zeros((PER_NODE * coarse.nodes.count, found.omega2.size))
    out[system.labels] = system.recover(found.shapes)
    return out


def _used(P: Matrix) -> Matrix:
    """P without columns that move nothing."""
    return sp.csr_matrix(P)[:, np.flatnonzero(np.diff(sp.csc_matrix(P).indptr))]
