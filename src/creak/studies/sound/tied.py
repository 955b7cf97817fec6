"""What is foretold beyond third octaves that are known both by computation and by statistics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray

UNTIED, LIKE = 5.0, 4.0
"""dB, standard deviation of a third octave that is tied to nothing, and as many of them as that is believed like. Real
parts are no flat plates of one thickness: those of a door and a cockpit that were computed are off by so much."""
FAR = 3.0
"""Times `UNTIED` beyond which a third octave is no more off: a part that stands still there is no plate yet."""
OCTAVE = 3.0
"""Third octaves over which the correlation of what two of them are off by falls to 1 / e."""


@dataclass(frozen=True)
class Tie:
    """How the statistical level of one sound stands to what was computed of it."""

    bands: int
    """Third octaves that both have; 0: it is tied to nothing."""
    offset: float
    """dB by which the statistics are corrected, mean over what lies beyond; 0 where nothing ties them."""
    scatter: float
    """dB, standard deviation of the level beyond: of the tie, and of one plate from the mean of all like it."""


@dataclass(frozen=True)
class Levels:
    """Third octaves by their numbers."""

    band: IntArray
    apart: FloatArray
    """dB of what was computed over the statistics."""
    scatter: FloatArray
    """dB, standard deviation of one plate from the mean of all like it."""


def tied(seen: Levels, further: IntArray, scatter: FloatArray, weight: FloatArray) -> tuple[Tie, FloatArray]:
    """The tie of levels beyond to those that were seen, and dB by which each of them is corrected.

    What third octaves are off by, dB, is a random function of their number b: normal, mean 0, covariance
    s^2 exp(-|b - b'| / OCTAVE). It is seen where both are known, with the scatter of one plate on it, and foretold
    beyond (kriging: Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, equations 2.23 and 2.24).
    What is seen tells s as well, beside `UNTIED` (inverse gamma of `LIKE`).

    Parameters
    ----------
    further, scatter : of the levels beyond, as `Levels` has them. weight : with which each counts, of any sum.
    """
    b, d, v = seen.band, np.clip(seen.apart, -FAR * UNTIED, FAR * UNTIED), seen.scatter**2

    def alike(one: IntArray, other: IntArray) -> FloatArray:
        return np.asarray(np.exp(-np.abs(one[:, None] - other) / OCTAVE))

    by_prior = alike(b, b) + np.diag(v / UNTIED**2)
    square = (LIKE * UNTIED**2 + float(d @ np.linalg.solve(by_prior, d))) / (LIKE + d.size)
    known, to = square * alike(b, b) + np.diag(v), square * alike(further, b)
    corrected = to @ np.linalg.solve(known, d)
    left = square * alike(further, further) - to @ np.linalg.solve(known, to.T) + np.diag(scatter**2)
    share = weight / max(float(weight.sum()), np.finfo(float).tiny)
    return Tie(d.size, float(share @ corrected), float(np.sqrt(share @ left @ share))), np.asarray(corrected)
