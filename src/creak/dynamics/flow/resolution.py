"""How finely contact is resolved: its own time scale, filtered channels, and bounds that hold between samples.

Near contact a step is kick, exact motion, kick. With the gaps read and the forces applied through a filter phi(omega h)
that vanishes from omega h = pi on that is the mollified impulse method: symplectic, second order, and stable whatever
the frequencies of the modes, as long as the contact springs are resolved, omega_c h < 2. What flexibility the filter
takes away is at most (omega_c h / pi)^2 of that of the springs, .6 % at omega_c h = 1/4. Source: Garcia-Archilla,
Sanz-Serna, Skeel, SIAM J. Sci. Comput. 20, 1998 (MOLLY); Hairer, Lubich, Wanner, Geometric Numerical Integration, 2006,
XIII.1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg as sla

from creak.arrays import FloatArray, IntArray
from creak.contact.laws.parameters import LawArrays
from creak.dynamics.flow.hard import hard_springs
from creak.dynamics.flow.model import FlowForm
from creak.errors import InputError

DEEPEST = 30
"""Most halvings of a flight step."""
BAND = 2.0
"""Ratio of the frequencies that bound a band."""


@dataclass(frozen=True)
class Resolution:
    """What is resolved how finely; `settled`, `quick` and `fine` are the choices of [time] accuracy."""

    contact: float
    """Largest product of a step near contact and the frequency of the contact springs."""
    longest: float
    """Longest step near contact, as a share of the flight step."""
    stepped: float
    """The same of Systems that are not diagonal."""
    hard: float = 1.0
    """Times the spring that stands for hard contact."""


QUICK, SETTLED = Resolution(0.5, 0.04, 0.04), Resolution(0.25, 0.01, 0.02)
FINE = Resolution(0.0625, 0.01, 0.02, hard=4.0)


@dataclass(frozen=True)
class FlowSteps:
    """The steps of a run: a flight step H and its halvings, the last of which is the step near contact."""

    H: float
    """s"""
    levels: int
    """H / 2^levels is the step near contact."""
    laws: LawArrays
    """With the stiffness of hard channels."""
    mollifier: FloatArray
    """(n,) what the channels see of each mode, `mollify(omega h)` with the step near contact."""
    band: IntArray
    """(n,) band of each mode."""
    fastest: float
    """rad/s, of the contact springs through the filter."""
    reach: FloatArray
    """(levels + 1, n_band, m): largest distance between a gap and the cubic through its ends, over sqrt(2 energy)."""

    @property
    def h(self) -> float:
        """Step near contact, s."""
        return float(math.ldexp(self.H, -self.levels))


def flow_steps(form: FlowForm, laws: LawArrays, H: float, resolution: Resolution) -> FlowSteps:
    """Steps of a run whose flight steps are H (s) long.

    Raises
    ------
    InputError : the contact springs are so stiff that a flight step would have to be halved more than `DEEPEST` times.
    """
    laws = with_hard(form, laws, H, resolution.hard)
    slopes = steepest(laws)
    levels, mollifier, fastest = 0, np.ones(form.omega.size), 0.0
    for levels in range(DEEPEST + 1):
        h = math.ldexp(H, -levels)
        if h > resolution.longest * H:
            continue
        mollifier = mollify(np.sqrt(form.omega2) * h)
        fastest = contact_frequency(form, mollifier, slopes)
        if fastest * h <= resolution.contact:
            break
    else:
        whole = contact_frequency(form, np.ones(form.omega.size), slopes)
        raise InputError(
            f"a contact stiffness of {slopes.max():.3g} on the mass at its channel oscillates at {whole:.3g} rad/s",
            expected="contact that can be resolved in time",
            fix='Give a stiffness that the material can have, or stiffness = "hard".',
        )
    band, top = bands(form.omega)
    seen = _seen(form, mollifier, math.ldexp(H, -levels))
    reach = np.stack([bound_of(form, band, top, math.ldexp(H, -n), *seen) for n in range(levels + 1)])
    return FlowSteps(H, levels, laws, mollifier, band, fastest, np.ascontiguousarray(reach))


def mollify(x: FloatArray) -> FloatArray:
    """phi(omega h): 1 up to 1, then falling smoothly to 0 at pi."""
    fall = np.clip((x - 1.0) / (np.pi - 1.0), 0.0, 1.0)
    return np.asarray(np.cos(0.5 * np.pi * fall) ** 2)


def steepest(laws: LawArrays) -> FloatArray:
    """(m,) largest slope of the law of each channel, force / length."""
    slopes = laws.stiffness.copy()
    for i in np.flatnonzero(laws.curve >= 0):
        part = slice(laws.start[laws.curve[i]], laws.start[laws.curve[i] + 1])
        slopes[i] = laws.scale[i] * float(np.max(np.diff(laws.y[part]) / np.diff(laws.x[part])))
    return slopes


def contact_frequency(form: FlowForm, mollifier: FloatArray, slopes: FloatArray) -> float:
    """omega_c (rad/s) of the contact springs against the mass at their channels, seen through the filter (n,).

    omega_c^2 = largest eigenvalue of k^(1/2) W k^(1/2).
    """
    acts = slopes > 0.0
    if not acts.any():
        return 0.0
    B = np.sqrt(slopes[acts])[:, None] * seen_through(form, mollifier)[: slopes.size][acts]
    size = int(acts.sum())
    value = sla.eigh(B @ B.T, eigvals_only=True, subset_by_index=[size - 1, size - 1])[0]
    return math.sqrt(max(float(value), 0.0))


def seen_through(form: FlowForm, mollifier: FloatArray) -> FloatArray:
    """(m + 2 f, n) root of the mobility of the channels: W = seen seen'."""
    return np.asarray(form.rows * (mollifier * form.root))


def with_hard(form: FlowForm, laws: LawArrays, H: float, by: float) -> LawArrays:
    """Springs in place of hard contact (`flow.hard`), times a factor."""
    hard = (laws.stiffness == np.inf) & (laws.curve < 0)
    if not hard.any():
        return laws
    stiffness = laws.stiffness.copy()
    channels = form.rows[: laws.stiffness.size][hard]
    stiffness[hard] = by * hard_springs(form.omega2, (channels * form.root) ** 2, H)
    return laws._replace(stiffness=stiffness, damping=np.where(hard, 0.0, laws.damping))


def bands(omega: FloatArray) -> tuple[IntArray, int]:
    """Band of each mode by its frequency, and their number; the first holds what does not oscillate."""
    moving = omega > 0.0
    band = np.zeros(omega.size, dtype=np.int64)
    if moving.any():
        low = float(omega[moving].min())
        band[moving] = 1 + np.floor(np.log(omega[moving] / low) / math.log(BAND)).astype(np.int64)
    return band, int(band.max(initial=0)) + 1


def bound_of(
    form: FlowForm, band: IntArray, count: int, h: float, far: FloatArray, slow: FloatArray | float = 0.0
) -> FloatArray:
    """(n_band, m) bound of |gap - cubic| / sqrt(2 E) of each band in a step h; far, slow (m, n): `_seen`.

    A pair of energy E moves a gap g within A = sqrt(2 E) far. The cubic through values and slopes at both ends is off
    by at most h^4 max |d^4 g / dt^4| / 384 = A (omega h)^4 / 384, and never by more than A (2 + omega h / 4). Slopes
    that are too small by sqrt(2 E) slow add h / 4 times that. Over a band: Cauchy-Schwarz.
    """
    x = form.omega * h
    return _by_band(band, count, far * np.minimum(x**4 / 384.0, 2.0 + 0.25 * x) + 0.25 * h * slow)


def below_parabola(form: FlowForm, T: float, rows: FloatArray) -> FloatArray:
    """(n_band, k) how far what rows (k, n) see may fall below the parabolas through it at instants T apart, over
    sqrt(2 E) of each band.

    A pair of energy E moves it within A = sqrt(2 E) far. A parabola through three instants is off by at most
    T^3 max |d^3 g / dt^3| / (9 sqrt(3)), and the lowest of them lies at most 2 A above what is between.
    """
    band, count = bands(form.omega)
    x = form.omega * T
    return _by_band(band, count, form.ways(rows) * np.minimum(x**3 / (9.0 * math.sqrt(3.0)), 2.0))


def straight(form: FlowForm, steps: FlowSteps, T: float) -> FloatArray:
    """(n_band, m) bound of |gap - straight line from its start| / sqrt(2 E) of each band in T s.

    A pair of energy E is off by at most A min((omega T)^2 / 2, 2 + omega T), A as for a cubic through both ends;
    slopes that are too small add T times what they lack.
    """
    x, (far, slow) = form.omega * T, _seen(form, steps.mollifier, steps.h)
    return _by_band(steps.band, steps.reach.shape[1], far * np.minimum(0.5 * x * x, 2.0 + x) + T * slow)


def _seen(form: FlowForm, mollifier: FloatArray, h: float) -> tuple[FloatArray, FloatArray]:
    """(m, n) how far a pair of energy 1/2 moves each gap, and what of its rate is missing (`flow.model.filtered`)."""
    rows = form.rows[: form.model.gap0.size] * mollifier
    return form.ways(rows), form.rates(rows * (1.0 - np.sinc(np.sqrt(form.omega2) * h / np.pi)))


def _by_band(band: IntArray, count: int, off: FloatArray) -> FloatArray:
    return np.stack([np.sqrt((off[:, band == b] ** 2).sum(axis=1)) for b in range(count)])


def finer(resolution: Resolution, by: float, hard: float = 1.0) -> Resolution:
    """The same with steps near contact that are shorter by a factor, and springs for hard contact by another one."""
    return Resolution(resolution.contact / by, resolution.longest / by, resolution.stepped / by, hard * resolution.hard)
