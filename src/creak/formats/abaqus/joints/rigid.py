"""Rigid components of connectors -> constraints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.model.constraints import Constraint, Equation, KinematicCoupling


@dataclass(frozen=True, eq=False)
class Connector:
    """One element with rigid components."""

    name: str
    nodes_idx: tuple[int, int]
    axes: FloatArray
    """(3, 3)"""
    rigid: frozenset[int]
    location: float
    along: bool
    """LINK: only the distance of the nodes is kept."""
    where: str


def joint_constraints(connectors: tuple[Connector, ...], coords: FloatArray) -> list[Constraint]:
    """Rigid components as constraints between the nodes; node b (the second) is eliminated.

    e_k . (u_b - u_a + ...) = 0 at the point between the nodes that `Bushing` measures at, e_k . (theta_b -
    theta_a) = 0; all of JOIN (and ALIGN) is a kinematic coupling.
    """
    result: list[Constraint] = []
    for c in connectors:
        a, b = c.nodes_idx
        if c.along:
            result.append(_link(c, coords))
        held = set(c.rigid)
        if {1, 2, 3} <= held and c.location == 1.0:
            dofs = (1, 2, 3, 4, 5, 6) if {4, 5, 6} <= held else (1, 2, 3)
            result.append(KinematicCoupling(c.name, a, np.array([b], dtype=np.int64), dofs, c.where))
            held -= set(dofs)
        result += [_component(c, k, coords) for k in sorted(held)]
    return result


def _link(c: Connector, coords: FloatArray) -> Equation:
    a, b = c.nodes_idx
    line = coords[b] - coords[a]
    length = float(np.linalg.norm(line))
    if not length > 0.0:
        raise InputError("a LINK joins coincident nodes", where=c.where, fix="Use JOIN.")
    return _equation(
        [(b, k + 1, float(v)) for k, v in enumerate(line / length)],
        [(a, k + 1, float(-v)) for k, v in enumerate(line / length)],
        c.where,
    )


def _component(c: Connector, k: int, coords: FloatArray) -> Equation:
    a, b = c.nodes_idx
    axis = c.axes[(k - 1) % 3]
    if k > 3:
        turn = [(n, j + 4, s * float(v)) for n, s in ((b, 1.0), (a, -1.0)) for j, v in enumerate(axis)]
        return _equation(turn[:3], turn[3:], c.where)
    point = coords[a] + c.location * (coords[b] - coords[a])
    terms: list[list[tuple[int, int, float]]] = []
    for n, s in ((b, 1.0), (a, -1.0)):
        lever = s * np.cross(point - coords[n], axis)
        terms.append([(n, j + 1, s * float(v)) for j, v in enumerate(axis)])
        terms[-1] += [(n, j + 4, float(v)) for j, v in enumerate(lever)]
    return _equation(terms[0][:3], terms[0][3:] + terms[1], c.where)


def _equation(first: list[tuple[int, int, float]], rest: list[tuple[int, int, float]], where: str) -> Equation:
    """The equation with the largest of its `first` terms in front: that dof is eliminated."""
    ordered = sorted(first, key=lambda t: -abs(t[2])) + rest
    kept = [t for t in ordered if abs(t[2]) > 1e-14]
    nodes, dofs, factors = (np.array(column) for column in zip(*kept, strict=True))
    return Equation(nodes.astype(np.int64), dofs.astype(np.int64), factors.astype(np.float64), where)
