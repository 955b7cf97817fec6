"""Figures of the page worked out from the outcomes, None where a case was not run; the thesis's own numbers."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from creak_thesis.outcome import EventRow, LoadOutcome, Outcome
from creak_thesis.plan import RATTLING, plan


@cache
def thesis() -> dict[str, Any]:
    """Tables and figures of the thesis by study."""
    text = resources.files("creak_thesis.report").joinpath("thesis_numbers.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


@cache
def million() -> dict[str, Any] | None:
    """What was measured on the door of 1.17 million dofs; None where the package holds no such measurement."""
    file = resources.files("creak_thesis.report").joinpath("million.json")
    return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else None


def thesis_cpu(name: str) -> float | None:
    """CPU time of a configuration in the thesis, 1000 s; None where it gives none."""
    t = thesis()
    tables = (
        (t["summary"]["names"], t["summary"]["cpu"]),
        ([f"C{k}" for k in range(1, 6)], t["spacing"]["cpu"]),
        (["Ref C"], [t["spacing"]["reference_cpu"]]),
        ([f"F{f}" for f in t["range"]["f_max"]], t["range"]["cpu"]),
        ([f"D{d}" for d in t["distance"]["distance"]], t["distance"]["cpu"]),
    )
    for names, cpu in tables:
        if name in names:
            return float(cpu[names.index(name)])
    return None


TOLERANCE = 0.010
"""s, events this close are the same (thesis 3.7.3)."""
PERFECT = 0.05
"""Largest difference of a force that the thesis calls perfect."""
WINDOW_START = 4.0
"""s, start of the last of five periods of one second."""
FLANGE = "flange"
"""The contact that the thesis looks at."""
PARTS = ("FRAME", "PANEL", "CARRIER")


@dataclass(frozen=True)
class Agreement:
    """Events of a run against those of its reference."""

    reference: int
    own: int
    common: list[tuple[EventRow, EventRow]]

    @property
    def missed(self) -> int:
        return self.reference - len(self.common)

    @property
    def extra(self) -> int:
        return self.own - len(self.common)

    @property
    def exact(self) -> bool:
        """The same events, neither more nor less."""
        return self.missed == 0 and self.extra == 0

    @property
    def force_ratio(self) -> float | None:
        """Mean force of the common events, run over reference (thesis 3.7.3)."""
        below = sum(a.force for a, _ in self.common)
        return sum(b.force for _, b in self.common) / below if below > 0.0 else None

    @property
    def impulse_ratio(self) -> float | None:
        below = sum(a.impulse for a, _ in self.common)
        return sum(b.impulse for _, b in self.common) / below if below > 0.0 else None

    @property
    def largest_error(self) -> float | None:
        """Largest relative difference of a force, without sign."""
        return max((abs(b.force / a.force - 1.0) for a, b in self.common if a.force > 0.0), default=None)

    @property
    def graded(self) -> tuple[int, int, int]:
        """Common events whose force is within 5 %, too low, too high (table 4.3)."""
        ratios = [b.force / a.force - 1.0 for a, b in self.common if a.force > 0.0]
        low, high = sum(r < -PERFECT for r in ratios), sum(r > PERFECT for r in ratios)
        return len(ratios) - low - high, low, high


@dataclass(frozen=True)
class Facts:
    """The outcomes by case, and what follows from them."""

    mesh_size: float
    outcomes: Mapping[str, Outcome]

    def case(self, name: str) -> Outcome | None:
        """The outcome of a case that was run."""
        found = self.outcomes.get(name)
        return None if found is None or found.reason else found

    def why_not(self, name: str) -> str:
        """Why a case has no outcome; empty where it has one."""
        found = self.outcomes.get(name)
        return "not run" if found is None else found.reason

    def ran(self, names: Sequence[str]) -> list[str]:
        return [n for n in names if self.case(n) is not None]

    def missing(self, names: Sequence[str]) -> list[str]:
        return [f"{n}: {self.why_not(n)}" for n in names if self.case(n) is None]

    def load(self, name: str, load: str) -> LoadOutcome | None:
        found = self.case(name)
        return None if found is None else found.loads.get(load)

    def fit(self, name: str, load: str, axis: str = "all") -> float | None:
        found = self.load(name, load)
        value = None if found is None else found.nrmse.get(axis)
        return value if value is not None and math.isfinite(value) else None

    def agreement(self, name: str, load: str) -> Agreement | None:
        """Events of a case against its reference under a load."""
        return self._agreement(name, load, True)

    def stops(self, name: str, load: str) -> Agreement | None:
        """The same of the events beside the flange: the stops of hooks with play."""
        return self._agreement(name, load, False)

    def _agreement(self, name: str, load: str, flange: bool) -> Agreement | None:
        own, reference = self.load(name, load), self.load(against(name), load)
        if own is None or reference is None:
            return None
        common = [(reference.events[i], own.events[j]) for i, j in own.pairs if on_flange(own.events[j]) == flange]
        of, mine = (sum(on_flange(e) == flange for e in run.events) for run in (reference, own))
        return Agreement(of, mine, common)

    def between(self, first: str, second: str, load: str) -> Agreement | None:
        """Events of any two cases, the second against the first, matched by their start."""
        a, b = self.load(first, load), self.load(second, load)
        if a is None or b is None:
            return None
        first_events, second_events = flange_events(a), flange_events(b)
        return Agreement(len(first_events), len(second_events), matched(first_events, second_events))

    def agreements(self, name: str) -> dict[str, Agreement]:
        """Of the loads with contact."""
        found = {load: self.agreement(name, load) for load in RATTLING}
        return {load: a for load, a in found.items() if a is not None}

    def own_cpu(self, name: str) -> float | None:
        """CPU time of creak's run under A4, s."""
        found = self.load(name, "A4")
        return None if found is None else found.cpu_s

    def usual_cpu(self, name: str, kind: str = "") -> float | None:
        """CPU time of a run under A4 by plain Newton with refactorisation, s.

        Cases without runs of their own take the steps of the unreduced run under A4.

        Parameters
        ----------
        kind : `condensed_` for condensed steps on the same matrices, where they were timed.
        """
        found = self.case(name)
        if found is None or found.newton is None or f"{kind}flight_s" not in found.newton:
            return None
        run = found.loads.get("A4") or self.load("Ref StS", "A4")
        if run is None:
            return None
        steps, touching = run.steps, run.contact_steps
        total = (steps - touching) * found.newton[f"{kind}flight_s"] + touching * found.newton[f"{kind}contact_s"]
        return total if math.isfinite(total) else None

    def retained(self, name: str, part: str) -> int | None:
        found = self.case(name)
        return None if found is None else found.retained.get(part)

    def all_retained(self, name: str) -> int | None:
        """Retained coordinates of all substructures."""
        found = self.case(name)
        return None if found is None else sum(found.retained.values())

    def lowest_mac(self, name: str) -> tuple[float, int] | None:
        """Lowest MAC of the pairs and the number of its mode."""
        found = self.case(name)
        if found is None or not found.mac:
            return None
        value = min(found.mac)
        return value, found.mac.index(value) + 1


def against(name: str) -> str:
    """The unreduced case that a case is compared with."""
    return _references().get(name) or name.replace("D8", "Ref", 1)


@cache
def _references() -> dict[str, str]:
    return {c.name: c.against for c in plan()}


def matched(first: Sequence[EventRow], second: Sequence[EventRow]) -> list[tuple[EventRow, EventRow]]:
    """Pairs of events that start within `TOLERANCE` of each other, nearest first, each once."""
    near = sorted(
        (abs(a.t_start - b.t_start), i, j)
        for i, a in enumerate(first)
        for j, b in enumerate(second)
        if abs(a.t_start - b.t_start) <= TOLERANCE
    )
    partner: dict[int, int] = {}
    for _, i, j in near:
        if i not in partner and j not in partner.values():
            partner[i] = j
    return [(first[i], second[j]) for i, j in sorted(partner.items())]


def on_flange(event: EventRow) -> bool:
    """Whether an event is one of the flange; the stops of hooks with play have events of their own."""
    return event.group in ("", FLANGE)


def flange_events(run: LoadOutcome) -> list[EventRow]:
    """Events of the flange, which the thesis counts."""
    return [e for e in run.events if on_flange(e)]


def milliseconds(event: EventRow) -> float:
    """When an event peaks within the last period, ms."""
    return 1e3 * (event.t_peak - WINDOW_START)
