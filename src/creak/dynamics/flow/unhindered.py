"""Exact flow where nothing presses: a recurrence of whole flight steps, in NumPy, for all pairs at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.flow.lowest import Lowest, Pieces, driven
from creak.dynamics.flow.march import SAMPLES, form_of
from creak.dynamics.flow.model import FlowModel, amplitudes, at_start
from creak.dynamics.flow.propagator import UU, UV, VU, VV
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms
from creak.linalg.threads import one_blas_thread
from creak.signals.spectra import largest

CHUNK = 1_000
"""Flight steps whose loads and motion are held at once."""
CUBIC = np.array([[6.0, 0.0, 0.0, 0.0], [-11.0, 18.0, -9.0, 2.0], [12.0, -30.0, 24.0, -6.0], [-6.0, 18.0, -18.0, 6.0]])
"""Value and derivatives at the first of four samples, times 6, and times the distance of two to the power of each:
`motion.cubic_through` of many at once."""


@dataclass(frozen=True)
class Silent:
    """Gaps of a run without contact."""

    at: FloatArray
    """(n_step + 1, m) at the ends of its flight steps."""
    lowest: FloatArray
    """(m,) in the whole run, between these too."""
    in_window: FloatArray
    """(m,) the same in a window."""


@one_blas_thread()
def gaps_without_contact(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    progress: Callable[[int, int], object] | None = None,
    window: tuple[float, float] = (0.0, np.inf),
) -> Silent:
    """Gaps of a System with diagonal M, C, K, contact left out.

    The motion is that of `simulate_flow`: a flight step is `SAMPLES` samples of the loads, which follow a cubic over
    it; so each pair goes on by its propagator z <- P z + Q D, D the four coefficients of its load. Where a mode is too
    fast for the ends of the steps to tell how far a gap closes, they are halved (`flow.lowest`).

    Parameters
    ----------
    window : in which the lowest gaps are looked for by themselves as well, s.

    Raises
    ------
    InputError : M, C or K is not diagonal, or damping couples too many modes.
    """
    terms = LinearTerms(system, loads)
    form = form_of(system, channel_matrices(system, gaps), terms, gaps)
    model, n_step, h = form.model, loads.n_step // SAMPLES, SAMPLES * loads.step
    P, to, at = form.flow(h), form.model.rows[: gaps.m], np.empty((n_step + 1, gaps.m))
    begins = [np.concatenate(at_start(form, model, terms))]
    at[0] = to @ begins[0][model.u0 : model.u1]
    for first in range(0, n_step, CHUNK):
        last = min(first + CHUNK, n_step)
        z = _course(P, begins[-1], _loads(model, first, last, h / SAMPLES))
        at[first + 1 : last + 1] = z[1:, model.u0 : model.u1] @ to.T
        begins.append(z[-1])
        if progress is not None:
            progress(last, 2 * n_step)
    at += gaps.gap0 + loads.support[0, : SAMPLES * n_step + 1 : SAMPLES] @ model.rows_s[: gaps.m].T
    ends = loads.time[: SAMPLES * n_step + 1 : SAMPLES]
    inside = (ends >= window[0]) & (ends <= window[1])
    within, beyond = (Lowest(form, gaps.gap0, -largest(-some)) for some in (at[inside], at))
    for begin, first in zip(begins, range(0, n_step, CHUNK), strict=False):
        last = min(first + CHUNK, n_step)
        D = _loads(model, first, last, h / SAMPLES)
        steps = Pieces(_course(P, begin, D)[:-1], D, _supports(loads, first, last, h))
        of_window = inside[first:last] & inside[first + 1 : last + 1]
        within.look(steps.some(of_window), h)
        beyond.look(steps.some(~of_window), h)
        if progress is not None:
            progress(n_step + last, 2 * n_step)
    return Silent(at, np.minimum(within.found, beyond.found), within.found)


def _course(P: FloatArray, begin: FloatArray, D: FloatArray) -> FloatArray:
    """(n_step + 1, 2 n) pairs at the ends of flight steps."""
    n = begin.size // 2
    uu, uv, vu, vv = P[UU], P[UV], P[VU], P[VV]
    to_a, to_b = driven(P, D, n)
    z = np.empty((len(D) + 1, 2 * n))
    z[0], a, b = begin, begin[:n], begin[n:]
    for k in range(len(D)):
        a, b = uu * a + uv * b + to_a[k], vu * a + vv * b + to_b[k]
        z[k + 1, :n], z[k + 1, n:] = a, b
    return z


def _supports(loads: Loads, first: int, last: int, T: float) -> FloatArray:
    """(n_step, 6, n_support) value and derivatives of the supports at the beginning of flight steps, T long:
    `motion.quintic_through` of many at once."""
    (p0, v0, a0), (p1, v1, a1) = (
        loads.support[:, SAMPLES * (first + k) : SAMPLES * (last + k - 1) + 1 : SAMPLES] for k in (0, 1)
    )
    way, turn, bend = p1 - p0 - T * (v0 + 0.5 * T * a0), T * (v1 - v0 - T * a0), T * T * (a1 - a0)
    third = 6.0 * (10.0 * way - 4.0 * turn + 0.5 * bend) / T**3
    fourth = 24.0 * (-15.0 * way + 7.0 * turn - bend) / T**4
    return np.stack([p0, v0, a0, third, fourth, 120.0 * (6.0 * way - 3.0 * turn + 0.5 * bend) / T**5], axis=1)


def _loads(model: FlowModel, first: int, last: int, third: float) -> FloatArray:
    """(n_step, 4, p) value and derivatives of the load on each pair at the beginning of flight steps."""
    at = amplitudes(model, slice(SAMPLES * first, SAMPLES * last + 1))
    samples = np.stack([at[:, j : j + SAMPLES * (last - first) : SAMPLES] for j in range(4)])
    size = 6.0 * third ** np.arange(4.0)
    drive = np.einsum("rj,jxk->krx", CUBIC / size[:, None], samples)
    return np.asarray(drive @ model.load)
