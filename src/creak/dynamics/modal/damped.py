"""Free motion of damped modes u'' + 2 delta u' + omega^2 u = 0 in closed form."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray


def damped_waves(delta: FloatArray, omega2: FloatArray, h: float) -> tuple[FloatArray, FloatArray]:
    """exp(-delta h) times cos(w h) and sin(w h) / w, (n,) each; w^2 = omega^2 - delta^2 of any sign, or 0."""
    root = np.sqrt((omega2 - delta**2).astype(complex))
    still = np.abs(root) * h < 1e-8
    root = np.where(still, 1.0, root)
    grow, fall = np.exp((1j * root - delta) * h), np.exp((-1j * root - delta) * h)
    cosine = np.where(still, np.exp(-delta * h), (0.5 * (grow + fall)).real)
    sine = np.where(still, h * np.exp(-delta * h), (0.5 * (grow - fall) / (1j * root)).real)
    return cosine, sine
