"""Events of a reduced run that the unreduced model marched through from the reduced one's state: what came out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.studies.converge.settling import FIGURES, TIMES
from creak.verify.events import Event


@dataclass(frozen=True)
class Spot:
    """One event of the reduced run and what the unreduced model makes of it."""

    event: Event
    """Of the reduced run."""
    place: int
    """Row of its place in `Places`, by worst force."""
    why: str
    """hardest, or drawn: by the stored seed."""
    reduced: dict[str, float]
    """`FIGURES` of the reduced run over the same stretch of time; those that the stretch does not hold are left out."""
    unreduced: dict[str, float] | None
    """The same of the unreduced model; None where it has no such event, or was not run through it."""
    numerical: dict[str, float] | None = None
    """What half the contact step changes of the unreduced figures: s, or shares; None: not looked at."""
    problem: str = ""
    """Why there is nothing to compare."""

    @property
    def differences(self) -> dict[str, float]:
        """Unreduced less reduced: s for times, shares of the unreduced figure else; nan where it has no such event."""
        if self.unreduced is None:
            return {} if self.problem else dict.fromkeys(FIGURES, np.nan)
        return {name: _apart(name, self.reduced[name], x) for name, x in self.unreduced.items() if name in self.reduced}


@dataclass(frozen=True)
class SpotChecks:
    """All of a run."""

    spots: tuple[Spot, ...]
    solves: int
    """Back-substitutions of the unreduced model that they took, each factor counted as `choose.FACTOR`."""
    wall_s: float
    why_not: str = ""
    """Why there are none."""

    @property
    def looked(self) -> tuple[Spot, ...]:
        """Those that have something to compare."""
        return tuple(s for s in self.spots if not s.problem)

    def of(self, event: Event) -> Spot | None:
        """That of an event, where it was checked."""
        return next((s for s in self.looked if s.event is event or s.event == event), None)

    def spread(self, name: str) -> float:
        """Root mean square of a figure's differences, times what as few as there are leave open (`surely`); of times
        as a share of the event's duration. nan: not one was checked; infinite: an event of the reduced run is none."""
        shares = [_share(s, name) for s in self.looked if name in s.differences]
        if not shares:
            return np.nan
        if np.isnan(shares).any():
            return np.inf
        return float(np.sqrt(np.mean(np.square(shares)))) * surely(len(shares))


def surely(n: int) -> float:
    """Half width of the interval that holds the next one of normal differences about zero in 95 of 100 cases, over the
    root mean square of the n that are known: Student's t with n degrees of freedom."""
    from scipy.stats import t

    return float(t.ppf(0.975, n))


def _share(spot: Spot, name: str) -> float:
    """Size of a difference with what the unreduced march itself leaves open, over the duration for times."""
    by = abs(spot.differences[name]) + abs((spot.numerical or {}).get(name, 0.0))
    lasts = (spot.unreduced or {}).get("duration", np.nan)
    return by / lasts if name in TIMES else by


def _apart(name: str, reduced: float, unreduced: float) -> float:
    if name in TIMES or unreduced == reduced:
        return unreduced - reduced
    return (unreduced - reduced) / abs(unreduced) if unreduced else np.inf
