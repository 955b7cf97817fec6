"""The few nonlinear equations of a step: all laws of contact at the ends of the channels, the structure condensed.

    g    = free.gap  + A[:m] force,     force = [p (m); tau (2f)]
    rate = free.rate + free.rate_gain (g - free.gap)
    d    = free.slip + free.slip_gain A[m:] force

with the laws of creak.contact.laws between p and g, g', and between tau, p and d. A (m + 2f, m + 2f) is symmetric
positive semidefinite. Only channels that close take part: those with free.gap < 0 or a force before, and whatever they
close in turn.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from creak.arrays import BoolArray, FloatArray
from creak.contact.coulomb import Rubbing
from creak.contact.coulomb_newton import fresh
from creak.contact.coulomb_solve import solve_rubbing
from creak.contact.laws.linear import linear_energy, linear_pieces
from creak.contact.laws.parameters import LawArrays
from creak.contact.laws.pieces import Pieces
from creak.contact.laws.tabular import curve_energy, curve_force, tabular_pieces
from creak.contact.laws.unilateral import hard_pieces
from creak.contact.pivoting import NO_SOLUTION, SOLVED, UNENDED, solve_frictionless
from creak.errors import NumericalError
from creak.linalg.compiled import either, few_collections, inner, with_arrays
from creak.linalg.loops import fill, places, put


class Unpressed(NamedTuple):
    """The ends of the channels at the end of a step without channel forces, and what a force changes there."""

    gap: FloatArray
    """(m,) length."""
    rate: FloatArray
    """(m,) length / time."""
    slip: FloatArray
    """(2f,) sliding of the step, length."""
    rate_gain: float
    """Rate over gap of what forces add, 1 / time."""
    slip_gain: float
    """Sliding over displacement along the contact of what forces add."""
    step: float
    """Time."""


@either
def spring_energy(laws, i, gap):  # type: ignore[no-untyped-def]
    """Energy in the spring of channel i at a gap; 0 for a hard one."""
    c = laws.curve[i]
    if c >= 0:
        return laws.scale[i] * curve_energy(laws.x, laws.y, laws.start[c], laws.start[c + 1], -gap)
    return linear_energy(laws.stiffness[i], gap) if laws.stiffness[i] < np.inf else 0.0


@either
def spring_force(laws, i, gap):  # type: ignore[no-untyped-def]
    """Elastic force of channel i at a gap, without its damper; 0 for a hard one."""
    c = laws.curve[i]
    if c >= 0:
        return laws.scale[i] * curve_force(laws.x, laws.y, laws.start[c], laws.start[c + 1], -gap)
    return laws.stiffness[i] * max(0.0, -gap) if laws.stiffness[i] < np.inf else 0.0


@either
def contact_energy(laws, gap):  # type: ignore[no-untyped-def]
    """Energy in the springs of all channels at gaps (m,)."""
    energy = 0.0
    for i in range(gap.size):
        energy += spring_energy(laws, i, gap[i])
    return energy


@either
def damper_work(laws, gap, gap_after, force_after):  # type: ignore[no-untyped-def]
    """Work that the channel dampers took in a step, by the backward rule: they act at its end.

    Also where a spring that unloads faster than its damper lets it go presses no more (p = 0, g < 0).
    """
    work = 0.0
    for i in range(gap.size):
        hard = laws.curve[i] < 0 and laws.stiffness[i] == np.inf
        if laws.damping[i] > 0.0 and not hard and (gap_after[i] < 0.0 or force_after[i] != 0.0):
            work += (force_after[i] - spring_force(laws, i, gap_after[i])) * (gap[i] - gap_after[i])
    return work


@with_arrays
def solve_step(A, free, laws, stuck, force, kept):  # type: ignore[no-untyped-def]
    """Channel forces at the end of a step, to be called from compiled code.

    Parameters
    ----------
    A : (m + 2f, m + 2f) C-contiguous compliance of the step, length / force, symmetric positive semidefinite.
    free : the ends of the channels without forces (`Unpressed`).
    stuck : (f,) bool; in: was stuck (or open) at the start of the step, out: is at its end.
    force : (m + 2f,) in: a first guess, the forces of the step before; out: the solution.
    kept : a factor of the step before (`coulomb_newton.Kept`), and of this one; of size 0: nothing is kept.

    Returns
    -------
    0 solved to round-off (residual of all laws below 1e-12 of the largest force), 1 the iteration did not end,
    2 no forces can open the gaps. `force` is the last iterate then.
    """
    m = free.gap.size
    inside = np.zeros(m, dtype=np.bool_)
    if not _add_closing(free.gap, laws, free.rate_gain, inside):
        fill(force, 0.0)
        fill(stuck, True)
        return SOLVED
    gap, chosen, was_stuck = np.empty(m), np.empty(m, dtype=np.int64), stuck.copy()
    for _ in range(m):
        members = chosen[: places(inside, chosen)]
        put(stuck, 0, was_stuck)
        code = _solve_members(A, free, laws, members, stuck, force, kept)
        if code != SOLVED or members.size == m:
            return code
        put(gap, 0, free.gap)
        for j in range(force.size):
            if force[j] != 0.0:
                for i in range(m):
                    gap[i] += A[j, i] * force[j]
        if not _add_closing(gap, laws, free.rate_gain, inside):
            return SOLVED
    return UNENDED


@inner
def _add_closing(gap, laws, rate_gain, inside):  # type: ignore[no-untyped-def]
    """Mark the channels with a law that would penetrate; True if there are new ones."""
    found = False
    for i in range(gap.size):
        presses = laws.curve[i] >= 0 or laws.stiffness[i] + laws.damping[i] * rate_gain > 0.0
        if gap[i] < 0.0 and presses and not inside[i]:
            inside[i] = True
            found = True
    return found


@with_arrays
def _solve_members(A, free, laws, members, stuck, force, kept):  # type: ignore[no-untyped-def]
    """Solve for the forces of some channels, all others open."""
    n, m = members.size, free.gap.size
    rub = _rubbing_members(A, free.slip, laws, members, m)
    at, tangent, end = np.empty(3 * n, dtype=np.int64), np.empty(n, dtype=np.int64), n
    fill(tangent, -1)
    for k in range(n):
        at[k] = members[k]
        if rub[k] >= 0:
            at[end], at[end + 1], tangent[k] = m + 2 * rub[k], m + 2 * rub[k] + 1, end
            end += 2
    own, moved, x = np.empty((end, end)), np.empty(end), np.empty(end)
    for k in range(end):
        moved[k] = free.gap[at[k]] if k < n else free.slip[at[k] - m] / free.slip_gain
        x[k] = force[at[k]]
        for j in range(end):
            own[k, j] = A[at[k], at[j]]
    law = _pieces(laws, members, free)
    c, holds = _rubbing(own, moved, law, tangent, free.slip_gain / free.step, laws, rub, stuck)
    code = solve_frictionless(own, moved, law, x) if end == n else solve_rubbing(c, holds, x, kept)
    fill(stuck, True)
    for k in range(n):
        if rub[k] >= 0:
            stuck[rub[k]] = holds[k]
    fill(force, 0.0)
    for k in range(end):
        force[at[k]] = x[k]
    return code


@with_arrays
def _rubbing_members(A, slip, laws, members, m):  # type: ignore[no-untyped-def]
    """Rubbing channel of each member; -1 if it does not rub, or neither moves nor can be moved along the contact.

    What is held along it gives to no force, and yet slides where supports move it.
    """
    rub, f = np.empty(members.size, dtype=np.int64), 0
    fill(rub, -1)
    for k in range(members.size):
        while f < laws.rubs.size and laws.rubs[f] < members[k]:
            f += 1
        if f < laws.rubs.size and laws.rubs[f] == members[k]:
            t = m + 2 * f
            moves = A[t, t] + A[t + 1, t + 1] > 0.0 or slip[2 * f] != 0.0 or slip[2 * f + 1] != 0.0
            rub[k] = f if moves else -1
    return rub


@with_arrays
def _pieces(laws, members, free):  # type: ignore[no-untyped-def]
    """The laws of the members as straight pieces; their dampers see the rate of this step."""
    room = 2 * members.size
    for i in members:
        c = laws.curve[i]
        if c >= 0:
            room += laws.start[c + 1] - laws.start[c]
    law = Pieces(np.empty(members.size + 1, dtype=np.int64), np.empty(room), np.empty(room), np.empty(room))
    at = np.int64(0)  # a plain 0 would have what is called with it compiled twice
    for k in range(members.size):
        i, law.first[k] = members[k], at
        c, slope = laws.curve[i], laws.damping[i] * free.rate_gain
        c_hat = laws.damping[i] * (free.rate[i] - free.rate_gain * free.gap[i])
        if c >= 0:
            start, end = laws.start[c], laws.start[c + 1]
            at = tabular_pieces(law, at, laws.x, laws.y, start, end, laws.scale[i], slope, c_hat)
        elif laws.stiffness[i] == np.inf:
            at = hard_pieces(law, at)
        else:
            at = linear_pieces(law, at, laws.stiffness[i] + slope, c_hat)
    law.first[members.size] = at
    return law


@with_arrays
def _rubbing(A, free, law, tangent, speed, laws, rub, stuck):  # type: ignore[no-untyped-def]
    """The problem of members with friction, and which of them stuck (or were open) before."""
    n = tangent.size
    c = Rubbing(A, free, law, tangent, np.zeros(n), np.zeros(n), np.zeros(n), speed, np.zeros(n))
    holds = np.empty(n, dtype=np.bool_)
    fill(holds, True)
    for k in range(n):
        f, t = rub[k], tangent[k]
        if f >= 0:
            c.static[k], c.kinetic[k], c.decay[k] = laws.mu_static[f], laws.mu_kinetic[f], laws.decay[f]
            give = 0.5 * (A[t, t] + A[t + 1, t + 1])  # a scale alone: any will do where there is none
            c.slack[k] = give if give > 0.0 else A[k, k] if A[k, k] > 0.0 else 1.0
            holds[k] = stuck[f]
    return c, holds


@either
def solve_alone(A, free, laws, stuck, force):  # type: ignore[no-untyped-def]
    """`solve_step`, for Python."""
    return solve_step(A, free, laws, stuck, force, fresh(0))


def solve_channels(A: FloatArray, free: Unpressed, laws: LawArrays, stuck: BoolArray, force: FloatArray) -> FloatArray:
    """`solve_step` for callers outside compiled code: `force` and `stuck` are changed in place, `force` returned.

    Raises
    ------
    NumericalError : the step has no solution, or it was not found.
    """
    code = solve_alone(A, free, laws, stuck, force)
    if code != SOLVED:
        raise NumericalError(failure(code))
    return force


def failure(code: int) -> str:
    """What a code of `solve_step` other than 0 means."""
    if code == NO_SOLUTION:
        return "contact has no solution: hard channels shut each other in, or press on parts that cannot move"
    return "the contact solve did not end: the compliance is not positive semidefinite, or friction is too steep"


def compile_kernels() -> None:
    """Compile now what would otherwise be compiled at the first contact of a run."""
    one, none, no_channel = np.ones(1), np.zeros(0), np.zeros(0, dtype=np.int64)
    laws = LawArrays(
        one, 0.0 * one, np.full(1, -1), np.zeros(1, dtype=np.int64), none, none, one, no_channel, none, none, none
    )
    with few_collections():
        free = Unpressed(-one, 0.0 * one, none, 1.0, 1.0, 1.0)
        solve_channels(np.eye(1), free, laws, np.zeros(0, dtype=np.bool_), np.zeros(1))
