"""A measured acceleration as displacement, and what is left of a course without its running mean."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray


def displacement_of(acceleration: FloatArray, step: float) -> FloatArray:
    """Twice the integral of evenly sampled values (n,), but for a constant and a slope: those of the least squares
    line are left out.

    A cubic spline is integrated: of a sine with ten samples a period one part in a thousand is lost.

    Parameters
    ----------
    step : s.
    """
    from scipy.interpolate import CubicSpline  # see `signals.spectra.low_pass`

    t = step * np.arange(acceleration.size)
    twice = CubicSpline(t, acceleration - acceleration.mean()).antiderivative(2)(t)
    return np.asarray(twice - np.polynomial.Polynomial.fit(t, twice, 1)(t))


def less_running_mean(time: FloatArray, values: FloatArray, width: float) -> tuple[FloatArray, FloatArray]:
    """Instants (k,) and values (k,) less their mean over `width` s around each, weighted by a Hann window.

    Half of a sine of 1 / width Hz is left. It has no delay, takes away any straight line, and what it gives hangs on
    no end of the record, for instants nearer to one than half the width are left out: two records of one motion give
    the same wherever both reach.

    Parameters
    ----------
    time : (n,) s, evenly spaced. width : s, less than the record.
    """
    from scipy.signal import fftconvolve

    step = float(time[-1] - time[0]) / (time.size - 1)
    side = int(0.5 * width / step)
    window = 1.0 + np.cos(2.0 * np.pi * step / width * np.arange(-side, side + 1))
    kept = slice(side, time.size - side)
    return time[kept], values[kept] - fftconvolve(values, window / window.sum(), mode="valid")
