"""What the excitation itself radiates without contact: the steady sound of the road beside which a rattle is heard."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.system import System, no_supports, to_dense
from creak.dynamics.diagonal import modal_matrices
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms
from creak.linalg.diagonal import Diagonal
from creak.sound.carriers import EASE
from creak.sound.forced import Modes, smooth
from creak.sound.third_octave import LOWER_EDGES, SILENCE, third_octave_levels
from creak.sound.zwicker_tables import RATE
from creak.studies.sound.background import NOTHING
from creak.studies.sound.ear import Ear
from creak.studies.sound.radiation import record_of
from creak.studies.sound.source import Source

SHORT = 0.1
"""Of the record, the longest time in which the motion comes and goes."""


def road_levels(system: System, loads: Loads, ear: Ear, window: tuple[float, float]) -> FloatArray:
    """(28,) dB re 20 uPa over a window of what a System sends to an ear without contact, up to the end of its modes.

    The motion comes and goes over 0.2 s at the ends of the run, a tenth of it at most; levels are those between.

    Parameters
    ----------
    system : diagonal, as it was run.
    """
    whole, source = _with_supports(system), _driven(system, loads)
    levels: FloatArray = np.full(LOWER_EDGES.size, NOTHING)
    if not source.force.any():
        return levels
    every = [np.arange(source.force.shape[1])]
    pressure = record_of(source, every, ear.hears(whole))
    if ear.cabin is not None:
        fed = pressure if ear.middle is None else record_of(source, every, ear.middle.hears(whole))
        pressure = pressure + ear.cabin.adds(fed)
    ease, end = _ease(source.force.shape[0]), source.force.shape[0] / RATE
    start, stop = max(window[0], ease), min(window[1], end - ease)
    shown = (start, stop) if stop > start else (ease, end - ease)
    found = third_octave_levels(pressure[0], RATE, (shown[0] + ear.start / RATE, shown[1] + ear.start / RATE))
    heard = (ear.band > LOWER_EDGES) & (found > SILENCE + 1.0)
    levels[heard] = found[heard]
    return levels


def sum_of_levels(one: FloatArray | None, other: FloatArray) -> FloatArray:
    """(28,) dB of two sounds whose energies add up; None: the other alone."""
    return other if one is None else np.asarray(10.0 * np.log10(10.0 ** (0.1 * one) + 10.0 ** (0.1 * other)))


def _ease(n: int) -> float:
    """s in which a record of n samples comes and goes."""
    return min(EASE, SHORT * n / RATE)


def _with_supports(system: System) -> System:
    """A System whose supports are coordinates like others, of mass 1 and held by nothing: pushed by their own
    acceleration they move as they are prescribed."""
    n, count = system.n, system.supports.count

    def rows(labels: IntArray) -> tuple[Matrix, Matrix]:
        R, R_s = system.rows(labels)
        return np.hstack([to_dense(R), to_dense(R_s)]), np.zeros((labels.size, 0))

    def combine(A: Matrix, labels: IntArray) -> tuple[Matrix, Matrix]:
        B, B_s = system.combined(sp.csr_matrix(A), labels)
        return np.hstack([to_dense(B), to_dense(B_s)]), np.zeros((B.shape[0], 0))

    return replace(
        system,
        M=Diagonal(np.concatenate([system.M.diagonal(), np.ones(count)])),
        K=Diagonal(np.concatenate([system.K.diagonal(), np.zeros(count)])),
        rows=rows,
        combine=combine,
        whole=None,
        supports=no_supports(n + count),
        coordinates=np.concatenate([system.coordinates, np.full(count, -1, dtype=np.int64)]),
        velocity=np.zeros(n + count),
    )


def _driven(system: System, loads: Loads) -> Source:
    """Loads as forces on `_with_supports`: M q'' + C q' + K q = f - M_qs s'' - C_qs s' - K_qs s."""
    count, terms = system.supports.count, LinearTerms(system, loads)
    sides = [-terms.M_qs, -terms.C_qs, -terms.K_qs, terms.B]
    push = np.vstack([np.pad(terms.on_all(side).T, ((0, 0), (0, count))) for side in sides])
    push[:count, system.n :] = np.eye(count)
    of_supports = np.ones(count), np.zeros(count), np.zeros(count)
    m, c, k = (np.concatenate(both) for both in zip(modal_matrices(system), of_supports, strict=True))
    f = np.hstack([*_eased(loads), _at_rate(loads, loads.force - loads.force[:1])])
    f[:, 3 * count :] *= _rise(f.shape[0])[0][:, None]
    acts = np.flatnonzero(f.any(axis=0)).astype(np.int64)
    return Source(Modes(m, c, k, push[acts]), f[:, acts], acts, acts)


def _eased(loads: Loads) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(n, n_support) acceleration, velocity, displacement at 48 kHz of supports that come and go from where they
    start."""
    s, v, a = (_at_rate(loads, x) for x in (loads.support[0] - loads.support[0, :1], *loads.support[1:]))
    w, w1, w2 = (x[:, None] for x in _rise(s.shape[0]))
    return w2 * s + 2.0 * w1 * v + w * a, w1 * s + w * v, w * s


def _rise(n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(n,) what rises from 0 to 1 and falls again at the ends of a record, its first and its second derivative."""
    at = np.arange(n) / RATE
    ease = _ease(n)
    w = smooth(at / ease) * smooth((at[-1] - at) / ease)
    w1 = np.gradient(w, 1.0 / RATE)
    return w, w1, np.gradient(w1, 1.0 / RATE)


def _at_rate(loads: Loads, x: FloatArray) -> FloatArray:
    """(n, k) at 48 kHz, on a cubic through samples (n_time, k)."""
    from scipy.interpolate import make_interp_spline  # see `signals.spectra.low_pass`

    own = loads.time - loads.time[0]
    at = np.minimum(np.arange(max(2, int(own[-1] * RATE * (1.0 + 1e-12)) + 1)) / RATE, own[-1])
    if not x.shape[1]:
        return np.zeros((at.size, 0))
    return np.asarray(make_interp_spline(own, x, k=3 if own.size > 3 else 1)(at))
