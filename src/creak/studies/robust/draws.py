"""What is drawn: causes and their values in every draw, from scrambled Sobol points."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import norm, qmc

from creak.arrays import BoolArray, FloatArray
from creak.errors import InputError, suggest
from creak.studies.design.clips import clip_scatter
from creak.studies.file.changes import checked_row, value_at
from creak.studies.file.places import Places
from creak.studies.file.scatter_tables import SIGMAS, Distribution, ScatterTable
from creak.verify.odds import Blocks

EDGE = 1e-12
"""Distance of a point from 0 and 1."""
KEPT = 0.9999
"""Share of a field's variance that its shapes hold; the rest is given back to them node by node. Correlations are then
off by some 5e-4. With 0.99 they are 0.04 too high, and the odds that one of many gaps closes too low by a fiftieth."""
SEEDS = 2**31
FURTHER = 1
"""Stream of the seed for draws that are foretold alone."""
LIMITS = ("lower", "upper")
"""Of a connector or clip: each is a stop of its own."""
OF_RUN = ("time", "verification", "scatter")
"""Tables of how long and how a run is looked at: all draws are counted in the one window of the study."""
BLOCK = 4_000_000
"""Numbers worked on at a time."""
ROUND_OFF = 1e-9
"""Of a gap: by so much its tolerance may be larger."""


class ContactGaps(NamedTuple):
    """The channels of a contact, whose gaps may be a field."""

    names: tuple[str, ...]
    places: FloatArray
    """(m, 3)"""
    gaps: FloatArray
    """(m,)"""
    nearest: BoolArray
    """(m,) to the nearest wall, for which a clearance holds."""


@dataclass(frozen=True)
class Cause:
    """One number of the study, or a field of gaps, that scatters."""

    key: str
    of: Distribution
    nominal: float
    """In the study; nan where it says none."""
    columns: slice
    """Of the unit points."""
    shapes: FloatArray | None = None
    """(m, k) of a field: gap = mean + shapes x, x independent standard normal."""
    mean: FloatArray | None = None
    """(m,) of a field."""
    names: tuple[str, ...] = ()
    """(m,) channels of a field."""

    @property
    def contact(self) -> str:
        """The contact that the key is of."""
        return self.key.split(".")[1]

    @property
    def is_factor(self) -> bool:
        """Whether it multiplies a stiffness that the elements give ("auto"), which the study has no number for."""
        return self.of.relative and math.isnan(self.nominal)

    def number(self, value: float) -> float | int:
        """A value as the study has it: seeds are whole."""
        return int(value) if self.of.type == "seed" else float(value)

    @property
    def moves_whole(self) -> bool:
        """Whether another number in the study moves all of the distribution and leaves its shape, but for `low` and
        `high`: normal ones and fields, about numbers between these."""
        d = self.of
        about = self.mean if self.mean is not None else d.mean if d.mean is not None else self.nominal
        inside = np.all((np.asarray(about) >= _or(d.low, -np.inf)) & (np.asarray(about) <= _or(d.high, np.inf)))
        return d.type in ("normal", "field") and not d.relative and bool(inside)

    @property
    def about(self) -> float:
        """The number about which it scatters: the mean of a normal distribution that moves with it, else the middle."""
        if self.moves_whole:
            return self.nominal if self.of.mean is None else self.of.mean
        return self.at(0.5)

    def at(self, share: float) -> float:
        """The number below which this share of what is drawn lies."""
        return float(self.values(np.full((1, self.columns.stop), share))[0])

    def values(self, unit: FloatArray) -> FloatArray:
        """(n,) numbers, or (n, m) gaps, from points (n, D) of the unit cube."""
        u = np.clip(unit[:, self.columns], EDGE, 1.0 - EDGE)
        d = self.of
        if self.shapes is not None and self.mean is not None:
            gaps = self.mean + norm.ppf(u) @ self.shapes.T
            return np.clip(gaps, 0.0 if d.low is None else d.low, np.inf if d.high is None else d.high)
        x = u[:, 0]
        if d.type == "seed":
            return np.floor(x * SEEDS)
        scale = self.nominal if d.relative and not self.is_factor else 1.0
        base = 1.0 if d.relative else self.nominal
        if d.type == "uniform":
            assert d.low is not None
            assert d.high is not None
            return scale * (d.low + x * (d.high - d.low))
        if d.type == "lognormal":
            median = base if d.median is None else d.median
            return np.asarray(scale * median * np.exp(d.deviation * norm.ppf(x)))
        mean = base if d.mean is None else d.mean
        ends = [norm.cdf((e - mean) / d.deviation) for e in (_or(d.low, -np.inf), _or(d.high, np.inf))]
        return np.asarray(scale * (mean + d.deviation * norm.ppf(ends[0] + x * (ends[1] - ends[0]))))


@dataclass(frozen=True)
class Design:
    """All draws: halves A and B, and where indices are wanted A with each cause from B."""

    causes: tuple[Cause, ...]
    n: int
    """Draws of A and B together."""
    indices: bool
    seed: int

    @property
    def total(self) -> int:
        return self.n + (self.n // 2 * len(self.causes) if self.indices else 0)

    def points(self) -> FloatArray:
        """(total, D) unit points: A, B, then those of each cause."""
        width = self.causes[-1].columns.stop
        half = self.n // 2
        both = qmc.Sobol(2 * width, scramble=True, seed=self.seed).random(half)
        A, B = both[:, :width], both[:, width:]
        blocks = [A, B]
        for cause in self.causes if self.indices else ():
            mixed = A.copy()
            mixed[:, cause.columns] = B[:, cause.columns]
            blocks.append(mixed)
        return np.concatenate(blocks)

    def further(self, n: int) -> Design:
        """Another one of n draws, independent of it."""
        return replace(self, n=n, seed=int(np.random.SeedSequence((self.seed, FURTHER)).generate_state(1)[0]))

    def blocks(self, figure: FloatArray, k: int) -> Blocks:
        """A figure (total,) of A, of B, and of A with cause k from B."""
        half = self.n // 2
        return figure[:half], figure[half : self.n], figure[self.mixed(k)]

    def mixed(self, k: int) -> slice:
        """Rows of the draws with cause k from B."""
        half = self.n // 2
        return slice(self.n + k * half, self.n + (k + 1) * half)


@dataclass(frozen=True)
class Draw:
    """Other numbers of a study."""

    number: int
    values: Mapping[str, Any]
    """Dotted key -> value."""
    fields: Mapping[str, FloatArray]
    """Contact -> (m,) gaps of its channels."""
    factors: Mapping[str, float] = field(default_factory=dict)
    """Contact -> factor on the stiffness that its elements give."""


@dataclass(frozen=True)
class Drawn:
    """The causes of a study at all points of a design. Fields are made where they are asked for."""

    causes: tuple[Cause, ...]
    points: FloatArray
    """(total, D) of the unit cube."""
    numbers: tuple[FloatArray | None, ...]
    """Of each cause (total,); None: it is a field."""

    @staticmethod
    def at(causes: tuple[Cause, ...], points: FloatArray) -> Drawn:
        """The causes at points of the unit cube."""
        return Drawn(causes, points, tuple(c.values(points) if c.shapes is None else None for c in causes))

    @property
    def total(self) -> int:
        return len(self.points)

    def draw(self, number: int) -> Draw:
        """One of them."""
        numbers, fields, factors = {}, {}, {}
        for cause, column in zip(self.causes, self.numbers, strict=True):
            if column is None:
                fields[cause.contact] = cause.values(self.points[number : number + 1])[0]
            elif cause.is_factor:
                factors[cause.contact] = float(column[number])
            else:
                numbers[cause.key] = cause.number(column[number])
        return Draw(number, numbers, fields, factors)

    def blocks(self, width: int, first: int = 0, last: int | None = None) -> list[slice]:
        """Those from `first` to before `last`, as many at a time as fit beside `width` numbers each."""
        step, end = max(1, BLOCK // max(width, 1)), self.total if last is None else last
        return [slice(k, min(k + step, end)) for k in range(first, end, step)]

    def means(self) -> dict[str, FloatArray]:
        """Key -> (total,) values; of a field its mean over the channels."""
        found = {}
        for cause, column in zip(self.causes, self.numbers, strict=True):
            if column is None:
                rows = self.blocks(len(cause.names))
                column = np.concatenate([cause.values(self.points[own]).mean(axis=1) for own in rows])
            found[cause.key] = column
        return found


def whole_power(n: int) -> int:
    """The power of two that is not below n, 4 at least: what Sobol points are even for."""
    return 2 ** max(2, math.ceil(math.log2(max(n, 1))))


def make_causes(
    table: ScatterTable,
    data: Mapping[str, Any],
    given: Mapping[str, Any],
    fields: Mapping[str, ContactGaps],
    places: Places,
    deviations: Mapping[str, FloatArray],
) -> tuple[Cause, ...]:
    """The causes of a study.

    Parameters
    ----------
    data : tables of the study with their defaults. given : as they were written.
    fields : contact -> its channels. deviations : key of a field whose
        tolerances a table has -> standard deviation (m,) of these gaps.

    Raises
    ------
    InputError : nothing scatters; an unknown key, one that is no number; a distribution that leaves what is allowed.
    """
    if not table.vary:
        raise InputError(
            "nothing scatters",
            where=places.where("scatter"),
            expected='[scatter.vary] with "contact.NAME.clearance" = { type = "field", tolerance = 0.6, length = 100 }',
            fix="Add it.",
        )
    causes: list[Cause] = []
    for key, of in table.vary.items():
        where = places.where("scatter", "vary", key)
        at = causes[-1].columns.stop if causes else 0
        of = clip_scatter(of, key, where) if of.type.startswith("clip-") else of
        if of.type == "field":
            causes.append(_field(key, of, at, fields, where, deviations.get(key)))
            continue
        _check_key(key, data, where)
        _check_limit(key, data, where)
        nominal = _nominal(key, of, value_at(given, key), value_at(data, key), where)
        causes.append(Cause(key, of, nominal, slice(at, at + 1)))
        if not any(load["press_fit"] for load in data.get("static", ())):  # surfaces that overlap press then
            _check_range(causes[-1], where)
    return tuple(causes)


def _check_key(key: str, data: Any, where: str) -> None:
    """Raise InputError where a table of the study knows no such key, or has no such name."""
    words = key.split(".")
    if words[0] in OF_RUN:
        raise InputError(
            f"{key} says how a run is made, not what a car is: all draws are counted in one window",
            where=where,
            expected="a number of the model, its contacts or its loads",
            fix="Compare other values with `creak run --set` or `creak sweep`.",
        )
    for depth, word in enumerate(words):
        if isinstance(data, Mapping) and word not in data:
            of_deck = words[0] in ("material", "section") and len(words) > 2 and depth < len(words) - 1
            fix = (
                f"Give the deck's value in the study, in [{'.'.join(words[:-1])}]." if of_deck else suggest(word, data)
            )
            raise InputError(f"unknown key {key!r}", where=where, fix=fix)
        if isinstance(data, list):
            checked_row(data, words, depth, where)
        data = value_at(data, word)


def _check_limit(key: str, data: Any, where: str) -> None:
    """Raise InputError for a limit or a friction of a connector or clip that the study does not give."""
    row, _, word = key.rpartition(".")
    lost, absent = ("nothing rubs there", (None, 0.0)) if word == "friction" else ("there is no such stop", (None,))
    of_place = row.startswith(("connector.", "clip.")) and word in (*LIMITS, "friction")
    if of_place and value_at(data, row) is not None and value_at(data, key) in absent:
        raise InputError(
            f"{key} is not given in the study: without it {lost}",
            where=where,
            expected="a number there, about which it scatters or which a draw replaces",
            fix="Give it there.",
        )


def _nominal(key: str, of: Distribution, given: Any, value: Any, where: str) -> float:
    found = value if given is None else given
    if of.type == "seed" and not key.endswith(".seed"):
        raise InputError(f"{key} is no seed", where=where, expected="the seed of a signal: excitation.NAME.signal.seed")
    if isinstance(found, int | float) and not isinstance(found, bool):
        return float(found)
    of_itself = of.type in ("uniform", "seed") or of.mean is not None or of.median is not None
    if found is None or isinstance(found, str):
        if of.relative and found == "auto" and key.startswith("contact.") and key.endswith(".stiffness"):
            return math.nan
        if of_itself and not of.relative:
            return math.nan
    raise InputError(
        f"{key} is {'not given' if found is None else repr(found)} in the study: it has no number to scatter about",
        where=where,
        expected="a number there, or a mean here" + (", or relative = true" if found == "auto" else ""),
    )


def _check_range(cause: Cause, where: str) -> None:
    """Raise InputError for a clearance that becomes negative within its tolerance."""
    if not cause.key.endswith(".clearance") or not cause.key.startswith("contact."):
        return
    _no_negative_gap(cause.at(norm.cdf(-3.0)), cause.at(0.5), where)


def _no_negative_gap(low: float, middle: float, where: str) -> None:
    if low < -ROUND_OFF * abs(middle):
        raise InputError(
            f"this distribution has negative gaps: {low:.3g} at three standard deviations",
            where=where,
            expected="gaps of 0 or more: parts that touch from the start have a gap of 0",
            fix="Give low = 0, a smaller tolerance, or a larger mean.",
        )


def _field(
    key: str,
    of: Distribution,
    at: int,
    fields: Mapping[str, ContactGaps],
    where: str,
    deviation: FloatArray | None,
) -> Cause:
    words = key.split(".")
    if len(words) != 3 or words[0] != "contact" or words[2] != "clearance":
        raise InputError(
            f"{key} is no field of gaps", where=where, expected="contact.NAME.clearance", fix="Use another type."
        )
    if words[1] not in fields:
        raise InputError(f"the study has no [contact.{words[1]}]", where=where, fix=suggest(words[1], fields))
    names, places, gaps, nearest = fields[words[1]]
    mean = gaps if of.mean is None else np.where(nearest, of.mean, gaps)
    sigma = np.full(gaps.size, of.deviation) if deviation is None else deviation
    if of.low is None:
        _no_negative_gap(float((mean - SIGMAS * sigma).min(initial=np.inf)), float(mean.max(initial=0.0)), where)
    shapes = sigma[:, None] * field_shapes(places, of.length or 1.0)
    return Cause(key, of, math.nan, slice(at, at + shapes.shape[1]), shapes, mean, names)


def field_shapes(places: FloatArray, length: float) -> FloatArray:
    """(m, k) shapes of a field of variance 1 with the correlation exp(-(d / length)^2) over places (m, 3).

    Eigenvectors of the correlation (Karhunen, Loeve), the strongest until they hold `KEPT` of the variance; each place
    is then scaled to a variance of 1.
    """
    d2 = ((places[:, None, :] - places[None, :, :]) ** 2).sum(axis=2)
    values, vectors = np.linalg.eigh(np.exp(-d2 / length**2))
    values, vectors = np.maximum(values[::-1], 0.0), vectors[:, ::-1]
    k = int(np.searchsorted(np.cumsum(values), KEPT * values.sum())) + 1
    shapes = vectors[:, :k] * np.sqrt(values[:k])
    return np.asarray(shapes / np.maximum(np.linalg.norm(shapes, axis=1), EDGE)[:, None])


def _or(value: float | None, other: float) -> float:
    return other if value is None else value
