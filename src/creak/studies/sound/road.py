"""What the excitation itself radiates without contact: the steady sound of the road beside which a rattle is heard."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.system import System, no_supports
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms
from creak.linalg.diagonal import Diagonal
from creak.sound.carriers import EASE
from creak.sound.forced import LOWEST, smooth
from creak.sound.third_octave import LOWER_EDGES, SILENCE, third_octave_levels
from creak.sound.zwicker_tables import RATE
from creak.studies.sound.cabin import NOTHING
from creak.studies.sound.ear import Ear
from creak.studies.sound.radiation import Source, answering, record_of

SHORT = 0.1
"""Of what counts, the longest time in which the motion comes and goes."""
LEAST = 0.5
"""s of whole periods that levels are those of, at least, and s before and after them: more than filters ring."""
SETTLED, LONGEST = 5.0, 5.0
"""Time constants of the slowest mode, and s at most, after which motion is steady."""
ALIKE = 0.05
"""Of the largest value of a load, and of its slope, by which it may be off a period later."""


def road_levels(
    system: System, loads: Loads, ear: Ear, window: tuple[float, float], period: float | None = None
) -> FloatArray:
    """(28,) dB re 20 uPa of what a System sends to an ear without contact, up to the end of its modes.

    Where the loads repeat, their last period in the run goes on and on: levels are those of whole periods of steady
    motion. Other motion comes and goes over 0.2 s at the ends of the run, a tenth of it at most: levels are those of
    the window, or of all of a run that has not come to its second period, without them.

    Parameters
    ----------
    system : as it was run, M and K diagonal. window : s of the run. period : s after which all loads begin again; None:
        none.
    """
    whole, ease = _with_supports(system), min(EASE, SHORT * window[1])
    if period is not None and _repeat(loads, period):
        start = EASE + _settling(system, ear.band)
        window, ease = (start, start + np.ceil(LEAST / period) * period), EASE
        loads = _continued(loads, period, window[1] + LEAST + ease)
    elif period is not None:
        window = 0.0, window[1]
    source = _driven(system, loads, ease)
    levels: FloatArray = np.full(LOWER_EDGES.size, NOTHING)
    if not source.force.any():
        return levels
    every = [np.arange(source.force.shape[1])]
    pressure = record_of(source, every, ear.hears(whole))
    if ear.cabin is not None:
        fed = pressure if ear.middle is None else record_of(source, every, ear.middle.hears(whole))
        pressure = pressure + ear.cabin.adds(fed)
    late, end = ear.start / RATE, source.force.shape[0] / RATE
    counts = max(window[0], ease) + late, min(window[1], end - ease) + late
    found = third_octave_levels(pressure[0], RATE, counts)
    heard = (ear.band > LOWER_EDGES) & (found > SILENCE + 1.0)
    levels[heard] = found[heard]
    return levels


def sum_of_levels(one: FloatArray | None, other: FloatArray) -> FloatArray:
    """(28,) dB of two sounds whose energies add up; None: the other alone."""
    return other if one is None else np.asarray(10.0 * np.log10(10.0 ** (0.1 * one) + 10.0 ** (0.1 * other)))


def _repeat(loads: Loads, period: float) -> bool:
    """Whether accelerations and forces at the end of a run are those of a period before, and so their slopes: not
    where the run is shorter, or where they still come in."""
    first, last = float(loads.time[0]), float(loads.time[-1])
    if last - period < first - 0.5 * loads.step:
        return False
    ends = np.array([max(last - period, first), last])
    every = np.hstack([loads.support[2], loads.force])
    for x, two in ((every, _through(loads, every, ends)), (_slope(loads, every), _through(loads, every, ends, 1))):
        if (np.abs(two[1] - two[0]) > ALIKE * np.abs(x).max(axis=0, initial=0.0)).any():
            return False
    return True


def _slope(loads: Loads, x: FloatArray) -> FloatArray:
    return np.asarray(np.diff(x, axis=0) / loads.step)


def _settling(system: System, band: float) -> float:
    """s after which modes that are heard are steady, as long as their own time lets them be."""
    modes = answering(system, np.zeros((0, system.n)))
    heard = (modes.omega > np.pi * LOWEST) & (modes.omega < 2.0 * np.pi * band)
    rate = float(modes.decay[heard].min(initial=SETTLED / LEAST))
    return SETTLED / max(rate, SETTLED / LONGEST)


def _continued(loads: Loads, period: float, length: float) -> Loads:
    """The last period of a run again and again, at 48 kHz, without what carries it away from where it was: a mean
    velocity and acceleration."""
    time = np.arange(int(length * RATE) + 1) / RATE
    begin = float(loads.time[-1]) - period
    t = np.mod(time, period)[:, None]
    s, v, a = (_through(loads, x, np.append(begin + t[:, 0], [begin, begin + period])) for x in loads.support)
    faster = v[-1] - v[-2]
    away = (s[-1] - s[-2]) / period - 0.5 * faster
    support = np.stack(
        [
            s[:-2] - s[-2] - away * t - 0.5 * faster * t**2 / period,
            v[:-2] - away - faster * t / period,
            a[:-2] - faster / period,
        ]
    )
    return Loads(time, support, _through(loads, loads.force, begin + t[:, 0]), loads.force_labels)


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


def _driven(system: System, loads: Loads, ease: float = EASE) -> Source:
    """Loads that come and go in `ease` s as forces on `_with_supports`:
    M q'' + C q' + K q = f - M_qs s'' - C_qs s' - K_qs s."""
    count, terms = system.supports.count, LinearTerms(system, loads)
    sides = [-terms.M_qs, -terms.C_qs, -terms.K_qs, terms.B]
    push = np.vstack([np.pad(terms.on_all(side).T, ((0, 0), (0, count))) for side in sides])
    push[:count, system.n :] = np.eye(count)
    f = np.hstack([*_eased(loads, ease), _at_rate(loads, loads.force - loads.force[:1])])
    f[:, 3 * count :] *= _rise(f.shape[0], ease)[0][:, None]
    acts = np.flatnonzero(f.any(axis=0)).astype(np.int64)
    modes = answering(system, push[acts, : system.n]).beside(push[acts, system.n :])
    return Source(modes, f[:, acts], acts, acts)


def _eased(loads: Loads, ease: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(n, n_support) acceleration, velocity, displacement at 48 kHz of supports that come and go from where they
    start."""
    s, v, a = (_at_rate(loads, x) for x in (loads.support[0] - loads.support[0, :1], *loads.support[1:]))
    w, w1, w2 = (x[:, None] for x in _rise(s.shape[0], ease))
    return w2 * s + 2.0 * w1 * v + w * a, w1 * s + w * v, w * s


def _rise(n: int, ease: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(n,) what rises from 0 to 1 and falls again at the ends of a record, its first and its second derivative."""
    at = np.arange(n) / RATE
    w = smooth(at / ease) * smooth((at[-1] - at) / ease)
    w1 = np.gradient(w, 1.0 / RATE)
    return w, w1, np.gradient(w1, 1.0 / RATE)


def _at_rate(loads: Loads, x: FloatArray) -> FloatArray:
    """(n, k) at 48 kHz, on a cubic through samples (n_time, k)."""
    first, length = float(loads.time[0]), float(loads.time[-1] - loads.time[0])
    n = max(2, int(length * RATE * (1.0 + 1e-12)) + 1)
    return _through(loads, x, first + np.minimum(np.arange(n) / RATE, length))


def _through(loads: Loads, x: FloatArray, at: FloatArray, order: int = 0) -> FloatArray:
    """(n, k) at instants (n,), on a cubic through samples (n_time, k); its derivative of an order."""
    from scipy.interpolate import make_interp_spline  # see `signals.spectra.low_pass`

    if not x.shape[1]:
        return np.zeros((at.size, 0))
    return np.asarray(make_interp_spline(loads.time, x, k=3 if loads.time.size > 3 else 1)(at, order))
