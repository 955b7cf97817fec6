"""Made-up outcomes of the thesis's cases: no run behind them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from creak_thesis.outcome import EventRow, LoadOutcome, Outcome
from creak_thesis.plan import Case, plan

STEPS = 5000
RATES = {"A1": 0, "A2": 5, "A3": 10, "A4": 15}
FREQ = np.arange(1.0, 501.0)


def fake_outcomes(*, force: float = 1.1, full_cost: float = 1.3) -> dict[str, Outcome]:
    """One outcome for every planned case.

    Parameters
    ----------
    force : force of reduced models over that of their reference.
    full_cost : cost of plain Newton on C1 over that on its reference.
    """
    return {c.name: fake_outcome(c, force, full_cost) for c in plan()}


def fake_outcome(case: Case, force: float = 1.1, full_cost: float = 1.3) -> Outcome:
    """The reduced cases find all events but one under A3, with their forces scaled."""
    unreduced = case.reduction is None
    loads = {load: _run(case, load, 1.0 if unreduced else force) for load in case.loads}
    retained, modes = {}, {}
    if not unreduced:
        share = {"C1": 8, "C2": 4, "C3": 2, "C4": 1.4, "C5": 1, "D40": 1.1, "D90": 1.4, "M1": 0.6, "M2": 0.5}
        retained = {"FRAME": int(1000 * share.get(case.name, 1.0)), "PANEL": 400, "CARRIER": 100}
        modes = {"FRAME": 288, "PANEL": 384, "CARRIER": 105}
        if case.study == "spacing":
            del retained["PANEL"], modes["PANEL"]
    f = np.linspace(8.0, 99.0, 20)
    keep = {"C5": 8, "P37": 15, "P40": 14, "P45": 10}.get(case.name, 20)
    mac = [] if unreduced else [1.0 if k < keep else 0.3 for k in range(20)]
    newton = None
    if case.newton:
        size = 1.0 if unreduced else full_cost if case.name == "C1" else 0.05
        newton = {"flight_s": 0.2 * size, "contact_s": 0.9 * size, "factorisations": 4.0, "steps": 6}
    return Outcome(
        case.name,
        case.study,
        case.variant.name,
        57000 if unreduced else 3000,
        60,
        retained,
        modes,
        500,
        10.0,
        12.0,
        f.tolist(),
        [] if unreduced else [1e-4] * 20,
        mac,
        [] if unreduced else np.diag(mac).tolist(),
        newton,
        loads,
        FREQ.tolist(),
    )


def failed(outcome: Outcome, reason: str) -> Outcome:
    """The same case, not run."""
    return replace(outcome, loads={}, retained={}, modes={}, mac=[], mac_matrix=[], newton=None, reason=reason)


def _run(case: Case, load: str, force: float) -> LoadOutcome:
    n = RATES[load]
    unreduced = case.reduction is None
    kept = range(n - 1) if load == "A3" and not unreduced else range(n)
    if case.name == "P37":
        kept = range(n // 3)
    events = [_event(4.03 + 0.9 * k / max(n, 1), force * (3.0 + k % 4)) for k in kept]
    own = case.against == case.name
    fit = {} if own else {a: 0.99 - 0.02 * k for k, a in enumerate(("x", "y", "z", "all"))}
    cpu = 100.0 if unreduced else 2.0
    return LoadOutcome(
        cpu,
        cpu,
        STEPS,
        30 * n,
        1e-6,
        events,
        [] if own else [[k, k] for k in range(len(events))],
        fit,
        _spectra(1.0 if unreduced else 1.02),
    )


@cache
def _spectra(scale: float) -> list[list[float]]:
    """The same rows for all, since nobody changes them."""
    return (np.exp(-FREQ / 80.0)[:, None] * np.array([1e-3, 4e-3, 2e-3]) * scale).tolist()


def _event(start: float, force: float) -> EventRow:
    return EventRow(start, start + 0.002, force, 1.05 * force, 2e-3 * force)
