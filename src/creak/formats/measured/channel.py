"""One channel of a measured file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray


@dataclass(frozen=True)
class Channel:
    """One measured quantity, evenly sampled."""

    name: str
    unit: str
    start: float
    """s"""
    step: float
    """s"""
    values: FloatArray
    """(n,)"""
    at: tuple[int, int] = (0, 0)
    """Node and direction, 1 to 6, where the file tells them; 0: none. Values are along the positive axis."""

    @property
    def time(self) -> FloatArray:
        """(n,) s"""
        return np.asarray(self.start + self.step * np.arange(self.values.size), dtype=np.float64)
