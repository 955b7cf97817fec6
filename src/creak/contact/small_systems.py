"""Dense systems of a few unknowns, solved in place; scaled so that their diagonal is about 1."""

from __future__ import annotations

from creak.linalg.compiled import inner, inner_fast
from creak.linalg.loops import dot

BREAKDOWN = 1e-13
"""A pivot below this, in a matrix scaled to a diagonal of 1, is round-off: the rows are dependent."""


@inner
def solve_symmetric(S, b):  # type: ignore[no-untyped-def]
    """b <- S^-1 b for S symmetric positive definite (upper triangle used, destroyed); False if it is singular."""
    n = b.size
    for c in range(n):
        if not S[c, c] > BREAKDOWN:
            return False
        for r in range(c + 1, n):
            factor = S[c, r] / S[c, c]
            if factor != 0.0:
                top, row = S[c, r:], S[r, r:]
                for s in range(row.size):
                    row[s] -= factor * top[s]
                b[r] -= factor * b[c]
    _substitute(S, b)
    return True


@inner
def factor_general(S, order):  # type: ignore[no-untyped-def]
    """Elimination with row exchange, in place of S; order (n,): the row that was taken for each. False if singular."""
    for c in range(order.size):
        best = c
        for r in range(c + 1, order.size):
            if abs(S[r, c]) > abs(S[best, c]):
                best = r
        if not abs(S[best, c]) > BREAKDOWN:
            return False
        order[c] = best
        if best != c:
            for s in range(order.size):
                S[c, s], S[best, s] = S[best, s], S[c, s]
        top = S[c, c + 1 :]
        for r in range(c + 1, order.size):
            factor = S[r, c] / S[c, c]
            S[r, c] = factor
            if factor != 0.0:
                row = S[r, c + 1 :]  # rows by themselves: several numbers at once
                for s in range(top.size):
                    row[s] -= factor * top[s]
    return True


@inner_fast
def solve_factored(S, order, b):  # type: ignore[no-untyped-def]
    """b <- the solution, of what `factor_general` left."""
    for c in range(order.size):
        best = order[c]
        b[c], b[best] = b[best], b[c]
    for r in range(1, order.size):
        b[r] -= dot(S[r, :r], b)
    _substitute(S, b)


@inner_fast
def _substitute(S, b):  # type: ignore[no-untyped-def]
    for r in range(b.size - 1, -1, -1):
        b[r] = (b[r] - dot(S[r, r + 1 :], b[r + 1 :])) / S[r, r]
