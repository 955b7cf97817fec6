"""One case measured: reduction, modes, runs under its loads, cost of the usual way."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from creak import Bench, Run, System, match_events, nrmse_by_axis
from creak_thesis.arrays import FloatArray
from creak_thesis.doors import Benches, under
from creak_thesis.newton_cost import newton_cost
from creak_thesis.outcome import EventRow, LoadOutcome, Outcome
from creak_thesis.plan import Case, Setting

Progress = Callable[[str, int, int], None]
TIMED_STEPS = 6
"""Steps of plain Newton that are timed of each kind."""


@dataclass(frozen=True)
class Bay:
    """What measuring needs besides the case."""

    benches: Benches
    variants: Mapping[str, Setting]
    cases: Mapping[str, Case]
    runs: Path
    """Folder of the unreduced runs, which are kept for cases to come."""
    progress: Progress
    made: dict[tuple[str, str], Run] = field(default_factory=dict)
    """Unreduced runs by case and load, as many cases are compared with each."""

    def base(self, case: Case) -> Bench:
        """The unreduced model of a case."""
        return self.benches.of(case.variant, self.variants)

    def unreduced(self, case: Case, load: str) -> Run:
        """The run of an unreduced case, made once."""
        if (case.name, load) not in self.made:
            key = digest([self.benches.mesh_size, case.key, load])
            file = self.runs / f"{case.name.replace('/', '_')}_{load}_{key[:12]}.npz"
            self.made[case.name, load] = under(self.base(case), load).run(keep=file)
        return self.made[case.name, load]


def measure(case: Case, bay: Bay) -> Outcome:
    """All figures of a case."""
    return _unreduced(case, bay) if case.reduction is None else _reduced(case, bay)


def _unreduced(case: Case, bay: Bay) -> Outcome:
    base = bay.base(case)
    loads, freq = {}, np.zeros(0)
    for load in case.loads:
        freq, loads[load] = _load_outcome(case, bay, load, bay.unreduced(case, load))
    f = base.frequencies
    return Outcome(
        name=case.name,
        study=case.study,
        variant=case.variant.name,
        n=base.system.n,
        channels=base.gaps.m,
        retained={},
        modes={},
        unreduced=base.system.n,
        offline_cpu_s=0.0,
        offline_wall_s=0.0,
        frequencies=f[f <= base.setup.study.config.verification.mac_f_max].tolist(),
        frequency_error=[],
        mac=[],
        mac_matrix=[],
        newton=_newton(case, base, base.system),
        loads=loads,
        freq=freq.tolist(),
        channel_names=list(base.gaps.names),
    )


def _reduced(case: Case, bay: Bay) -> Outcome:
    assert case.reduction is not None
    base = bay.base(case).reduced(case.reduction)
    model = base.model
    assert model is not None
    loads, freq = {}, np.zeros(0)
    for load in case.loads:
        freq, loads[load] = _load_outcome(case, bay, load, under(base, load).run(case.name))
    names = [r.system.name for r in model.superelements]
    retained = {n: r.system.stats.retained for n, r in zip(names, model.superelements, strict=True)}
    kept = {n: r.system.stats.modes for n, r in zip(names, model.superelements, strict=True)}
    frequencies, errors, mac, matrix = _modes(base)
    n = model.system.n if model.coupled is None else model.coupled.n
    return Outcome(
        name=case.name,
        study=case.study,
        variant=case.variant.name,
        n=n,
        channels=base.gaps.m,
        retained=retained or {"assembly": model.retained},
        modes=kept or {"assembly": model.modes},
        unreduced=model.unreduced_dof,
        offline_cpu_s=model.cpu_s,
        offline_wall_s=model.wall_s,
        frequencies=frequencies,
        frequency_error=errors,
        mac=mac,
        mac_matrix=matrix,
        newton=_newton(case, base, model.coupled or model.system),
        loads=loads,
        freq=freq.tolist(),
        channel_names=list(base.gaps.names),
    )


def digest(value: Any) -> str:
    """Hash of plain data, the same for the same content."""
    return hashlib.blake2b(json.dumps(value, sort_keys=True).encode(), digest_size=16).hexdigest()


def _modes(base: Bench) -> tuple[list[float], list[float], list[float], list[list[float]]]:
    """Reference frequencies, relative errors, MAC of the pairs, MAC matrix."""
    found = base.modes()
    if found is None:
        return [], [], [], []
    partner = found.pairs.partner
    mates = np.where(partner >= 0, found.freq_reduced[np.maximum(partner, 0)], np.inf)
    errors = mates / found.freq_reference - 1.0
    matrix = np.round(found.pairs.matrix, 4).tolist()
    return found.freq_reference.tolist(), errors.tolist(), found.pairs.mac.tolist(), matrix


def _load_outcome(case: Case, bay: Bay, load: str, run: Run) -> tuple[FloatArray, LoadOutcome]:
    """Figures of a run, against the unreduced run of the same load; and the frequencies of the spectra."""
    bench = under(bay.base(case), load)
    freq, spectra = bench.spectra(run)
    events = bench.events(run)
    rows = [EventRow(e.t_start, e.t_peak, e.force_place, e.force_peak, e.impulse, e.group) for e in events]
    pairs: list[list[int]] = []
    fit: dict[str, float | None] = {}
    against = bay.cases[case.against]
    if against.name != case.name:
        other = bay.unreduced(against, load)
        fit = nrmse_by_axis(under(bay.base(against), load).spectra(other)[1], spectra)
        tolerance = bench.setup.study.config.verification.event_tolerance
        match, first = match_events(other.events, run.events, tolerance, bench.window), bench.events(other)
        pairs = [[first.index(a), events.index(b)] for a, b in match.pairs if a in first and b in events]
    history = run.history
    mean_square = np.sqrt((np.abs(spectra) ** 2).mean(axis=1))
    return freq, LoadOutcome(
        cpu_s=run.cost.cpu_s,
        wall_s=run.cost.wall_s,
        steps=history.time.size - 1,
        contact_steps=history.contact_steps,
        energy_created=history.energy_created,
        events=rows,
        pairs=pairs,
        nrmse=fit,
        spectra=[[float(f"{x:.4g}") for x in row] for row in mean_square.tolist()],
    )


def _newton(case: Case, base: Bench, system: System) -> dict[str, float] | None:
    if not case.newton:
        return None
    return asdict(newton_cost(system, base.gaps, under(base, "A4").setup.loads, base.scheme, TIMED_STEPS))
