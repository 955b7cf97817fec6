"""Specific loudness over the critical-band rate, with the slopes of masking, and its integral: ISO 532-1, 5.4."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.jit import njit
from creak.sound.zwicker_tables import BARK, EDGES, RANGES, SLOPES

ON_THE_EDGE = 1e-6
"""Bark by which a point may lie beyond a piece and still be its last."""


def with_slopes(core: FloatArray, every: int = 1) -> tuple[FloatArray, FloatArray]:
    """Total loudness (n,) in sone and, of each `every`-th row, specific loudness (n_out, 240) in sone/Bark at `BARK`.

    Parameters
    ----------
    core : (n, 20) sone/Bark of the critical bands.
    """
    total, specific = _with_slopes(core, every, EDGES, RANGES, SLOPES, BARK)
    return np.asarray(total), np.asarray(specific)


@njit(nogil=True)
def _with_slopes(
    core: FloatArray, every: int, edges: FloatArray, ranges: FloatArray, slopes: FloatArray, bark: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The pattern in straight pieces from low to high bands.

    A band louder than what spills over from below is flat; else that spill falls on, ever flatter the softer it is,
    down to the band's own loudness.
    """
    count, bands = core.shape
    total, specific = np.zeros(count), np.zeros(((count + every - 1) // every, bark.size))
    for k in range(count):
        z, n, point = 0.0, 0.0, 0
        for i in range(edges.size):
            own = core[k, i] if i < bands else 0.0
            while z < edges[i]:
                if n <= own:
                    n, steep, end, low = own, 0.0, edges[i], own
                else:
                    row = 0
                    while ranges[row] >= n:
                        row += 1
                    steep = slopes[row, min(i - 1, slopes.shape[1] - 1)]
                    low = max(ranges[row], own)
                    end = z + (n - low) / steep
                    if end > edges[i]:
                        end = edges[i]
                        low = n - (end - z) * steep
                total[k] += 0.5 * (end - z) * (n + low)
                if k % every == 0:
                    while point < bark.size and bark[point] <= end + ON_THE_EDGE:
                        specific[k // every, point] = max(n - (bark[point] - z) * steep, 0.0)
                        point += 1
                z, n = end, low
    return total, specific
