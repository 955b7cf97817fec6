"""How a study asks to be reduced: what, by which table, and up to which frequencies modes are kept."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray
from creak.linalg.modes import BAND, with_further
from creak.studies.file.case import Driving
from creak.studies.file.config import ReductionTable
from creak.studies.prepare.exterior import Exterior
from creak.studies.prepare.structure import Structure


@dataclass(frozen=True)
class Band:
    """Frequencies up to which parts and their assembly have modes, Hz."""

    first: float
    """[reduction] f_max; of "auto" the one that it begins with."""
    raised: int
    """How often "auto" has gone half as high again."""
    auto: bool
    """Whether f_max follows from what more modes change."""
    further: bool
    """Whether a reduction computes further modes at once: what the run with more modes takes."""
    excited: float
    """Highest frequency that the excitations are known to hold; 0: none is known."""
    assembly: float
    """Up to which modes of the assembly are looked at."""
    damped: float | None
    """Up to which modal damping needs them at least; None: there is none."""

    @property
    def f_max(self) -> float:
        """Up to which each part has all its modes."""
        return self.first * BAND**self.raised

    def raised_to(self, times: int) -> Band:
        """The same with f_max raised so often."""
        return replace(self, raised=times)

    def kept_modes(self, omega2: FloatArray) -> int:
        """How many of these a reduction keeps: those below f_max, and the further ones each time that it was raised."""
        kept = 0
        for k in range(self.raised + 1):
            below = int(np.count_nonzero(omega2 <= (2.0 * np.pi * self.first * BAND**k) ** 2))
            kept = with_further(kept, below) if k else below
        return min(kept, omega2.size)


@dataclass(frozen=True)
class Reduction:
    """What is reduced, and how: as [reduction] says, with the band that follows from it."""

    structure: Structure
    exterior: Exterior
    table: ReductionTable
    band: Band
    driving: Driving
