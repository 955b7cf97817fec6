"""Constraints and supports as linear equations between dof labels."""

from __future__ import annotations

from collections.abc import Iterator

from creak.arrays import FloatArray
from creak.assembly.elimination import LinearEquation
from creak.model.constraints import Constraint, Fixed
from creak.model.dofs import dof_label, dof_labels


def linear_equations(constraint: Constraint, coords: FloatArray) -> Iterator[LinearEquation]:
    """The constraint as scalar equations; `coords` is (n_node, 3)."""
    for e in constraint.equations(coords):
        yield LinearEquation(dof_labels(e.nodes_idx, e.dofs).tolist(), e.coefficients.tolist(), e.where)


def fixed_equations(fixed: Fixed) -> Iterator[LinearEquation]:
    """u = 0 for each held dof."""
    for node in fixed.nodes_idx.tolist():
        for dof in fixed.dofs:
            yield LinearEquation([dof_label(node, dof)], [1.0], fixed.where)
