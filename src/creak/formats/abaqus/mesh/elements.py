"""*ELEMENT blocks -> one table of all elements, before sections and parts are known."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from creak.arrays import BoolArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.text.fields import Labels, Registry, integer_table, to_label
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.model.faces import FACES, SHELL_FACETS, faces_of, free_faces


@dataclass(frozen=True)
class ElementType:
    """An Abaqus element type and creak's formulation for it."""

    name: str
    kind: str
    n_nodes: int
    sections: tuple[str, ...]
    """Keywords that can give it its properties."""
    note: str = ""


_SHELL = ("SHELL SECTION", "SHELL GENERAL SECTION")
_BEAM, _SOLID, _CONTINUUM = ("BEAM SECTION", "BEAM GENERAL SECTION"), ("SOLID SECTION",), ("SHELL SECTION",)
_MEMBRANE, _RIGID, _LAYER = ("MEMBRANE SECTION",), ("RIGID BODY",), ("COHESIVE SECTION",)
_SKIN = "membranes keep a millionth of a shell's bending stiffness, so that no rotation is loose"
_HALVES = "beams of three nodes are two straight ones, with exact shape functions and their consistent mass"
TYPES: tuple[ElementType, ...] = (
    ElementType("S4", "quad4", 4, _SHELL),
    ElementType("S4R", "quad4", 4, _SHELL),
    ElementType("S3", "tri3", 3, _SHELL),
    ElementType("S3R", "tri3", 3, _SHELL),
    ElementType("STRI3", "tri3", 3, _SHELL, "STRI3 (thin) is treated as S3, which shears a little"),
    ElementType("S4R5", "quad4", 4, _SHELL, "S4R5 (thin) is treated as S4"),
    ElementType("S4RS", "quad4", 4, _SHELL),
    ElementType("S4RSW", "quad4", 4, _SHELL),
    ElementType("S3RS", "tri3", 3, _SHELL),
    ElementType("S8R", "quad8", 8, _SHELL),
    ElementType("S8R5", "quad8", 8, _SHELL, "S8R5 (thin) is treated as S8R"),
    ElementType("S8", "quad8", 8, _SHELL, "S8 is treated as S8R"),
    ElementType("STRI65", "tri6", 6, _SHELL, "STRI65 (thin) is treated as a shell that shears a little"),
    ElementType("S6", "tri6", 6, _SHELL),
    ElementType("M3D4", "quad4", 4, _MEMBRANE, _SKIN),
    ElementType("M3D4R", "quad4", 4, _MEMBRANE, _SKIN),
    ElementType("M3D3", "tri3", 3, _MEMBRANE, _SKIN),
    ElementType("M3D8", "quad8", 8, _MEMBRANE, _SKIN),
    ElementType("M3D8R", "quad8", 8, _MEMBRANE, _SKIN),
    ElementType("M3D6", "tri6", 6, _MEMBRANE, _SKIN),
    ElementType("R3D4", "quad4", 4, _RIGID),
    ElementType("R3D3", "tri3", 3, _RIGID),
    ElementType(
        "B31",
        "beam2",
        2,
        _BEAM,
        "B31 has exact shape functions and their consistent mass: one element is as good as many of Abaqus's",
    ),
    ElementType("B31H", "beam2", 2, _BEAM, "B31H is treated as B31"),
    ElementType("B33", "beam2", 2, _BEAM),
    ElementType("B32", "beam3", 3, _BEAM, _HALVES),
    ElementType("B32R", "beam3", 3, _BEAM, _HALVES),
    ElementType("B32H", "beam3", 3, _BEAM, _HALVES),
    ElementType("PIPE32", "beam3", 3, _BEAM, "PIPE32 is two straight beams: no pressure in the pipe"),
    ElementType("PIPE31", "beam2", 2, _BEAM, "PIPE31 is treated as B31: no pressure in the pipe"),
    ElementType("T3D2", "truss2", 2, _SOLID),
    ElementType("C3D8", "hex8", 8, _SOLID, "C3D8 is treated as C3D8I (incompatible modes): softer in bending"),
    ElementType("C3D8I", "hex8", 8, _SOLID),
    ElementType("C3D8H", "hex8", 8, _SOLID, "C3D8H is treated as C3D8I, which does not lock in volume either"),
    ElementType("C3D8RH", "hex8", 8, _SOLID, "C3D8RH is treated as C3D8I, which does not lock in volume either"),
    ElementType(
        "C3D8R",
        "hex8",
        8,
        _SOLID,
        "C3D8R is treated as C3D8I (fully integrated, incompatible modes): no hourglass modes, stiffer where one "
        "element goes through the thickness",
    ),
    ElementType("C3D6", "wedge6", 6, _SOLID, "C3D6 is fully integrated: a little stiffer than in Abaqus"),
    ElementType("C3D6H", "wedge6", 6, _SOLID, "C3D6H is treated as C3D6: stiff if nearly incompressible"),
    ElementType("C3D4", "tet4", 4, _SOLID),
    ElementType("C3D4H", "tet4", 4, _SOLID, "C3D4H is treated as C3D4: locked if nearly incompressible"),
    ElementType("C3D5", "pyramid5", 5, _SOLID),
    ElementType("C3D8S", "hex8", 8, _SOLID, "C3D8S is treated as C3D8I"),
    ElementType("C3D8IH", "hex8", 8, _SOLID, "C3D8IH is treated as C3D8I, which does not lock in volume either"),
    ElementType("SC8R", "hex8", 8, _CONTINUUM, "SC8R is treated as C3D8I: sharp angles between its sides stiffen it"),
    ElementType("SC6R", "wedge6", 6, _CONTINUUM, "SC6R is treated as C3D6: stiffer in bending"),
    ElementType("COH3D8", "coh8", 8, _LAYER),
    ElementType("COH3D6", "coh6", 6, _LAYER),
    ElementType("C3D10", "tet10", 10, _SOLID),
    ElementType("C3D10M", "tet10", 10, _SOLID, "C3D10M is treated as C3D10"),
    ElementType("C3D10I", "tet10", 10, _SOLID, "C3D10I is treated as C3D10"),
    ElementType("C3D10H", "tet10", 10, _SOLID, "C3D10H is treated as C3D10: stiff if nearly incompressible"),
    ElementType("C3D10MH", "tet10", 10, _SOLID, "C3D10MH is treated as C3D10: stiff if nearly incompressible"),
    ElementType("C3D10HS", "tet10", 10, _SOLID, "C3D10HS is treated as C3D10: stiff if nearly incompressible"),
    ElementType("C3D20", "hex20", 20, _SOLID),
    ElementType("C3D20R", "hex20r", 20, _SOLID),
    ElementType("C3D20H", "hex20", 20, _SOLID, "C3D20H is treated as C3D20: stiff if nearly incompressible"),
    ElementType("C3D20RH", "hex20r", 20, _SOLID, "C3D20RH is treated as C3D20R, which hardly locks in volume"),
    ElementType("C3D15", "wedge15", 15, _SOLID),
    ElementType("C3D15H", "wedge15", 15, _SOLID, "C3D15H is treated as C3D15: stiff if nearly incompressible"),
    ElementType("MASS", "mass", 1, ("MASS",)),
    ElementType("ROTARYI", "rotary", 1, ("ROTARY INERTIA",)),
    ElementType("SPRING1", "spring1", 1, ("SPRING",)),
    ElementType("SPRING2", "spring2", 2, ("SPRING",)),
    ElementType("SPRINGA", "axial2", 2, ("SPRING",)),
    ElementType("DASHPOTA", "axial2", 2, ("DASHPOT",)),
    ElementType("CONN3D2", "bush2", 2, ("CONNECTOR SECTION",)),
    ElementType("DCOUP3D", "bush1", 1, ("DISTRIBUTING COUPLING",)),
    *(ElementType(name, "gap2", 2, ("GAP",)) for name in ("GAPUNI", "GAPCYL", "GAPSPHER")),
    ElementType("DASHPOT1", "spring1", 1, ("DASHPOT",)),
    ElementType("DASHPOT2", "spring2", 2, ("DASHPOT",)),
)
_WITH_TEMPERATURE = ("S4", "S4R", "S8R", "S3", "S3R", "C3D8", "C3D8R", "C3D6", "C3D4", "C3D10M", "C3D20", "C3D20R")
TYPES += tuple(
    replace(t, name=f"{t.name}T", note=f"{t.name}T is treated as {t.name}: temperatures are left out")
    for t in TYPES
    if t.name in _WITH_TEMPERATURE
)
_OTHERS = {
    **dict.fromkeys(("S9R", "M3D9"), ("creak has no shell of nine nodes", "S8R")),
    **dict.fromkeys(("B31OS", "B32OS", "ELBOW"), ("creak has beams without warping and ovalisation", "B31")),
    **dict.fromkeys(("B21", "B22", "B23", "CPS", "CPE", "CAX", "SAX"), ("creak's models are in space, not plane", "")),
    **dict.fromkeys(("ITT",), ("contact is that of the study: a [[connector]] of type play", "")),
    **dict.fromkeys(("AC", "DC", "F3D", "FC"), ("creak has no fluids and no heat", "")),
}
"""Beginnings of types that creak has not -> why, and what comes nearest."""
_FAMILIES = (
    "S3, S4, S8R, STRI65, B31, B32, T3D2, C3D4 to C3D20R, M3D4, R3D4, SC8R, COH3D8, MASS, SPRINGA, CONN3D2 or one of "
    "their kin (`docs/abaqus_decks.md`)"
)
_TYPE_ROW = {t.name: k for k, t in enumerate(TYPES)}
ROTATIONLESS = ("truss2", "coh8", "coh6", "gap2", *FACES)
STRUCTURAL = (*SHELL_FACETS, "beam2", "beam3", "truss2", "coh8", "coh6", *FACES)


@dataclass(frozen=True)
class Elements:
    """All elements of a deck, in deck order, scope by scope."""

    ids: IntArray
    """(n_elem,) labels."""
    type_idx: IntArray
    """(n_elem,) rows into TYPES."""
    nodes_idx: IntArray
    """(n_elem, 4, or more in decks with larger elements) node rows, -1 where the element has fewer nodes."""
    scope_idx: IntArray
    """(n_elem,) rows into the deck's scopes."""
    codes: IntArray
    """(n_elem,) places in the deck, for `Block.place`."""
    probe: Block
    """Any block: it decodes places."""
    third: IntArray
    """(n_elem,) node rows that give beams their axis 1, -1 for none."""

    @property
    def structural(self) -> BoolArray:
        """(n_elem,) True for shells, beams, trusses and solids."""
        return self.of_kinds(STRUCTURAL)

    @property
    def heavy(self) -> BoolArray:
        """(n_elem,) True for those and point masses."""
        return self.of_kinds((*STRUCTURAL, "mass"))

    def of_kinds(self, kinds: Collection[str]) -> BoolArray:
        """(n_elem,) True for elements of these."""
        return np.array([t.kind in kinds for t in TYPES])[self.type_idx]

    @cached_property
    def with_facets(self) -> list[tuple[str, IntArray]]:
        """Kind and nodes (n, n_node) of the shells and solids, kind by kind."""
        wide, rows = {t.kind: t.n_nodes for t in TYPES}, {k: self.of_kinds((k,)) for k in (*SHELL_FACETS, *FACES)}
        return [(kind, self.nodes_idx[mine, : wide[kind]]) for kind, mine in rows.items() if mine.any()]

    def turn(self, nodes: IntArray) -> bool:
        """Whether something other than solids and bars, which have no rotations, is at any of the node rows."""
        return bool(np.isin(self.nodes_idx[~self.of_kinds(ROTATIONLESS)], nodes).any())

    @cached_property
    def free_faces(self) -> BoolArray:
        """(n_elem, most facets) True for the facets of solids (`FACES`) that no other solid has."""
        rows, sides, corners = [], [], []
        for kind in FACES:
            mine = np.flatnonzero(self.of_kinds((kind,)))
            faces = faces_of(kind, self.nodes_idx[mine, : 1 + max(max(face) for face in FACES[kind])])
            rows.append(np.repeat(mine, faces.shape[1]))
            sides.append(np.tile(np.arange(faces.shape[1]), mine.size))
            corners.append(faces.reshape(-1, 4))
        every, alone = np.concatenate(corners), np.zeros((self.ids.size, max(map(len, FACES.values()))), dtype=np.bool_)
        free = free_faces(every, [every])
        alone[np.concatenate(rows)[free], np.concatenate(sides)[free]] = True
        return alone

    def of(self, row: int) -> ElementType:
        return TYPES[int(self.type_idx[row])]

    def where(self, row: int) -> str:
        """file:line of an element."""
        return self.probe.place(int(self.codes[row]))


@dataclass(frozen=True)
class _Table:
    """Elements of one *ELEMENT block, nodes as rows."""

    ids: IntArray
    nodes_idx: IntArray
    codes: IntArray
    third: IntArray


def read_elements(deck: Outline, nodes: Registry) -> tuple[Elements, Registry]:
    """Elements of all scopes.

    Raises
    ------
    InputError : no elements, unknown type, malformed or truncated line, unknown or repeated node,
        two elements with one label.
    """
    registry = Registry("element", {}, deck.assembly)
    tables: list[tuple[int, int, _Table, Block]] = []
    for k, scope in enumerate(deck.scopes):
        blocks = [b for b in scope.blocks if b.name == "ELEMENT"]
        tables += [(k, type_row(b), _element_table(b, scope, nodes), b) for b in blocks]
    if not any(t.ids.size for _, _, t, _ in tables):
        raise InputError("the deck has no elements", expected="*ELEMENT blocks", fix="Is this the right file?")
    elements = Elements(
        np.concatenate([t.ids for _, _, t, _ in tables]),
        np.concatenate([np.full(t.ids.size, row, np.int64) for _, row, t, _ in tables]),
        _stacked([t.nodes_idx for _, _, t, _ in tables]),
        np.concatenate([np.full(t.ids.size, k, np.int64) for k, _, t, _ in tables]),
        np.concatenate([t.codes for _, _, t, _ in tables]),
        tables[0][3],
        np.concatenate([t.third for _, _, t, _ in tables]),
    )
    _register(deck, elements, registry)
    _name_sets(deck, tables, registry)
    _list_notes(deck, tables)
    return elements, registry


def type_row(block: Block) -> int:
    """Row into TYPES of an *ELEMENT block.

    Raises
    ------
    InputError : TYPE= missing or not an element that creak has.
    """
    name = block.need("TYPE").upper()
    if name not in _TYPE_ROW:
        what, instead = next((pair for start, pair in _OTHERS.items() if name.startswith(start)), ("", ""))
        raise block.error(
            f"unknown element type {name!r}{f': {what}' if what else ''}",
            expected=_FAMILIES,
            fix=f"Did you mean {instead!r}?" if instead else suggest(name, _TYPE_ROW) if name else "",
        )
    return _TYPE_ROW[name]


def _element_table(block: Block, scope: Scope, nodes: Registry) -> _Table:
    kind = TYPES[type_row(block)]
    fast = integer_table(block, kind.n_nodes + 1)
    if fast is None:
        return _element_table_by_line(block, kind, scope, nodes)
    rows = nodes.labels[scope.name].find(fast[:, 1:])
    codes = np.array(block.codes, dtype=np.int64)
    if rows.min() < 0:
        k, j = (int(v) for v in np.argwhere(rows < 0)[0])
        raise _unknown_node(int(fast[k, 0]), str(fast[k, j + 1]), scope, nodes, block.place(int(codes[k])))
    _check_distinct(fast[:, 0], rows, codes, block)
    return _Table(fast[:, 0], rows, codes, np.full(rows.shape[0], -1, np.int64))


def _element_table_by_line(block: Block, kind: ElementType, scope: Scope, nodes: Registry) -> _Table:
    ids, table, codes, third = [], [], [], []
    for fields, where, code in _joined_rows(block, kind.n_nodes + 1):
        ids.append(to_label(fields[0], where, "element label"))
        third.append(-1)
        if kind.kind in ("beam2", "beam3") and len(fields) == kind.n_nodes + 2:
            third[-1] = _node_row(ids[-1], fields.pop(), scope, nodes, where)
        if len(fields) != kind.n_nodes + 1:
            raise InputError(
                f"element {fields[0]} of type {kind.name} has {len(fields) - 1} nodes",
                expected=f"{kind.n_nodes}: label, node" + ", node" * (kind.n_nodes - 1),
                where=where,
                fix="Complete or correct the line.",
            )
        table.append([_node_row(ids[-1], f, scope, nodes, where) for f in fields[1:]])
        codes.append(code)
    rows = np.array(table, dtype=np.int64).reshape(-1, kind.n_nodes)
    id_array, code_array = np.array(ids, np.int64), np.array(codes, np.int64)
    _check_distinct(id_array, rows, code_array, block)
    return _Table(id_array, rows, code_array, np.array(third, np.int64))


def _joined_rows(block: Block, n_fields: int) -> list[tuple[list[str], str, int]]:
    """Data lines as fields; a line that ends in a comma and is too short goes on in the next one."""
    result: list[tuple[list[str], str, int]] = []
    unfinished = False
    for k, (fields, where) in enumerate(block.rows(blanks=True)):
        if not fields:
            continue
        if unfinished:
            result[-1][0].extend(fields)
        else:
            result.append((fields, where, block.codes[k]))
        unfinished = block.lines[k].endswith(",") and len(result[-1][0]) < n_fields
    return result


def _node_row(element: int, field: str, scope: Scope, nodes: Registry, where: str) -> int:
    inst, _, label = field.rpartition(".")
    inst = inst.upper().removeprefix(f"{nodes.assembly}.") or scope.name
    number = to_label(label, where, f"node of element {element}")
    labels = nodes.labels.get(inst)
    row = -1 if labels is None else int(labels.find(np.array([number]))[0])
    if row < 0:
        raise _unknown_node(element, field, scope, nodes, where)
    return row


def _unknown_node(element: int, node: str, scope: Scope, nodes: Registry, where: str) -> InputError:
    inside = f" in instance {scope.name!r}" if scope.name else ""
    fix = f"Define node {node} or correct the element."
    if not scope.name and len(nodes.labels) > 1:
        fix = f"Instances are {', '.join(n for n in nodes.labels if n)}: write INSTANCE.LABEL."
    return InputError(f"element {element} uses node {node}, which is not defined{inside}", where=where, fix=fix)


def _stacked(tables: list[IntArray]) -> IntArray:
    """All node rows in one table."""
    width = max(4, *(t.shape[1] for t in tables))
    return np.concatenate([np.pad(t, ((0, 0), (0, width - t.shape[1])), constant_values=-1) for t in tables])


def _check_distinct(ids: IntArray, rows: IntArray, codes: IntArray, block: Block) -> None:
    ordered = np.sort(rows, axis=1)
    repeated = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    if repeated.any():
        k = int(np.argmax(repeated))
        raise InputError(
            f"element {ids[k]} has the same node twice",
            expected="distinct nodes",
            where=block.place(int(codes[k])),
            fix="Correct it; a collapsed quadrilateral is an S3, a collapsed C3D8 a C3D6.",
        )


def _register(deck: Outline, elements: Elements, registry: Registry) -> None:
    for k, scope in enumerate(deck.scopes):
        rows = np.flatnonzero(elements.scope_idx == k)
        labels = Labels(elements.ids[rows], rows)
        registry.labels[scope.name] = labels
        twice = np.flatnonzero(labels.ids[1:] == labels.ids[:-1])
        if twice.size:
            old, new = int(labels.rows[twice[0]]), int(labels.rows[twice[0] + 1])
            raise InputError(
                f"element {elements.ids[new]} is defined twice, first at {elements.where(old)}",
                expected="one definition of each element",
                where=elements.where(new),
                fix="Give one of them another label.",
            )


def _name_sets(deck: Outline, tables: list[tuple[int, int, _Table, Block]], registry: Registry) -> None:
    """Sets named by *ELEMENT, ELSET=, in deck order; many blocks may add to one set."""
    chunks: dict[tuple[str, str], list[IntArray]] = {}
    start = 0
    for k, _, table, block in tables:
        if block.get("ELSET"):
            key = (deck.scopes[k].name, block.get("ELSET").upper())
            chunks.setdefault(key, []).append(np.arange(start, start + table.ids.size))
        start += table.ids.size
    for (scope, name), rows in chunks.items():
        registry.add(scope, name, rows)


def _list_notes(deck: Outline, tables: list[tuple[int, int, _Table, Block]]) -> None:
    seen: set[int] = set()
    for _, row, _, block in tables:
        if TYPES[row].note and row not in seen:
            seen.add(row)
            deck.note(block, TYPES[row].note, changes=False, used=True, what=f"*ELEMENT, TYPE={TYPES[row].name}")
