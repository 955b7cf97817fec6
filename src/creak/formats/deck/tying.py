"""Nodes tied to the nearest points of a surface: the same for every deck format."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.formats.deck.parts import Group
from creak.model.constraints import Constraint, Equation, Tie
from creak.model.faces import (
    FACES,
    FEW,
    SHELL_FACETS,
    FaceShapes,
    faces_of,
    facets_of_shells,
    free_faces,
    shapes_of,
    unit,
    vector_areas,
)
from creak.model.materials import GeneralShell, Section, ShellSection
from creak.model.projection import SAME, Nearest, nearest_points

DEFAULT_TOLERANCE = 0.05
"""Position tolerance as a share of the mean edge length of the main surface (Abaqus: 5 % of a typical element)."""


@dataclass(frozen=True)
class MainSurface:
    """What nodes can be tied to: shell facets, faces of solids or shell edges, as in `model.projection`."""

    nodes_idx: IntArray
    """(n, 4) node rows; a triangle repeats its third node, an edge its second one twice."""
    coords: FloatArray
    """(n, 4, 3)"""
    sheets: FloatArray
    """(n, 2) thickness, and height of the middle above the nodes along the facet's normal; 0 for faces of solids and
    for edges."""
    solid: BoolArray
    """(n,) whether it is the face of a solid, whose nodes have no rotations."""
    shapes: FaceShapes
    """The whole faces, by whose shape functions tied nodes follow."""
    places: FloatArray
    """(n, w, 3) of their nodes."""

    @property
    def is_triangle(self) -> BoolArray:
        return self.nodes_idx[:, 2] == self.nodes_idx[:, 3]

    @property
    def size(self) -> float:
        """Mean length of the edges of its faces, from corner to corner where there are nodes between them."""
        X, whole, triangle = self.coords.copy(), self.shapes.sides > 0, self.shapes.sides == 3
        X[whole] = self.places[whole, :FEW]
        X[triangle, 3] = X[triangle, 2]
        length = np.linalg.norm(np.roll(X, -1, axis=1) - X, axis=2)
        return float(length[length > 0.0].mean())


def main_surface(
    shapes: FaceShapes, corners: IntArray, sheets: FloatArray, solid: BoolArray, coords: FloatArray
) -> MainSurface:
    """From facets with corners (n, 4), and the places of all nodes."""
    return MainSurface(corners, coords[corners], sheets, solid, shapes, coords[shapes.nodes])


Piece = tuple[IntArray, tuple[float, float], bool]
"""Facets (n, 4), their sheet as of a `MainSurface`, and whether they are of solids."""


@dataclass(frozen=True)
class Side:
    """One side of what is tied, as a deck in which elements stand in groups tells it."""

    corners: IntArray
    """(n, 4) node rows of its facets; a triangle repeats its third."""
    sheets: FloatArray
    """(n, 2) as of a `MainSurface`."""
    solid: BoolArray

    @classmethod
    def of(cls, pieces: Sequence[Piece]) -> Side:
        corners = np.concatenate([np.zeros((0, 4), dtype=np.int64), *(facets for facets, _, _ in pieces)])
        count = [len(facets) for facets, _, _ in pieces]
        sheets = np.repeat(np.array([sheet for _, sheet, _ in pieces]).reshape(-1, 2), count, axis=0)
        return cls(corners, sheets, np.repeat(np.array([solid for _, _, solid in pieces], dtype=np.bool_), count))

    def main(self, elements: list[tuple[str, IntArray]], coords: FloatArray) -> MainSurface:
        """What nodes can be tied to; `elements`: kind and nodes of each group of the deck."""
        return main_surface(shapes_of(self.corners, elements), self.corners, self.sheets, self.solid, coords)


def facets_of_elements(groups: Sequence[Group], chosen: Sequence[Sequence[bool]]) -> list[Piece]:
    """Shells, and last the free faces of solids, of the chosen elements of each group."""
    found: list[Piece] = []
    wanted, every = [np.zeros((0, 4), dtype=np.int64)], []
    for group, mask in zip(groups, chosen, strict=True):
        nodes = np.array(group.nodes, dtype=np.int64)
        mine = nodes[np.array(mask, dtype=np.bool_)]
        if group.kind in FACES:
            every.append(faces_of(group.kind, nodes).reshape(-1, 4))
            wanted.append(faces_of(group.kind, mine).reshape(-1, 4))
        elif group.kind in SHELL_FACETS and mine.size:
            found.append((facets_of_shells(group.kind, mine).reshape(-1, 4), sheet_of(group.section), False))
    faces = np.concatenate(wanted)
    return [*found, (faces[free_faces(faces, every)], NO_SHEET, True)]


@dataclass(frozen=True)
class Skins:
    """Shells at nodes that are to be tied."""

    half: FloatArray
    """(n,) half their thickness."""
    middle: FloatArray
    """(n, 3) from the node to their middle."""

    def at(self, rows: IntArray) -> Skins:
        """Those of some nodes."""
        return Skins(self.half[rows], self.middle[rows])


def skins_of(corners: IntArray, sheets: FloatArray, coords: FloatArray) -> Skins:
    """Of all nodes, from facets with corners (n, 4) and `sheets` (n, 2) as of a `MainSurface`: the thickest facet, the
    mean of their middles."""
    half, middle, count = np.zeros(len(coords)), np.zeros(coords.shape), np.zeros(len(coords))
    np.maximum.at(half, corners, np.repeat(0.5 * sheets[:, :1], 4, axis=1))
    np.add.at(middle, corners, np.repeat((sheets[:, 1:] * unit(vector_areas(coords[corners])))[:, None, :], 4, axis=1))
    np.add.at(count, corners, 1.0)
    return Skins(half, middle / np.maximum(count, 1.0)[:, None])


@dataclass(frozen=True)
class Meeting:
    """Candidate nodes and where they meet the main surface."""

    rows: IntArray
    tolerance: float
    nearest: Nearest
    arm: FloatArray
    """(n, 3) from the nearest point of the main surface to the node."""
    tied: BoolArray


def meet(
    points: FloatArray,
    rows: IntArray,
    skins: Skins,
    main: MainSurface,
    tolerance: float,
    sideways: float | None = None,
) -> Meeting:
    """Which nodes lie within `tolerance` of the main surface.

    Parameters
    ----------
    points : (n, 3) places of the nodes `rows` (n,).
    skins : of the secondary shells there. Distances across a facet are those between the skins of both.
    sideways : how far beside a facet a node may lie; None: as far as `tolerance`.
    """
    thick = 0.5 * main.sheets[:, 0] + np.abs(main.sheets[:, 1])
    reach = tolerance + (skins.half + np.linalg.norm(skins.middle, axis=1)).max(initial=0.0) + thick.max()
    nearest = nearest_points(points, main.coords, main.is_triangle, reach)
    arm = points - np.einsum("nj,njx->nx", nearest.shape, main.coords[nearest.facet])
    arm[np.linalg.norm(arm, axis=1) < SAME * main.size] = 0.0
    across, along = _clearance(arm, skins, main, nearest)
    limit = tolerance + SAME * main.size
    tied = nearest.found & (np.hypot(across, along) <= limit)
    if sideways is not None:
        tied &= along <= sideways
    return Meeting(rows, tolerance, nearest, arm, tied)


def _clearance(arm: FloatArray, skins: Skins, main: MainSurface, nearest: Nearest) -> tuple[FloatArray, FloatArray]:
    """Distances (n,) of the nodes from the facet: across it between the skins of both, and beside it."""
    normal = unit(vector_areas(main.coords[nearest.facet]))
    across = (arm * normal).sum(axis=1)
    along = np.linalg.norm(arm - across[:, None] * normal, axis=1)
    thickness, height = main.sheets[nearest.facet].T
    apart = np.abs(across + (skins.middle * normal).sum(axis=1) - height)
    return np.maximum(apart - skins.half - 0.5 * thickness, 0.0), along


def ties_of(name: str, where: str, main: MainSurface, found: Meeting, *, rotations: bool) -> list[Constraint]:
    """A `Tie` for each node that is tied; equations where an arm stands on the face of a solid.

    rotations : tie those of nodes on shells and edges, too; nodes of solids have none.
    """
    result: list[Constraint] = []
    tied = np.flatnonzero(found.tied)
    facets, shape = found.nearest.facet[tied], found.nearest.shape[tied]
    faces, N = main.shapes.at(facets, shape)
    moved = np.einsum("nj,njx->nx", shape, main.coords[facets]) - np.einsum("nw,nwx->nx", N, main.places[facets])
    arms = np.where(np.linalg.norm(moved, axis=1, keepdims=True) < SAME * main.size, 0.0, moved) + found.arm[tied]
    for k, (facet, arm, node) in enumerate(zip(facets.tolist(), arms, found.rows[tied].tolist(), strict=True)):
        solid = bool(main.solid[facet])
        if solid and arm.any():
            result += _on_solid(node, faces[k], main.places[facet], N[k], arm, where)
            continue
        nodes, at = np.unique(faces[k], return_inverse=True)
        weights = np.bincount(at, weights=N[k])
        used = np.abs(weights) > SAME
        share = weights[used] / weights[used].sum()
        result.append(Tie(name, node, nodes[used], share, arm, rotations and not solid, where))
    return result


def _on_solid(
    node: int, corners: IntArray, X: FloatArray, shape: FloatArray, arm: FloatArray, where: str
) -> Iterator[Equation]:
    """u = sum_k N_k u_k + omega x arm, omega the rotation of the face that fits its nodes' motion best:

    omega = A^-1 sum_k r_k x u_k,  A = sum_k (r_k' r_k I - r_k r_k'),  r_k from the mean of the nodes. Rigid motion
    is exact.
    """
    own, first, at = np.unique(corners, return_index=True, return_inverse=True)
    N = np.bincount(at, weights=shape)
    r = X[first] - X[first].mean(axis=0)
    A = (r**2).sum() * np.eye(3) - r.T @ r
    turn = -_cross(arm) @ np.linalg.inv(A)
    shares = np.array([n * np.eye(3) + turn @ _cross(rk) for n, rk in zip(N, r, strict=True)])
    nodes = np.array([node, *np.repeat(own, 3).tolist()], dtype=np.int64)
    for dof in range(3):
        coefficients = np.array([1.0, *(-shares[:, dof, :]).ravel().tolist()])
        dofs = np.array([dof + 1, *([1, 2, 3] * own.size)], dtype=np.int64)
        used = coefficients != 0.0
        yield Equation(nodes[used], dofs[used], coefficients[used], where)


def _cross(v: FloatArray) -> FloatArray:
    """(3, 3) with _cross(v) w = v x w."""
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


NO_SHEET = (0.0, 0.0)


def sheet_of(section: Section) -> tuple[float, float]:
    """Thickness of a shell, and height of its middle above the nodes; 0 of others."""
    if isinstance(section, GeneralShell):
        return section.thickness, section.offset
    return (section.thickness, 0.0) if isinstance(section, ShellSection) else NO_SHEET
