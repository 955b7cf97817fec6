"""[scatter]: numbers of the study that are not known better than by a distribution."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from creak.studies.file.table import Finite, Positive, Table
from creak.studies.file.tolerance_tables import SIGMAS, ScatterTolerance, table_of


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
