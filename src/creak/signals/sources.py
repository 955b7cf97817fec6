"""Excitation signals as functions of time, with the derivatives or integrals that prescribed motion needs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from creak.arrays import BoolArray, FloatArray
from creak.errors import InputError
from creak.given import check_fields, finite, number, of_kind, positive, row_of, whole
from creak.signals.between_samples import between_samples, even_step
from creak.signals.curves import Rounded
from creak.signals.signal import Curve, Lines, Motion, Signal, faded_in, windowed

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

MIRRORED = 8.0
"""Periods of the high-pass by which a record goes on as its mirror image."""
KINK = 3.0
"""Second difference where both ends meet, over the root mean square of those of the record, up to which they do."""


def integrate_twice(
    acceleration: FloatArray, step: float, high_pass: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Displacement, velocity and acceleration, all without content below `high_pass`.

    X = -A / omega^2, V = A / (i omega) in the complex spectrum; lines below the cut-off (and the mean) are
    dropped. Exact on signals that are periodic over the record; elsewhere the ends wrap around.

    Parameters
    ----------
    acceleration : (n,) evenly sampled. step : s. high_pass : Hz.

    Raises
    ------
    InputError : samples that are no finite numbers; a step or a frequency that is no positive number.
    """
    acceleration = row_of(acceleration, "acceleration", least=1)
    step, high_pass = positive(step, "step"), positive(high_pass, "high_pass")
    spectrum = np.fft.rfft(acceleration)
    freq = np.fft.rfftfreq(acceleration.size, step)
    keep = (freq >= high_pass) & (freq > 0.0)
    omega = 2.0 * np.pi * np.where(keep, freq, 1.0)
    A = np.where(keep, spectrum, 0.0)
    n = acceleration.size
    return np.fft.irfft(-A / omega**2, n), np.fft.irfft(A / (1j * omega), n), np.fft.irfft(A, n)


def wrapped_share(acceleration: FloatArray, step: float, high_pass: float, displacement: FloatArray) -> float:
    """How far off displacements (`integrate_twice`) are in the middle half of a record whose ends do not meet.

    The root mean square of what becomes of them where the record goes on as its mirror image, and dies out in
    `MIRRORED` / high_pass, over that of the displacements: within a factor of two or three what cuts of long tones and
    road noise were off by. 0 where the record goes round with no more of a kink than it has inside (`KINK`).

    Parameters
    ----------
    displacement : (n,) that `integrate_twice` makes of it.
    """
    n, beyond = acceleration.size, min(acceleration.size - 1, int(MIRRORED / (high_pass * step)))
    around = np.concatenate([acceleration[-2:], acceleration, acceleration[:2]])
    bends = np.abs(np.diff(around, 2))
    if beyond < 2 or max(bends[:3].max(), bends[-3:].max()) <= KINK * np.sqrt(np.mean(bends[3:-3] ** 2)):
        return 0.0
    x = np.linspace(0.0, 1.0, beyond)
    rise = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    before, after = acceleration[beyond:0:-1], acceleration[-2 : -beyond - 2 : -1]
    longer = np.concatenate([rise * before, acceleration, rise[::-1] * after])
    middle = slice(n // 4, n - n // 4)
    wrapped = displacement[middle]
    mirrored = integrate_twice(longer, step, high_pass)[0][beyond : beyond + n][middle]
    size = float(np.linalg.norm(wrapped))
    return float(np.linalg.norm(wrapped - mirrored)) / size if size > 0.0 else 0.0


FEW = 16
"""Instants whose square is few: each is computed by itself."""
ROUND_OFF = 4.0 * np.finfo(float).eps
AT_ONCE = 1 << 22
"""Cosines that memory holds at once."""
A_SIGNAL = "a signal, as creak.Sine(20.0, 0.1)"
APART = 0.03
"""Distance of both splines over the largest change of the table near it, from which on there is a corner."""
NEAR = 2
"""Intervals to both sides that count as near."""
ROUNDS = 20


@dataclass(frozen=True)
class Multisine(Lines):
    """Random-phase multisine: sum_k A cos(2 pi k f0 t + phi_k), f0 = 1/period, f_min <= k f0 <= f_max.

    Phases are uniform on [0, 2 pi) from `seed` (Pintelon and Schoukens, System Identification, 2012, 2.3.1).
    `amplitude` is that of each line.
    """

    f_min: float
    f_max: float
    amplitude: float
    period: float = 1.0
    seed: int = 1

    def __post_init__(self) -> None:
        check_fields(self, {"f_min": finite, "f_max": finite, "amplitude": finite, "period": positive, "seed": _seed})
        if not self.lines[0].size:
            raise InputError(
                f"a multisine without a line from {self.f_min:g} to {self.f_max:g} Hz",
                expected=f"a multiple of 1 / period = {1.0 / self.period:g} Hz between the two",
            )

    @cached_property
    def lines(self) -> tuple[FloatArray, FloatArray]:
        """(n_line,) circular frequencies, rad/s, and phases, rad."""
        first = max(1, int(np.ceil(self.f_min * self.period - 1e-9)))
        last = int(np.floor(self.f_max * self.period + 1e-9))
        omega = 2.0 * np.pi * np.arange(first, last + 1) / self.period
        phase = np.random.default_rng(self.seed).uniform(0.0, 2.0 * np.pi, omega.size)
        return np.asarray(omega, dtype=np.float64), phase

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        omega, phase = self.lines
        turned = phase + 0.5 * np.pi * order
        weight = self.amplitude * omega**order
        if (cut := _even_cut(t)) is not None:  # cos(a + b) = Re exp(i a) exp(i b): sqrt(n) of either do for all n
            coarse, fine = cut
            rows = np.exp(1j * (np.outer(coarse, omega) + turned)) * weight
            return np.ascontiguousarray((rows @ np.exp(1j * np.outer(omega, fine))).real.ravel()[: t.size])
        at_once = max(AT_ONCE // omega.size, 1)
        blocks = (t[i : i + at_once] for i in range(0, t.size, at_once))
        found = [np.cos(np.outer(b, omega) + turned) @ weight for b in blocks]
        return np.asarray(np.concatenate([np.zeros(0), *found]), dtype=np.float64)


def _seed(value: Any, name: str) -> int:
    return whole(value, name, 0)


def _even_cut(t: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Even instants as coarse[i] + fine[j], in this order, to round-off; None: they are not even, or few."""
    m = math.isqrt(t.size)
    if m < FEW:
        return None
    coarse, fine = t[::m], t[:m] - t[0]
    both = np.add.outer(coarse, fine).ravel()[: t.size]
    return (coarse, fine) if np.abs(both - t).max() <= ROUND_OFF * np.abs(t).max() else None


@dataclass(frozen=True)
class Sine(Curve):
    """A sin(2 pi f t), from t = 0."""

    frequency: float
    amplitude: float

    def __post_init__(self) -> None:
        check_fields(self, {"frequency": positive, "amplitude": finite})

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        w, A = 2.0 * np.pi * self.frequency, self.amplitude
        if order == -2:
            return A / w * (t - np.sin(w * t) / w)
        if order == -1:
            return A / w * (1.0 - np.cos(w * t))
        return (A * np.sin(w * t), A * w * np.cos(w * t), -A * w**2 * np.sin(w * t))[order]


@dataclass(frozen=True)
class Step(Curve):
    """Constant A from t = 0 on."""

    amplitude: float

    def __post_init__(self) -> None:
        check_fields(self, {"amplitude": finite})

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        if order > 0:
            return np.zeros_like(t)
        return self.amplitude * (np.ones_like(t), t, 0.5 * t**2)[-order]


@dataclass(frozen=True)
class Table(Signal):
    """Samples of the signal; zero slope outside. `time` strictly increasing, s.

    A displacement is interpolated by `smooth_table`; velocity and acceleration are linear between the points, the
    corners of the velocity rounded by `rounding`.
    """

    sudden: ClassVar[bool] = True
    time: FloatArray
    value: FloatArray
    rounding: float | None = None
    """Share of the shorter interval at a point over which prescribed motion rounds the corner (`Rounded`); None:
    prescribed displacement follows splines instead of straight lines."""

    def __post_init__(self) -> None:
        check_fields(self, {"time": partial(row_of, least=1), "value": row_of})
        _check_rising(self)
        if self.rounding is not None and not 0.0 <= number(self.rounding, "Table: rounding") <= 0.5:
            raise InputError(f"Table: rounding = {self.rounding}", expected="a number from 0 to 0.5, or None")

    def values(self, t: FloatArray) -> FloatArray:
        return np.interp(t, self.time, self.value)

    def motion(self, t: FloatArray, order: int) -> Motion:
        if order == 2:
            # Exact integrals of the piecewise linear acceleration, constant before the first and after the last row.
            knots = np.union1d(np.union1d(self.time, t), [0.0])
            a = np.interp(knots, self.time, self.value)
            h = np.diff(knots)
            v = np.concatenate([[0.0], np.cumsum(0.5 * h * (a[:-1] + a[1:]))])
            u = np.concatenate([[0.0], np.cumsum(h * v[:-1] + h**2 * (a[:-1] / 3.0 + a[1:] / 6.0))])
            start = int(np.searchsorted(knots, 0.0))
            u = u - u[start] - v[start] * (knots - knots[start])
            v = v - v[start]
            at = np.searchsorted(knots, t)
            return Motion(u[at], v[at], a[at])
        if order == 1 or self.rounding is not None:
            return Rounded(self.time, self.value, self.rounding or 0.0).motion(t, order)
        if self.time.size == 1:
            return Motion(np.full_like(t, self.value[0]), np.zeros_like(t), np.zeros_like(t))
        inside = np.clip(t, self.time[0], self.time[-1])
        moving = (t >= self.time[0]) & (t <= self.time[-1])
        spline = smooth_table(self.time, self.value)
        return Motion(
            spline(inside), np.where(moving, spline(inside, 1), 0.0), np.where(moving, spline(inside, 2), 0.0)
        )


@dataclass(frozen=True)
class Record(Signal):
    """A measured acceleration, turned into displacement by omega arithmetic above `high_pass` Hz.

    Whatever it prescribes, its motion is the zero-mean one of that acceleration.
    """

    time: FloatArray
    value: FloatArray
    high_pass: float
    evened: float = 0.0
    """Share of its rms by which it may be off, because it was put on even times (`between_samples.evened`)."""

    def __post_init__(self) -> None:
        check_fields(self, {"time": partial(row_of, least=2), "value": row_of, "high_pass": positive})
        _check_rising(self)
        if even_step(self.time) is None:
            raise InputError("a record with uneven times", expected="samples evenly spaced", fix="Resample the record.")

    @property
    def step(self) -> float:
        """s, of the whole record: single times are rounded."""
        return float(self.time[-1] - self.time[0]) / (self.time.size - 1)

    @cached_property
    def integrals(self) -> FloatArray:
        """(3, n) displacement, velocity and acceleration at its samples."""
        return np.stack(integrate_twice(self.value, self.step, self.high_pass))

    @cached_property
    def wrapped(self) -> float:
        """How far off the displacement is, `wrapped_share`."""
        return wrapped_share(self.value, self.step, self.high_pass, self.integrals[0])

    def values(self, t: FloatArray) -> FloatArray:
        return between_samples(self.value[None], (t - self.time[0]) / self.step)[0]

    def motion(self, t: FloatArray, order: int) -> Motion:
        """Faded in from its beginning, or from t = 0 where that is later; faded out at its end where t goes on."""
        first, last, step = float(self.time[0]), float(self.time[-1]), self.step
        motion = Motion(*between_samples(self.integrals, (t - first) / step))
        motion = faded_in(motion, t - max(first, 0.0), 1.0 / self.high_pass)
        if not (t > last + 1.001 * step).any():  # the last sample stands for a step
            return motion
        return windowed(motion, (last - t) * self.high_pass, -self.high_pass)


def _check_rising(course: Table | Record) -> None:
    name, n = type(course).__name__, course.time.size
    if course.value.size != n:
        raise InputError(f"{name}: {course.value.size} values at {n} times", expected="as many of both")
    fall = np.flatnonzero(np.diff(course.time) <= 0.0)
    if fall.size:
        before, after = course.time[fall[0] : fall[0] + 2]
        raise InputError(f"{name}: the time {after:g} after {before:g}", expected="times that rise")


def displacement_motion(signal: Signal, t: FloatArray) -> Motion:
    """The signal is a displacement: differentiate it. Multisine and record are faded in (`signal.faded_in`).

    A table is interpolated by `smooth_table`; a record is integrated twice first.
    """
    return _checked(signal).motion(row_of(t, "t"), 0)


def acceleration_motion(signal: Signal, t: FloatArray) -> Motion:
    """The signal is an acceleration (base motion).

    Sine, step and table start from rest: v(0) = u(0) = 0. Multisine and record are periodic: their motion is
    the zero-mean one of omega arithmetic, faded in.
    """
    return _checked(signal).motion(row_of(t, "t"), 2)


def _checked(signal: Signal) -> Signal:
    of_kind(signal, Signal, "signal", A_SIGNAL)
    return signal


def smooth_table(time: FloatArray, value: FloatArray) -> CubicHermiteSpline:
    """The cubic spline where it and the modified Akima spline are alike, and that one at corners and plateaus.

    A cubic spline has continuous second derivatives, off by h^2 / 12 of their own second derivative: an acceleration
    that can be used. At a corner it swings to both sides. A modified Akima spline does not swing, but its second
    derivative is off by as much as it is, however close the points lie. Where both differ in the middle of an interval
    by more than `APART` of what the table changes by near it, the slopes at its ends are those of the latter, and the
    cubic spline is found anew between them.

    Parameters
    ----------
    time : (k,) strictly increasing, k >= 2. value : (k,)
    """
    from scipy.interpolate import Akima1DInterpolator, CubicHermiteSpline, CubicSpline  # see `signals.spectra`

    akima = np.asarray(Akima1DInterpolator(time, value, method="makima")(time, 1))
    slope, fixed = akima.copy(), np.zeros(time.size, dtype=bool)
    slope[[0, -1]] = CubicSpline(time, value)(time[[0, -1]], 1)
    fixed[[0, -1]] = True
    h, allowed = np.diff(time), APART * _largest_near(np.abs(np.diff(value))) + 1e-12 * np.ptp(value)
    for _ in range(ROUNDS):
        found = _with_continuous_bends(h, np.diff(value) / h, slope, fixed)
        off = found - akima
        corner = np.abs(h / 8.0 * (off[:-1] - off[1:])) > allowed
        ends = np.concatenate([[False], corner]) | np.concatenate([corner, [False]])
        if not (ends & ((found != akima) | ~fixed)).any():
            break
        fixed |= ends
        slope[ends] = akima[ends]
    return CubicHermiteSpline(time, value, found)


def _with_continuous_bends(h: FloatArray, rise: FloatArray, slope: FloatArray, fixed: BoolArray) -> FloatArray:
    """Slopes at the points: those that are fixed, and between them those of continuous second derivatives.

    h_i d_(i-1) + 2 (h_(i-1) + h_i) d_i + h_(i-1) d_(i+1) = 3 (h_i rise_(i-1) + h_(i-1) rise_i)
    """
    from scipy.linalg import solve_banded

    i = np.flatnonzero(~fixed)
    bands, right = np.zeros((3, slope.size)), slope.copy()
    bands[1] = 1.0
    bands[0, i + 1], bands[1, i], bands[2, i - 1] = h[i - 1], 2.0 * (h[i - 1] + h[i]), h[i]
    right[i] = 3.0 * (h[i] * rise[i - 1] + h[i - 1] * rise[i])
    return np.asarray(solve_banded((1, 1), bands, right))


def _largest_near(size: FloatArray) -> FloatArray:
    found = size.copy()
    for k in range(1, min(NEAR, size.size - 1) + 1):
        found[k:] = np.maximum(found[k:], size[:-k])
        found[:-k] = np.maximum(found[:-k], size[k:])
    return found
