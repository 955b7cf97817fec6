"""Shells of a model as plates: what contact forces push, and what each part radiates as a whole."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.elements.shells.rigidity import areal_mass, bending_stiffness, is_membrane
from creak.model.constraints import DistributingCoupling
from creak.model.dofs import TRANSLATIONS, dofs_of, nodes_of
from creak.model.faces import FACES, LINES, SHELL_FACETS, facet_areas, facets_of_shells
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import Model
from creak.model.skin import Skin, panels, sides_of
from creak.sound.plates import EDGE, Plate

LEAST = 1.0
"""Modes in a third octave from which on a part counts as a plate."""
OUT = 0.05
"""Share of a force across a plate below which it is along the plate, and bends nothing."""
ACROSS = 0.5
"""Share of the normal's square that supports must hold for a node to count as held across its plate."""


@dataclass(frozen=True)
class PartPlates:
    """A part of shells: its sections, each as a plate of the area and the edges of the whole part."""

    part: int
    """Row into `Model.parts`."""
    plates: tuple[Plate, ...]
    """m, and the deck's mass."""
    areas: FloatArray
    """(n_plate,) m^2 that each has of the part."""

    @property
    def mass(self) -> float:
        """Of its shells, in the deck's mass."""
        return float(sum(p.mass * a for p, a in zip(self.plates, self.areas, strict=True)))

    @property
    def density(self) -> float:
        """Modes per Hz."""
        return float(sum(p.density * a / p.area for p, a in zip(self.plates, self.areas, strict=True)))


@dataclass(frozen=True)
class Sheets:
    """All parts of shells, and what they are at each of their nodes."""

    parts: tuple[PartPlates, ...]
    part: IntArray
    """(n_node,) row into `Model.parts` of the shells at a node; -1: it has none, and is not led by any."""
    leads: IntArray
    """(n_node,) the node with shells that stands for a node: itself, or the nearest of its part."""
    coords: FloatArray
    """(n_node, 3) m."""
    normal: FloatArray
    """(n_node, 3), turned alike over each panel."""
    mobility: FloatArray
    """(n_node,) m/s per deck's mass m/s^2; that of an edge where it is free."""
    direct: FloatArray
    """(n_node,) `Plate.direct`."""


@dataclass(frozen=True)
class Push:
    """Forces on one part, across it."""

    part: PartPlates
    column: IntArray
    """(k,) of the forces."""
    across: FloatArray
    """(k,) share of each that is across the plate, with its sign."""
    point: FloatArray
    """(k, 3) m."""
    mobility: FloatArray
    """(k,)"""
    direct: FloatArray
    """(k,)"""
    normal: FloatArray
    """(k, 3) of the plate there, unit length; `across` is along it."""

    def of(self, which: BoolArray, column: IntArray) -> Push:
        """Some of the forces, as other columns."""
        each = (x[which] for x in (self.across, self.point, self.mobility, self.direct, self.normal))
        return Push(self.part, column, *each)


def sheets_of(model: Model, skin: Skin, metre: float) -> Sheets:
    """The shells of a model; rigid ones and membranes are none."""
    n = model.nodes.count
    whole, D_sum, m_sum = np.zeros(n), np.zeros(n), np.zeros(n)
    sections: dict[int, list[tuple[float, float, float]]] = {}
    part = np.full(n, -1, dtype=np.int64)
    solid = np.zeros(n, dtype=bool)
    for block in model.blocks:
        section = block.section
        if block.kind not in SHELL_FACETS or not isinstance(section, ShellSection | GeneralShell):
            continue
        mass, (D1, D2) = float(areal_mass(section)[0]), bending_stiffness(section)
        rigid = isinstance(section, GeneralShell) and section.rigid
        if rigid or is_membrane(section) or mass <= 0.0 or min(D1, D2) <= 0.0:
            continue
        corners = model.nodes.coords[facets_of_shells(block.kind, block.nodes_idx)] * metre
        area = facet_areas(corners).sum(axis=1)
        thick = np.ones(area.size) if block.own.thickness is None else block.own.thickness.mean(axis=1)
        # D in N m where mass is in kg: force times length is mass length^2 / s^2.
        D, m = np.sqrt(D1 * D2) * metre**2 * thick**3, areal_mass(section, thick)[0] / metre**2
        for column in block.nodes_idx.T:
            np.add.at(whole, column, area)
            np.add.at(D_sum, column, area * D)
            np.add.at(m_sum, column, area * m)
        part[block.nodes_idx] = block.part
        own = sections.setdefault(block.part, [])
        own.append((float(area.sum()), float(area @ D / area.sum()), float(area @ m / area.sum())))
    shells = skin.select(~skin.solid)
    solid[skin.nodes_idx[skin.solid]] = True
    normal, free, edges = edges_of(model, shells, metre)
    has = whole > 0.0
    D, m = D_sum / np.where(has, whole, 1.0), m_sum / np.where(has, whole, 1.0)
    at = np.where(has, 1.0 / (8.0 * np.sqrt(np.where(has, D * m, 1.0))), 0.0) * np.where(free, EDGE, 1.0)
    direct = np.zeros(n)
    direct[has] = [Plate(1.0, x, 1.0, 1.0).direct for x in m[has].tolist()]
    plates = tuple(_part(k, own, edges.get(k, Edges())) for k, own in sorted(sections.items()) if k >= 0)
    coords = model.nodes.coords * metre
    leads = np.where(has, np.arange(n), -1)
    _lead(model, coords, has, solid, part, leads)
    return Sheets(plates, part, leads, coords, normal, at, direct)


def _part(part: int, sections: Sequence[tuple[float, float, float]], edges: Edges) -> PartPlates:
    areas = np.array([s[0] for s in sections])
    whole = float(areas.sum())
    closed = edges.held + edges.free == 0.0  # has no edge; it sends no less than a square
    of_part = whole, 4.0 * whole**0.5 if closed else edges.held, edges.free, edges.points
    return PartPlates(part, tuple(Plate(D, m, *of_part) for _, D, m in sections), areas)


def _lead(model: Model, coords: FloatArray, has: BoolArray, solid: BoolArray, part: IntArray, leads: IntArray) -> None:
    """Nodes without elements, as reference nodes of couplings, follow the nearest node with shells of their part."""
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    for k, one in enumerate(model.parts):
        own = one.nodes_idx[has[one.nodes_idx]]
        others = one.nodes_idx[~has[one.nodes_idx] & ~solid[one.nodes_idx]]
        if own.size and others.size:
            leads[others] = own[cKDTree(coords[own]).query(coords[others])[1]]
            part[others] = k


def pushes(sheets: Sheets, gaps: GapOperator, row: IntArray) -> list[Push]:
    """What forces do across each part of shells.

    Parameters
    ----------
    row : (n_force,) of each force into normals of all channels, then both tangents of each that rubs.
    """
    R = _rows(gaps)[row].tocoo()
    labels = gaps.labels[R.col]
    node, dof = nodes_of(labels), dofs_of(labels)
    moves = np.isin(dof, TRANSLATIONS) & (R.data != 0.0)
    force, node, axis, value = R.row[moves].astype(np.int64), node[moves], dof[moves] - 1, R.data[moves]
    on = sheets.leads[node]
    force, axis, value, on = force[on >= 0], axis[on >= 0], value[on >= 0], on[on >= 0]
    part, found = sheets.part[on], []
    for one in sheets.parts:
        mine = part == one.part
        column, k = np.unique(force[mine], return_inverse=True)
        if not column.size:
            continue
        at, share = on[mine], np.abs(value[mine])
        across = np.asarray(np.bincount(k, value[mine] * sheets.normal[at, axis[mine]]), dtype=np.float64)
        mean = sp.csr_array((share / np.bincount(k, share)[k], (k, at)), shape=(column.size, sheets.part.size))
        normal = mean @ sheets.normal
        normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
        point, mobility, direct = (np.asarray(mean @ x) for x in (sheets.coords, sheets.mobility, sheets.direct))
        push = Push(one, column, across, point, mobility, direct, normal)
        bends = np.abs(across) > OUT * np.abs(across).max(initial=0.0)
        if bends.any():
            found.append(push.of(bends, push.column[bends]))
    return found


def _rows(gaps: GapOperator) -> sp.csr_array:
    """(m + 2 f, n_label), as `channel_matrices` has them on coordinates."""
    G = sp.csr_array(gaps.G)
    if gaps.friction is None:
        return G
    both = sp.vstack([sp.csr_array(t)[gaps.friction.channels] for t in gaps.tangents], format="csr")
    f = gaps.rubbing
    return sp.csr_array(sp.vstack([G, both[np.arange(2 * f).reshape(2, f).T.ravel()]], format="csr"))


@dataclass(frozen=True)
class Edges:
    """Of the shells of one part."""

    held: float = 0.0
    """m along which they are held across: supported edges, both sides of lines inside, rims of rigid patches."""
    free: float = 0.0
    """m of edges and holes where nothing holds them."""
    points: int = 0
    """Separate places where something else holds them."""


def edges_of(model: Model, shells: Skin, metre: float) -> tuple[FloatArray, BoolArray, dict[int, Edges]]:
    """(n_node, 3) unit normals, turned alike over each panel; (n_node,) which lie on a free edge; by part its edges.

    Waves that run into a point that is held send what that pushes back; the rim of a patch that moves as one body is
    taken for a supported edge. Folds count as none: beads and flanges lie closer than half a wave mostly, where what
    one sends the next takes back.
    """
    n = model.nodes.count
    normal, free = np.zeros((n, 3)), np.zeros(n, dtype=bool)
    if not shells.count:
        return normal, free, {}
    sides = sides_of(shells.nodes_idx)
    turned = shells.areas * panels(shells.nodes_idx, sides)[0][:, None]
    for column in shells.nodes_idx.T:
        np.add.at(normal, column, turned)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    (facet, ends, _, count), (held, joined) = sides, _held(model, normal)
    along = model.nodes.coords[ends]
    length = metre * np.linalg.norm(along[:, 1] - along[:, 0], axis=1)
    both, rigid = held[ends].all(axis=1), np.asarray(held[shells.nodes_idx].all(axis=1))
    open_edge: BoolArray = np.logical_and(count == 1, ~both)
    free[ends[open_edge].ravel()] = True
    stops = np.where(both & ~rigid[facet], length, 0.0)
    # (n_node,) number of the patch of joined nodes that each belongs to.
    i, j = ends[joined[ends].all(axis=1)].T
    graph = sp.coo_array((np.ones(i.size), (i, j)), shape=(joined.size,) * 2)
    cluster, part = np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64), shells.part[facet]
    found: dict[int, Edges] = {}
    for k in np.unique(part).tolist():
        mine = part == k
        own = np.unique(ends[mine])
        points = np.unique(cluster[own[joined[own]]]).size
        found[k] = Edges(float(stops[mine].sum()), float(length[mine & open_edge].sum()), int(points))
    return normal, free, found


def _held(model: Model, normal: FloatArray) -> tuple[BoolArray, BoolArray]:
    """(n_node,) what supports, constraints and other elements hold; the same with what follows in the mean alone."""
    n = model.nodes.count
    across = np.zeros(n)
    for fixed in model.fixed:
        for dof in (d for d in fixed.dofs if d <= 3):
            across[fixed.nodes_idx] += normal[fixed.nodes_idx, dof - 1] ** 2
    held, joined = across > ACROSS, np.zeros(n, dtype=bool)
    for constraint in model.constraints:
        (joined if isinstance(constraint, DistributingCoupling) else held)[constraint.nodes] = True
    for block in model.blocks:
        if block.kind not in SHELL_FACETS and (block.kind in FACES or block.kind in LINES):
            held[block.nodes_idx] = True
    return held, held | joined
