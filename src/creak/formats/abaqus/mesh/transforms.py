"""*TRANSFORM: nodes whose dofs are along axes of their own."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.abaqus.mesh.directions import LocalSystem
from creak.formats.abaqus.text.names import Registry
from creak.formats.abaqus.text.numbers import floats
from creak.formats.abaqus.text.outline import Outline
from creak.model.constraints import Equation, Fixed
from creak.model.dofs import ROTATIONS, TRANSLATIONS

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
