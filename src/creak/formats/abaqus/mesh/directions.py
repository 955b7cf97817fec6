"""Local axes at points, rectangular, cylindrical and spherical; *TRANSFORM: nodes whose dofs are along axes of their
own."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.abaqus.text.fields import Registry, floats
from creak.formats.abaqus.text.outline import Outline
from creak.model.constraints import Equation, Fixed
from creak.model.dofs import ROTATIONS, TRANSLATIONS

TINY = 1e-9


@dataclass(frozen=True, eq=False)
class LocalSystem:
    """A rectangular, cylindrical or spherical system, placed in global coordinates."""

    kind: str
    """R, C or S"""
    a: FloatArray
    """(3,) R: direction of axis 1. C: a point of the polar axis. S: the centre."""
    b: FloatArray
    """(3,) R: a direction in the 1-2 plane. C: another point of the axis. S: a point of the polar axis."""
    where: str = ""

    def axes(self, points: FloatArray) -> FloatArray:
        """(n, 3, 3): rows are axes 1, 2, 3 at the points (n, 3).

        R: x', y', z'. C: radial, tangential, axial. S: radial, tangential (circumferential), meridional. On the
        axis, where the radial direction is not defined, it is any one.

        Raises
        ------
        InputError : the two points or directions define no system.
        """
        if self.kind == "R":
            return np.broadcast_to(_frame(self.a, self.b, self.where), (len(points), 3, 3))
        polar = _unit(self.b - self.a, self.where)
        r = points - self.a
        radial = r - (r @ polar)[:, None] * polar
        size = np.linalg.norm(radial, axis=1)
        extent = max(float(np.linalg.norm(r, axis=1).max(initial=0.0)), float(np.linalg.norm(self.b - self.a)))
        spare = np.cross(polar, np.eye(3)[int(np.argmin(np.abs(polar)))])
        spare /= np.linalg.norm(spare)
        on_axis = size <= TINY * extent
        radial = np.where(on_axis[:, None], spare, radial / np.maximum(size, 1e-300)[:, None])
        tangential = np.cross(polar, radial)
        if self.kind == "C":
            return np.stack([radial, tangential, np.broadcast_to(polar, radial.shape)], axis=1)
        distance = np.linalg.norm(r, axis=1)
        outward = np.where((distance > TINY * extent)[:, None], r / np.maximum(distance, 1e-300)[:, None], radial)
        return np.stack([outward, tangential, np.cross(outward, tangential)], axis=1)

    def moved(self, rotation: FloatArray, origin: FloatArray) -> LocalSystem:
        """The system of an instance: x_global = rotation x + origin; directions only turn."""
        shift = 0.0 if self.kind == "R" else origin
        return LocalSystem(self.kind, rotation @ self.a + shift, rotation @ self.b + shift, self.where)


def _unit(vector: FloatArray, where: str) -> FloatArray:
    size = float(np.linalg.norm(vector))
    if not 0.0 < size < np.inf:
        raise InputError(
            "the points of a local system coincide",
            expected="two different points",
            where=where,
            fix="Correct the coordinates.",
        )
    return vector / size


def _frame(a: FloatArray, b: FloatArray, where: str) -> FloatArray:
    first = _unit(a, where)
    third = np.cross(first, b)
    if not float(np.linalg.norm(third)) > TINY * float(np.linalg.norm(b)):
        raise InputError(
            "the two directions of a local system are parallel or zero",
            expected="a point on axis 1 and another in the 1-2 plane",
            where=where,
            fix="Correct the coordinates.",
        )
    third = _unit(third, where)
    return np.stack([first, np.cross(third, first), third])


def turned_about(frames: FloatArray, axis: int, degrees: float) -> FloatArray:
    """The two other axes of frames (n, 3, 3) turned about axis 1, 2 or 3 by an angle in degrees."""
    if not degrees:
        return frames
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = axis % 3, (axis + 1) % 3
    out = np.array(frames)
    out[:, i] = c * frames[:, i] + s * frames[:, j]
    out[:, j] = c * frames[:, j] - s * frames[:, i]
    return out


_DIRECTED = ("CLOAD", "INITIAL CONDITIONS")


@dataclass
class Transforms:
    """Axes of the nodes that have their own."""

    axes: dict[int, FloatArray] = field(default_factory=dict)
    """Node row -> (3, 3), rows are the node's axes 1, 2, 3 in global components."""

    def touched(self, rows: IntArray) -> list[int]:
        """Those of the rows that have axes of their own."""
        return [int(r) for r in rows if int(r) in self.axes] if self.axes else []

    def terms(self, node: int, dof: int) -> list[tuple[int, float]]:
        """The node's dof 1..6 in its own axes as a sum of global dofs: (dof, coefficient), largest first."""
        if node not in self.axes:
            return [(dof, 1.0)]
        first = 1 if dof <= 3 else 4
        direction = self.axes[node][dof - first]
        order = np.argsort(-np.abs(direction), kind="stable")
        return [(first + int(k), float(direction[k])) for k in order if abs(direction[k]) > 1e-14]


def read_transforms(deck: Outline, nodes: Registry, coords: FloatArray) -> Transforms:
    """*TRANSFORM, NSET=, TYPE=R (default), C or S; a transform of a part turns and moves with each instance.

    R: a point on axis 1 and one in the 1-2 plane. C: two points of the polar axis; axes radial, tangential, axial.
    S: centre and a point of the polar axis; axes radial, circumferential, meridional. The last one of a node counts.

    Raises
    ------
    InputError : unknown set or type, points that define no axes.
    """
    result = Transforms()
    for scope, block in deck.blocks("TRANSFORM"):
        kind = block.option("TYPE", "R")
        rows = list(block.rows())
        if kind not in ("R", "C", "S") or not rows:
            raise block.error(
                f"*TRANSFORM, TYPE={kind}" if rows else "*TRANSFORM has no data line",
                expected="TYPE=R, C or S and a line with two points",
                fix="Correct the keyword.",
            )
        numbers = np.array(floats(rows[0][0], rows[0][1], "point of the transform", 6))
        system = LocalSystem(kind, numbers[:3], numbers[3:], rows[0][1]).moved(scope.rotation, scope.origin)
        found = nodes.find(block.need("NSET"), scope.name, block.where)
        for row, frame in zip(found.tolist(), system.axes(coords[found]), strict=True):
            result.axes[row] = frame
    return result


def note_transformed(deck: Outline, transforms: Transforms, nodes: Registry) -> None:
    """List loads, motions and initial velocities at nodes with axes of their own: creak takes those as global."""
    if not transforms.axes:
        return
    inside = [("", b) for step in deck.steps[:1] for b in step.blocks if b.name in _DIRECTED]
    for scope, block in [*inside, *((s.name, b) for s, b in deck.blocks(*_DIRECTED))]:
        if any(_turned(fields, nodes, scope, where, transforms) for fields, where in block.rows()):
            why = "creak takes its directions as global, though *TRANSFORM gives some of its nodes other axes"
            deck.note(block, why, changes=True, what=f"*{block.name} on transformed nodes")


def _turned(fields: list[str], nodes: Registry, scope: str, where: str, transforms: Transforms) -> bool:
    """Whether a line `node or set, dof, [last dof,] value` acts along the own axes of a node."""
    known = fields[0].rpartition(".")[2].strip().isdigit() or nodes.has_set(fields[0], scope)
    if len(fields) < 3 or not known or not transforms.touched(nodes.find(fields[0], scope, where)):
        return False
    return any(f.strip("+-0.eEdD ") for f in fields[2:])


def held_along_axes(fixed: Iterable[Fixed], transforms: Transforms) -> tuple[list[Fixed], list[Equation]]:
    """Supports in global dofs, and equations for those along the axes of a node's own.

    All three translations (or rotations) held along own axes are all three held along global ones; one or two
    of them become equations, which are eliminated like any other.
    """
    if not transforms.axes:
        return list(fixed), []
    kept: list[Fixed] = []
    equations: list[Equation] = []
    for f in fixed:
        own = set(transforms.touched(f.nodes_idx))
        plain = np.array([int(r) for r in f.nodes_idx if int(r) not in own], dtype=np.int64)
        if plain.size:
            kept.append(Fixed(plain, f.dofs, f.where))
        for node in sorted(own):
            whole = [d for group in (TRANSLATIONS, ROTATIONS) if set(group) <= set(f.dofs) for d in group]
            if whole:
                kept.append(Fixed(np.array([node], dtype=np.int64), tuple(whole), f.where))
            equations += [_along(node, d, transforms, f.where) for d in f.dofs if d not in whole]
    return kept, equations


def _along(node: int, dof: int, transforms: Transforms, where: str) -> Equation:
    terms = transforms.terms(node, dof)
    dofs = np.array([d for d, _ in terms], dtype=np.int64)
    return Equation(np.full(dofs.size, node), dofs, np.array([c for _, c in terms]), where)
