"""Guyan reduction: the inside follows the boundary statically."""

from __future__ import annotations

from creak.arrays import IntArray, Matrix
from creak.assembly.system import System
from creak.progress import Progress
from creak.reduction.craig_bampton import craig_bampton
from creak.reduction.inside import Inside


def guyan(
    system: System,
    boundary: IntArray,
    *,
    shape: Matrix | None = None,
    inside: Inside | None = None,
    progress: Progress | None = None,
) -> System:
    """Reduce a System to its boundary coordinates: u_i = -K_ii^-1 K_ib u_b, and nothing else.

    Exact in statics for loads on the boundary; its mass is right for rigid motion. Frequencies are upper bounds and
    soon useless: a few per cent off at a fifth of the first fixed-interface frequency is usual.

    Parameters and errors as `craig_bampton`, of which it is the case of no modes.
    Source: Guyan, AIAA J. 3(2), 1965.
    """
    return craig_bampton(system, boundary, count=0, shape=shape, inside=inside, progress=progress)
