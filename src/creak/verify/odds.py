"""Probabilities with their confidence, and what share of a scatter each cause has."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.stats import beta, norm, t

from creak.arrays import BoolArray, FloatArray, IntArray

LEVEL = 0.95
UNSEEN = 2.0
"""Two draws more that are off by this, one to either side, count in the bounds of an index: among few draws there may
be none in which a cause matters."""


@dataclass(frozen=True)
class Odds:
    """A probability that was counted."""

    p: float
    low: float
    high: float
    """Clopper-Pearson bounds: they cover the truth in at least `LEVEL` of all repeats of independent draws, more often
    with draws as even as Sobol's."""
    hits: int
    n: int
    foretold: int = 0
    """Further draws of which a forecast is known: p and its bounds follow from both (`with_forecast`)."""


def odds(hits: int, n: int) -> Odds:
    """`hits` of `n` draws. Source: Clopper, Pearson, Biometrika 26, 1934."""
    tail = 0.5 * (1.0 - LEVEL)
    low = float(beta.ppf(tail, hits, n - hits + 1)) if hits else 0.0
    high = float(beta.ppf(1.0 - tail, hits + 1, n - hits)) if hits < n else 1.0
    return Odds(hits / n if n else 0.0, low, high, hits, n)


@dataclass(frozen=True)
class Forecast:
    """What is known of draws before they are made."""

    hits: BoolArray
    """(n,) whether each would hit."""
    can: BoolArray
    """(n,) whether it can; where not it does not, for sure."""


def with_forecast(hit: BoolArray, here: Forecast, further: Forecast, rows: IntArray, seen: BoolArray) -> Odds:
    """Odds of draws that hit (n,) and of many further ones, of which the forecast is known.

        p = mean X + mean C (mean of Y - X over the draws that can hit)

    X is the forecast of the further draws, C whether they can hit, Y what the draws here came to: a difference
    estimator of two-phase sampling (Cochran, Sampling Techniques, 1977, chapter 12). The bounds of its terms are those
    of Clopper and Pearson; they add by squares about p (Zou and Donner, Stat. Med. 27, 2008). Where the forecast says
    so little that the draws here alone tell more, the odds are theirs.

    Parameters
    ----------
    rows, seen : (k,) further draws that can hit and were made, and whether they hit: they count in the mean of Y - X.
    """
    alone, X, C = counted(hit), counted(further.hits), counted(further.can)
    came = np.concatenate([hit[here.can], seen])
    said = np.concatenate([here.hits[here.can], further.hits[rows]])
    more, less, m = counted(came & ~said), counted(said & ~came), came.size
    p = X.p + C.p * (more.p - less.p)
    together = 2.0 * C.p**2 * more.p * less.p / m if m else 0.0
    down = (X.p - X.low) ** 2 + (C.p * more.p - C.low * more.low) ** 2 + (C.high * less.high - C.p * less.p) ** 2
    up = (X.high - X.p) ** 2 + (C.high * more.high - C.p * more.p) ** 2 + (C.p * less.p - C.low * less.low) ** 2
    margin = float(norm.ppf(0.5 * (1.0 + LEVEL))) ** 2 * together
    p = min(max(p, 0.0), C.p)
    low, high = max(p - math.sqrt(down + margin), 0.0), min(p + math.sqrt(up + margin), C.high)
    if high - low >= alone.high - alone.low:
        return alone
    return Odds(p, low, high, alone.hits, alone.n, further.hits.size)


@dataclass(frozen=True)
class Index:
    """Sobol indices of one cause: shares of the variance of a figure, they and their bounds cut to 0 .. 1."""

    first: float
    """What knowing the cause alone would take away."""
    first_bounds: tuple[float, float]
    total: float
    """What would be left if all others were known: with its interactions."""
    total_bounds: tuple[float, float]


Blocks = tuple[FloatArray, FloatArray, FloatArray]
"""A figure (n,) of draws A, of draws B, and of A with the cause from B."""


def sobol_index(own: Blocks, forecast: Blocks | None = None, further: Blocks | None = None) -> Index | None:
    """Indices of one cause from three times n figures; None: nothing varies.

    First: mean(B (mixed - A)) / V with centred figures; total: mean((A - mixed)^2) / (2 V). Bounds of 95 %: Student's t
    of the quotient's linear part (the variance is drawn too) and of `UNSEEN`. They cover in 95 of 100 repeats where
    either outcome of a figure of two values comes up ten times or more.
    Source: Saltelli et al., Comput. Phys. Commun. 181, 2010 (table 2, b and f).

    Parameters
    ----------
    forecast : the same of something that is like the figure. further : of that from many more draws. Its indices are
        known better so, and by as much as both go together the figure's own are, too (control variate: Owen, Monte
        Carlo theory, methods and examples, 2013, section 8.9).
    """
    known = np.isfinite(np.stack(own)).all(axis=0)
    parts = _parts(*(x[known] for x in own))
    if parts is None:
        return None
    told = None if forecast is None else _parts(*(x[known] for x in forecast))
    many = None if further is None else _parts(*further)
    found = []
    for k in range(2):
        like = None if told is None or many is None else (_Share.of(told[k], told[2]), _Share.of(many[k], many[2]))
        found.append(_Share.of(parts[k], parts[2]).with_bounds(like))
    return Index(*found[0], *found[1])


def _parts(A: FloatArray, B: FloatArray, mixed: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """(n,) parts of the first and of the total index, and of the variance; None: nothing varies."""
    if A.size < 2 or not np.ptp(np.concatenate([A, B])) > 0.0:
        return None
    middle = float(np.concatenate([A, B]).mean())
    A, B, mixed = A - middle, B - middle, mixed - middle
    return B * (mixed - A), 0.5 * (A - mixed) ** 2, 0.5 * (A**2 + B**2)


@dataclass(frozen=True)
class _Share:
    """mean(part) / mean(square) of n draws."""

    share: float
    off: FloatArray
    """(n,) its linear part, of mean 0."""

    @staticmethod
    def of(part: FloatArray, square: FloatArray) -> _Share:
        variance = float(square.mean())
        share = float(part.mean()) / variance
        return _Share(share, (part - share * square) / variance)

    def with_bounds(self, like: tuple[_Share, _Share] | None) -> tuple[float, tuple[float, float]]:
        """It, corrected by what is like it: from the same draws, and from many."""
        n, share, off, of_many = self.off.size, self.share, self.off, 0.0
        if like is not None:
            here, many = like
            square, m = float(here.off @ here.off), many.off.size
            by = float(off @ here.off) / square if square > 0.0 else 0.0
            share, off = share - by * (here.share - many.share), off - by * here.off
            of_many = by**2 * float(many.off @ many.off) / (m * (m - 1))
        error = math.sqrt(float(off @ off + 2.0 * UNSEEN**2) / (n * (n - 1)) + of_many)
        half = float(t.ppf(0.5 * (1.0 + LEVEL), n - 1)) * error
        cut, low, high = (min(max(x, 0.0), 1.0) for x in (share, share - half, share + half))
        return cut, (low, high)


def shift_needed(slack: FloatArray, target: float) -> tuple[float, float, float]:
    """How much all slacks (n,) have to grow for at most the share `target` of them to be negative; with bounds.

    The quantile of the slacks with its binomial bounds (order statistics); infinite where there are too few draws.
    """
    ordered, n = np.sort(slack), slack.size
    tail = 0.5 * (1.0 - LEVEL)
    counts = np.arange(n + 1, dtype=np.float64)
    at = np.asarray(beta.cdf(1.0 - target, np.maximum(n - counts, 1e-300), counts + 1))
    lowest = int(np.searchsorted(at, tail, side="left")) - 1
    highest = int(np.searchsorted(at, 1.0 - tail, side="left"))
    middle = int(np.floor(target * n))
    return (
        -float(ordered[min(middle, n - 1)]),
        -float(ordered[min(highest, n - 1)]),
        -float(ordered[lowest]) if lowest >= 0 else np.inf,
    )


def spread(values: FloatArray) -> dict[str, float]:
    """Mean and quantiles of a figure."""
    q = np.quantile(values, [0.05, 0.25, 0.5, 0.75, 0.95, 0.99])
    names = ("p5", "p25", "median", "p75", "p95", "p99")
    return {"mean": float(values.mean()), **dict(zip(names, q.tolist(), strict=True)), "max": float(values.max())}


def ends(cause: FloatArray, figure: FloatArray) -> tuple[float, float]:
    """Mean of a figure over the draws with the lowest and with the highest quarter of the values of a cause."""
    order, k = np.argsort(cause, kind="stable"), max(1, int(0.25 * cause.size))
    return float(figure[order[:k]].mean()), float(figure[order[-k:]].mean())


def counted(hit: BoolArray) -> Odds:
    """Odds of draws that hit (n,)."""
    return odds(int(np.count_nonzero(hit)), int(hit.size))
