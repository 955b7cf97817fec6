"""Couplings, links and equations written as linear equations between dof labels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.dofs import dof_label
from creak.assembly.elimination import LinearEquation
from creak.errors import InputError
from creak.model.constraints import (
    Constraint,
    DistributingCoupling,
    Equation,
    Fixed,
    KinematicCoupling,
    RigidLink,
    Tie,
)


def constraint_nodes(constraint: Constraint) -> list[int]:
    """All node rows that a constraint touches."""
    if isinstance(constraint, RigidLink):
        return [constraint.dependent_idx, constraint.independent_idx]
    if isinstance(constraint, Equation):
        return [int(i) for i in constraint.nodes_idx]
    if isinstance(constraint, Tie):
        return [constraint.node_idx, *(int(i) for i in constraint.nodes_idx)]
    return [constraint.ref_idx, *(int(i) for i in constraint.nodes_idx)]


def linear_equations(constraint: Constraint, coords: FloatArray) -> Iterator[LinearEquation]:
    """The constraint as scalar equations; `coords` is (n_node, 3)."""
    if isinstance(constraint, KinematicCoupling):
        for node in constraint.nodes_idx.tolist():
            yield from _rigid(node, constraint.ref_idx, constraint.dofs, coords, constraint.where)
    elif isinstance(constraint, RigidLink):
        yield from _link(constraint, coords)
    elif isinstance(constraint, DistributingCoupling):
        yield from _distributing(constraint, coords)
    elif isinstance(constraint, Tie):
        yield from _tie(constraint)
    else:
        labels = [dof_label(int(n), int(d)) for n, d in zip(constraint.nodes_idx, constraint.dofs, strict=True)]
        yield LinearEquation(labels, constraint.coefficients.tolist(), constraint.where)


def fixed_equations(fixed: Fixed) -> Iterator[LinearEquation]:
    """u = 0 for each held dof."""
    for node in fixed.nodes_idx.tolist():
        for dof in fixed.dofs:
            yield LinearEquation([dof_label(node, dof)], [1.0], fixed.where)


def _rigid(node: int, ref: int, dofs: tuple[int, ...], coords: FloatArray, where: str) -> Iterator[LinearEquation]:
    """u_node = u_ref + theta_ref x r, theta_node = theta_ref."""
    yield from _follow(node, [ref], [1.0], coords[node] - coords[ref], dofs, where)


def _tie(tie: Tie) -> Iterator[LinearEquation]:
    dofs = (1, 2, 3, 4, 5, 6) if tie.rotations else (1, 2, 3)
    yield from _follow(tie.node_idx, tie.nodes_idx.tolist(), tie.weights.tolist(), tie.arm, dofs, tie.where)


def _follow(
    node: int, main: Sequence[int], weights: Sequence[float], arm: FloatArray, dofs: Sequence[int], where: str
) -> Iterator[LinearEquation]:
    """u_node = sum_k w_k (u_k + theta_k x arm), theta_node = sum_k w_k theta_k."""
    for dof in dofs:
        labels, c = [dof_label(node, dof)], [1.0]
        j, k = dof % 3, (dof + 1) % 3
        for other, w in zip(main, weights, strict=True):
            labels.append(dof_label(other, dof))
            c.append(-w)
            for axis, lever in ((j, -arm[k]), (k, arm[j])) if dof <= 3 else ():
                if lever != 0.0:
                    labels.append(dof_label(other, 4 + axis))
                    c.append(float(w * lever))
        yield LinearEquation(labels, c, where)


def _link(link: RigidLink, coords: FloatArray) -> Iterator[LinearEquation]:
    a, b = link.dependent_idx, link.independent_idx
    if link.kind == "beam":
        yield from _rigid(a, b, (1, 2, 3, 4, 5, 6), coords, link.where)
        return
    for dof in (1, 2, 3) if link.kind == "pin" else (1, 2, 3, 4, 5, 6):
        yield LinearEquation([dof_label(a, dof), dof_label(b, dof)], [1.0, -1.0], link.where)


def _distributing(coupling: DistributingCoupling, coords: FloatArray) -> Iterator[LinearEquation]:
    """Weighted least-squares rigid motion of the cloud, moved to the reference node.

    With S_k = [I, -(r_k x)] and A = sum w_k S_k' S_k: (u, theta)_ref = A^-1 sum w_k S_k' u_k.
    """
    nodes = coupling.nodes_idx
    r = coords[nodes] - coords[coupling.ref_idx]
    S = np.zeros((nodes.size, 3, 6))
    S[:, :, :3] = np.eye(3)
    S[:, 0, 4], S[:, 0, 5] = r[:, 2], -r[:, 1]
    S[:, 1, 3], S[:, 1, 5] = -r[:, 2], r[:, 0]
    S[:, 2, 3], S[:, 2, 4] = r[:, 1], -r[:, 0]
    weighted = S * coupling.weights[:, None, None]
    A = np.einsum("kia,kib->ab", weighted, S)
    length = max(float(np.sqrt((r**2).sum(axis=1).mean())), 1e-300)
    scale = np.array([1.0, 1.0, 1.0, length, length, length])
    if np.linalg.cond(A / np.outer(scale, scale)) > 1e12:
        raise InputError(
            f"distributing coupling {coupling.name!r} has its {nodes.size} node(s) on a line or in a point",
            where=coupling.where,
            expected="at least three nodes that span an area",
            fix="Couple more nodes, or use a kinematic coupling.",
        )
    weights = np.linalg.solve(A, weighted.transpose(2, 0, 1).reshape(6, -1))
    labels = [dof_label(int(n), d) for n in nodes for d in (1, 2, 3)]
    for dof in coupling.dofs:
        row = weights[dof - 1]
        yield LinearEquation([dof_label(coupling.ref_idx, dof), *labels], [1.0, *(-row).tolist()], coupling.where)
