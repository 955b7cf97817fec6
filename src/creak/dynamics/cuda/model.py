"""What the blocks of a GPU read and write, and a thread's own part of it."""

from __future__ import annotations

from typing import Any, NamedTuple

from creak.dynamics.compiled import inner
from creak.dynamics.flow.rows import Cone


class Shared(NamedTuple):
    """Of all runs of a launch; names as in `FlowModel`, `FlowSteps`, `Block`, `FlowRun`."""

    rows: Any
    rates: Any
    push: Any
    rows_s: Any
    preload: Any
    load: Any
    order: Any
    column: Any
    m: Any
    k: Any
    still: Any
    P: Any
    W: Any
    B: Any
    gain: Any
    band: Any
    reach: Any
    off: Any
    width: Any
    support: Any
    """(n_loads, 3, n_instant, n_support)"""
    force: Any
    """(n_loads, n_instant, n_force)"""
    every: Any
    """(m,) 0, 1, 2, ..."""
    zero: Any
    """(m,)"""
    curve: Any
    """(m,) -1"""
    none: Any
    none_int: Any
    none_bool: Any
    """(0,)"""


class Sizes(NamedTuple):
    """Numbers of all runs of a launch."""

    H: float
    levels: int
    lasting: int
    length: int
    """Of the longest block of contact; 0: there are none."""
    chunk: int
    """Flight steps that a launch takes at most."""


class Work(NamedTuple):
    """Arrays of the runs, one after the other."""

    gap0: Any
    stiffness: Any
    """(runs, m)"""
    loads: Any
    """(runs,) row of `Shared.support`."""
    x: Any
    """(runs, 2, 2, n): two instants, as all that follow with a second 2."""
    F: Any
    """(runs, 2, n)"""
    force: Any
    gap: Any
    rate: Any
    drift: Any
    """(runs, 2, m)"""
    s: Any
    """(runs, 2, 3, n_support)"""
    D: Any
    """(runs, 4, n)"""
    course: Any
    drive: Any
    energy: Any
    """(runs, threads, n_band)"""
    share: Any
    lowest: Any
    flag: Any
    near: Any
    is_near: Any
    chosen: Any
    gap_then: Any
    rate_then: Any
    """(runs, m): gaps and rates where a block of contact began."""
    cone: Any
    """(runs, threads, 7, w): a cone for the channels of each thread; the first of the last row is its time."""
    pressing: Any
    right: Any
    end: Any
    mean: Any
    inverse: Any
    """(runs, m m)"""


class Written(NamedTuple):
    """What a launch leaves."""

    table: Any
    """(runs, rows, 1 + 2 m): time, gaps, forces."""
    at: Any
    u: Any
    s: Any
    """(runs, chunk), and n or n_support beside: as `Output`."""
    state: Any
    """(runs, 6): code, flight steps done, rows taken, motions kept, instant that is the last; flight steps to go to."""
    time: Any
    """(runs,) of the last instant, s."""


class Laws(NamedTuple):
    """Springs, as `LawArrays` has them."""

    stiffness: Any
    curve: Any
    scale: Any
    start: Any
    x: Any
    y: Any
    rubs: Any


class At(NamedTuple):
    """An instant, or a thread's part of it: what `FlowState` has but for the energies."""

    x: Any
    F: Any
    force: Any
    gap: Any
    rate: Any
    drift: Any
    sliding: Any
    stuck: Any
    support: Any


class Own(NamedTuple):
    """A thread's part of the model."""

    push: Any
    load: Any
    order: Any
    column: Any
    support: Any
    force: Any
    preload: Any
    m: Any
    k: Any
    still: Any
    gain: Any
    band: Any
    W: Any
    """(m, own channels)"""
    slope: Any


@inner
def laws_of(shared, stiffness):  # type: ignore[no-untyped-def]
    return Laws(stiffness, shared.curve, shared.zero, shared.none_int, shared.none, shared.none, shared.none_int)


@inner
def instant(shared, work, v, a):  # type: ignore[no-untyped-def]
    """Instant a of run v."""
    return At(
        work.x[v, a],
        work.F[v, a],
        work.force[v, a],
        work.gap[v, a],
        work.rate[v, a],
        work.drift[v, a],
        shared.none,
        shared.none_bool,
        work.s[v, a],
    )


@inner
def part(team, x):  # type: ignore[no-untyped-def]
    """A thread's part of an instant."""
    t, T = team.lane, team.width
    return At(
        x.x[:, t::T],
        x.F[t::T],
        x.force[t::T],
        x.gap[t::T],
        x.rate[t::T],
        x.drift[t::T],
        x.sliding,
        x.stuck,
        x.support,
    )


@inner
def own_of(team, shared, laws, loads):  # type: ignore[no-untyped-def]
    """A thread's part of the model."""
    t, T = team.lane, team.width
    return Own(
        shared.push[:, t::T],
        shared.load[:, t::T],
        shared.order,
        shared.column,
        shared.support[loads],
        shared.force[loads],
        shared.preload[t::T],
        shared.m[t::T],
        shared.k[t::T],
        shared.still,
        shared.gain[t::T],
        shared.band[t::T],
        shared.W[:, t::T],
        laws.stiffness[t::T],
    )


@inner
def cone_of(team, work, v, m):  # type: ignore[no-untyped-def]
    """The cone of a thread's channels, m of all."""
    c, w = work.cone[v, team.lane], 2 * ((m - team.lane + team.width - 1) // team.width)
    return Cone(c[6, :1], c[0, :w], c[1, :w], c[2, :w], c[3, :w], c[4, :w], c[5, :w])
