"""Which numbers of a study would bring its modes to those of a test: sensitivities, and an update by least squares."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, NumericalError
from creak.formats.decks import read_model
from creak.formats.measured.mode_files import read_measured_modes
from creak.progress import Progress, silent
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import Study
from creak.studies.models.correlation import Correlation
from creak.studies.models.trials import (
    Parameter,
    Trial,
    UpdateCase,
    candidates,
    correlated,
    partners,
    read_parameters,
    slopes,
    start_of,
    tried,
)
from creak.studies.prepare.sensors import read_sensor_map
from creak.studies.unraised import none_ignored
from creak.verify.bounded_fit import Fit, bounded_fit

SIGMA = 0.01
"""Standard deviation of measured frequencies, as a share, where nobody says another."""
ROUNDS = 3
"""Fits at most, each with the pairs that the one before has found."""
OF_ONE = 0.75
"""Mean MAC of the pairs below which a test is taken for that of another structure."""
UNMOVED = 1e-9
"""Slope below which a parameter moves nothing."""
PHASE = "fit the parameters"
DIGITS = 7
"""Of the values that are written."""
WIDEST = 100.0
"""Half width of an interval of ln p that is told: what is wider is not determined."""


@dataclass(frozen=True)
class Sensitivities:
    """How the paired modes follow every number that can change."""

    before: Correlation
    keys: tuple[str, ...]
    values: FloatArray
    """(n_key,)"""
    slopes: FloatArray
    """(n_pair, n_key) d(ln f)/d(ln p)"""

    @property
    def differences(self) -> FloatArray:
        """(n_pair,) f_model / f_test - 1"""
        return np.array([p.difference for p in self.before.pairs])

    @property
    def best_factors(self) -> FloatArray:
        """(n_key,) factor of each key, alone, that leaves least of the differences, to first order."""
        size = np.einsum("ij,ij->j", self.slopes, self.slopes)
        along = -np.log1p(self.differences) @ self.slopes
        return np.exp(np.divide(along, size, out=np.zeros(size.size), where=size > UNMOVED**2))

    @property
    def left(self) -> FloatArray:
        """(n_key,) root mean square of the differences that would be left, to first order."""
        rest = np.log1p(self.differences)[:, None] + self.slopes * np.log(self.best_factors)
        return np.asarray(np.sqrt((rest**2).mean(axis=0)))

    @property
    def ranked(self) -> list[int]:
        """Keys, the one that would mend most first."""
        return [int(k) for k in np.argsort(self.left, kind="stable")]

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON; modes count from 1."""
        pairs = [{"test": p.test + 1, "frequency_test": p.frequency_test} for p in self.before.pairs]
        keys = [
            {
                "key": self.keys[k],
                "value": float(self.values[k]),
                "best_factor": float(self.best_factors[k]),
                "left": float(self.left[k]),
                "slopes": self.slopes[:, k].tolist(),
            }
            for k in self.ranked
        ]
        return {"pairs": pairs, "sensitivities": keys, "correlation": self.before.as_dict()}


@dataclass(frozen=True)
class Estimate:
    """What a parameter became."""

    key: str
    start: float
    value: float
    low: float
    """End of the 95 % interval; nan where it stopped at a bound."""
    high: float
    on_bound: bool


@dataclass(frozen=True)
class ModelUpdate:
    """A study changed so that its modes lie as near to those of a test as its parameters allow."""

    study: Study
    """With the new values."""
    sigma: float
    before: Correlation
    after: Correlation
    tracked: tuple[int, ...]
    """Rows of the measured modes that were fitted."""
    fit: Fit
    """In ln p, and residuals (f_model / f_test - 1) / sigma."""
    estimates: tuple[Estimate, ...]

    @property
    def lost(self) -> list[int]:
        """Measured modes that had a partner before and have none after."""
        return sorted({p.test for p in self.before.pairs} - {p.test for p in self.after.pairs})

    @property
    def gained(self) -> list[int]:
        """Measured modes that have a partner after and had none before."""
        return sorted({p.test for p in self.after.pairs} - {p.test for p in self.before.pairs})

    @property
    def settled(self) -> bool:
        """Whether the modes that were fitted are those that have a partner after the fit."""
        return {p.test for p in self.after.pairs} == set(self.tracked)

    @property
    def off(self) -> tuple[FloatArray, FloatArray]:
        """f_model / f_test - 1 before and after, of the modes that have a partner in both."""
        both = [{p.test: p.difference for p in c.pairs} for c in (self.before, self.after)]
        common = sorted(both[0].keys() & both[1].keys())
        before, after = (np.array([of[k] for k in common]) for of in both)
        return before, after

    @property
    def unexplained(self) -> tuple[float, float]:
        """Root mean square of `off`."""
        before, after = (float(np.sqrt(np.mean(x**2))) if x.size else math.nan for x in self.off)
        return before, after

    @property
    def foretold(self) -> float:
        """Root mean square by which modes are off as the others foretell them; nan where a parameter hangs on one."""
        return float(self.sigma * np.sqrt(np.mean(self.fit.foretold**2)))

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON; modes count from 1."""
        before, after = self.unexplained
        return {
            "sigma": self.sigma,
            "parameters": [
                {
                    "key": e.key,
                    "before": e.start,
                    "after": e.value,
                    "low_95": e.low,
                    "high_95": e.high,
                    "at_bound": e.on_bound,
                }
                for e in self.estimates
            ],
            "parameter_correlation": self.fit.correlation.tolist(),
            "slopes": (self.sigma * self.fit.jacobian).tolist(),
            "fitted": [k + 1 for k in self.tracked],
            "rms_before": before,
            "rms_after": after,
            "rms_foretold": self.foretold,
            "lost": [k + 1 for k in self.lost],
            "gained": [k + 1 for k in self.gained],
            "before": self.before.as_dict(),
            "after": self.after.as_dict(),
        }


def update_case(
    study: Study,
    test: Path,
    *,
    test_units: str | None = None,
    sensors: Path | None = None,
    ignore: Sequence[str] = (),
    closed: Sequence[str] = (),
) -> UpdateCase:
    """A study and the modes of a test.

    Parameters
    ----------
    test_units, ignore : as `deck_beside_test`. sensors : CSV file with the header sensor,node.
    closed : contacts, connectors and clips that stay closed in the test.

    Raises
    ------
    InputError : a file is wrong, or the test holds no modes.
    """
    measured = read_measured_modes(test)
    model = read_model(study.places.sibling(study.config.model.deck))
    mapped = read_sensor_map(sensors, model, measured)
    return UpdateCase(study, model, measured, test_units, mapped, ignore, closed)


@none_ignored()
def sensitivities(case: UpdateCase, progress: Progress = silent) -> Sensitivities:
    """How the paired modes follow every number that can change; nothing is changed.

    Raises
    ------
    InputError : anything wrong in study, deck or test, or no measured mode has a partner.
    NumericalError : the modes could not be found.
    """
    trial = tried(case, {})
    before = correlated(case, trial)
    every = {key: start_of(case.study, case.model, key) for key in candidates(case.study, case.model)}
    columns = []
    for k, (key, value) in enumerate(every.items()):
        progress("sensitivities", k, len(every))
        columns.append(slopes(case, trial, {}, {key: value}))
    progress("sensitivities", len(every), len(every))
    rows = [p.model for p in before.pairs]
    found = np.hstack(columns)[rows] if columns else np.zeros((len(rows), 0))
    moving = np.flatnonzero(np.abs(found).max(axis=0, initial=0.0) >= UNMOVED)
    keys = tuple(list(every)[k] for k in moving.tolist())
    return Sensitivities(before, keys, np.array([every[key] for key in keys]), found[:, moving])


@none_ignored()
def update(
    case: UpdateCase, chosen: Sequence[str], *, sigma: float = SIGMA, progress: Progress = silent
) -> ModelUpdate:
    """Find the values of some keys that bring the frequencies of paired modes to the measured ones.

    sum ((f_model / f_test - 1) / sigma)^2 is least between the bounds, over the logarithms of the parameters. Partners
    are followed by MAC at each step; modes that have found a partner or lost it at the end join the fit or leave it.

    Parameters
    ----------
    chosen : `KEY` or `KEY=LOW:HIGH`. sigma : standard deviation of the measured frequencies, as a share.

    Raises
    ------
    InputError : as `read_parameters` and `sensitivities`; more parameters than pairs; one that moves no mode.
    NumericalError : modes could not be found, or fewer pairs than parameters are left.
    """
    parameters = read_parameters(case.study, case.model, chosen)
    if not parameters or not 0.0 < sigma < 1.0:
        given = f"sigma = {sigma:g}" if parameters else "no parameters"
        raise InputError(given, expected="a key or more that may change, and 0 < sigma < 1", fix="Give them.")
    progress(PHASE, 0, 1)
    search = _Search(case, parameters, sigma)
    before = search.before
    _require_pairs(case, before, parameters)
    _require_moved(search)
    x = search.start
    tests = tuple(p.test for p in before.pairs)
    for _ in range(ROUNDS):
        fit = search.fitted(x, tests)
        x, after = fit.x, correlated(case, search.trial(fit.x))
        fitted, tests = tests, tuple(p.test for p in after.pairs)
        if tests == fitted:
            break
        if len(tests) < len(parameters):
            raise NumericalError(
                f"only {len(tests)} of {len(fitted)} pairs are left after the update of {len(parameters)} parameters: "
                "give closer bounds, or fewer parameters"
            )
    progress(PHASE, 1, 1)
    values = search.values(x)
    changed = with_changes(case.study, {key: float(f"{v:.{DIGITS}g}") for key, v in values.items()})
    estimates = tuple(
        Estimate(p.key, p.start, v, v * math.exp(-min(h, WIDEST)), v * math.exp(min(h, WIDEST)), bool(b))
        for p, v, h, b in zip(parameters, values.values(), fit.half_width.tolist(), fit.on_bound, strict=True)
    )
    return ModelUpdate(changed, sigma, before, after, fitted, fit, estimates)


class _Search:
    """Modes and slopes at any x = ln p. The last ones are kept, and each trial takes from them what did not change."""

    def __init__(self, case: UpdateCase, parameters: Sequence[Parameter], sigma: float) -> None:
        self.case, self.parameters, self.sigma = case, parameters, sigma
        self.low, self.high = (np.log([getattr(p, end) for p in parameters]) for end in ("low", "high"))
        self.start = np.log([p.start for p in parameters])
        self._at, self._trial = self.start, tried(case, {})
        self._slopes: FloatArray | None = None
        self.before = correlated(case, self._trial)

    def values(self, x: FloatArray) -> dict[str, float]:
        """Key -> value."""
        return {p.key: v for p, v in zip(self.parameters, np.exp(x).tolist(), strict=True)}

    def trial(self, x: FloatArray) -> Trial:
        """The structure at x with its modes."""
        if not np.array_equal(x, self._at):
            self._trial = tried(self.case, self.values(x), self._trial.joined)
            self._at, self._slopes = x.copy(), None
        return self._trial

    def slopes(self, x: FloatArray) -> FloatArray:
        """(n_mode, n) d(ln f)/dx"""
        trial = self.trial(x)
        if self._slopes is None:
            self._slopes = slopes(self.case, trial, self.values(x), self.values(x))
        return self._slopes

    def fitted(self, x: FloatArray, tests: Sequence[int]) -> Fit:
        """The fit of some measured modes, begun at x."""
        freq = self.case.measured.frequencies[list(tests)]

        def ratio(x: FloatArray) -> tuple[IntArray, FloatArray]:
            own = partners(self.case, self.before.sensors, self.trial(x), tests)
            return own, self.trial(x).found.frequencies[own] / freq

        def residuals(x: FloatArray) -> FloatArray:
            return np.asarray((ratio(x)[1] - 1.0) / self.sigma)

        def jacobian(x: FloatArray) -> FloatArray:
            own, r = ratio(x)
            return np.asarray(r[:, None] * self.slopes(x)[own] / self.sigma)

        return bounded_fit(residuals, jacobian, x, self.low, self.high)


def _require_pairs(case: UpdateCase, before: Correlation, parameters: Sequence[Parameter]) -> None:
    mean = float(np.mean([p.mac for p in before.pairs]))
    if mean < OF_ONE:
        raise InputError(
            f"the shapes of {len(before.pairs)} pairs agree too little to follow them: their mean MAC is {mean:.2f}",
            where=case.measured.path,
            expected=f"{OF_ONE:g} or more, as of modes of one structure",
            fix="Is it the test of this structure, with the same supports? `creak modes --test` shows the pairs.",
        )
    if len(parameters) > len(before.pairs):
        raise InputError(
            f"{len(parameters)} parameters are more than the {len(before.pairs)} measured modes with a partner: many "
            "values would fit",
            where=case.measured.path,
            expected="fewer parameters than pairs",
            fix="Leave parameters out, or measure more modes.",
        )


def _require_moved(search: _Search) -> None:
    every, pairs = np.abs(search.slopes(search.start)), [p.model for p in search.before.pairs]
    for p, column in zip(search.parameters, every.T, strict=True):
        if column[pairs].max() >= UNMOVED:
            continue
        most = int(column.argmax())
        freq = search.trial(search.start).found.frequencies
        other = f"; of the others most mode {most + 1} at {freq[most]:.4g} Hz, which the test does not have"
        why = other if column[most] >= UNMOVED else ": no stiffness and no mass depends on it"
        raise InputError(
            f"{p.key} moves no mode that has a partner{why}",
            where=search.case.study.path,
            expected="a number that stiffness or mass of the linear structure depends on; contact is open in it unless "
            "--closed names it",
            fix="`creak update` without --parameter lists those that move them.",
        )
