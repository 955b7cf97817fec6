"""What a study should hear of its measured records before it runs: when they move something, how well, and which of
their samples are wrong."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from creak.arrays import IntArray
from creak.dynamics.loads import Loads
from creak.signals import faults
from creak.signals.sources import Record
from creak.studies.file.case import Driving
from creak.studies.prepare.excitation import records_of

STANDS = 0.02
"""Share of a run that a record may leave out at its beginning and at its end: it may be a few samples."""
KNOWN = 0.02
"""Share of its displacement up to which a record is known in its middle."""


def record_warnings(driving: Driving, loads: Loads) -> list[str]:
    """Records that cover another time than the run, are too short for the displacement that is made of them, or whose
    samples are not what was to be measured."""
    end, names = float(loads.time[-1]), list(driving.moving)
    texts = [text for name, r in records_of(driving, driving.forcing).items() for text in _of_force(name, r, end)]
    for name, record in records_of(driving, driving.moving).items():
        moves = loads.time[loads.support[:, :, names.index(name)].any(axis=0)]
        begins, ends = float(record.time[0]), float(record.time[-1])
        if not np.ptp(record.value):
            texts.append(
                f"the record of [excitation.{name}] moves nothing: it is {record.value[0] + 0.0:.4g} throughout. Name "
                "another channel or file"
            )
            continue
        texts += [f"the record of [excitation.{name}] {text}" for text in _faults(record)]
        if not moves.size:
            texts.append(
                f"[excitation.{name}] is zero throughout the run: its record holds {begins:.4g} to {ends:.4g} s, the "
                f"run 0 to {end:.4g} s. Shift its times to begin at 0"
            )
            continue
        if moves[0] > STANDS * end:
            texts.append(
                f"the record of [excitation.{name}] begins at {begins:.4g} s: nothing moves before, and rates are "
                f"those of the whole run to {end:.4g} s. Shift its times to begin at 0"
            )
        if moves[-1] < (1.0 - STANDS) * end:
            texts.append(
                f"the record of [excitation.{name}] ends at {ends:.4g} s, the run at {end:g} s: the motion fades "
                "out there, and nothing moves it any more"
            )
        if (share := record.wrapped) > KNOWN:
            texts.append(
                f"the displacement made of the record of [excitation.{name}] is off by some {100.0 * share:.2g} % in "
                f"its middle, and by more near its ends: it is {(ends - begins) * record.high_pass:.3g} / high_pass "
                "long, and its ends do not meet. Take a longer record, or one of whole periods"
            )
    return texts


def _of_force(name: str, record: Record, end: float) -> Iterator[str]:
    """Of a force, which outside its record stays at the first and the last sample."""
    first, last = record.value[[0, -1]]
    if record.time[0] > STANDS * end and abs(first) > STANDS * np.abs(record.value).max():
        yield (
            f"the record of [excitation.{name}] begins at {record.time[0]:.4g} s with a force of {first:.4g}, which "
            "acts from 0 on. Shift its times to begin at 0, or let it begin with zero"
        )
    if record.time[-1] < (1.0 - STANDS) * end and abs(last) > STANDS * np.abs(record.value).max():
        yield (
            f"the record of [excitation.{name}] ends at {record.time[-1]:.4g} s with a force of {last:.4g}, which acts "
            f"on until the run ends at {end:g} s. Let the run end with it, or let it end with zero"
        )


def _faults(record: Record) -> Iterator[str]:
    x = record.value
    if (still := faults.dropouts(x)).size:
        yield (
            f"stands still {_longest(record, still)}, and jumps there: the sensor may have dropped out. Take "
            "a stretch without it, or measure again"
        )
    if (cut := faults.cut_off(x)).size:
        yield (
            f"is cut off {_longest(record, cut)}: the sensor or its amplifier was at its limit, and the peaks "
            "were higher. Measure again with a larger range"
        )
    if (alone := faults.spikes(x)).size:
        yield (
            f"has {alone.size} sample{'s' * (alone.size > 1)} far beyond all others, the first {x[alone[0]]:.4g} at "
            f"{record.time[alone[0]]:.6g} s: no motion is that short. Replace by the mean of the samples beside"
        )
    elif faults.reaches_top(x):
        yield (
            f"reaches up to the {0.5 / record.step:.4g} Hz that samples {record.step:.4g} s apart can hold: what "
            "vibrated faster is missing, or was folded into lower frequencies if no filter kept it out. Sample faster, "
            "or filter it where it is the noise of the sensor"
        )


def _longest(record: Record, stretches: IntArray) -> str:
    first, last = stretches[np.diff(stretches)[:, 0].argmax()]
    often = "once," if len(stretches) == 1 else f"{len(stretches)} times, longest"
    return f"{often} at {record.value[first]:.4g} from {record.time[first]:.6g} to {record.time[last]:.6g} s"
