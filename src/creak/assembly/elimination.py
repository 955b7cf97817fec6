"""Elimination of linear constraints: sum_k c_k u_k = 0 becomes u = T q."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import InputError
from creak.model.constraints import Constraint, Fixed
from creak.model.dofs import dof_label, dof_labels

Expression = dict[int, float]
ROUND_OFF = 1e-12
"""Terms of an equation that cancel to this share of their size are nothing."""


@dataclass(frozen=True)
class LinearEquation:
    """sum_k coefficients[k] u[labels[k]] = 0; the first label is the one to eliminate when it can be."""

    labels: Sequence[int]
    coefficients: Sequence[float]
    where: str = ""


def eliminate(equations: Iterable[LinearEquation], driven: frozenset[int] = frozenset()) -> dict[int, Expression]:
    """Dependent label -> {independent label: coefficient}, fully substituted.

    Each equation is reduced by those before it; then its first label, or else the one with the largest
    coefficient, becomes dependent. Equations that have become 0 = 0 are redundant and dropped. Labels in
    `driven` never become dependent.

    Raises
    ------
    InputError : an equation forces a driven dof to zero or ties driven dofs to each other.
    """
    solved: dict[int, Expression] = {}
    users: dict[int, set[int]] = {}
    for equation in equations:
        terms = _substituted(equation, solved)
        if not terms:
            continue
        dependent = _pivot(equation, terms, driven)
        c = terms.pop(dependent)
        expression = {label: -value / c for label, value in terms.items()}
        for user in users.pop(dependent, set()):
            _replace(solved[user], dependent, expression)
            for label in expression:
                users.setdefault(label, set()).add(user)
        solved[dependent] = expression
        for label in expression:
            users.setdefault(label, set()).add(dependent)
    return solved


def _substituted(equation: LinearEquation, solved: dict[int, Expression]) -> Expression:
    terms: Expression = {}
    scale = 0.0
    for label, c in zip(equation.labels, equation.coefficients, strict=True):
        scale = max(scale, abs(c))
        for independent, factor in solved.get(label, {label: 1.0}).items():
            terms[independent] = terms.get(independent, 0.0) + c * factor
    return {label: c for label, c in terms.items() if abs(c) > 1e-10 * scale}


def through(equation: LinearEquation, R: Matrix, place: Mapping[int, int]) -> tuple[list[int], list[float]]:
    """The equation over the columns of R, u[label] = R[place[label]] q; the declared dependent dof comes first where it
    is a coordinate."""
    terms: dict[int, float] = {}
    size: dict[int, float] = {}
    for label, c in zip(equation.labels, equation.coefficients, strict=True):
        i = place[label]
        span = slice(R.indptr[i], R.indptr[i + 1])
        for column, value in zip(R.indices[span].tolist(), R.data[span].tolist(), strict=True):
            terms[column] = terms.get(column, 0.0) + c * value
            size[column] = size.get(column, 0.0) + abs(c * value)
    left = {column: value for column, value in terms.items() if abs(value) > ROUND_OFF * size[column]}
    return list(left), list(left.values())


def _pivot(equation: LinearEquation, terms: Expression, driven: frozenset[int]) -> int:
    first = equation.labels[0]
    if first in terms and first not in driven:
        return first
    free = [label for label in terms if label not in driven]
    if not free:
        raise InputError(
            "a driven degree of freedom is also constrained",
            where=equation.where,
            fix="Take it out of the boundary condition or coupling, or drive another one.",
        )
    return max(free, key=lambda label: abs(terms[label]))


def _replace(expression: Expression, label: int, by: Expression) -> None:
    c = expression.pop(label)
    for independent, factor in by.items():
        expression[independent] = expression.get(independent, 0.0) + c * factor


def transformation(labels: IntArray, solved: dict[int, Expression]) -> tuple[Matrix, IntArray]:
    """Sparse T (n_label, n_independent) with u[labels] = T q, and the labels of q (sorted as in `labels`).

    Independents that the expressions bring in but `labels` lacks are an error of the caller.
    """
    dependent = np.isin(labels, np.fromiter(solved, dtype=np.int64, count=len(solved)))
    own, independent = np.flatnonzero(~dependent), labels[~dependent].astype(np.int64)
    column = np.full(int(labels.max(initial=-1)) + 1, -1, dtype=np.int64)
    column[independent] = np.arange(independent.size)
    rows = np.flatnonzero(dependent).tolist()
    followed = [(i, label, c) for i in rows for label, c in solved[int(labels[i])].items()]
    row = np.concatenate([own, np.array([i for i, _, _ in followed], dtype=np.int64)])
    col = np.concatenate([column[independent], column[np.array([label for _, label, _ in followed], dtype=np.int64)]])
    values: FloatArray = np.concatenate([np.ones(own.size), np.array([c for _, _, c in followed], dtype=np.float64)])
    T = sp.csr_matrix((values, (row, col)), shape=(labels.size, independent.size))
    return T, independent


def principal(A: Matrix, keep: IntArray) -> Matrix:
    """The rows and columns `keep` (sorted, each once) of a square matrix."""
    return A if keep.size == A.shape[0] else A[keep][:, keep]


def linear_equations(constraint: Constraint, coords: FloatArray) -> Iterator[LinearEquation]:
    """The constraint as scalar equations; `coords` is (n_node, 3)."""
    for e in constraint.equations(coords):
        yield LinearEquation(dof_labels(e.nodes_idx, e.dofs).tolist(), e.coefficients.tolist(), e.where)


def fixed_equations(fixed: Fixed) -> Iterator[LinearEquation]:
    """u = 0 for each held dof."""
    for node in fixed.nodes_idx.tolist():
        for dof in fixed.dofs:
            yield LinearEquation([dof_label(node, dof)], [1.0], fixed.where)
