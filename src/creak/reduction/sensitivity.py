"""How natural frequencies follow a parameter of stiffness and mass."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, Matrix


def frequency_slopes(dK: Matrix, dM: Matrix, shapes: FloatArray, omega2: FloatArray) -> FloatArray:
    """(n_mode,) d(ln f)/dp = phi' (dK/dp - omega^2 dM/dp) phi / (2 omega^2) of mass-normalised modes.

    Parameters
    ----------
    dK, dM : (n, n) derivatives of stiffness and mass. shapes : (n, n_mode), phi' M phi = 1. omega2 : (n_mode,) > 0.

    Exact for modes of different frequency. Modes of one frequency have a slope each only along the shapes into which
    the parameter splits them, which these need not be.

    Source: Fox and Kapoor, AIAA Journal 6 (1968), equation 5.
    """
    stiffness, mass = (np.einsum("ij,ij->j", shapes, np.asarray(A @ shapes)) for A in (dK, dM))
    return np.asarray((stiffness - omega2 * mass) / (2.0 * omega2))
