"""[scatter]: numbers of the study that are not known better than by a distribution, and what it may take of gaps.

Gaps scatter by one number, or by a table as tolerance programs write it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from creak.errors import InputError
from creak.studies.file.named_columns import ColumnTable, Wanted, read_columns
from creak.studies.file.quantities import checked_length
from creak.studies.file.table import Finite, Positive, Table

SIGMAS = 3.0
"""A tolerance is so many standard deviations."""
TABLES = (".csv", ".tsv", ".txt")
"""How the name of a table ends."""
AGREES = 0.05
"""Share by which the sides that a row gives twice (limits, and three sigma) may differ: programs round them."""

ToleranceColumn = Literal["point", "x", "y", "z", "nominal", "plus", "minus", "sigma", "lower", "upper"]
"""Columns of a table of tolerances."""


class ToleranceFile(Table):
    """A table of tolerances whose columns have names of their own."""

    file: Annotated[str, Field(min_length=1)]
    """CSV file, relative to the study file."""
    columns: dict[ToleranceColumn, Annotated[str, Field(min_length=1)]] = {}
    """What the file calls its columns, where it calls them otherwise: { point = "Feature", minus = "LSL" }."""


def names_table(value: Any) -> bool:
    """Whether a text is the name of a table, and not a length."""
    return isinstance(value, str) and value.strip().lower().endswith(TABLES)


def _length_or_name(value: Any) -> str:
    if names_table(value):
        return str(value)
    try:
        return checked_length(value)
    except ValueError as error:
        raise ValueError(f'{error}; or name a CSV file, as "gaps.csv"') from error


def _name(value: Any) -> str:
    if names_table(value):
        return str(value)
    raise ValueError('no number and no name of a table; write 0.6, or name a CSV file, as "gaps.csv"')


Tolerance = Annotated[
    Annotated[str, BeforeValidator(_length_or_name), Tag("text")] | Annotated[ToleranceFile, Tag("table")],
    Discriminator(lambda value: "table" if isinstance(value, dict | ToleranceFile) else "text"),
]
"""A length of 0 or more with its unit, "0.3 mm", or a table of tolerances: "gaps.csv"."""

ScatterTolerance = Annotated[
    Annotated[Positive, Tag("number")]
    | Annotated[str, BeforeValidator(_name), Tag("text")]
    | Annotated[ToleranceFile, Tag("table")],
    Discriminator(
        lambda value: (
            "table" if isinstance(value, dict | ToleranceFile) else "text" if isinstance(value, str) else "number"
        )
    ),
]
"""The same where numbers have no unit: a number above 0, or a table."""


def table_of(value: str | float | ToleranceFile | None) -> ToleranceFile | None:
    """The table that a tolerance names; None: it is a number."""
    if isinstance(value, ToleranceFile):
        return value
    return ToleranceFile(file=value) if isinstance(value, str) and names_table(value) else None


@dataclass(frozen=True)
class GapTolerance:
    """A row of the table, in the length of the study."""

    point: str
    """Name of a point, of the points that begin with it and a colon, or of a line; empty: `place` says where."""
    place: tuple[float, float, float] | None
    nominal: float | None
    below: float
    """What scatter may take of the gap: the minus side, or three sigma."""
    above: float
    """What it may add; where nothing is said of it the same."""
    side: str
    """What `below` is: "minus" or "3 sigma"."""
    where: str
    """file:line"""

    @property
    def name(self) -> str:
        """What messages call it."""
        return repr(self.point) if self.place is None else f"({', '.join(f'{x:g}' for x in self.place)})"


def _synonyms() -> dict[str, str]:
    words = {
        "point": "point pointid pointname name id feature featurename measure measurename measurement eline elineid "
        "gap gapid gapname node nodeid label characteristic",
        "x": "x xcoord xcoordinate posx",
        "y": "y ycoord ycoordinate posy",
        "z": "z zcoord zcoordinate posz",
        "nominal": "nominal nom nominalgap gapnominal nominalvalue target design",
        "plus": "plus plustol plustolerance tolplus toleranceplus upptol uppertol uppertolerance utol upperdeviation",
        "minus": "minus minustol minustolerance tolminus toleranceminus lowtol lowertol lowertolerance ltol "
        "lowerdeviation tol tolerance plusminus plusminustol plusminustolerance tolplusminus",
        "sigma": "sigma 1sigma std stdev stddev standarddeviation sd",
        "lower": "lower lsl lowerlimit lowerspec lowerspeclimit min minimum mingap gapmin",
        "upper": "upper usl upperlimit upperspec upperspeclimit max maximum maxgap gapmax",
    }
    return {word: column for column, text in words.items() for word in text.split()}


PLACE = ("x", "y", "z")
SIDES = (("minus",), ("sigma",), ("nominal", "lower"))
"""Columns that say what the gap may lose; any of them."""
WANTED = Wanted(
    "table of tolerances",
    tuple((*where, *side) for where, side in product(((PLACE), ("point",)), SIDES)),
    _synonyms(),
    frozenset((*PLACE, "nominal", "plus", "minus", "sigma", "lower", "upper")),
    "point (or x,y,z) and minus, sigma, or nominal,lower",
)


def read_tolerances(
    path: Path, where: str, columns: Mapping[ToleranceColumn, str], units: str
) -> tuple[GapTolerance, ...]:
    """The rows of a table of tolerances.

    Parameters
    ----------
    where : of the key that names it. columns : what the file calls them. units : of the study.

    Raises
    ------
    InputError : as `named_columns.read_columns`; a row without point or side, text for a number, a negative sigma, a
        nominal gap outside its limits, limits and sigma that contradict each other, minus tolerances of both signs, a
        second row of a point.
    """
    named = {str(column): name for column, name in columns.items()}
    table = read_columns(path, where, WANTED, named, units)
    kept = _without_the_other(table, named)
    rows = tuple(_row(table, k, kept) for k in range(len(table.lines)))
    _check_signs(table, kept)
    first: dict[str, str] = {}
    for row in rows:
        if row.name.casefold() in first:
            raise InputError(
                f"{row.name} has a second row; the first is {first[row.name.casefold()]}",
                where=row.where,
                expected="one row for each point",
                fix="Remove one of them.",
            )
        first[row.name.casefold()] = row.where
    return rows


def _without_the_other(table: ColumnTable, named: Mapping[str, str]) -> frozenset[str]:
    """Columns that count: of two ways to say the same only that which `columns` names, where it names one."""
    kept = set(table.cells)
    for pair in (({"point"}, {*PLACE}), ({"minus", "lower"}, {"sigma"})):
        for mine, other in (pair, pair[::-1]):
            if named.keys() & mine and not named.keys() & other:
                kept -= other
    return frozenset(kept)


def _row(table: ColumnTable, k: int, kept: frozenset[str]) -> GapTolerance:
    def cell(column: str) -> float | None:
        return table.number(k, column) if column in kept else None

    where = table.where(k)
    point = table.cells["point"][k] if "point" in kept else ""
    placed = kept >= {*PLACE} and any(table.cells[axis][k] for axis in PLACE)
    if not placed and not point:
        raise InputError(
            "a row without a point", where=where, expected="its name, or x,y,z", fix="Name it, or remove the row."
        )
    x, y, z = table.numbers(k, PLACE) if placed else (0.0, 0.0, 0.0)
    nominal, plus, minus, sigma = (cell(c) for c in ("nominal", "plus", "minus", "sigma"))
    lower, upper = cell("lower"), cell("upper")
    for name, value in (("plus", plus), ("sigma", sigma)):
        if value is not None and value < 0.0:
            raise InputError(
                f"{name} is {value:g}",
                where=where,
                expected="0 or more",
                fix="Limits of the gap itself are the columns lower and upper." if name == "plus" else "Correct it.",
            )
    below = {} if minus is None else {"minus": abs(minus)}
    if nominal is not None and lower is not None:
        below["lower"] = nominal - lower
    if sigma is not None:
        below["sigma"] = SIGMAS * sigma
    above = plus if plus is not None else upper - nominal if None not in (upper, nominal) else None  # type: ignore[operator]
    if min(below.get("lower", 0.0), above or 0.0) < 0.0:
        raise InputError(
            f"the nominal gap {nominal:g} is outside its limits",
            where=where,
            expected="lower and upper as gaps, the nominal one between them",
            fix='If they are deviations from it, say columns = { minus = "...", plus = "..." } with their names.',
        )
    if not below:
        raise InputError(
            "a row that does not say what the gap may lose",
            where=where,
            expected="a number for minus, sigma, or nominal and lower",
            fix="Fill it in, or remove the row.",
        )
    _check_agreement(below, where)
    side = next(iter(below))
    most = max(below.values())
    place = (x, y, z) if placed else None
    words = "3 sigma" if side == "sigma" else "minus"
    return GapTolerance(point, place, nominal, below[side], most if above is None else above, words, where)


def _check_agreement(below: Mapping[str, float], where: str) -> None:
    if max(below.values()) - min(below.values()) > AGREES * max(below.values()):
        words = {"minus": "minus is {:g}", "lower": "nominal less lower is {:g}", "sigma": "three sigma are {:g}"}
        raise InputError(
            f"this row contradicts itself: {', '.join(words[side].format(x) for side, x in below.items())}",
            where=where,
            expected="one tolerance of the gap",
            fix='Name the column that counts: columns = { sigma = "..." } or { minus = "..." } with its name.',
        )


def _check_signs(table: ColumnTable, kept: frozenset[str]) -> None:
    """Raise InputError where some minus tolerances are below and others above 0."""
    if "minus" not in kept:
        return
    values = [table.number(k, "minus") or 0.0 for k in range(len(table.lines))]
    low, high = (next((k for k, v in enumerate(values) if sign * v > 0.0), None) for sign in (-1.0, 1.0))
    if low is not None and high is not None:
        raise InputError(
            f"minus is {values[low]:g} here and {values[high]:g} in line {table.lines[high]}",
            where=table.where(low),
            expected="one sign in all rows: minus is what the gap may lose",
            fix="Correct the rows, or give lower and upper.",
        )


class Distribution(Table):
    """How one number scatters."""

    type: Literal["normal", "uniform", "lognormal", "field", "seed", "clip-one-side", "clip-both-sides"]
    """normal, truncated where low or high is given; uniform; lognormal; field: gaps of a contact, normal and correlated
    along it; seed: another course of a random signal in every draw; clip-one-side, clip-both-sides: stiffness or
    damping of a clip as plastic clips were measured to differ, 7 and 8 %, and 40 and 36 %."""
    mean: Finite | None = None
    """normal, field: default the value of the study (of a field without clearance: each channel's own gap)."""
    median: Positive | None = None
    """lognormal: default the value of the study."""
    sigma: Positive | None = None
    """Standard deviation; lognormal: of the logarithm."""
    tolerance: ScatterTolerance | None = None
    """normal, field: three standard deviations, instead of sigma; of a field also the name of a CSV file, as [eline]
    takes it, for each gap its own."""
    low: Finite | None = None
    """uniform; normal and field: nothing below."""
    high: Finite | None = None
    """uniform; normal and field: nothing above."""
    length: Positive | None = None
    """field: correlation length, at which the correlation exp(-(d / length)^2) has fallen to 0.37."""
    relative: bool = False
    """Its values are factors on the value of the study (their mean or median is then 1)."""

    source: str | None = None
    """Where it comes from, for the page."""

    @property
    def deviation(self) -> float:
        """Standard deviation (lognormal: of the logarithm); nan: a table has them."""
        if self.sigma is not None:
            return self.sigma
        return math.nan if table_of(self.tolerance) else float(self.tolerance or 0.0) / SIGMAS  # type: ignore[arg-type]

    @model_validator(mode="after")
    def _complete(self) -> Distribution:
        takes = {
            "normal": {"mean", "sigma", "tolerance", "low", "high", "relative"},
            "uniform": {"low", "high", "relative"},
            "lognormal": {"median", "sigma", "relative"},
            "field": {"mean", "sigma", "tolerance", "low", "high", "length"},
        }.get(self.type, set[str]())
        foreign = sorted(
            k for k in self.model_fields_set - takes - {"type", "source"} if getattr(self, k) not in (None, False)
        )
        if foreign:
            raise ValueError(f"a {self.type} distribution has no {foreign[0]}")
        if self.type in ("normal", "lognormal", "field") and (self.sigma is None) == (self.tolerance is None):
            raise ValueError("give either sigma or tolerance" if self.type != "lognormal" else "give sigma")
        if self.type == "normal" and table_of(self.tolerance) is not None:
            raise ValueError('a table of tolerances is for the gaps of a contact: type = "field"')
        if self.type == "uniform" and (self.low is None or self.high is None):
            raise ValueError("a uniform distribution needs low and high")
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise ValueError(f"low = {self.low:g} is not below high = {self.high:g}")
        if self.type == "field" and self.length is None:
            raise ValueError("a field needs length: over how much of the flange gaps go together")
        return self


class ScatterTable(Table):
    """[scatter]: what `creak robust` draws."""

    vary: dict[str, Distribution] = {}
    """Dotted key of a number of the study -> its distribution."""
    seed: Annotated[int, Field(ge=0)] = 1
    """Of the draws."""
    target: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.05
    """Probability of rattle that is still allowed: the gap that it needs is told."""
