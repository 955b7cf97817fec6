"""Double integration of a measured acceleration in the frequency domain (Mercer 2006)."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray


def integrate_twice(
    acceleration: FloatArray, step: float, high_pass: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Displacement, velocity and acceleration, all without content below `high_pass`.

    X = -A / omega^2, V = A / (i omega) in the complex spectrum; lines below the cut-off (and the mean) are
    dropped. Exact on signals that are periodic over the record; elsewhere the ends wrap around.

    Parameters
    ----------
    acceleration : (n,) evenly sampled. step : s. high_pass : Hz.
    """
    spectrum = np.fft.rfft(acceleration)
    freq = np.fft.rfftfreq(acceleration.size, step)
    keep = (freq >= high_pass) & (freq > 0.0)
    omega = 2.0 * np.pi * np.where(keep, freq, 1.0)
    A = np.where(keep, spectrum, 0.0)
    n = acceleration.size
    return np.fft.irfft(-A / omega**2, n), np.fft.irfft(A / (1j * omega), n), np.fft.irfft(A, n)
