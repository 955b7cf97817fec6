"""Exact flow where nothing presses: a recurrence of whole flight steps, in NumPy, for all pairs at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.flow.march import SAMPLES, form_of
from creak.dynamics.flow.model import FlowModel, amplitudes, at_start
from creak.dynamics.flow.propagator import Q0, SINGLE, UU, UV, VU, VV
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms
from creak.linalg.threads import one_blas_thread

CHUNK = 1_000
"""Flight steps whose loads and motion are held at once."""
CUBIC = np.array([[6.0, 0.0, 0.0, 0.0], [-11.0, 18.0, -9.0, 2.0], [12.0, -30.0, 24.0, -6.0], [-6.0, 18.0, -18.0, 6.0]])
"""Value and derivatives at the first of four samples, times 6, and times the distance of two to the power of each:
`motion.cubic_through` of many at once."""


@one_blas_thread()
def gaps_without_contact(
    system: System, gaps: GapOperator, loads: Loads, progress: Callable[[int, int], object] | None = None
) -> FloatArray:
    """(n_step + 1, m) gaps of a System with diagonal M, C, K at the ends of its flight steps, contact left out.

    The motion is that of `simulate_flow`: a flight step is `SAMPLES` samples of the loads, which follow a cubic over
    it; so each pair goes on by its propagator z <- P z + Q D, D the four coefficients of its load.

    Raises
    ------
    InputError : M, C or K is not diagonal, or damping couples too many modes.
    """
    terms = LinearTerms(system, loads)
    form = form_of(system, channel_matrices(system, gaps), terms, gaps)
    model, n_step, h = form.model, loads.n_step // SAMPLES, SAMPLES * loads.step
    P, n, m = form.flow(h), form.model.m.size, gaps.m
    to = model.rows[:m]
    a, b = at_start(form, model, terms)
    found = np.empty((n_step + 1, m))
    found[0] = to @ np.concatenate([a, b])[model.u0 : model.u1]
    uu, uv, vu, vv = P[UU], P[UV], P[VU], P[VV]
    for first in range(0, n_step, CHUNK):
        last = min(first + CHUNK, n_step)
        to_a, to_b = _driven(P, _loads(model, first, last, h / SAMPLES), n)
        course = np.empty((last - first, 2 * n))
        for k in range(last - first):
            a, b = uu * a + uv * b + to_a[k], vu * a + vv * b + to_b[k]
            course[k, :n], course[k, n:] = a, b
        found[first + 1 : last + 1] = course[:, model.u0 : model.u1] @ to.T
        if progress is not None:
            progress(last, n_step)
    return found + gaps.gap0 + loads.support[0, : SAMPLES * n_step + 1 : SAMPLES] @ model.rows_s[:m].T


def _loads(model: FlowModel, first: int, last: int, third: float) -> FloatArray:
    """(n_step, 4, p) value and derivatives of the load on each pair at the beginning of flight steps."""
    at = amplitudes(model, slice(SAMPLES * first, SAMPLES * last + 1))
    samples = np.stack([at[:, j : j + SAMPLES * (last - first) : SAMPLES] for j in range(4)])
    size = 6.0 * third ** np.arange(4.0)
    drive = np.einsum("rj,jxk->krx", CUBIC / size[:, None], samples)
    return np.asarray(drive @ model.load)


def _driven(P: FloatArray, D: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """(n_step, n) what the loads add to both members of each pair over a step; both of pairs are loaded."""
    if P.shape[0] == SINGLE:
        return _times(D, P[Q0 + 1 : Q0 + 5]), _times(D, P[Q0 : Q0 + 4])
    by, own, other = P[4:20].reshape(4, 4, n), D[:, :, :n], D[:, :, n:]
    return _times(own, by[:, 0]) + _times(other, by[:, 1]), _times(own, by[:, 2]) + _times(other, by[:, 3])


def _times(D: FloatArray, by: FloatArray) -> FloatArray:
    """(n_step, n) sum over the four coefficients."""
    return np.asarray(np.einsum("krn,rn->kn", D, by))
