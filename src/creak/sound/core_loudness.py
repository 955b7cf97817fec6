"""Core loudness of the critical bands from third-octave levels, and how it dies away: ISO 532-1, 5.3 to 6.4."""

from __future__ import annotations

import math

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.given import one_of
from creak.jit import njit
from creak.sound.zwicker_tables import (
    ADAPTION,
    DIFFUSE,
    EAR,
    LOW_BANDS,
    LOW_GROUPS,
    LOW_LIMITS,
    LOW_WEIGHTS,
    THRESHOLD,
)

FIELDS = ("free", "diffuse")
TO_FIRST_BAND = 8
"""Critical band less this is its third octave, from the fourth band on."""
INNER = 24
"""Steps of the decay between two band levels, between which core loudness is straight."""
SHORT, LONG, VARIABLE = 0.005, 0.015, 0.075
"""s, time constants of the decay."""
LEVEL = 1e-5
"""sone/Bark: change below which the input of the decay stands still."""
Six = tuple[float, float, float, float, float, float]


def core_loudness(levels: FloatArray, field: str) -> FloatArray:
    """(n, 20) sone/Bark in the critical bands, without slopes.

    Parameters
    ----------
    levels : (n, 28) dB of the third-octave bands. field : "free", sound from the front, or "diffuse".

    Raises
    ------
    InputError : another field; a band up to 250 Hz above 120 dB, for which the standard has no weights.
    """
    one_of(field, FIELDS, "sound field")
    loudest = float(levels[:, :LOW_BANDS].max())
    if loudest > LOW_LIMITS[-1]:
        raise InputError(
            f"{loudest:.0f} dB in a third octave up to 250 Hz",
            expected=f"at most {LOW_LIMITS[-1]:g} dB: ISO 532-1 ends there",
            fix="Look at the pressure's unit, Pa, and at slow motion in it.",
        )
    off = EAR - DIFFUSE if field == "diffuse" else EAR
    return np.asarray(_core(levels, LOW_LIMITS, LOW_WEIGHTS, np.array(LOW_GROUPS), off, THRESHOLD, ADAPTION))


@njit(nogil=True)
def _core(
    levels: FloatArray,
    limits: FloatArray,
    weights: FloatArray,
    groups: FloatArray,
    off: FloatArray,
    threshold: FloatArray,
    adaption: FloatArray,
) -> FloatArray:
    """Core loudness (n, 20) of levels (n, 28)."""
    count, bands = levels.shape[0], off.size
    found = np.zeros((count, bands))
    for k in range(count):
        for i in range(bands):
            if i < groups.size - 1:
                intensity = 0.0
                for low in range(groups[i], groups[i + 1]):
                    row = 0
                    while row < limits.size - 1 and levels[k, low] + weights[row, low] > limits[row]:
                        row += 1
                    intensity += 10.0 ** (0.1 * (levels[k, low] + weights[row, low]))
                level = 10.0 * math.log10(intensity)
            else:
                level = levels[k, i + TO_FIRST_BAND]
            level -= off[i]
            if level > threshold[i]:
                above = 10.0 ** (0.1 * (level - adaption[i] - threshold[i]))
                loud = 0.0635 * 10.0 ** (0.025 * threshold[i]) * ((0.75 + 0.25 * above) ** 0.25 - 1.0)
                found[k, i] = max(loud, 0.0)
        found[k, 0] *= min(1.0, 0.4 + 0.32 * found[k, 0] ** 0.2)
    return found


def decayed(core: FloatArray, rate: float) -> FloatArray:
    """Core loudness (n, bands) at `rate` Hz with the slow fall of hearing: slower after long sounds than after short.

    Two stores, filled at once by a rise: the first empties through the second and, once both are level, together
    with it.
    """
    return np.asarray(_decayed(core, decay_factors(1.0 / (rate * INNER)), INNER))


def decay_factors(step: float) -> Six:
    """What a step of `step` s leaves of the two stores.

    While the output u is above the inner store w, both fall with lambda^2 + P lambda + Q = 0,
    P = (VARIABLE + LONG) / (VARIABLE SHORT), Q = 1 / (SHORT VARIABLE).

    Returns
    -------
    w from u, w from w (negative), u from u, u from w (negative), both level, inner store towards a constant input.
    """
    P, Q = (VARIABLE + LONG) / (VARIABLE * SHORT), 1.0 / (SHORT * VARIABLE)
    root = math.sqrt(0.25 * P * P - Q)
    first, second = -0.5 * P + root, -0.5 * P - root
    e1, e2 = math.exp(first * step), math.exp(second * step)
    m1, m2, by = VARIABLE * first + 1.0, VARIABLE * second + 1.0, VARIABLE * (first - second)
    return (
        (e1 - e2) / by,
        (m2 * e1 - m1 * e2) / by,
        (m1 * e1 - m2 * e2) / by,
        m1 * m2 * (e1 - e2) / by,
        math.exp(-step / LONG),
        math.exp(-step / VARIABLE),
    )


@njit(nogil=True)
def _decayed(core: FloatArray, factors: Six, inner: int) -> FloatArray:
    """The stores marched through every band; the input is straight between its samples."""
    w_of_u, w_of_w, u_of_u, u_of_w, level, towards = factors
    count, bands = core.shape
    found = np.empty_like(core)
    for i in range(bands):
        u, w = 0.0, 0.0
        for k in range(count):
            rise = (core[k + 1, i] - core[k, i]) / inner if k + 1 < count else 0.0
            for j in range(inner):
                given = core[k, i] + j * rise
                if given < u:
                    if u > w:
                        emptied = max(u * u_of_u - w * u_of_w, given)
                        w = min(u * w_of_u - w * w_of_w, emptied)
                        u = emptied
                    else:
                        u = max(u * level, given)
                        w = u
                else:
                    if abs(given - u) < LEVEL and given <= w:
                        w = given
                    else:
                        w = given + (w - given) * towards
                    u = given
                if j == 0:
                    found[k, i] = u
    return found


@njit(nogil=True)
def low_pass(x: FloatArray, factor: float, inner: int) -> FloatArray:
    """First-order low-pass of x (n,), straight between its samples, `inner` steps of `factor` exp(-step / tau) each."""
    found = np.empty_like(x)
    y = 0.0
    for k in range(x.size):
        rise = (x[k + 1] - x[k]) / inner if k + 1 < x.size else 0.0
        for j in range(inner):
            given = x[k] + j * rise
            y = given + (y - given) * factor
            if j == 0:
                found[k] = y
    return found
