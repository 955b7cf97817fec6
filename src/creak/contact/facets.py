"""Facets of contact surfaces: geometry, thickness and stiffness of the shells and solids they belong to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeGuard

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.model.constraints import held_nodes
from creak.model.faces import (
    FACES,
    N_CORNER,
    SHELL_FACETS,
    FaceShapes,
    face_numbers,
    face_shapes,
    faces_of,
    facet_areas,
    facets_of_shells,
    free_faces,
    joined,
    unit,
    vector_areas,
    volumes,
)
from creak.model.materials import AnisotropicMaterial, GeneralShell, Material, ShellSection
from creak.model.mesh import ElementBlock, Model

SHEAR_CORRECTION = 5.0 / 6.0
FEATURE = np.cos(np.radians(45.0))
"""Faces of solids that turn by more than 45 degrees meet at an edge; their normals are not averaged across it."""
NO_AREA = 1e-10
"""A facet with less than this share of the square of its extent has no area."""


@dataclass(frozen=True)
class Facets:
    """Facets of a surface: shells and outer faces of solids; triangles repeat their third node in the fourth column.

    Shells have a thickness and touch with either side unless the surface names one. Faces of solids are ordered so
    that their normal looks outward, touch with that side only (side = 1) and have no thickness.
    """

    nodes: IntArray
    """(n, 4) node rows."""
    coords: FloatArray
    """(n, 4, 3)"""
    side: IntArray
    """(n,) +1, -1, or 0 for both sides."""
    thickness: FloatArray
    """(n,) 0 for faces of solids."""
    normal_stiffness: FloatArray
    """(n,) how the parent element resists a displacement across the facet, force / length: kappa G t of shells;
    E_c A^2 / V of solids with the modulus E_c = K + 4 G / 3 of confined compression (LS-DYNA takes K A^2 / V:
    Hallquist, LS-DYNA Theory Manual, contact stiffness); inf where all nodes are held."""
    depth: FloatArray
    """(n,) half the height V / A of solids, 0 for shells."""
    arm: FloatArray
    """(n,) from the surface of the nodes to the side that touches; 0 where no node turns it: solids, membranes."""
    shapes: FaceShapes
    """How they move."""

    @property
    def arrays(self) -> list[FloatArray | IntArray]:
        """All that says what they are."""
        own = {**vars(self), **vars(self.shapes)}
        del own["shapes"]
        return list(own.values())

    @property
    def count(self) -> int:
        return int(self.nodes.shape[0])

    @property
    def is_triangle(self) -> BoolArray:
        return self.nodes[:, 2] == self.nodes[:, 3]

    @property
    def is_solid(self) -> BoolArray:
        return self.thickness == 0.0

    @property
    def area_normals(self) -> FloatArray:
        """(n, 3) normals whose length is the facet's area (half the cross product of the diagonals)."""
        return vector_areas(self.coords)

    @property
    def width(self) -> FloatArray:
        """(n,) length of the shorter way across: area over the longest edge (triangles: height on it)."""
        longest = np.linalg.norm(np.roll(self.coords, -1, axis=1) - self.coords, axis=2).max(axis=1)
        area = np.linalg.norm(self.area_normals, axis=1)
        return np.asarray(np.where(self.is_triangle, 2.0, 1.0) * area / longest, dtype=np.float64)

    @property
    def node_rows(self) -> IntArray:
        """Sorted node rows of the surface."""
        return np.unique(self.nodes)


def facets_of(model: Model, name: str, *, where: str) -> Facets:
    """The facets of a surface or element set; of the solids in a set all faces that no other solid shares.

    Raises
    ------
    InputError : no such surface or set; it is node-based or empty; it has elements that are neither shells nor
        solids; a facet without area.
    """
    surface = model.surfaces.get(name.upper())
    if surface is not None and not surface.is_node_based:
        return _gather(model, surface.facets, surface.side, name, where)
    if surface is None and name.upper() in model.element_sets:
        return _gather(model, *_of_set(model, model.element_sets[name.upper()]), name, where)
    if surface is not None or name.upper() in model.node_sets:
        raise InputError(
            f"{name!r} is a set of nodes, without facets",
            where=where,
            expected="an element-based surface or set",
            fix='Give one, or use it as secondary with method = "node-to-surface".',
        )
    known = [*model.surfaces, *model.element_sets, *model.node_sets]
    raise InputError(f"unknown surface or set {name!r}", where=where, fix=suggest(name, known))


def nodal_normals(facets: Facets) -> FloatArray:
    """(n_node, 3) area-weighted unit normals at `node_rows`; neighbouring facets are first turned to one side.

    Where the normals of the facets cancel (a sharp fold) the largest facet decides.
    """
    normals = facets.area_normals * _orientation(facets)[:, None]
    rows = facets.node_rows
    at = np.searchsorted(rows, facets.nodes)
    total = np.zeros((rows.size, 3))
    for column in range(4):
        np.add.at(total, at[:, column], normals)
    length = np.linalg.norm(total, axis=1)
    weak = np.flatnonzero(length < 1e-6 * np.linalg.norm(normals, axis=1).max())
    for node in weak:
        mine = np.flatnonzero((at == node).any(axis=1))
        total[node] = normals[mine[np.argmax(np.linalg.norm(normals[mine], axis=1))]]
    return total / np.linalg.norm(total, axis=1)[:, None]


def corner_normals(facets: Facets) -> FloatArray:
    """(n, 4, 3) unit normals at the corners of each facet: `nodal_normals`, but not averaged round edges of solids."""
    normals = nodal_normals(facets)[np.searchsorted(facets.node_rows, facets.nodes)]
    solid = np.flatnonzero(facets.is_solid)
    if not solid.size:
        return normals
    area_normals = facets.area_normals
    unit = area_normals / np.linalg.norm(area_normals, axis=1)[:, None]
    # Pairs: corner 4 i + j of the i-th solid facet, and every solid facet with that node (itself included).
    at = facets.nodes[solid]
    own = np.where(facets.is_triangle[solid][:, None] & (np.arange(4) == 3), -1, at).ravel()
    order = np.argsort(own, kind="stable")
    first, last = (np.searchsorted(own[order], at.ravel(), side=side) for side in ("left", "right"))
    count = last - first
    inner = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    corner, other = np.repeat(np.arange(at.size), count), solid[order[np.repeat(first, count) + inner] // 4]
    facet = solid[corner // 4]
    level = np.einsum("nx,nx->n", unit[facet], unit[other]) > FEATURE
    total = np.zeros((4 * solid.size, 3))
    np.add.at(total, corner[level], area_normals[other[level]])
    normals[solid] = (total / np.linalg.norm(total, axis=1)[:, None]).reshape(-1, 4, 3)
    return normals


def _orientation(facets: Facets) -> FloatArray:
    """+1 or -1 per facet so that facets sharing an edge have the same orientation; given sides are kept."""
    if (facets.side != 0).all():
        return facets.side.astype(np.float64)
    edges, owner, direction = _directed_edges(facets)
    order = np.lexsort((owner, edges[:, 1], edges[:, 0]))
    edges, owner, direction = edges[order], owner[order], direction[order]
    same = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    a, b = owner[same], owner[same + 1]
    agree = direction[same] != direction[same + 1]
    return _propagate(facets.side, a, b, agree)


def _directed_edges(facets: Facets) -> tuple[IntArray, IntArray, BoolArray]:
    start = facets.nodes
    stop = np.roll(facets.nodes, -1, axis=1)
    owner = np.repeat(np.arange(facets.count), 4)
    pairs = np.stack([start.ravel(), stop.ravel()], axis=1)
    real = pairs[:, 0] != pairs[:, 1]
    pairs, owner = pairs[real], owner[real]
    return np.sort(pairs, axis=1), owner, pairs[:, 0] < pairs[:, 1]


def _propagate(side: IntArray, a: IntArray, b: IntArray, agree: BoolArray) -> FloatArray:
    """Signs from the facets with a given side (or the first of a connected piece) on, along a spanning tree."""
    n = side.size
    _, once = np.unique(a * n + b, return_index=True)
    a, b, agree = a[once], b[once], agree[once]
    graph = sp.coo_matrix((np.where(agree, 1.0, -1.0), (a, b)), shape=(n, n)).tocsr()
    _, piece = sp.csgraph.connected_components(graph, directed=False)
    given = np.flatnonzero(side != 0)
    first = np.unique(piece, return_index=True)[1]
    seeds = np.append(given, first[~np.isin(np.arange(first.size), piece[given])])
    root = sp.coo_matrix((np.where(side[seeds] < 0, -1.0, 1.0), (np.full(seeds.size, n), seeds)), shape=(n + 1, n + 1))
    graph.resize((n + 1, n + 1))
    graph = (graph + graph.T + root + root.T).tocsr()
    _, parent = sp.csgraph.breadth_first_order(graph, n, directed=False)
    above = np.append(parent[:n], n).astype(np.int64)
    sign = np.where(np.asarray(graph[above, np.arange(n + 1)]).ravel() < 0.0, -1.0, 1.0)
    while (above != n).any():
        sign, above = sign * sign[above], above[above]
    return np.asarray(sign[:n], dtype=np.float64)


def _of_set(model: Model, members: IntArray) -> tuple[IntArray, IntArray]:
    """Facets and sides of an element set: shells with both sides, all free faces of solids."""
    kind = np.array([model.blocks[row].kind for row in members[:, 0]], dtype=object)
    solid = np.isin(kind, tuple(FACES))
    pairs, number, corners = [np.zeros((0, 2), dtype=np.int64)], [np.zeros(0, np.int64)], [np.zeros((0, 4), np.int64)]
    for row in np.unique(members[solid, 0]).tolist():
        block, mine = model.blocks[row], members[members[:, 0] == row]
        faces = faces_of(block.kind, block.nodes_idx[mine[:, 1]])
        pairs.append(np.repeat(mine, faces.shape[1], axis=0))
        number.append(np.tile(np.arange(1, faces.shape[1] + 1), mine.shape[0]))
        corners.append(faces.reshape(-1, 4))
    every = [faces_of(b.kind, b.nodes_idx).reshape(-1, 4) for b in model.blocks if b.kind in FACES]
    free = free_faces(np.concatenate(corners), every)
    shells = members[~solid]
    return (
        np.concatenate([shells, np.concatenate(pairs)[free]]),
        np.concatenate([np.zeros(shells.shape[0], dtype=np.int64), np.concatenate(number)[free]]),
    )


def _gather(model: Model, pairs: IntArray, side: IntArray, name: str, where: str) -> Facets:
    """Facets of elements (block, row); `side` of a solid is the number of its face."""
    count = np.array([len(SHELL_FACETS.get(block.kind, (0,))) for block in model.blocks])[pairs[:, 0]]
    pairs, side = np.repeat(pairs, count, axis=0), np.repeat(side, count)
    number = np.arange(pairs.shape[0]) - np.repeat(np.cumsum(count) - count, count)
    n = pairs.shape[0]
    nodes = np.zeros((n, 4), dtype=np.int64)
    thickness, stiffness, depth, arm = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    shapes: list[tuple[IntArray, FaceShapes]] = []
    for row in np.unique(pairs[:, 0]).tolist():
        block, mine = model.blocks[row], np.flatnonzero(pairs[:, 0] == row)
        element, section = pairs[mine, 1], block.section
        if block.kind in FACES:
            nodes[mine], stiffness[mine], depth[mine] = _faces(model, block, element, side[mine])
            number[mine], side[mine] = side[mine] - 1, 1
        elif block.kind in SHELL_FACETS and isinstance(section, ShellSection | GeneralShell):
            nodes[mine] = facets_of_shells(block.kind, block.nodes_idx[element])[np.arange(element.size), number[mine]]
            thickness[mine] = _thickness(model, block, element, side[mine], name, where)
            stiffness[mine] = _shear_stiffness(section)
            arm[mine] = 0.5 * thickness[mine] * bends(section)
        else:
            raise InputError(
                f"surface {name!r} holds {block.kind} elements (element {block.ids[element[0]]})",
                where=where,
                expected="shell and solid elements",
                fix="Take only shells and solids into a contact surface; nodes of beams may be secondary "
                'with method = "node-to-surface".',
            )
        shapes.append((mine, face_shapes(block.kind, block.nodes_idx[element], number[mine])))
    if not nodes.size:
        raise InputError(
            f"surface {name!r} is empty",
            where=where,
            expected="shell elements or free faces of solids",
            fix="Put shell or solid elements into it.",
        )
    held = np.zeros(model.nodes.count, dtype=bool)
    held[held_nodes(model.fixed)] = True
    stiffness[held[nodes].all(axis=1)] = np.inf
    facets = Facets(nodes, model.nodes.coords[nodes], side, thickness, stiffness, depth, arm, joined(shapes, n))
    _require_area(model, facets, pairs, name, where)
    return facets


def bends(section: object) -> TypeGuard[ShellSection | GeneralShell]:
    """Whether it is a shell's whose nodes turn its sides; membranes do not."""
    return isinstance(section, ShellSection) or (isinstance(section, GeneralShell) and not section.is_membrane)


def _thickness(
    model: Model, block: ElementBlock, element: IntArray, side: IntArray, name: str, where: str
) -> FloatArray:
    """Twice the distance (n,) of a shell's outer surface from the surface of its nodes."""
    thickness, offset = middles(model, block, element)
    if not offset.any():
        return thickness
    if (side == 0).any():
        raise InputError(
            f"surface {name!r} holds shells whose nodes lie off their middle (element {block.ids[element[0]]})",
            where=where,
            expected="a side, SPOS or SNEG",
            fix=f"Say which side touches: {name}.SPOS or {name}.SNEG, or name it in a *SURFACE of an Abaqus deck.",
        )
    return thickness + 2.0 * side * offset


def middles(model: Model, block: ElementBlock, element: IntArray) -> tuple[FloatArray, FloatArray]:
    """Thickness (n,) of shells, and how far (n,) their middle lies off the surface of their nodes, along the normal."""
    section: ShellSection | GeneralShell = block.section  # type: ignore[assignment]
    own = block.own.take(element)
    ratio = np.ones(element.size) if own.thickness is None else own.thickness.mean(axis=1)
    offset = ratio * (section.offset if isinstance(section, GeneralShell) else 0.0)
    if own.arms is not None:
        corner = model.nodes.coords[block.nodes_idx[element, : N_CORNER[block.kind]]]
        offset = offset + np.einsum("nx,nx->n", own.arms.mean(axis=1), unit(vector_areas(corner)))
    return section.thickness * ratio, offset


def _shear_stiffness(section: ShellSection | GeneralShell) -> float:
    """Transverse shear force per width over shear strain; the mean of both directions."""
    if isinstance(section, GeneralShell):
        return 0.5 * float(section.S[0, 0] + section.S[1, 1])
    return SHEAR_CORRECTION * section.material.shear_modulus * section.thickness


def _faces(
    model: Model, block: ElementBlock, element: IntArray, number: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Corners (n, 4), normal stiffness and depth of facets `number` (1, 2, ...) of solids.

    A facet has the share of the volume that it has of the area of its face.
    """
    every = faces_of(block.kind, block.nodes_idx[element])
    x = model.nodes.coords[every]
    areas = facet_areas(x)
    of_face = face_numbers(block.kind)
    share = areas / np.maximum(areas @ (of_face[:, None] == of_face), 1e-300)
    rows = np.arange(element.size)
    area = areas[rows, number - 1]
    volume = np.maximum(np.abs(volumes(x)) * share[rows, number - 1], 1e-300)
    confined = confined_modulus(block.section.material)  # type: ignore[union-attr]
    return every[rows, number - 1], confined * area**2 / volume, 0.5 * volume / np.maximum(area, 1e-300)


def confined_modulus(material: Material | AnisotropicMaterial) -> float:
    """Stress over strain in uniaxial strain; the mean of the three directions."""
    if isinstance(material, AnisotropicMaterial):
        return float(np.trace(material.elasticity[:3, :3])) / 3.0
    return 2.0 * material.shear_modulus * (1.0 - material.poisson_ratio) / (1.0 - 2.0 * material.poisson_ratio)


def _require_area(model: Model, facets: Facets, pairs: IntArray, name: str, where: str) -> None:
    extent = np.ptp(facets.coords, axis=1).max(axis=1)
    bad = np.flatnonzero(~(np.linalg.norm(facets.area_normals, axis=1) > NO_AREA * extent**2))
    if bad.size:
        block, row = pairs[bad[0]]
        raise InputError(
            f"surface {name!r} has {bad.size} facet(s) without area, so without a normal; the first is of element "
            f"{model.blocks[block].ids[row]}",
            where=where,
            expected="facets with an area",
            fix="Repair or leave out the element: do nodes coincide?",
        )
