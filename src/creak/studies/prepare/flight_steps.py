"""Steps that follow from a study's accuracy: how often motion is written, and how long a flight step may be."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.dynamics.flow.march import SAMPLES
from creak.dynamics.flow.resolution import FINE, QUICK, SETTLED, Resolution
from creak.studies.file.case import Driving
from creak.studies.file.config import VerificationTable
from creak.studies.file.reader import Study
from creak.studies.file.signals.course import RecordTable, TableTable, columns
from creak.studies.file.tables import read_signal
from creak.studies.prepare.excitation import highest_frequency
from creak.studies.warned import Warned

WRITTEN_PER_PERIOD = 2.0
"""Instants written in a period of the verification's f_max."""
FASTEST = 100.0
"""Longest flight step over the shortest: loads whose samples are closer are followed as closely as that."""
PER_PERIOD = 10.0
"""Flight steps in a period of the excitation, and of the modes that are compared: a cubic through four samples is then
within 1e-4 of a sine."""
WRITTEN = 1000.0
"""Instants written of a short run."""
EVEN = 0.5
"""Share of the median spacing of points below which some stand closer than the others."""
LEAST = 1e-3
"""Height of a lobe that is followed, as a share of all that a signal spans."""
FEW = 20
"""Lobes that are followed one by one."""
PER_LOBE, FEWEST = 10.0, 2.5
"""Flight steps in a lobe at half its height, and how few of them are told."""
RESOLUTIONS: dict[str, Resolution] = {"quick": QUICK, "settled": SETTLED, "fine": FINE}
"""Of [time] accuracy."""


def with_flight_steps(study: Study) -> tuple[Study, list[str]]:
    """The study with the steps that its accuracy asks for, and warnings of what they do not follow; one with a forced
    step is returned as it is.

    `[time] step` becomes the flight step, `substeps` its samples of the loads, `[output] interval` a number.

    Raises
    ------
    InputError : no end of the run.
    """
    c = study.config
    if not c.time.exact:
        return study, []
    points, course = _wanted(study.driving), study.course
    wanted = _resolved(study.driving, c.verification, points)
    interval = c.output.interval
    if interval is None:
        most = min(wanted, course.end / WRITTEN)
        whole = c.output.field_interval or min(course.period or course.end, course.end)
        interval = whole / math.ceil(whole / most * (1.0 - 1e-9))
    step = interval / math.ceil(interval / wanted * (1.0 - 1e-9))
    tables = {
        "time": c.time.model_copy(update={"integrator": "exact", "step": step, "substeps": SAMPLES}),
        "output": c.output.model_copy(update={"interval": interval}),
    }
    return replace(study, config=c.model_copy(update=tables)), _unfollowed(study.driving, step, points)


def _unfollowed(driving: Driving, step: float, points: Mapping[str, float]) -> list[str]:
    """Excitations that change faster than flight steps follow; those whose frequencies are known are told by these."""
    return [
        Warned(
            f"[excitation.{name}] changes within {PER_LOBE * wanted:.2g} s, which flight steps of {step:.2g} s do not "
            "follow: what this moves may be wrong; a higher [verification] f_max makes them shorter"
        )
        for name, wanted in points.items()
        if FEWEST * step > PER_LOBE * wanted and not driving.excitations[name].signal.highest
    ]


def _resolved(driving: Driving, v: VerificationTable, points: Mapping[str, float]) -> float:
    """s of a flight step that follows what is compared and the excitations: their highest frequency, their `points`."""
    longest = min(1.0 / (WRITTEN_PER_PERIOD * v.f_max), 1.0 / (PER_PERIOD * v.mac_f_max))
    highest = highest_frequency(driving)
    steps = [1.0 / (PER_PERIOD * highest)] if highest else []
    return max(min([longest, *steps, *points.values()]), longest / FASTEST)


def _wanted(driving: Driving) -> dict[str, float]:
    """s of the longest flight step that follows each excitation whose frequencies do not tell it."""
    found = {}
    for name, table in driving.excitations.items():
        signal = table.signal
        if signal.resolving is not None:
            found[name] = signal.resolving
        elif isinstance(signal, TableTable) and signal.values is not None:
            found[name] = _between_points(*columns(signal.values))
        elif isinstance(signal, TableTable | RecordTable) and signal.file is not None:
            path, where = driving.places.sibling(signal.file), driving.places.where("excitation", name, "signal")
            found[name] = _between_points(*read_signal(path, signal.channel, where))
    return found


def _between_points(time: FloatArray, value: FloatArray) -> float:
    """s of a flight step that follows straight lines between points.

    The median of their spacing; where a few lobes are narrower than that, at half their height, a tenth of their width.
    Many are those of a record with uneven steps, which the median follows as it does even ones.
    """
    if time.size < 2:
        return np.inf
    between = np.diff(time)
    median, first, last = float(np.median(between)), 2.0 * time[0] - time[1], 2.0 * time[-1] - time[-2]
    if between.min() > EVEN * median:
        return median
    from scipy.signal import find_peaks, peak_widths  # half a second that other studies need not wait for

    time, value = np.concatenate([[first], time, [last]]), np.concatenate([[0.0], value, [0.0]])
    narrow, least = list[float](), LEAST * float(np.ptp(value))
    for side in (value, -value):
        peaks, _ = find_peaks(side, prominence=least)
        _, _, *ends = peak_widths(side, peaks)
        left, right = (np.interp(at, np.arange(time.size), time) for at in ends)
        narrow += (right - left)[right - left < median].tolist()
    return min(narrow) / PER_LOBE if 0 < len(narrow) <= FEW else median
