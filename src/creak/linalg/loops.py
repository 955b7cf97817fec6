"""Small loops over vectors for compiled code, in place of slices and reductions of NumPy, which compile far longer.

Setting a slice alone brings all that words the error of a wrong size: four seconds.
"""

from __future__ import annotations

from creak.linalg.compiled import inner, inner_fast


@inner
def fill(to, value):  # type: ignore[no-untyped-def]
    """to[:] = value; a loop compiles in a fraction of the time."""
    for i in range(to.size):
        to[i] = value


@inner
def put(to, begin, values):  # type: ignore[no-untyped-def]
    """to[begin : begin + values.size] = values; returns the next place."""
    for i in range(values.size):
        to[begin + i] = values[i]
    return begin + values.size


@inner
def acts(force, begin, end):  # type: ignore[no-untyped-def]
    """Is any of force[begin:end] not zero?"""
    found = False
    for i in range(begin, end):
        found = found or force[i] != 0.0
    return found


@inner_fast
def dot(row, u):  # type: ignore[no-untyped-def]
    """row . u"""
    a = 0.0
    for i in range(row.size):
        a += row[i] * u[i]
    return a


@inner
def largest(values):  # type: ignore[no-untyped-def]
    """max |values|, (n,); 0 of none, NaN where one is."""
    top = 0.0
    for i in range(values.size):
        size = abs(values[i])
        if size > top or size != size:
            top = size
    return top


@inner
def places(marked, out):  # type: ignore[no-untyped-def]
    """Where `marked` (n,) holds, written to the start of `out` (n,); their number."""
    count = 0
    for i in range(marked.size):
        if marked[i]:
            out[count] = i
            count += 1
    return count
