"""Nodes, elements, sets, surfaces and parts, as the user described them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.model.constraints import Constraint, Fixed
from creak.model.dofs import AXES, dofs_of, node_and_dof, nodes_of
from creak.model.materials import Section
from creak.model.steps import DeckContact, NodeTemperatures, StaticLoads, StaticStep, Stop
from creak.words import first_few


@dataclass(frozen=True)
class Nodes:
    """Grid points. `ids` are the deck's labels, rows (`*_idx`) are creak's."""

    ids: IntArray
    """(n_node,) labels as written in the deck."""
    coords: FloatArray
    """(n_node, 3) global coordinates, length unit of the deck."""
    instance: tuple[str, ...] = ()
    """Instance names; empty for a flat deck."""
    instance_idx: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(n_node,) row into `instance`, -1 for assembly-level nodes; empty for a flat deck."""
    scalar: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """Rows of scalar points: dof 1 is all they have, it has no direction, and rigid motion leaves it at rest."""

    @property
    def count(self) -> int:
        return int(self.ids.size)

    def label(self, idx: int) -> str:
        """Name of a node for people: `17`, or `FRAME-1.17` in a deck with instances."""
        if self.instance and self.instance_idx[idx] >= 0:
            return f"{self.instance[self.instance_idx[idx]]}.{self.ids[idx]}"
        return str(self.ids[idx])

    def first_few(self, rows: IntArray) -> str:
        """Names of nodes for people: `17, 18, 21, 22, 23 and 9 more`."""
        return first_few(rows.tolist(), name=self.label)

    def dof_name(self, label: int) -> str:
        """Name of a dof for people: `node 17 RZ`."""
        node, dof = node_and_dof(label)
        return f"node {self.label(node)} {AXES[dof - 1]}"


def elements_named(ids: IntArray) -> str:
    """`element 7`, or `elements 1, 2, 3, 4, 5 and 9 more`."""
    return f"element{'s' * (ids.size > 1)} {first_few(ids.tolist())}"


@dataclass(frozen=True, eq=False)
class Own:
    """What elements of a block have each of their own; None where all follow the section."""

    axis1: FloatArray | None = None
    """(n_elem, 3) direction 1 in global axes. Shells: the material direction, projected on the surface (None:
    global x, or z where x is normal to it). Solids, bushings: material or spring axis 1 (None: global axes).
    Beams: instead of axis 1 of the section."""
    axis2: FloatArray | None = None
    """(n_elem, 3) a direction in the 1-2 plane, of solids and bushings."""
    thickness: FloatArray | None = None
    """(n_elem, n_node_per_element) thickness of shells at the nodes over that of the section."""
    arms: FloatArray | None = None
    """(n_elem, n_node_per_element, 3) rigid arms from the nodes to the corners of the element, global axes."""
    free_sides: BoolArray | None = None
    """(n_elem, 4 or 3) sides of shells, node k to k + 1: of quadrilaterals those that no other shell has, of triangles
    those along which a twisting moment falls to nothing (`elements.free_sides`); None: not looked for."""

    def take(self, rows: slice | IntArray) -> Own:
        """The same of some elements."""
        axis1, axis2, thickness, arms = (
            None if a is None else a[rows] for a in (self.axis1, self.axis2, self.thickness, self.arms)
        )
        free_sides = None if self.free_sides is None else self.free_sides[rows]
        return Own(axis1, axis2, thickness, arms, free_sides)


COMMON = Own()
"""Elements that differ in nothing but their nodes."""


@dataclass(frozen=True)
class ElementBlock:
    """Elements of one kind, one section and one part."""

    kind: str
    """Element formulation, a key of `elements.registry.FORMULATIONS`."""
    ids: IntArray
    """(n_elem,) labels as written in the deck."""
    nodes_idx: IntArray
    """(n_elem, n_node_per_element) rows into `Nodes`."""
    section: Section
    part: int
    """Row into `Model.parts`, -1 for elements that belong to no part (springs between parts)."""
    where: str = ""
    """file:line of the first line of the block."""
    own: Own = COMMON

    @property
    def title(self) -> str:
        """The elements for people: `elements 1, 2, 3, 4, 5 and 9 more`."""
        return elements_named(self.ids)


def some_of(block: ElementBlock, rows: IntArray) -> ElementBlock:
    """The block of some of its elements."""
    return replace(block, ids=block.ids[rows], nodes_idx=block.nodes_idx[rows], own=block.own.take(rows))


@dataclass(frozen=True)
class Surface:
    """A contact surface: element facets or nodes.

    `facets` is (n_facet, 2): row of the block in `Model.blocks`, row of the element in that block.
    `side` is (n_facet,): +1 positive side only, -1 negative side only, 0 both sides;
    for solids the number of the facet in `solid_faces.FACES`, from 1 (1 to 6 where faces are not divided).
    A node surface has `nodes_idx` and no facets.
    """

    name: str
    facets: IntArray
    side: IntArray
    nodes_idx: IntArray
    where: str = ""

    @property
    def is_node_based(self) -> bool:
        return self.facets.shape[0] == 0


@dataclass(frozen=True)
class Part:
    """A connected piece of structure that can become a substructure."""

    name: str
    nodes_idx: IntArray
    """Rows of all its nodes, coupling reference nodes included."""
    aliases: tuple[str, ...] = ()
    """Other names of the part: the *PART of its only instance."""

    def has(self, node_idx: int) -> bool:
        return bool((self.nodes_idx == node_idx).any())


@dataclass(frozen=True)
class Unread:
    """A keyword of the deck that creak did not use, or what it made of one."""

    keyword: str
    where: str
    changes_answer: bool
    why: str
    damps: bool = False
    """Whether it is damping alone, on which no stiffness or mass depends."""
    used: bool = False
    """It was used: `why` says what became of it."""
    share: float = 0.0
    """Of critical damping in every mode, which does the same at resonance; 0: it is not known."""
    share_of: str = ""
    """The material or property that has this share alone; empty: all of the model."""

    @property
    def word(self) -> str:
        """What became of it, before its name."""
        return "read" if self.used else "not read"


@dataclass(frozen=True)
class Model:
    """Everything a deck describes, with rows instead of labels."""

    source: str
    nodes: Nodes
    blocks: tuple[ElementBlock, ...]
    parts: tuple[Part, ...]
    node_sets: Mapping[str, IntArray]
    """Name (upper case) -> rows into `Nodes`, in the order of the deck."""
    element_sets: Mapping[str, IntArray]
    """Name (upper case) -> (n, 2): row into `blocks`, row in the block."""
    surfaces: Mapping[str, Surface]
    constraints: tuple[Constraint, ...] = ()
    fixed: tuple[Fixed, ...] = ()
    initial_velocity: tuple[tuple[int, int, float], ...] = ()
    """(node row, dof 1..6, velocity)."""
    unread: tuple[Unread, ...] = ()
    mass_form: str = "consistent"
    """Mass of structural elements: consistent, lumped or linear; see `elements.block_matrices`."""
    prestress: StaticStep | None = None
    """The static step before the deck's modes that they start from, where creak can follow it."""
    initial_temperature: NodeTemperatures | None = None
    """At which nothing is strained, but for materials that say their own; None: the deck gives none."""
    static_loads: Mapping[str, StaticLoads] = field(default_factory=dict)
    """Loads of the deck that a run may start under, by name."""
    contact: DeckContact | None = None
    """Contact of the deck; None: it has none, or its reader does not look for it."""
    frames: Mapping[int, FloatArray] = field(default_factory=dict)
    """Row of a node -> (3, 3), columns are its directions in matrices of Nastran (CD); not of nodes that move along
    the global axes. All else of the model is in global axes."""
    untyped: tuple[str, ...] = ()
    """Sets of nodes and of elements that are one list of numbers, of which the deck does not say what they count."""
    stops: tuple[Stop, ...] = ()
    """Gaps between nodes of the deck, which press only where connectors of the study name their node sets."""

    @property
    def n_elements(self) -> int:
        return sum(b.ids.size for b in self.blocks)

    def dof_name(self, label: int) -> str:
        """`node 17 RZ of part FRAME`."""
        parts = [p.name for p in self.parts if np.isin(node_and_dof(label)[0], p.nodes_idx)]
        return self.nodes.dof_name(label) + (f" of part {parts[0]}" if parts else "")

    def node_set(self, name: str, *, where: object = "") -> IntArray:
        """Rows of a node set (names are case-insensitive).

        Raises
        ------
        InputError : the deck has no such set, or it is empty.
        """
        rows = self.node_sets.get(name.upper())
        if rows is None:
            raise InputError(f"unknown node set {name!r}", where=where, fix=suggest(name, self.node_sets))
        if rows.size == 0:
            raise InputError(f"node set {name!r} is empty", where=where, fix="Put nodes into it.")
        return rows


def rigid_vectors(labels: IntArray, nodes: Nodes, about: FloatArray) -> FloatArray:
    """(k, 6) u = e_j and u = e_j x (x - about), theta = e_j at labels of dofs; 0 at scalar points, as in Nastran."""
    node, axis = nodes_of(labels), dofs_of(labels) - 1
    arm = nodes.coords[node] - about
    R = np.zeros((labels.size, 6))
    R[np.arange(labels.size), axis] = 1.0
    for j, e in enumerate(np.eye(3)):
        moves = np.flatnonzero(axis < 3)
        R[moves, 3 + j] = np.cross(e, arm[moves])[np.arange(moves.size), axis[moves]]
    R[np.isin(node, nodes.scalar)] = 0.0
    return R
