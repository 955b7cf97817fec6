"""*NODE blocks -> nodes of all scopes, in global coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError
from creak.formats.abaqus.mesh.directions import LocalSystem
from creak.formats.abaqus.text.fields import Labels, Registry, floats, label_and_reals, to_float, to_label
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.model.mesh import Nodes

LARGEST = 1e100
"""Coordinate whose square is still a number."""


@dataclass(frozen=True)
class _Table:
    """Nodes of one *NODE block in part coordinates."""

    ids: IntArray
    coords: FloatArray
    codes: IntArray
    has_normals: bool


def read_nodes(deck: Outline) -> tuple[Nodes, Registry]:
    """Nodes of the flat deck, or of all instances and then of the assembly.

    Raises
    ------
    InputError : no nodes, a malformed line, two nodes with one label and different coordinates.
    """
    tables: dict[int, _Table] = {}
    ids, coords, owner = [np.zeros(0, np.int64)], [np.zeros((0, 3))], [np.zeros(0, np.int64)]
    registry = Registry("node", {}, deck.assembly)
    count = 0
    for k, scope in enumerate(deck.scopes):
        scope_ids, scope_coords = _scope_nodes(deck, scope, tables)
        rows = np.arange(count, count + scope_ids.size)
        registry.labels[scope.name] = Labels(scope_ids, rows)
        count += scope_ids.size
        ids.append(scope_ids)
        coords.append(scope_coords)
        owner.append(np.full(scope_ids.size, k if scope.name else -1, dtype=np.int64))
        _name_sets(scope, tables, registry)
    if count == 0:
        raise InputError("the deck has no nodes", expected="*NODE blocks", fix="Is this the right file?")
    instances = tuple(s.name for s in deck.scopes if s.name)
    instance_idx = np.concatenate(owner) if instances else np.zeros(0, np.int64)
    return Nodes(np.concatenate(ids), np.concatenate(coords), instances, instance_idx), registry


def _scope_nodes(deck: Outline, scope: Scope, tables: dict[int, _Table]) -> tuple[IntArray, FloatArray]:
    blocks = [b for b in scope.blocks if b.name == "NODE"]
    systems = _systems(scope)
    for block in blocks:
        if id(block) not in tables:
            tables[id(block)] = _placed(_node_table(block), block, systems[id(block)])
            if tables[id(block)].has_normals:
                deck.note(
                    block,
                    "creak computes shell normals from the mesh and does not read normals at nodes",
                    changes=True,
                    what="*NODE, normals",
                )
    if not blocks:
        return np.zeros(0, np.int64), np.zeros((0, 3))
    ids = np.concatenate([tables[id(b)].ids for b in blocks])
    coords = np.concatenate([tables[id(b)].coords for b in blocks])
    codes = np.concatenate([tables[id(b)].codes for b in blocks])
    keep = _without_repeats(ids, coords, codes, blocks[0])
    placed = coords[keep]
    if scope.rotated or scope.origin.any():
        placed = placed @ scope.rotation.T + scope.origin
    far = np.flatnonzero(~(np.abs(placed) < LARGEST).all(axis=1))
    if far.size:
        raise InputError(
            f"node {ids[keep][far[0]]} has coordinates too large to compute with: {_shown(placed[far[0]])}",
            where=blocks[0].place(int(codes[keep][far[0]])),
            fix="Correct them.",
        )
    return ids[keep], placed


def _without_repeats(ids: IntArray, coords: FloatArray, codes: IntArray, block: Block) -> BoolArray:
    """Mask of first occurrences; a repeat must have the same coordinates."""
    order = np.argsort(ids, kind="stable")
    repeat = np.flatnonzero(ids[order][1:] == ids[order][:-1])
    keep = np.ones(ids.size, dtype=bool)
    keep[order[repeat + 1]] = False
    moved = np.flatnonzero((coords[order[repeat]] != coords[order[repeat + 1]]).any(axis=1))
    if moved.size:
        old, new = order[repeat[moved[0]]], order[repeat[moved[0]] + 1]
        raise InputError(
            f"node {ids[new]} is defined twice with different coordinates: {_shown(coords[old])} at "
            f"{block.place(int(codes[old]))} and {_shown(coords[new])} here",
            expected="one definition of each node",
            where=block.place(int(codes[new])),
            fix="Delete one of them or give it another label.",
        )
    return keep


def _shown(xyz: FloatArray) -> str:
    return "(" + ", ".join(f"{x:g}" for x in xyz) + ")"


@dataclass(frozen=True)
class _System:
    """*SYSTEM: x_part = rotation x + origin for the *NODE blocks after it."""

    rotation: FloatArray
    origin: FloatArray


def _systems(scope: Scope) -> dict[int, _System]:
    """The system in force at each *NODE block, by id of the block."""
    current = _System(np.eye(3), np.zeros(3))
    result: dict[int, _System] = {}
    for block in scope.blocks:
        if block.name == "SYSTEM":
            current = _system(block)
        elif block.name == "NODE":
            result[id(block)] = current
    return result


def _system(block: Block) -> _System:
    """Origin and a point on axis 1; a point in the 1-2 plane (without it axis 3 stays global z). No line: global."""
    rows = list(block.rows())
    if not rows:
        return _System(np.eye(3), np.zeros(3))
    numbers = np.array(floats(*rows[0], "point of the system", 6))
    origin, first = numbers[:3], numbers[3:] - numbers[:3]
    where = rows[0][1]
    second = np.cross([0.0, 0.0, 1.0], first)
    if len(rows) > 1:
        second = np.array(floats(*rows[1], "point of the system", 3)) - origin
    if not first.any():
        return _System(np.eye(3), origin)
    frame = LocalSystem("R", first, second, where).axes(np.zeros((1, 3)))[0]
    return _System(frame.T, origin)


def _placed(table: _Table, block: Block, system: _System) -> _Table:
    """Nodes in Cartesian coordinates of the part.

    SYSTEM=C: r, angle in degrees, z. S: r, angle in the x-y plane, angle up from that plane, in degrees.
    """
    kind = block.option("SYSTEM", "R")
    x = table.coords
    if kind == "C":
        angle = np.radians(x[:, 1])
        x = np.column_stack([x[:, 0] * np.cos(angle), x[:, 0] * np.sin(angle), x[:, 2]])
    elif kind == "S":
        angle, up = np.radians(x[:, 1]), np.radians(x[:, 2])
        flat = x[:, 0] * np.cos(up)
        x = np.column_stack([flat * np.cos(angle), flat * np.sin(angle), x[:, 0] * np.sin(up)])
    elif kind != "R":
        raise block.error(f"*NODE, SYSTEM={kind}", expected="SYSTEM=R, C or S", fix="Correct the system.")
    if not np.array_equal(system.rotation, np.eye(3)) or system.origin.any():
        x = x @ system.rotation.T + system.origin
    return replace(table, coords=x)


def _node_table(block: Block) -> _Table:
    fast = label_and_reals(block, 3)
    if fast is not None:
        return _Table(*fast, np.array(block.codes, dtype=np.int64), False)
    return _node_table_by_line(block)


def _node_table_by_line(block: Block) -> _Table:
    """Coordinates that a line leaves out are 0, as in Abaqus and CalculiX."""
    ids, coords, codes, normals = [], [], [], False
    for (fields, where), code in zip(block.rows(blanks=True), block.codes, strict=True):
        if not fields:
            continue
        ids.append(to_label(fields[0], where, "node label"))
        if len(fields) > 7:
            raise InputError(
                f"node {fields[0]} has {len(fields) - 1} numbers",
                expected="label, x, y, z and the normal's three components",
                where=where,
                fix="Take away what is too much.",
            )
        xyz = [to_float(f, where, f"coordinate of node {fields[0]}") for f in fields[1:4]]
        coords.append([*xyz, 0.0, 0.0, 0.0][:3])
        codes.append(code)
        normals = normals or any(fields[4:])
    xyz_table = np.array(coords, dtype=np.float64).reshape(-1, 3)
    return _Table(np.array(ids, np.int64), xyz_table, np.array(codes, np.int64), normals)


def _name_sets(scope: Scope, tables: dict[int, _Table], registry: Registry) -> None:
    for block in scope.blocks:
        if block.name == "NODE" and block.get("NSET"):
            rows = registry.labels[scope.name].find(tables[id(block)].ids)
            registry.add(scope.name, block.get("NSET"), [rows])
