"""The threads of a block of a GPU at work together: sums, rows times a vector, choices.

One block marches one run; its threads share the modes and the channels in strides, so that what is written for all
modes or channels runs on a thread's own by slices `[lane :: width]` of the same arrays. Every function here is called
by all threads of a block.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import cuda

from creak.dynamics.compiled import inner
from creak.dynamics.vector_kernels import dot

THREADS = 128
"""Of a block: a multiple of `LANES`."""
LANES = 32
"""Threads that multiply a row together: a warp."""


class Team(NamedTuple):
    """The threads of a block, as one of them sees them."""

    lane: int
    width: int
    scratch: Any
    """(width,) shared by all."""
    counter: Any
    """(1,) shared by all."""


@inner
def team_of(scratch, counter):  # type: ignore[no-untyped-def]
    """The block that is running."""
    return Team(cuda.threadIdx.x, cuda.blockDim.x, scratch, counter)


@inner
def sync():  # type: ignore[no-untyped-def]
    """What any thread has written is there for all."""
    cuda.syncthreads()


@inner
def any_of(found):  # type: ignore[no-untyped-def]
    """Is it true for any thread? Syncs."""
    return cuda.syncthreads_or(np.int32(1) if found else np.int32(0)) != 0


@inner
def total(team, x):  # type: ignore[no-untyped-def]
    """Sum over the threads, always in the same order. Syncs."""
    sync()
    team.scratch[team.lane] = x
    sync()
    s = 0.0
    for i in range(team.width):
        s += team.scratch[i]
    return s


@inner
def gather(team, flag, among, count, chosen):  # type: ignore[no-untyped-def]
    """Those of the first `count` of `among` whose flag is up, in their order; their number. Syncs."""
    sync()
    if team.lane == 0:
        n = 0
        for k in range(count):
            i = among[k]
            if flag[i]:
                chosen[n] = i
                n += 1
        team.counter[0] = n
    sync()
    return team.counter[0]


@inner
def look_at(team, A, z, offset, model, support, which, count, out):  # type: ignore[no-untyped-def]
    """out[i] = offset[i] + A[i] . z + rows_s[i] . support of the first `count` channels of `which`. Syncs."""
    sync()
    group, lane = team.lane // LANES, team.lane % LANES
    groups = team.width // LANES
    for first in range(0, count, groups):
        k = first + group
        part = 0.0
        if k < count:
            part = dot(A[which[k], lane::LANES], z[lane::LANES])
        team.scratch[team.lane] = part
        half = LANES // 2
        while half > 0:
            cuda.syncwarp()
            if lane < half:
                team.scratch[team.lane] += team.scratch[team.lane + half]
            half //= 2
        if lane == 0 and k < count:
            i = which[k]
            s = offset[i] + team.scratch[team.lane]
            for a in range(support.size):
                s += model.rows_s[i, a] * support[a]
            out[i] = s
        cuda.syncwarp()
    sync()


@inner
def invert(team, A, n):  # type: ignore[no-untyped-def]
    """Inverse of a positive definite matrix in place (Gauss and Jordan); A (n n,), rows one after the other. Syncs."""
    for p in range(n):
        sync()
        pivot = 1.0 / A[p * n + p]
        sync()
        for j in range(team.lane, n, team.width):
            if j != p:
                A[p * n + j] *= pivot
        sync()
        for i in range(team.lane, n, team.width):
            if i != p:
                f = A[i * n + p]
                for j in range(n):
                    if j != p:
                        A[i * n + j] -= f * A[p * n + j]
                A[i * n + p] = -f * pivot
        sync()
        if team.lane == 0:
            A[p * n + p] = pivot
    sync()
