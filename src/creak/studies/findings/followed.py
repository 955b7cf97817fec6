"""What each place of a run does in other runs of its model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.diagonal import is_modal
from creak.dynamics.history import History
from creak.studies.converge.settling import Followed
from creak.studies.findings.places import Place, channels_at, events_at, resting_places
from creak.studies.findings.sound import heard_places
from creak.studies.prepare.marching import Scope
from creak.studies.run.one_run import Run
from creak.studies.sound.ear import Ear, n5_of
from creak.studies.sound.heard import WHAT, Sound, n5_of_less, share_apart
from creak.verify.figures import OF_PLACE
from creak.verify.rubbing import Rub, rub_of

MOST_PLACES = 12
"""Places, the first ones, that are followed."""


@dataclass(frozen=True)
class _Places:
    """The places of the base run that are looked for in the repeated ones."""

    places: tuple[Place, ...]
    scope: Scope
    ear: Ear | None
    """Who hears them; None: there is no sound."""
    rub: tuple[Place, ...]
    """All places, and those that rest."""

    def figures(self, system: System, gaps: GapOperator, history: History) -> tuple[dict[str, float], ...]:
        """`OF_PLACE` of each place in a run; no N5 where there is no sound, or beyond what ISO 532-1 covers."""
        if not self.places:
            return ()
        groups = channels_at(self.places, self.scope.model, gaps, history)
        events = events_at(groups, self.scope, gaps, history)
        here = [replace(p, events=tuple(own)) for p, own in zip(self.places, events, strict=True)]
        heard: Sequence[float | None] = [None] * len(here)
        if self.ear is not None and is_modal(system):
            *heard, _ = n5_of(self.scope.window, system, gaps, history, groups, self.ear)
        return tuple(map(_figures, here, heard))

    def rubs(self, gaps: GapOperator, history: History) -> tuple[Rub, ...]:
        """Friction and lasting contact of each place in a run."""
        window, f_max = self.scope.window, self.scope.verification.f_max
        groups = channels_at(self.rub, self.scope.model, gaps, history)
        return tuple(rub_of(history, gaps, channels, window, f_max) for channels in groups)


def followed(scope: Scope, run: Run | None, sound: Sound | str | None) -> Followed:
    """The first places of the run that is repeated, ranked as they are told."""
    if run is None:
        return Followed()
    every = heard_places(scope, run, sound)
    places, rub = every[:MOST_PLACES], (*every, *resting_places(scope, run))
    ear, heard = None, list[float | None]([None] * len(places))
    band: tuple[float, ...] = ()
    ways: tuple[float, ...] = ()
    scatter: tuple[float, ...] = ()
    ends: tuple[float, str] | None = None
    if isinstance(sound, Sound) and sound.run == run.name:
        ear, heard = sound.ear, [h.rank[0] for h in sound.heard[0]]
        less = n5_of_less(sound, scope.window)[: len(places)]
        band = tuple(share_apart(a, b) for a, b in zip(heard, less, strict=False))
        ways, scatter = sound.ways[: len(places)], sound.scatter[: len(places)]
        ends = sound.band.high, WHAT[sound.band.limit]
    base = tuple(_figures(p, n5) for p, n5 in zip(places, heard, strict=False))
    here = _Places(places, scope, ear, rub)
    names, rubs = tuple((p.contact, p.number) for p in rub), tuple(p.rub for p in rub)
    impulses = tuple(tuple(e.impulse for e in p.events) for p in every)
    return Followed(base, here.figures, impulses, band, ways, scatter, ends, names, rubs, here.rubs)


def _figures(place: Place, n5: float | None) -> dict[str, float]:
    every = (float(len(place.events)), place.impulse, place.force, place.speed, n5)
    return {name: x for name, x in zip(OF_PLACE, every, strict=True) if x is not None and np.isfinite(x)}
