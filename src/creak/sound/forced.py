"""Sound of forces on a linear structure: its modes between forces and listener, exactly, frequency by frequency.

With forces f_j(t), their rows X and what modal accelerations send to a listener, R(s) = sum_k rows_k e^(-s k / rate),

    P(s) = R(s) s^2 H(s) X' F(s),     s = sigma + i omega,     H = diag(1 / (m s^2 + c s + k))

where damping couples no modes (`answering`),

a discrete Fourier transform of what is weighted by e^(-sigma t). The weight makes the motion die out within the
record, so that nothing comes around at its start, however weakly the modes are damped; rigid ones need no care. Source:
the exponential window, Kausel and Roesset, J. Eng. Mech. 118, 1992. Only the band that is wanted is computed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from creak.arrays import ComplexArray, FloatArray, IntArray
from creak.errors import InputError
from creak.sound.answering import Answering
from creak.sound.rayleigh import HIGHEST, PressureRows

DECAY = 10.0
"""sigma times the length of the padded record: 5e-5 of what is at its end comes around, where nothing is damped."""
PAD = 0.25
"""Of the record, silence behind it."""
BEFORE, AFTER = 8.0, 24.0
"""Silence before and at least behind a record, over the width in Hz of the fade at the end of the band: what the fade
sends ahead of a blow falls to 1e-6 and less."""
LOWEST = 20.0
"""Hz, where hearing begins; faded out over the octave below."""
TAIL, FADES = 4.0 / LOWEST, 1.0 / LOWEST
"""s behind the record that are computed, so that its own end is none for fades and filters, and of the fade there."""
FADE = 0.85
"""Share of the band from which the sound fades out to its end."""
STIFF = 4.0
"""Frequency of a mode over the end of the band from which its motion follows the force by two terms of a series."""
SHORT = 0.05
"""Of a record that is cut, the longest fade."""
FEW, LEAST = 4, 256
"""Samples of a velocity per line of its spectrum, and the fewest."""
BLOCK = 4_000_000
"""Complex numbers worked on at a time."""

Gain = Callable[[FloatArray], FloatArray | ComplexArray]
"""Of frequencies, Hz, above 0."""


def sound_of_forces(
    modes: Answering,
    force: FloatArray,
    rate: float,
    groups: Sequence[IntArray],
    rows: PressureRows,
    band: float,
    gains: Sequence[Gain] = (),
    *,
    around: bool = False,
) -> FloatArray:
    """Pressure (n_listener, n_group, n) in Pa that each group of forces makes by itself, at rest before.

    Valid for linear structures in air that does not load them. Nothing is left above `band`, nor below 10 Hz.

    Parameters
    ----------
    force : (n, n_force) means over the sampling intervals around each instant. rate : theirs, Hz, and of the pressure.
    groups : columns of `force`. rows : right up to the band; their own rate may be lower. band : Hz.
    gains : of each listener.
    around : with the `lead` before the record, which fades and gains send ahead, and with what rings on behind it.

    Raises
    ------
    InputError : shapes that do not fit; a band that is not above 20 Hz and within .4 of the rate and that of the rows.
    """
    n, count = force.shape
    _checked(modes, force, rows.rows.shape[2])
    _in_band(band, min(HIGHEST * rate, rows.band))
    on = _transformed(force, rate, band)
    slow = modes.omega <= 2.0 * np.pi * STIFF * band
    whole = slice(0, on.front + n + int(TAIL * rate))
    kept = whole if around else slice(on.front, on.front + n)
    out = on.growth(whole, rate) * _fade(whole.stop, FADES * rate)[::-1]
    found = np.zeros((rows.rows.shape[0], len(groups), kept.stop - kept.start))
    for listener, (taps, start) in enumerate(zip(rows.rows, rows.start.tolist(), strict=True)):
        late = (start + np.arange(taps.shape[0])) / rows.rate
        P = np.zeros((len(groups), on.size // 2 + 1), dtype=complex)
        seen = modes.seen(taps)
        flexible, own = modes.select(slow, seen)
        stiff, other = modes.select(~slow, seen)
        still, own, push = stiff.series(other), np.ascontiguousarray(own), np.ascontiguousarray(flexible.push.T)
        for here in _blocks(on.used.size, own.shape[1] + late.size + count):
            z = on.s[here, None]
            delay = np.exp(-z * late)
            each = _by_real(flexible.answer(_by_real(delay, own), z), push)
            for power, table in still:
                each += z**power * _by_real(delay, table)
            each *= z * z * on.F[here]
            for g, columns in enumerate(groups):
                P[g, on.used[here]] = each[:, columns].sum(axis=1)
        for g in range(len(groups)):
            x = irfft(P[g], on.size)[whole] * out
            found[listener, g] = without_lows(x, rate, *gains[listener : listener + 1])[kept]
    return found


def lead(rate: float, band: float) -> int:
    """Samples before a record that hold what the fade at the end of the band sends ahead."""
    return int(BEFORE * _fade_samples(rate, band))


def velocity_of_forces(
    modes: Answering, force: FloatArray, rate: float, rows: FloatArray, band: float
) -> tuple[FloatArray, FloatArray]:
    """Times (n,) and velocities (n, k) of the motion `rows` (k, n_mode) under all forces, 20 Hz to the band's end.

    The times are as few as the band asks for. Parameters and errors as `sound_of_forces`.
    """
    _checked(modes, force, rows.shape[1])
    _in_band(band, HIGHEST * rate)
    on = _transformed(force, rate, band)
    size = next_fast_len(max(FEW * on.used.size, LEAST), real=True)
    V = np.zeros((size // 2 + 1, rows.shape[0]), dtype=complex)
    seen = np.ascontiguousarray(modes.seen(rows).T)
    for here in _blocks(on.used.size, seen.shape[0] + rows.shape[0]):
        z = on.s[here, None]
        moved = z * modes.answered(_by_real(on.F[here], modes.push), z)
        V[on.used[here]] = _by_real(moved, seen) * (size / on.size)
    slow = rate * size / on.size
    first, last = (round(slow / rate * k) for k in (on.front, on.front + force.shape[0] + int(TAIL * rate)))
    found = irfft(V, size, axis=0)[first:last] * on.growth(slice(first, last), slow)[:, None]
    time = np.arange(first, last) / slow - on.front / rate
    within = time <= (force.shape[0] - 1) / rate
    return time[within], np.stack([without_lows(x, slow) for x in found.T], axis=1)[within]


@dataclass(frozen=True)
class _Transformed:
    """Forces on a line beside the imaginary axis."""

    size: int
    front: int
    """Samples of silence before them."""
    used: IntArray
    s: np.ndarray
    """(n_used,) rad/s."""
    F: np.ndarray
    """(n_used, n_force), faded out at the end of the band."""

    def growth(self, at: slice, rate: float) -> FloatArray:
        """What the weight took from samples, at a rate."""
        return np.asarray(np.exp(self.s[0].real / rate * np.arange(at.start, at.stop)))


def _transformed(force: FloatArray, rate: float, band: float) -> _Transformed:
    n, count = force.shape
    width, front, whole = _fade_samples(rate, band), lead(rate, band), n + int(TAIL * rate)
    size = next_fast_len(front + whole + int(max(PAD * n, AFTER * width)), real=True)
    sigma = DECAY * rate / size
    weight = np.exp(-sigma / rate * np.arange(front, front + n))
    freq = np.arange(size // 2 + 1) * (rate / size)
    used = np.flatnonzero(freq < band)
    F = np.empty((used.size, count), dtype=complex)
    for j in range(count):
        F[:, j] = rfft(np.concatenate([np.zeros(front), force[:, j] * weight]), size)[used]
    F *= (high_end(freq[used], band) / np.sinc(freq[used] / rate))[:, None]
    return _Transformed(size, front, used, sigma + 2j * np.pi * freq[used], F)


def _fade_samples(rate: float, band: float) -> float:
    """Samples of a second over the width of the fade at the end of the band, Hz."""
    return rate / (band * (1.0 - FADE))


def _checked(modes: Answering, force: FloatArray, n_mode: int) -> None:
    if modes.shape != (force.shape[1], n_mode):
        raise InputError(
            f"forces {force.shape}, rows of {n_mode} modes, beside {modes.shape[0]} forces on {modes.shape[1]} modes",
            expected=f"({force.shape[0]}, {modes.shape[0]}), and rows of {modes.shape[1]} modes",
        )


def _in_band(band: float, highest: float) -> None:
    if not LOWEST < band <= highest:
        raise InputError(f"a band up to {band:g} Hz", expected=f"{LOWEST:g} to {highest:g} Hz")


def without_clicks(x: FloatArray, rate: float) -> FloatArray:
    """Records (..., n) that fade in and out over 50 ms, a twentieth of them at most: what is cut does not click."""
    n = x.shape[-1]
    fade = _fade(n, min(FADES * rate, SHORT * n))
    return np.asarray(x * fade * fade[::-1])


def _fade(n: int, width: float) -> FloatArray:
    """(n,) rising from 0 to 1 over the first samples."""
    return smooth(np.arange(n) / max(width, 1.0))


def high_end(freq: FloatArray, band: float) -> FloatArray:
    """Gain of each frequency, Hz: 1 up to .85 of the band, falling to 0 at its end."""
    return smooth((1.0 - freq / band) / (1.0 - FADE))


def without_lows(x: FloatArray, rate: float, *gains: Gain) -> FloatArray:
    """What is left above 20 Hz of a record (n,) that is silent before and after, times gains."""
    size = next_fast_len(x.size + int(rate), real=True)
    freq = np.arange(size // 2 + 1) * (rate / size)
    X = rfft(x, size) * smooth(2.0 * freq / LOWEST - 1.0)
    for gain in gains:
        X[1:] *= gain(freq[1:])
    return np.asarray(irfft(X, size)[: x.size])


def smooth(x: FloatArray) -> FloatArray:
    """From 0 at 0 to 1 at 1 with all derivatives continuous."""
    inside = np.clip(x, 1e-3, 1.0 - 1e-3)
    step = 1.0 / (1.0 + np.exp(np.clip(1.0 / inside - 1.0 / (1.0 - inside), -700.0, 700.0)))
    return np.where(x <= 0.0, 0.0, np.where(x >= 1.0, 1.0, step))


def _by_real(A: np.ndarray, B: FloatArray) -> np.ndarray:
    """Complex times real without the zeros of a complex B."""
    return np.asarray(A.real @ B + 1j * (A.imag @ B))


def _blocks(count: int, width: int) -> list[slice]:
    few = max(1, BLOCK // max(width, 1))
    return [slice(k, min(k + few, count)) for k in range(0, count, few)]
