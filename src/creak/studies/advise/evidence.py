"""What was measured elsewhere: accuracy against modes kept, what a step resolves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

DOOR = "door, docs/guidelines.md"
"""Where `MEASURED` comes from: events of the last period under three loads to 100 Hz, each against its partner in the
unreduced run with the same step, channels and stiffness, all with HHT. Craig-Bampton (8 mm of mesh around the contact
unreduced) and gap modes to 7 times: the worse of 20 and 10 mm, 31 and 29 events, errors summed over the events and
divided by their sum. The other assembly modes: 25 events at 40 mm, means of the relative errors of single events,
which weak events make larger."""


@dataclass(frozen=True)
class Measured:
    """A reduction whose f_max was `multiple` times the excitation, against the unreduced run."""

    multiple: float
    frequency_error: float
    """Worst relative error of a mode up to the excitation's highest frequency."""
    force_error: float
    impulse_error: float
    """Mean size of the error of an event over the mean event; the force low-passed."""


MEASURED: dict[str, tuple[Measured, ...]] = {
    "craig-bampton": (
        Measured(3.0, 5.3e-3, 1.6e-1, 8.8e-2),
        Measured(5.0, 2.3e-3, 5.2e-2, 3.2e-2),
        Measured(7.0, 1.1e-3, 2.6e-2, 1.8e-2),
        Measured(9.0, 5.5e-4, 1.5e-2, 1.1e-2),
        Measured(11.0, 2.4e-4, 9.8e-3, 7.5e-3),
        Measured(13.0, 1.3e-4, 5.7e-3, 4.3e-3),
        Measured(15.0, 9e-5, 3.8e-3, 2.9e-3),
        Measured(20.0, 4e-5, 1.7e-3, 1.3e-3),
    ),
    "gap-modes": (Measured(3.0, 0.0, 4.2e-3, 3.9e-3), Measured(7.0, 0.0, 5e-4, 4e-4)),
    "massless-boundary": (
        Measured(3.0, 0.0, 6.9e-2, 9.2e-2),
        Measured(7.0, 0.0, 7.9e-3, 9.4e-3),
        Measured(11.0, 0.0, 1.0e-3, 9e-4),
    ),
}
RULE_OF_THUMB = ((2.0, 1e-2), (3.0, 1e-3), (5.0, 3e-4))
"""(f_max / frequency, relative frequency error): two cantilever halves; beyond the last point no more than that."""


@dataclass(frozen=True)
class StepEvidence:
    """What a step of 1 / (per_period f) left on the door, f the excitation's highest frequency."""

    per_period: float
    hht: str
    massless: str


STEPS = (
    StepEvidence(10.0, "45 of 96 events found, impulse 65 % low", "91 of 96 events found, impulse 16 % low"),
    StepEvidence(
        40.0,
        "95 of 96 events found; start and duration settled, impulse 7 % low",
        "96 of 96 events found; impulse 3 % low",
    ),
    StepEvidence(
        100.0, "the impulse of 21 of 22 events settled to 5 %", "the impulse of 17 of 22 events settled to 5 %"
    ),
)
"""docs/contact_convergence.md: against the massless boundary at the shortest step, automatic stiffness."""


def measured(method: str, multiple: float) -> Measured | None:
    """Errors on the door for this multiple, interpolated between measurements (power laws); None beyond them.

    Valid for that door: other structures with other damping and mode density differ, by a factor of a few.
    """
    points = MEASURED[method]
    if not points[0].multiple <= multiple <= points[-1].multiple:
        return None
    errors = [[getattr(p, name) for p in points] for name in ("frequency_error", "force_error", "impulse_error")]
    x = [p.multiple for p in points]
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


def step_evidence(per_period: float) -> StepEvidence | None:
    """Of the longest measured step that is no shorter than this one; None for coarser ones than measured."""
    fit = [s for s in STEPS if s.per_period <= per_period * 1.001]
    return fit[-1] if fit else None
