"""*TIE: nodes of one surface joined to the nearest points of another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.elements import Elements
from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.names import Registry, lookup, with_short_names
from creak.formats.abaqus.numbers import to_float
from creak.formats.abaqus.outline import Outline, Scope
from creak.formats.abaqus.sections import Assigned
from creak.formats.abaqus.surfaces import RawSurface
from creak.model.constraints import Tie
from creak.model.materials import GeneralShell, Section, ShellSection
from creak.model.mesh import Nodes
from creak.model.projection import SAME, Nearest, nearest_points

DEFAULT_TOLERANCE = 0.05
"""Position tolerance as a share of the mean edge length of the main surface (Abaqus: 5 % of a typical element)."""
SHOWN = 8
"""Untied nodes that a message names."""


@dataclass(frozen=True)
class MainSurface:
    """What nodes can be tied to: shell facets, faces of solids or shell edges, as in `model.projection`."""

    nodes_idx: IntArray
    """(n, 4) node rows; a triangle repeats its third node, an edge its second one twice."""
    coords: FloatArray
    """(n, 4, 3)"""
    thickness: FloatArray
    """(n,) 0 for faces of solids and for edges."""

    @property
    def is_triangle(self) -> BoolArray:
        return self.nodes_idx[:, 2] == self.nodes_idx[:, 3]

    @property
    def size(self) -> float:
        """Mean length of the edges."""
        length = np.linalg.norm(np.roll(self.coords, -1, axis=1) - self.coords, axis=2)
        return float(length[length > 0.0].mean())


@dataclass(frozen=True)
class _Source:
    """What a tie refers to."""

    deck: Outline
    nodes: Nodes
    elements: Elements
    assigned: Assigned
    surfaces: Mapping[str, RawSurface]
    names: Registry


@dataclass(frozen=True)
class _Search:
    """Candidate nodes of a secondary surface and where they meet the main one."""

    rows: IntArray
    shared: int
    """Number of nodes that belong to both surfaces."""
    tolerance: float
    nearest: Nearest
    arm: FloatArray
    """(n, 3)"""
    tied: BoolArray


def read_ties(
    deck: Outline,
    nodes: Nodes,
    elements: Elements,
    assigned: Assigned,
    surfaces: Mapping[str, RawSurface],
    names: Registry,
) -> list[Tie]:
    """Every *TIE as one `Tie` for each node of its secondary surface.

    A node is tied when its distance from the main surface is within POSITION TOLERANCE, by default 5 % of the
    mean edge length of the main surface. Across a facet the distance is measured between the faces of the shells
    (half of both thicknesses is taken off) unless NO THICKNESS is given; with TIED NSET= the nodes of that set,
    and no others, are tied at any distance. Nodes are not moved: a rigid arm bridges what is left of the offset,
    so that rigid motion strains no tie. Nodes that the surfaces share are joined already and are passed over;
    they and the nodes out of reach are listed in `Model.unread`.

    Node collocation is exact for rigid motion, and for constant strain where every node of the main surface lies
    on a node of the secondary one (make the finer side secondary); else it errs by the order of its mesh.

    Raises
    ------
    InputError : unknown surface, a main surface of nodes, a bad tolerance, or no node within it.
    """
    source = _Source(deck, nodes, elements, assigned, surfaces, names)
    ties: list[Tie] = []
    for scope, block in deck.blocks("TIE"):
        rows = list(block.rows())
        if not rows:
            raise InputError(
                "*TIE without surfaces",
                expected="secondary surface, main surface",
                where=block.where,
                fix="Name the two surfaces on a data line.",
            )
        if block.option("TYPE") != "NODE TO SURFACE":
            why = "creak ties each secondary node to the nearest point of the main surface (NODE TO SURFACE)"
            deck.note(block, why, changes=False, what=f"*TIE, TYPE={block.option('TYPE', 'SURFACE TO SURFACE')}")
        for fields, where in rows:
            ties += _tie_pair(source, scope, block, fields, where)
    return ties


def _tie_pair(source: _Source, scope: Scope, block: Block, fields: list[str], where: str) -> list[Tie]:
    secondary, other = (_surface(source, name, scope, where) for name in (*fields, "", "")[:2])
    main = _main_surface(other, source, where)
    if block.has("NO THICKNESS"):
        main = replace(main, thickness=0.0 * main.thickness)
    found = _search(source, scope, block, secondary, main, where)
    if not found.tied.any():
        raise _nothing_tied(secondary, other, found, where)
    _note_untied(source, block, secondary, other, found)
    return _ties(block, where, main, found)


def _surface(source: _Source, name: str, scope: Scope, where: str) -> RawSurface:
    surface = lookup(source.surfaces, name, scope.name, source.deck.assembly) if name else None
    if surface is None:
        raise InputError(
            f"*TIE on unknown surface {name!r}" if name else "*TIE names one surface only",
            expected="secondary surface, main surface",
            where=where,
            fix=suggest(name, with_short_names(source.surfaces)),
        )
    return surface


def _search(
    source: _Source, scope: Scope, block: Block, secondary: RawSurface, main: MainSurface, where: str
) -> _Search:
    rows, tolerance = secondary.nodes_idx, _tolerance(block, main)
    if block.has("TIED NSET"):
        rows = rows[np.isin(rows, source.names.find(block.need("TIED NSET"), scope.name, where))]
        tolerance = np.inf
    shared = np.isin(rows, main.nodes_idx)
    rows = rows[~shared]
    half = np.zeros(rows.size) if block.has("NO THICKNESS") else _half_thickness(rows, secondary, source)
    reach = tolerance + half.max(initial=0.0) + 0.5 * main.thickness.max()
    points = source.nodes.coords[rows]
    nearest = nearest_points(points, main.coords, main.is_triangle, reach)
    arm = _arms(points, main, nearest)
    tied = nearest.found & (_clearance(arm, half, main, nearest) <= tolerance + SAME * main.size)
    return _Search(rows, int(shared.sum()), tolerance, nearest, arm, tied)


def _note_untied(source: _Source, block: Block, secondary: RawSurface, main: RawSurface, found: _Search) -> None:
    """List the nodes that are not tied, and the offset that Abaqus would have closed by moving nodes."""
    title, pair = f"*TIE, NAME={block.get('NAME')}", f"{secondary.name!r} and {main.name!r}"
    if found.shared:
        why = f"{found.shared} node(s) of {pair} belong to both surfaces and are joined already"
        source.deck.note(block, why, changes=False, what=title)
    if not found.tied.all():
        out = np.sort(found.rows[~found.tied])
        why = f"{out.size} of {found.rows.size} nodes of {secondary.name!r} lie farther than {found.tolerance:.4g} "
        why += f"from {main.name!r} and stay untied: {_listed(out, source.nodes)}"
        source.deck.note(block, why, changes=False, what=title)
    offset = float(np.linalg.norm(found.arm[found.tied], axis=1).max())
    if offset > 0.0 and block.option("ADJUST", "YES") != "NO":
        why = f"creak does not move tied nodes; rigid arms up to {offset:.3g} long bridge the offset of {pair}"
        source.deck.note(block, why, changes=False, what=f"{title}, ADJUST=YES")


def _main_surface(surface: RawSurface, source: _Source, where: str) -> MainSurface:
    coords = source.nodes.coords
    if surface.edges.size:
        corners = surface.edges[:, [0, 1, 1, 1]]
        return MainSurface(corners, coords[corners], np.zeros(corners.shape[0]))
    if not surface.element_rows.size:
        raise InputError(
            f"main surface {surface.name!r} of *TIE is a surface of nodes",
            expected="a surface of shell facets, faces of solids or shell edges",
            where=where,
            fix="Give one; the surface of nodes may be the secondary one, which stands first.",
        )
    corners = surface.corners
    return MainSurface(corners, coords[corners], _thickness(surface.element_rows, source.assigned))


def _thickness(element_rows: IntArray, assigned: Assigned) -> FloatArray:
    of = np.array([_reach(s) for s in assigned.sections])
    return np.asarray(of[assigned.section_idx[element_rows]], dtype=np.float64)


def _reach(section: Section) -> float:
    """Thickness of a shell, and twice the offset of its middle from the nodes."""
    if isinstance(section, GeneralShell):
        return section.thickness + 2.0 * abs(section.offset)
    return section.thickness if isinstance(section, ShellSection) else 0.0


def _half_thickness(rows: IntArray, surface: RawSurface, source: _Source) -> FloatArray:
    """Half the thickness of the secondary shells at the nodes; surfaces of nodes and edges have none."""
    corners = surface.corners
    thickness = np.repeat(_thickness(surface.element_rows, source.assigned)[:, None], corners.shape[1], axis=1)
    at_node = np.zeros(max(int(corners.max(initial=0)), int(rows.max(initial=0))) + 1)
    np.maximum.at(at_node, corners, thickness)
    return 0.5 * at_node[rows]


def _tolerance(block: Block, main: MainSurface) -> float:
    if not block.has("POSITION TOLERANCE"):
        return DEFAULT_TOLERANCE * main.size
    value = to_float(block.get("POSITION TOLERANCE"), block.where, "position tolerance")
    if value < 0.0:
        raise InputError(
            f"position tolerance is {value:g}",
            expected="a number, zero or more",
            where=block.where,
            fix="Give the largest distance at which a node is tied.",
        )
    return value


def _arms(points: FloatArray, main: MainSurface, nearest: Nearest) -> FloatArray:
    """(n, 3) from the nearest point of the main surface to the node; round-off is set to zero."""
    arm = points - np.einsum("nj,njx->nx", nearest.shape, main.coords[nearest.facet])
    arm[np.linalg.norm(arm, axis=1) < SAME * main.size] = 0.0
    return arm


def _clearance(arm: FloatArray, half: FloatArray, main: MainSurface, nearest: Nearest) -> FloatArray:
    """Distance (n,) of the nodes from the main surface, half of both thicknesses taken off across the facet."""
    X = main.coords[nearest.facet]
    normal = np.cross(X[:, 2] - X[:, 0], X[:, 3] - X[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    across = (arm * normal).sum(axis=1)
    along = np.linalg.norm(arm - across[:, None] * normal, axis=1)
    taken = half + 0.5 * main.thickness[nearest.facet]
    return np.hypot(np.maximum(np.abs(across) - taken, 0.0), along)


def _ties(block: Block, where: str, main: MainSurface, found: _Search) -> list[Tie]:
    result = []
    rotations, nearest = not block.has("NO ROTATION"), found.nearest
    for k in np.flatnonzero(found.tied).tolist():
        corners, at = np.unique(main.nodes_idx[nearest.facet[k]], return_inverse=True)
        weights = np.bincount(at, weights=nearest.shape[k])
        used = weights > SAME
        share = weights[used] / weights[used].sum()
        node = int(found.rows[k])
        result.append(Tie(block.get("NAME"), node, corners[used], share, found.arm[k], rotations, where))
    return result


def _listed(rows: IntArray, nodes: Nodes) -> str:
    names = ", ".join(nodes.label(int(i)) for i in rows[:SHOWN])
    return f"node {names}" + (f" and {rows.size - SHOWN} more" if rows.size > SHOWN else "")


def _nothing_tied(secondary: RawSurface, main: RawSurface, found: _Search, where: str) -> InputError:
    shared = f"{found.shared} node(s) belong to both surfaces, " if found.shared else ""
    far = f"{found.rows.size} lie farther than {found.tolerance:.4g} from {main.name!r}"
    if found.tolerance == np.inf and not found.shared:
        far = "TIED NSET= holds none of them"
    return InputError(
        f"*TIE joins no node of {secondary.name!r}: {shared}{far}",
        expected="surfaces that meet without sharing nodes",
        where=where,
        fix="Raise POSITION TOLERANCE=, correct the surfaces (secondary first, then main), or remove the tie.",
    )
