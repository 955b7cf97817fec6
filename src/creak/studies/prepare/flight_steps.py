"""Steps that follow from a study's accuracy: how often motion is written, and how long a flight step may be."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from creak.dynamics.flow.march import SAMPLES
from creak.dynamics.flow.resolution import FINE, QUICK, SETTLED, Resolution
from creak.studies.file.case import Driving
from creak.studies.file.config import VerificationTable
from creak.studies.file.reader import Study
from creak.studies.file.signals.course import RecordTable, TableTable
from creak.studies.file.tables import read_signal
from creak.studies.prepare.excitation import highest_frequency

WRITTEN_PER_PERIOD = 2.0
"""Instants written in a period of the verification's f_max."""
FASTEST = 100.0
"""Longest flight step over the shortest: loads whose samples are closer are followed as closely as that."""
PER_PERIOD = 10.0
"""Flight steps in a period of the excitation, and of the modes that are compared: a cubic through four samples is then
within 1e-4 of a sine."""
WRITTEN = 1000.0
"""Instants written of a short run."""
RESOLUTIONS: dict[str, Resolution] = {"quick": QUICK, "settled": SETTLED, "fine": FINE}
"""Of [time] accuracy."""


def with_flight_steps(study: Study) -> Study:
    """The study with the steps that its accuracy asks for; one with a forced step is returned as it is.

    `[time] step` becomes the flight step, `substeps` its samples of the loads, `[output] interval` a number.

    Raises
    ------
    InputError : no end of the run.
    """
    c = study.config
    if not c.time.exact:
        return study
    wanted, course = _resolved(study.driving, c.verification), study.course
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
    return replace(study, config=c.model_copy(update=tables))


def _resolved(driving: Driving, v: VerificationTable) -> float:
    """s of a flight step that follows what is compared and the excitations: their highest frequency, their samples."""
    longest = min(1.0 / (WRITTEN_PER_PERIOD * v.f_max), 1.0 / (PER_PERIOD * v.mac_f_max))
    highest = highest_frequency(driving)
    steps = [1.0 / (PER_PERIOD * highest)] if highest else []
    for name, table in driving.excitations.items():
        signal = table.signal
        steps += [] if signal.resolving is None else [signal.resolving]
        if isinstance(signal, TableTable) and signal.values is not None:
            time = np.array([point[0] for point in signal.values])
        elif isinstance(signal, TableTable | RecordTable) and signal.file is not None:
            path, where = driving.places.sibling(signal.file), driving.places.where("excitation", name, "signal")
            time, _ = read_signal(path, signal.channel, where)
        else:
            continue
        steps += [float(np.median(np.diff(time)))] if time.size > 1 else []
    return max(min([longest, *steps]), longest / FASTEST)
