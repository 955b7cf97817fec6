"""What was measured on the door: one record, which `python -m benchmarks.evidence` writes; all words are made of it.

Runs are of the default accuracy and are held to modes of the assembly up to 20 times the excitation; errors are the
mean size of the difference of an event over the mean event, all events of three loads together. They are those of that
door: other structures with other damping and mode density differ by a factor of a few.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

DOOR = "door, docs/guidelines.md"
"""Where the record is shown."""
CONTACT = "door, docs/contact_convergence.md"
FAMILIES = {"craig-bampton": "Craig-Bampton", "gap-modes": "gap modes"}
"""Method -> the first words of its cases, which go on with `N x`."""
HHT = "HHT"
"""The scheme of the forced steps."""
FINEST = 100.0
"""Forced steps in a period beyond which the door found no further event."""
ROUND_OFF = 1e-9
"""Relative errors up to this are none."""


@dataclass(frozen=True)
class Measured:
    """A reduction whose f_max was `multiple` times the excitation."""

    multiple: float
    frequency_error: float
    """Worst relative error of a mode up to the excitation's highest frequency."""
    force_error: float
    impulse_error: float
    """Mean size of the error of an event over the mean event; the force is that of the place, low-passed."""


@dataclass(frozen=True)
class StepEvidence:
    """What a forced step of 1 / (per_period f) left on the door, f the excitation's highest frequency."""

    per_period: float
    hht: str


RULE_OF_THUMB = ((2.0, 1e-2), (3.0, 1e-3), (5.0, 3e-4))
"""(f_max / frequency, relative frequency error): two cantilever halves; beyond the last point no more than that."""


@cache
def record() -> Mapping[str, Any]:
    """The record of this version of creak."""
    text = resources.files("creak.studies.advise").joinpath("evidence.json").read_text(encoding="utf-8")
    found: Mapping[str, Any] = json.loads(text)
    return found


def case(found: Mapping[str, Any], name: str, fine: bool = False) -> Mapping[str, Any]:
    """A reduction by its name; of the finer door with `fine`.

    Raises
    ------
    KeyError : it was not measured.
    """
    for row in found["fine" if fine else "door"]["reductions"]:
        if row["name"] == name:
            return dict(row)
    raise KeyError(name)


def doors(found: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The doors of a record, the coarse one first."""
    return [found[part] for part in ("door", "fine") if part in found]


@cache
def points() -> dict[str, tuple[Measured, ...]]:
    """Errors by method, by rising multiple: the worse of the two doors where both were measured."""
    return {method: _series(record(), family) for method, family in FAMILIES.items()}


def _series(found: Mapping[str, Any], family: str) -> tuple[Measured, ...]:
    rows = [row for door in doors(found) for row in door["reductions"]]
    by: dict[float, list[Mapping[str, Any]]] = {}
    for row in rows:
        if row["name"].startswith(family) and row["name"].endswith(" x"):
            by.setdefault(row["multiple"], []).append(row)
    keys = ("frequency_error", "force_error", "impulse_error")
    worst = {m: [max(float(row[key]) for row in by[m]) for key in keys] for m in sorted(by)}
    return tuple(Measured(m, *(e if e > ROUND_OFF else 0.0 for e in errors)) for m, errors in worst.items())


def measured(method: str, multiple: float) -> Measured | None:
    """Errors on the door for this multiple, interpolated between measurements (power laws); None beyond them."""
    known = points()[method]
    if not known[0].multiple <= multiple <= known[-1].multiple:
        return None
    errors = [[getattr(p, name) for p in known] for name in ("frequency_error", "force_error", "impulse_error")]
    x = [p.multiple for p in known]
    return Measured(multiple, *(power_law(x, y, multiple) for y in errors))


def rule_of_thumb(multiple: float) -> float:
    """Relative frequency error at f_max / multiple, fixed-interface modes to f_max; infinite for multiples below 2."""
    x, y = zip(*RULE_OF_THUMB, strict=True)
    return math.inf if multiple < x[0] else power_law(x, y, min(multiple, x[-1]))


def power_law(x: Sequence[float], y: Sequence[float], at: float) -> float:
    """y at a point within x, straight between the points on logarithmic axes; zeros stay zero."""
    k = next((k for k in range(len(x) - 2) if at <= x[k + 1]), len(x) - 2)
    if min(y[k], y[k + 1]) <= 0.0:
        return max(y[k], y[k + 1])
    share = math.log(at / x[k]) / math.log(x[k + 1] / x[k])
    return y[k] * (y[k + 1] / y[k]) ** share


@cache
def steps() -> tuple[StepEvidence, ...]:
    """Of the forced steps that are worth trying, longest first."""
    rows = [row for row in record()["contact"]["steps"]["rows"] if row["scheme"] == HHT]
    rows = sorted((row for row in rows if row["per_period"] <= FINEST * 1.001), key=lambda row: -row["step"])
    return tuple(StepEvidence(row["per_period"], step_words(row)) for row in rows)


def step_words(row: Mapping[str, Any]) -> str:
    """`25 of 40 events found, 7 more, total impulse +66 %`."""
    return (
        f"{row['matched']} of {row['reference']} events found, {row['extra'] or 'none'} more, total impulse "
        f"{100.0 * (row['total_impulse_ratio'] - 1.0):+.0f} %"
    )


def step_evidence(per_period: float) -> StepEvidence | None:
    """Of the longest measured step that is no shorter than this one; None for coarser ones than measured."""
    fit = [s for s in steps() if s.per_period <= per_period * 1.001]
    return fit[-1] if fit else None


def varied(kind: str, factor: float) -> Mapping[str, Any]:
    """The run with damping or load times a factor; `base` with 1."""
    (row,) = (row for row in record()["contact"]["physics"] if row["kind"] == kind and row["factor"] == factor)
    return dict(row)


def penalty(factor: float) -> Mapping[str, Any]:
    """The run with the contact stiffness times a factor."""
    (row,) = (row for row in record()["contact"]["penalties"]["rows"] if row["factor"] == factor)
    return dict(row)
