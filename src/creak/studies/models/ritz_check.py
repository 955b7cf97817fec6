"""A reduced model is never softer than the unreduced one: what would tell of joints that were lost on the way."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.errors import NumericalError

SOFTER = 0.01
"""Share by which a frequency may lie below that of the unreduced model: those of both have far smaller errors."""
LOW = 1e-3
"""Of the highest frequency that is compared, up to which frequencies may be round-off."""


def require_no_softer(reduced: FloatArray, unreduced: FloatArray) -> None:
    """Refuse a reduced model whose k-th frequency is below the k-th of the unreduced one.

    A Galerkin basis holds some motions of the structure; the least of Rayleigh's quotient over some is no smaller than
    that over all (Courant, Fischer). Frequencies below say that parts are joined at fewer dofs than they share.

    Parameters
    ----------
    reduced, unreduced : lowest frequencies of both models, Hz; those of the unreduced one rise, rigid ones first.

    Raises
    ------
    NumericalError : with the first mode that is.
    """
    n = min(reduced.size, unreduced.size)
    known, own = unreduced[:n], np.sort(reduced)[:n]
    soft = np.flatnonzero((own < (1.0 - SOFTER) * known) & (known > LOW * known[-1:].max(initial=0.0)))
    if soft.size:
        k = int(soft[0])
        raise NumericalError(
            f"mode {k + 1} of the reduced model has {own[k]:.4g} Hz, and {known[k]:.4g} Hz in the unreduced one: no "
            'reduction is softer, its parts are joined wrongly. Run with [reduction] method = "none", or without '
            "substructures, unreduced and keep_out, and send us the deck"
        )
