"""N5 at a listener of a run, in other runs of its model: repeated ones, and those with a change."""

from __future__ import annotations

from collections.abc import Sequence

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.sound.forced import lead
from creak.sound.zwicker_tables import RATE
from creak.studies.sound.heard import heard_of
from creak.studies.sound.radiation import Radiation, record_of
from creak.studies.sound.source import source_of


def n5_of(
    background: FloatArray | None,
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
    record = record_of(source, source.groups(groups), to)
    record[-1] = record.sum(axis=0)
    heard = [heard_of(x, window, background, lead(RATE, to.band)) for x in record]
    return [h.n5 if background is None else h.n5_added for h in heard]
