"""Double integration of a measured acceleration in the frequency domain (Mercer 2006)."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.given import positive, row_of

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
