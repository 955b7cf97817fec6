"""At which steps of a run what is kept, which stretch of it is compared, and settings that leave nothing of it."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.studies.file.reader import Study
from creak.studies.prepare.excitation import period_of
from creak.studies.warned import Warned


def check_outputs(study: Study, time: FloatArray, pairs: int) -> list[str]:
    """Refuse outputs that a run cannot have, before it is made; warnings of what they cannot show.

    Parameters
    ----------
    time : ends of the whole steps. pairs : how many the study compares.

    Raises
    ------
    InputError : an interval that is no multiple of the step or longer than the run, a field that starts after it; with
        pairs, fewer than two outputs in the verification window, or no line of their spectra up to f_max.
    """
    table, f_max, step = study.config.output, study.config.verification.f_max, study.config.time.step
    field_steps(study, time)
    interval, end = output_every(study) * step, float(time[-1])
    for key, value in (("interval", table.interval), ("field_interval", table.field_interval)):
        if value is not None and value > end * (1.0 + 1e-9):
            raise InputError(
                f"{key} = {value:g} s is longer than the run, which ends at {end:g} s",
                where=study.places.where("output", key),
                expected="several intervals in a run",
                fix="Shorten it.",
            )
    start, end = excitation_window(study, time)
    if not pairs:
        return []
    if (end - start) / interval < 2.0 - 1e-6:
        raise InputError(
            f"interval = {interval:g} s leaves fewer than two outputs in the {end - start:g} s that are compared",
            where=study.places.where("output", "interval"),
            expected=f"at most {0.5 * (end - start):g} s",
            fix="Shorten it.",
        )
    if f_max * (end - start) < 1.0 - 1e-6:
        raise InputError(
            f"f_max = {f_max:g} Hz lies below the first line of the spectra of the {end - start:g} s that are compared",
            where=study.places.where("verification", "f_max"),
            expected=f"{1.0 / (end - start):g} Hz or more",
            fix="Raise it, or make the run longer.",
        )
    if table.interval is not None and interval > step and f_max > 0.5 / interval * (1.0 + 1e-9):
        return [
            Warned(
                f"[output] interval = {interval:g} s holds frequencies up to {0.5 / interval:g} Hz: the spectra and "
                f"their fit end there, below [verification] f_max = {f_max:g} Hz"
            )
        ]
    return []


def output_every(study: Study) -> int:
    """Steps between outputs.

    Raises
    ------
    InputError : an interval shorter than the step, or no multiple of it.
    """
    interval = study.config.output.interval
    return 1 if interval is None else _steps(study, "interval", interval)


def field_steps(study: Study, time: FloatArray) -> IntArray:
    """Whole steps, of those that end at `time`, at which the motion of all nodes is written.

    Raises
    ------
    InputError : an interval shorter than the step, or no multiple of it; a start after the end of the run.
    """
    table = study.config.output
    if table.field_interval is None:
        return np.zeros(0, dtype=np.int64)
    every = _steps(study, "field_interval", table.field_interval)
    first = int(np.searchsorted(time, table.field_start - 1e-9 * study.config.time.step))
    if first >= time.size:
        raise InputError(
            f"field_start = {table.field_start:g} s",
            where=study.places.where("output", "field_start"),
            expected=f"a time within the run, which ends at {time[-1]:g} s",
            fix="Start earlier.",
        )
    return np.arange(first, time.size, every, dtype=np.int64)


def _steps(study: Study, key: str, interval: float) -> int:
    step = study.config.time.step
    every = round(interval / step)
    if every < 1 or abs(every * step - interval) > 1e-6 * interval:
        raise InputError(
            f"{key} = {interval:g} s",
            where=study.places.where("output", key),
            expected=f"a multiple of the step, {step:g} s",
            fix=f"Use {max(every, 1) * step:g}.",
        )
    return every


def excitation_window(study: Study, time: FloatArray) -> tuple[float, float]:
    """The time span that verification looks at: the last period, or all of a run without one."""
    period, end = period_of(study), float(time[-1])
    return (end - period, end) if period is not None and period < end else (0.0, end)


def compared_end(study: Study, end: float) -> float:
    """s up to which the unreduced model is run beside the reduced one; the whole run unless the study says less."""
    c = study.config
    until = c.reference.until if c.proof == "whole" and c.reduction.method != "none" else None
    return end if until is None or until >= end * (1.0 - 1e-9) else until


def shown_window(study: Study, time: FloatArray) -> tuple[float, float]:
    """`excitation_window` up to `compared_end`: what the page shows event by event."""
    end = compared_end(study, float(time[-1]))
    return excitation_window(study, time[: max(2, int(np.searchsorted(time, end * (1.0 + 1e-9), side="right")))])
