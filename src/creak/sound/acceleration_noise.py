"""Noise of a compact body that is suddenly accelerated, as in an impact: the dipole of a rigid sphere.

With s = t - (r - a) / c, A the acceleration towards the listener and l = c / a (Koss and Alfredson, 1973),

    x'' + 2 l x' + 2 l^2 x = A(s),     p = rho a^3 l^2 (x' / (c r) + x / r^2).

Slow motion leaves rho a^3 / 2 (A' / (c r) + A / r^2): a dipole whose strength is mass of air displaced and carried.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.jit import njit
from creak.sound.rayleigh import AIR


def equivalent_radius(volume: float) -> float:
    """Radius in m of the sphere with a volume in m^3, for bodies about as wide as long."""
    return math.cbrt(0.75 * volume / math.pi)


def acceleration_noise(
    acceleration: FloatArray,
    rate: float,
    radius: float,
    centre: FloatArray,
    listener: FloatArray,
) -> FloatArray:
    """Pressure (n,) in Pa of a rigid sphere at the instants of its acceleration, which is at rest before.

    Exact for accelerations that are straight between samples and move the sphere little. Bodies that touch are taken
    one by one, without the other's shadow, as Koss does.

    Parameters
    ----------
    acceleration : (n, 3) m/s^2. rate : Hz. radius : m. centre, listener : (3,) m.

    Raises
    ------
    InputError : a listener inside the sphere, a radius that is not above 0, accelerations of another shape.
    """
    if acceleration.ndim != 2 or acceleration.shape[1] != 3 or not np.isfinite(acceleration).all():
        raise InputError(f"acceleration of shape {acceleration.shape}", expected="finite numbers (n, 3) in m/s^2")
    if not (math.isfinite(radius) and radius > 0.0):
        raise InputError(f"a radius of {radius:g} m", expected="a number above 0")
    away = np.asarray(listener, dtype=np.float64) - np.asarray(centre, dtype=np.float64)
    distance = float(np.linalg.norm(away))
    if distance < radius:
        raise InputError(
            f"a listener {distance:g} m from the middle of a body of {radius:g} m radius", fix="Move it off the body."
        )
    towards = acceleration @ (away / distance)
    pace = AIR.speed / radius
    late = (distance - radius) / AIR.speed * rate
    whole = math.ceil(late)
    motion = np.zeros((4, 4))
    motion[0, 1] = motion[2, 3] = 1.0
    motion[1, :3] = -2.0 * pace**2, -2.0 * pace, 1.0
    step, part = expm(motion / rate), expm(motion * ((whole - late) / rate))
    scale = AIR.density * radius**3 * pace**2
    take = scale * (part[1] / (AIR.speed * distance) + part[0] / distance**2)
    found = np.zeros(towards.size)
    if whole < towards.size:
        found[whole:] = _marched(towards, step, take, rate)[: towards.size - whole]
    return found


@njit(nogil=True)
def _marched(A: FloatArray, step: FloatArray, take: FloatArray, rate: float) -> FloatArray:
    """`take` of the state (x, x', A, A') at every sample (n,), the state advanced by `step`."""
    found = np.empty(A.size)
    x, v = 0.0, 0.0
    for k in range(A.size):
        slope = (A[k + 1] - A[k]) * rate if k + 1 < A.size else 0.0
        found[k] = take[0] * x + take[1] * v + take[2] * A[k] + take[3] * slope
        x, v = (
            step[0, 0] * x + step[0, 1] * v + step[0, 2] * A[k] + step[0, 3] * slope,
            step[1, 0] * x + step[1, 1] * v + step[1, 2] * A[k] + step[1, 3] * slope,
        )
    return found
