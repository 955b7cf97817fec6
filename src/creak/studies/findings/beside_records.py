"""Time histories of a test over those of a run: displacement, acceleration, gap and force by name."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.measured.files import is_measured
from creak.formats.measured.histories import AXES, Histories, read_histories
from creak.formats.measured.modes import ACCELERANCE, RECEPTANCE, Channel
from creak.formats.measured.unit_words import BARE, MOTIONS, NEWTONS, PASCALS, mixed_up, plain_unit
from creak.model.units import UNITS
from creak.signals.spectra import low_pass
from creak.studies.prepare.measurements import OF_CONTACT, TABLES, record_channels
from creak.studies.warned import Warned
from creak.verify.records import Course, Kind, RecordFit, fitted, shift_between
from creak.words import first_few

SAME_COURSE = 0.95
"""Correlation from which a difference in level is looked for a reason."""
STILL = 1e-3
"""Share of a step between outputs below which a shift in time is round-off."""
ALIKE = 0.5
"""Correlation below which the shift in time means little."""
SLOW = 3.0
"""Periods in the shorter record of the slowest motion that is kept where an acceleration is integrated."""
NAMED = 8
SAMPLES = 10.0
"""In a period of the highest frequency of a pressure."""
DROPPED = (
    "A contact that cannot close is dropped by the pre-check: name the file in a [test.NAME] of the study, which keeps "
    "its channels, or say [precheck] enabled = false, and run again."
)
OF_LINES = re.compile(r" relative [xyz]'?$")
OF_LINES_WORDS = ": motion of one side of an E-line against the other is not compared"


@dataclass(frozen=True)
class _Computed:
    name: str
    course: Course
    kind: Kind


@dataclass(frozen=True)
class RecordPair:
    """One channel of a test over what the run computed."""

    name: str
    unit: str
    fit: RecordFit


@dataclass(frozen=True)
class RecordFits:
    """A test's time histories over a run's."""

    run: str
    shift: float
    """s that are added to the times of the test."""
    pairs: tuple[RecordPair, ...]
    notes: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON."""
        return {
            "run": self.run,
            "shift": self.shift,
            "channels": [
                {
                    "name": p.name,
                    "unit": p.unit,
                    "fit": p.fit.fit,
                    "correlation": p.fit.correlation,
                    "rms_test": p.fit.rms[0],
                    "rms_model": p.fit.rms[1],
                    "events_test": None if p.fit.events is None else [list(e) for e in p.fit.events[0]],
                    "events_model": None if p.fit.events is None else [list(e) for e in p.fit.events[1]],
                }
                for p in self.pairs
            ],
            "notes": list(self.notes),
        }


@dataclass(frozen=True)
class RecordComparison(RecordFits):
    """A file of time histories over the results of a run."""

    results: Path = field(kw_only=True)
    test: Path = field(kw_only=True)

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON."""
        return {"results": str(self.results), "test": self.test.name, **super().as_dict()}


def holds_records(path: Path) -> bool:
    """Whether a path is a file of time histories by its ending, and no folder."""
    return (is_measured(path) or path.suffix.lower() in TABLES) and not path.is_dir()


def compare_records(results: Path, test: Path, f_max: float, run: str | None = None) -> RecordComparison:
    """The time histories of a file over those of a run, aligned by one shift in time.

    Channels are named as what they measure: `1017 Z` a node's displacement (or its acceleration, by the unit),
    `flange gap` and `flange force` the smallest gap and the whole force of a contact, `flange:3 gap` and
    `flange:3 normal force` those of a channel. Functions of universal files go by node and direction.

    Parameters
    ----------
    results : folder that a run wrote. test : CSV, universal file (58) or RPC III. f_max : of the run's
        verification, Hz, by which contacts are merged into events. run : as `read_histories`.

    Raises
    ------
    InputError : a file is wrong; no channel is one of the run's, or its unit is of another quantity.
    """
    found = fit_records(read_histories(results / "results.h5", run), list(record_channels(test)), test, f_max)
    return RecordComparison(found.run, found.shift, found.pairs, found.notes, results=results, test=test)


def fit_records(histories: Histories, channels: Sequence[Channel], test: Path, f_max: float) -> RecordFits:
    """Time histories over those of a run, as `compare_records`, which raises the same.

    Parameters
    ----------
    channels : under the names of the run. test : their file, for messages.
    """
    computed = {c.name.lower(): c for c in _computed(histories)}
    found: list[tuple[_Computed, Course, bool]] = []
    others: list[str] = []
    for channel in channels:
        if (c := computed.get(channel.name.lower())) is None:
            others.append(repr(channel.name))
        else:
            found.append((c, *_measured(channel, c, histories, test)))
    if not found:
        raise _nothing_computed([c.name for c in channels], [c.name for c in computed.values()], test)
    notes = [_left_out(others)] if others else []
    both = [_without_slow(course, c.course) if rough else (course, c.course) for c, course, rough in found]
    shift = shift_between(both)
    units = UNITS[histories.units]
    pairs = []
    for (c, whole, rough), (course, model) in zip(found, both, strict=True):
        fit = fitted(course, model, shift, kind=c.kind, f_max=f_max)
        if fit is not None and rough:
            level = float(fit.model.mean() - fit.test.mean())
            fit = fitted(replace(course, values=course.values + level), model, shift, kind=c.kind, f_max=f_max)
        if fit is None:
            raise InputError(f"channel {c.name} and the run have fewer than four instants in common", where=test)
        pairs.append(RecordPair(c.name, units.force if c.kind == "force" else units.length, fit))
        if rough:
            lowest = 1.0 / _width(whole, c.course)
            notes.append(f"{c.name} is an acceleration: both are compared as displacement above {lowest:.3g} Hz")
    known = [p.fit.correlation for p in pairs if np.isfinite(p.fit.correlation)]
    alike = float(np.mean(known)) if known else 0.0
    still = abs(shift) <= STILL * float(np.diff(histories.time).mean())
    moved = "the test's times are the run's" if still else f"{shift:+.6g} s are added to the times of the test"
    notes.insert(0, f"{moved}, where the mean correlation is {alike:.2f}")
    notes += [text for p in pairs for text in _level_question(p)]
    if alike < ALIKE:
        notes.insert(1, "test and run are hardly alike: the shift in time means little")
    return RecordFits(histories.run, shift, tuple(pairs), tuple(notes))


def _level_question(p: RecordPair) -> Iterator[Warned]:
    """Which units may be mixed up, or what turned round, where two courses are one but for a factor."""
    test, model = float(p.fit.test.std()), float(p.fit.model.std())
    if p.fit.correlation <= -SAME_COURSE:
        yield Warned(f"{p.name} of the test is that of the run with the other sign: is its sensor turned round?")
    if abs(p.fit.correlation) >= SAME_COURSE and test > 0.0:
        for factor, what in mixed_up(model / test):
            times = f"{factor:g}" if model > test else f"1/{factor:g}"
            yield Warned(f"{p.name} of the run is {times} times that of the test: are {what} mixed up?")


def _nothing_computed(names: Sequence[str], known: Sequence[str], test: Path) -> InputError:
    fix = suggest(names[0], known) if names and known else "Name its columns so."
    return InputError(
        f"none of its {len(names)} channels is one that the run computed",
        where=test,
        expected=f"names as {first_few(known, NAMED)}" if known else "a run of watched nodes or contacts",
        fix=f"{fix if known else ''} {DROPPED if any(map(OF_CONTACT.fullmatch, names)) else ''}".strip(),
    )


def _left_out(names: Sequence[str]) -> str:
    told = first_few(names, NAMED)
    subject, verb = ("channel", "is") if len(names) == 1 else ("channels", "are")
    hint = f". {DROPPED}" if any(OF_CONTACT.fullmatch(name.strip("'")) for name in names) else ""
    nothing = "" if all(OF_LINES.search(name) for name in names) else f"nothing that the run computed and {verb} "
    return f"{subject} {told} {verb} {nothing}left out{hint}{OF_LINES_WORDS if not nothing else ''}"


def fit_pressures(
    heard: Mapping[str, Course], channels: Sequence[Channel], test: Path, top: float, run: str, shift: float | None
) -> RecordFits:
    """Sound pressure over that at listeners, both low-passed at `top` Hz, up to which each wave is computed.

    Parameters
    ----------
    heard : name of the channel, in small letters -> Pa. shift : s, of the other channels of the test; None: the one
        that aligns these is found.

    Raises
    ------
    InputError : a channel is in no unit of pressure, or does not overlap.
    """
    pairs: list[tuple[str, Course, Course]] = []
    for channel in channels:
        if (unit := plain_unit(channel.unit)) not in PASCALS:
            raise InputError(
                f"channel {channel.name!r} is in {channel.unit or 'no unit'}",
                where=test,
                expected="a pressure, as Pa",
                fix="Correct its unit or its name.",
            )
        measured = _narrow(Course(channel.time, PASCALS[unit] * channel.values), top)
        pairs.append((channel.name, measured, _narrow(heard[channel.name.lower()], top)))
    found = shift_between([(a, b) for _, a, b in pairs]) if shift is None else shift
    fits = []
    for name, measured, model in pairs:
        fit = fitted(measured, model, found, kind="motion", f_max=top)
        if fit is None:
            raise InputError(f"channel {name} and the run have fewer than four instants in common", where=test)
        fits.append(RecordPair(name, "Pa", fit))
    note = f"pressures are compared up to {top:.0f} Hz, as far as waves are computed"
    return RecordFits(run, found, tuple(fits), (note,))


def _narrow(course: Course, top: float) -> Course:
    """Without what is above a frequency, sampled for it."""
    step = float(course.time[1] - course.time[0])
    at = np.arange(course.time[0], course.time[-1], max(step, 1.0 / (SAMPLES * top)))
    return Course(at, np.interp(at, course.time, low_pass(course.values, step, top)))


def _computed(h: Histories) -> Iterator[_Computed]:
    for k, name in enumerate(h.node_names):
        for axis in range(3):
            yield _Computed(f"{name} {AXES[axis]}", Course(h.time, h.displacement[:, k, axis]), "motion")
    groups: dict[str, list[int]] = {}
    for k, name in enumerate(h.channels):
        groups.setdefault(name.rpartition(":")[0] or name, []).append(k)
        yield _Computed(f"{name} gap", Course(h.time, h.gap[:, k]), "gap")
        for what, force in (("normal", h.normal_force), ("peak", h.peak_force)):
            yield _Computed(f"{name} {what} force", Course(h.time, force[:, k]), "force")
    for group, rows in groups.items():
        yield _Computed(f"{group} gap", Course(h.time, h.gap[:, rows].min(axis=1)), "gap")
        yield _Computed(f"{group} force", Course(h.time, h.normal_force[:, rows].sum(axis=1)), "force")


def _measured(channel: Channel, c: _Computed, h: Histories, path: Path) -> tuple[Course, bool]:
    """The channel in the units of the run, and whether it was an acceleration."""
    unit, values = plain_unit(channel.unit), channel.values
    if not unit:
        return Course(channel.time, values), False
    order, size = MOTIONS.get(unit, (BARE.get(unit), 1.0 / UNITS[h.units].per_metre))
    if c.kind == "force" and unit in NEWTONS:
        return Course(channel.time, NEWTONS[unit] / UNITS[h.units].newton * values), False
    if c.kind != "force" and order == RECEPTANCE:
        return Course(channel.time, size * UNITS[h.units].per_metre * values), False
    if c.kind == "motion" and order == ACCELERANCE:
        course = Course(channel.time, size * UNITS[h.units].per_metre * values)
        return replace(course, values=displacement_of(course.values, channel.step)), True
    raise InputError(
        f"channel {channel.name!r} is in {channel.unit}",
        where=path,
        expected="a force, as N" if c.kind == "force" else "a length or an acceleration, as mm or m/s^2",
        fix="Correct its unit or its name.",
    )


def _width(test: Course, model: Course) -> float:
    """s of the mean that both lose: what is slower is not known of an integrated acceleration."""
    return min(float(c.time[-1] - c.time[0]) for c in (test, model)) / SLOW


def _without_slow(test: Course, model: Course) -> tuple[Course, Course]:
    """Both without what is slow, by the same filter. The mean of the test stays unknown: the sensor's zero is in it."""
    width = _width(test, model)
    filtered = [Course(*less_running_mean(c.time, c.values, width)) for c in (test, model)]
    return filtered[0], filtered[1]


def displacement_of(acceleration: FloatArray, step: float) -> FloatArray:
    """Twice the integral of evenly sampled values (n,), but for a constant and a slope: those of the least squares
    line are left out.

    A cubic spline is integrated: of a sine with ten samples a period one part in a thousand is lost.

    Parameters
    ----------
    step : s.
    """
    from scipy.interpolate import CubicSpline  # see `signals.spectra.low_pass`

    t = step * np.arange(acceleration.size)
    twice = CubicSpline(t, acceleration - acceleration.mean()).antiderivative(2)(t)
    return np.asarray(twice - np.polynomial.Polynomial.fit(t, twice, 1)(t))


def less_running_mean(time: FloatArray, values: FloatArray, width: float) -> tuple[FloatArray, FloatArray]:
    """Instants (k,) and values (k,) less their mean over `width` s around each, weighted by a Hann window.

    Half of a sine of 1 / width Hz is left. It has no delay, takes away any straight line, and what it gives hangs on
    no end of the record, for instants nearer to one than half the width are left out: two records of one motion give
    the same wherever both reach.

    Parameters
    ----------
    time : (n,) s, evenly spaced. width : s, less than the record.
    """
    from scipy.signal import fftconvolve

    step = float(time[-1] - time[0]) / (time.size - 1)
    side = int(0.5 * width / step)
    window = 1.0 + np.cos(2.0 * np.pi * step / width * np.arange(-side, side + 1))
    kept = slice(side, time.size - side)
    return time[kept], values[kept] - fftconvolve(values, window / window.sum(), mode="valid")
