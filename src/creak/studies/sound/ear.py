"""N5 at a listener of a run, in other runs of its model: repeated ones, and those with a change."""

from __future__ import annotations

from collections.abc import Sequence

from creak.arrays import IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.studies.prepare.setup import Setup
from creak.studies.sound.background import background_of
from creak.studies.sound.heard import heard_of
from creak.studies.sound.radiation import Radiation, pressure_of
from creak.studies.sound.source import source_of


def n5_of(
    setup: Setup,
    window: tuple[float, float],
    system: System,
    gaps: GapOperator,
    history: History,
    groups: Sequence[IntArray],
    to: Radiation,
) -> list[float | None]:
    """N5 of the forces of each group of channels by itself and, last, of all, as places are ranked by it.

    With a background it is what they add to it. None: beyond what ISO 532-1 covers.
    """
    source = source_of(system, gaps, history)
    if not source.channel.size:
        return [0.0] * (len(groups) + 1)
    pressure = pressure_of(source, source.groups(groups), to)
    pressure[-1] = pressure.sum(axis=0)
    background = background_of(setup.study)
    heard = [heard_of(x, window, background) for x in pressure]
    return [h.n5 if background is None else h.n5_added for h in heard]
