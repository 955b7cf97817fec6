"""How high the load reaches, and what [reduction] f_max = "auto" begins with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.dynamics.loads import Loads
from creak.studies.file.reader import Study
from creak.studies.file.signals.course import RecordTable
from creak.studies.prepare.excitation import end_of, highest_frequency

POWER = 0.99
"""Share of a sampled load's power below its highest frequency."""
START = 11.0
"""f_max that "auto" begins with over the highest frequency of the excitation (docs/guidelines.md)."""


@dataclass(frozen=True)
class Excitation:
    """How high the load reaches."""

    frequency: float
    """Hz"""
    source: str
    """"stated", "sampled" (99 % of the power lies below) or "assumed" (the verification's mac_f_max)."""


def first_f_max(study: Study, loads: Loads) -> float:
    """[reduction] f_max, Hz; of "auto" the one that it begins with. A run is no shorter than a period of its load."""
    given = study.config.reduction.f_max
    if given != "auto":
        return given
    return START * max(excitation_of(study, loads).frequency, 1.0 / end_of(study))


def excitation_of(study: Study, loads: Loads) -> Excitation:
    """The highest frequency of the load: stated, found in its samples, or assumed.

    Samples of records, tables and steps: the frequency below which 99 % of the power of the force, of the acceleration
    (where that is given) or of the velocity lies, the mean left out. The acceleration of a displacement given by points
    would show the points themselves.
    """
    stated = highest_frequency(study)
    if all(t.signal.stated for t in study.config.excitation.values()) and stated > 0.0:
        return Excitation(stated, "stated")
    sampled = max((_reach(x, loads.step) for x in _samples(study, loads)), default=0.0)
    if max(stated, sampled) > 0.0:
        return Excitation(max(stated, sampled), "stated" if stated >= sampled else "sampled")
    return Excitation(study.config.verification.mac_f_max, "assumed")


def _samples(study: Study, loads: Loads) -> Iterator[FloatArray]:
    """(n_time,) of each excitation that moves something, then of each force."""
    tables = [t for t in study.config.excitation.values() if t.kind != "force"]
    for j, table in enumerate(tables):
        given = table.kind == "acceleration" or isinstance(table.signal, RecordTable)
        yield loads.support[2 if given else 1, :, j]
    yield from loads.force.T


def _reach(x: FloatArray, step: float) -> float:
    power = np.abs(np.fft.rfft(x - x.mean())) ** 2
    total = np.cumsum(power)
    if total[-1] <= 1e-20 * x.size * float(x @ x):
        return 0.0
    return float(np.fft.rfftfreq(x.size, step)[np.searchsorted(total, POWER * total[-1])])
