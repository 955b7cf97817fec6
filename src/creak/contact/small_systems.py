"""Dense systems of a few unknowns, solved in place; scaled so that their diagonal is about 1."""

from __future__ import annotations

from creak.linalg.compiled import with_arrays

BREAKDOWN = 1e-13
"""A pivot below this, in a matrix scaled to a diagonal of 1, is round-off: the rows are dependent."""


@with_arrays
def solve_symmetric(S, b):  # type: ignore[no-untyped-def]
    """b <- S^-1 b for S symmetric positive definite (upper triangle used, destroyed); False if it is singular."""
    n = b.size
    for c in range(n):
        if not S[c, c] > BREAKDOWN:
            return False
        for r in range(c + 1, n):
            factor = S[c, r] / S[c, c]
            if factor != 0.0:
                for s in range(r, n):
                    S[r, s] -= factor * S[c, s]
                b[r] -= factor * b[c]
    _substitute(S, b)
    return True


@with_arrays
def solve_general(S, b):  # type: ignore[no-untyped-def]
    """b <- S^-1 b by elimination with row exchange (S destroyed); False if it is singular."""
    n = b.size
    for c in range(n):
        best = c
        for r in range(c + 1, n):
            if abs(S[r, c]) > abs(S[best, c]):
                best = r
        if not abs(S[best, c]) > BREAKDOWN:
            return False
        if best != c:
            for s in range(c, n):
                S[c, s], S[best, s] = S[best, s], S[c, s]
            b[c], b[best] = b[best], b[c]
        for r in range(c + 1, n):
            factor = S[r, c] / S[c, c]
            if factor != 0.0:
                for s in range(c + 1, n):
                    S[r, s] -= factor * S[c, s]
                b[r] -= factor * b[c]
    _substitute(S, b)
    return True


@with_arrays
def _substitute(S, b):  # type: ignore[no-untyped-def]
    for r in range(b.size - 1, -1, -1):
        total = b[r]
        for s in range(r + 1, b.size):
            total -= S[r, s] * b[s]
        b[r] = total / S[r, r]
