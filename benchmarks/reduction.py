"""What a reduction costs, in blocked back-substitutions per column."""

from __future__ import annotations

import time

import numpy as np
import scipy.sparse as sp

from benchmarks.door import Door
from creak.linalg.factor import factor
from creak.reduction.craig_bampton import COLUMNS, craig_bampton
from creak.studies.reduced_model import retained_labels

Row = tuple[str, str, str]


def craig_bampton_cost(door: Door) -> list[Row]:
    """Wall time of each part's reduction over (columns solved) x (blocked back-substitution), limit 2."""
    labels = retained_labels(door.setup, door.gaps)
    f_max = door.setup.study.config.reduction.f_max
    rows = []
    for part in door.reference.parts:
        boundary = np.unique(sp.csr_matrix(part.rows(labels)[0]).indices)
        started = time.perf_counter()
        reduced = craig_bampton(part, boundary, f_max=f_max)
        wall = time.perf_counter() - started
        inner = np.setdiff1d(np.arange(part.n), boundary)
        K_ii = sp.csr_matrix(part.K)[inner][:, inner]
        column = _column_seconds(factor(K_ii), inner.size)
        columns = boundary.size + int(reduced.stats["modes"])
        ratio = wall / (columns * column)
        text = f"{wall:.1f} s, {columns} columns at {1e3 * column:.2f} ms: {ratio:.1f} x"
        rows.append((f"{part.name} ({inner.size} inner dofs)", text, "limit 2 x"))
    return rows


def _column_seconds(solver: object, n: int) -> float:
    B = np.asfortranarray(np.random.default_rng(1).standard_normal((n, COLUMNS)))
    started = time.perf_counter()
    solver.solve(B)  # type: ignore[attr-defined]
    return (time.perf_counter() - started) / COLUMNS
