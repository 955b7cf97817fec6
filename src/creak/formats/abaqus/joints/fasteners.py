"""*FASTENER: each joins patches of two or more surfaces at a reference node, rigidly or by connectors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.joints.connectors import Connector, described, read_behaviours
from creak.formats.abaqus.mesh.elements import Elements
from creak.formats.abaqus.mesh.sets import RawSurface
from creak.formats.abaqus.sections.own_data import Geometry
from creak.formats.abaqus.text.fields import Registry, lookup, positive, to_float, with_short_names
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.model.constraints import Constraint, DistributingCoupling
from creak.model.materials import AxialSpring, Bushing, PointMass
from creak.model.mesh import ElementBlock, Nodes, Own, Part
from creak.model.projection import nearest_points

FLAT = 1e-12
"""Area over the square of the longest edge below which a facet has none."""
RIGID = ("BEAM", "WELD")
"""Connection types of rigid fasteners; without a *CONNECTOR SECTION a fastener is a BEAM."""


@dataclass
class Fasteners:
    """What fasteners add to a model."""

    constraints: list[Constraint] = field(default_factory=list)
    points: list[FloatArray] = field(default_factory=list)
    """Fastening points, nodes of their own after those of the deck."""
    springs: list[tuple[Block, Bushing | AxialSpring, Own, IntArray]] = field(default_factory=list)
    """*CONNECTOR SECTION, section, axes and node rows (n, 2)."""
    joints: list[Connector] = field(default_factory=list)
    masses: list[tuple[Block, float, IntArray]] = field(default_factory=list)
    """*FASTENER PROPERTY, its mass and the reference nodes that have it."""


def read_fasteners(deck: Outline, surfaces: dict[str, RawSurface], nodes: Registry, geometry: Geometry) -> Fasteners:
    """On each surface the mean motion of the nodes round the fastening point carries the fastener.

    The point is the nearest one of the surface; the nodes are those within RADIUS OF INFLUENCE of it, by default
    those within the radius of *FASTENER PROPERTY and of the facet that it lies on, all of equal weight. Rotations of
    the nodes are not tied. A rigid fastener is the motion of the reference node on all layers; others have a node at
    each fastening point and connectors between layer and layer, along the axes of their section, or with axis 3 along
    the normal of the first surface and axis 1 along global x (z where x is within 0.1 degree of the normal).

    Raises
    ------
    InputError : no property, surface or reference nodes; fewer than two surfaces, or one that is too far.
    """
    properties = {block.need("NAME").upper(): block for _, block in deck.blocks("FASTENER PROPERTY")}
    behaviours, coords = read_behaviours(deck), geometry.coords
    found = Fasteners()
    for scope, block in deck.blocks("FASTENER"):
        owner = properties.get(block.need("PROPERTY").upper())
        if owner is None:
            raise block.error(
                f"unknown *FASTENER PROPERTY {block.get('PROPERTY')!r}", fix=suggest(block.get("PROPERTY"), properties)
            )
        if block.option("COUPLING", "CONTINUUM") != "CONTINUUM":
            why = "creak does not tie rotations of the nodes round a fastener"
            deck.note(block, why, changes=True, what="*FASTENER, COUPLING=STRUCTURAL")
        if block.option("WEIGHTING METHOD", "UNIFORM") != "UNIFORM":
            deck.note(block, "creak weights all nodes alike", changes=True, what="*FASTENER, WEIGHTING METHOD")
        rows = nodes.find(block.need("REFERENCE NODE SET"), scope.name, block.where)
        if mass := _mass(owner):
            found.masses.append((owner, mass, rows))
        layers = [_hung(block, rows, s, _radius(owner), coords) for s in _surfaces(deck, scope, block, surfaces)]
        section = _connectors(deck, block)
        if section is None:
            found.constraints += [p.coupling for layer in layers for p in layer]
            continue
        pairs, frames = _elastic(found, layers, len(coords))
        every = replace(geometry, coords=np.concatenate([coords, *(p[None] for p in found.points)]))
        spring, own, joints = described(deck, scope, section, pairs, behaviours, every, frames)
        found.springs.append((section, spring, own, pairs))
        found.joints += joints
    return found


def extended(nodes: Nodes, points: list[FloatArray]) -> Nodes:
    """The nodes with further ones after them, labelled from the largest label on."""
    if not points:
        return nodes
    first = int(nodes.ids.max()) + 1
    owner = nodes.instance_idx
    owner = np.concatenate([owner, np.full(len(points), -1, np.int64)]) if owner.size else owner
    ids = np.concatenate([nodes.ids, np.arange(first, first + len(points))])
    return Nodes(ids, np.concatenate([nodes.coords, np.array(points)]), nodes.instance, owner)


def spring_blocks(found: Fasteners, elements: Elements, parts: Sequence[Part], n_node: int) -> list[ElementBlock]:
    """Connectors and masses of fasteners as blocks, in the part of all their nodes where that is one."""
    owner = np.full(n_node, -1, dtype=np.int64)
    for i, part in enumerate(parts):
        owner[part.nodes_idx] = i
    blocks: list[ElementBlock] = []
    label = int(elements.ids.max()) + 1
    for block, section, own, pairs in found.springs:
        kind = "axial2" if isinstance(section, AxialSpring) else "bush2"
        of = np.where(owner[pairs[:, 0]] == owner[pairs[:, 1]], owner[pairs[:, 0]], -1)
        for part in np.unique(of).tolist():
            rows = np.flatnonzero(of == part)
            blocks.append(ElementBlock(kind, label + rows, pairs[rows], section, part, block.where, own.take(rows)))
        label += len(pairs)
    for block, mass, rows in found.masses:
        for part in np.unique(owner[rows]).tolist():
            some = np.flatnonzero(owner[rows] == part)
            point = PointMass(block.get("NAME"), mass)
            blocks.append(ElementBlock("mass", label + some, rows[some][:, None], point, part, block.where))
        label += len(rows)
    return blocks


def _connectors(deck: Outline, block: Block) -> Block | None:
    """The *CONNECTOR SECTION of the fastener's connectors; None where they are rigid."""
    for _, section in deck.blocks("CONNECTOR SECTION"):
        if block.get("ELSET") and section.get("ELSET").upper() == block.get("ELSET").upper():
            kinds = [f.upper() for fields, _ in list(section.rows())[:1] for f in fields]
            return None if kinds in [[k] for k in RIGID] else section
    return None


@dataclass(frozen=True)
class _Point:
    """Where a fastener meets a surface."""

    coupling: DistributingCoupling
    """Of the reference node."""
    place: FloatArray
    normal: FloatArray


def _elastic(found: Fasteners, layers: Sequence[list[_Point]], n_node: int) -> tuple[IntArray, FloatArray]:
    """Nodes at the fastening points, hung on their layers; pairs of them (n, 2) and axes (n, 3, 3)."""
    pairs: list[tuple[int, int]] = []
    frames: list[FloatArray] = []
    for points in zip(*layers, strict=True):
        rows = []
        found.constraints.append(points[0].coupling)
        for point in points:
            rows.append(n_node + len(found.points))
            found.points.append(point.place)
            found.constraints.append(replace(point.coupling, ref_idx=rows[-1]))
        pairs += list(pairwise(rows))
        frames += [_frame(points[0].normal)] * (len(rows) - 1)
    return np.array(pairs, dtype=np.int64).reshape(-1, 2), np.array(frames).reshape(-1, 3, 3)


def _frame(normal: FloatArray) -> FloatArray:
    """Rows 1, 2, 3: along the surface, twice, and the normal."""
    near_x = float(np.hypot(normal[1], normal[2])) < 1.7e-3
    first = np.eye(3)[2 if near_x else 0]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first), normal])


def _mass(owner: Block) -> float:
    mass = to_float(owner.get("MASS"), owner.where, "MASS of the fastener")
    if mass < 0.0:
        raise owner.error(f"MASS of the fastener is {mass:g}", expected="zero or more", fix="Correct it.")
    return mass


def _radius(owner: Block) -> float:
    rows = list(owner.rows())
    fields, where = rows[0] if rows else ([""], owner.where)
    return positive(fields[0], where, "radius of the fastener")


def _surfaces(deck: Outline, scope: Scope, block: Block, known: dict[str, RawSurface]) -> list[RawSurface]:
    """Surfaces of the data lines after the first, which holds a direction."""
    names = [(f, where) for fields, where in list(block.rows(blanks=True))[1:] for f in fields if f]
    if len(names) < 2:
        raise block.error(
            f"*FASTENER names {len(names)} surface(s)",
            expected="a line with the direction (or blank), then two surfaces or more",
            fix="Name the surfaces of both layers: creak does not look for them.",
        )
    found = []
    for name, where in names:
        surface = lookup(known, name, scope.name, deck.assembly)
        if surface is None or not surface.corners.size:
            near = with_short_names(known, deck.instances)
            fix = suggest(name, near) if surface is None else "Name a surface of elements."
            raise InputError(f"*FASTENER on surface {name!r}, which has no facets", where=where, fix=fix)
        found.append(surface)
    return found


def _hung(block: Block, rows: IntArray, surface: RawSurface, radius: float, coords: FloatArray) -> list[_Point]:
    """Where each reference node meets the surface."""
    X = coords[surface.corners]
    edge = float(np.linalg.norm(np.roll(X, -1, axis=1) - X, axis=2).max())
    reach = edge
    if block.has("SEARCH RADIUS"):
        reach = positive(block.get("SEARCH RADIUS"), block.where, "SEARCH RADIUS")
    influence = radius
    if block.has("RADIUS OF INFLUENCE"):
        influence = positive(block.get("RADIUS OF INFLUENCE"), block.where, "RADIUS OF INFLUENCE")
    nearest = nearest_points(coords[rows], X, surface.corners[:, 2] == surface.corners[:, 3], reach)
    name = block.get("INTERACTION NAME") or block.get("PROPERTY")
    points: list[_Point] = []
    for k, row in enumerate(rows.tolist()):
        if not nearest.found[k]:
            raise block.error(
                f"reference node at {', '.join(f'{x:g}' for x in coords[row])} of *FASTENER is farther than {reach:g} "
                f"from surface {surface.name!r}",
                expected="reference nodes between the layers",
                fix="Move the node, or give SEARCH RADIUS.",
            )
        facet = int(nearest.facet[k])
        point = nearest.shape[k] @ X[facet]
        close = np.linalg.norm(coords[surface.nodes_idx] - point, axis=1) <= influence * (1.0 + 1e-9)
        patch = np.union1d(surface.nodes_idx[close], surface.corners[facet])
        patch = patch[patch != row]
        across = np.cross(X[facet, 2] - X[facet, 0], X[facet, 3] - X[facet, 1])
        if not float(np.linalg.norm(across)) > FLAT * edge * edge:
            raise block.error(
                f"the facet of surface {surface.name!r} nearest to a reference node of *FASTENER has no area",
                expected="a direction across the layers",
                fix="Look for nodes of the surface that coincide.",
            )
        coupling = DistributingCoupling(name, row, patch, np.ones(patch.size), (1, 2, 3, 4, 5, 6), block.where)
        points.append(_Point(coupling, point, across / float(np.linalg.norm(across))))
    return points
