"""One case measured: reduction, modes, runs under its loads, cost of the usual way."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.studies.file.config import ReductionTable
from creak.studies.file.paths import digest
from creak.studies.models.reduced import ReducedModel, reduce_model
from creak.studies.models.substructures import UNREDUCED
from creak.studies.prepare.output_steps import excitation_window
from creak.studies.prepare.setup import Setup
from creak.studies.run.integrate import output_times
from creak.studies.run.job import Run, compare_modes, compare_spectra, events_in, march_run
from creak.studies.sweep.reference import SharedReference
from creak.studies.thesis.bench import Base, Bench
from creak.studies.thesis.newton_cost import newton_cost
from creak.studies.thesis.outcome import EventRow, LoadOutcome, Outcome
from creak.studies.thesis.plan import Case, Variant
from creak.verify.matching import match_events
from creak.verify.nrmse import nrmse_by_axis

Progress = Callable[[str, int, int], None]
TIMED_STEPS = 6
"""Steps of plain Newton that are timed of each kind."""


@dataclass(frozen=True)
class Bay:
    """What measuring needs besides the case."""

    bench: Bench
    variants: Mapping[str, Variant]
    cases: Mapping[str, Case]
    runs: Path
    """Folder of the unreduced runs, which are kept for cases to come."""
    progress: Progress
    made: dict[tuple[str, str], Run] = field(default_factory=dict)
    """Unreduced runs by case and load, as many cases are compared with each."""

    def base(self, case: Case) -> Base:
        return self.bench.base(case.variant, self.variants)

    def unreduced(self, case: Case, load: str) -> Run:
        """The run of an unreduced case, made once."""
        if (case.name, load) not in self.made:
            base = self.base(case)
            key = digest([self.bench.mesh_size, case.key, load])
            shared = SharedReference(self.runs / f"{case.name.replace('/', '_')}_{load}_{key[:12]}.npz")
            self.made[case.name, load] = shared(base.under(load), base.reference, base.gaps, self.progress)
        return self.made[case.name, load]


def measure(case: Case, bay: Bay) -> Outcome:
    """All figures of a case."""
    return _unreduced(case, bay) if case.reduction is None else _reduced(case, bay)


def _unreduced(case: Case, bay: Bay) -> Outcome:
    base = bay.base(case)
    loads, freq = {}, np.zeros(0)
    for load in case.loads:
        freq, loads[load] = _load_outcome(case, bay, load, bay.unreduced(case, load))
    f = base.reference.modes.frequencies
    return Outcome(
        case.name,
        case.study,
        case.variant.name,
        base.reference.system.n,
        base.gaps.m,
        {},
        {},
        base.reference.system.n,
        0.0,
        0.0,
        f[f <= base.setup.study.config.verification.mac_f_max].tolist(),
        [],
        [],
        [],
        _newton(case, base, base.reference.system),
        loads,
        freq.tolist(),
        list(base.gaps.names),
    )


def _reduced(case: Case, bay: Bay) -> Outcome:
    base = bay.base(case)
    setup = with_reduction(base.setup, case)
    model = reduce_model(setup, base.reference, base.gaps, bay.progress)
    loads, freq = {}, np.zeros(0)
    for load in case.loads:
        under = with_reduction(base.under(load), case)
        run = march_run(case.name, under, model.system, base.gaps, bay.progress, model)
        freq, loads[load] = _load_outcome(case, bay, load, run)
    names = [r.system.name for r in model.superelements]
    retained = {n: r.system.stats.retained for n, r in zip(names, model.superelements, strict=True)}
    kept = {n: r.system.stats.modes for n, r in zip(names, model.superelements, strict=True)}
    frequencies, errors, mac, matrix = _modes(setup, base, model)
    n = model.system.n if model.coupled is None else model.coupled.n
    return Outcome(
        case.name,
        case.study,
        case.variant.name,
        n,
        base.gaps.m,
        retained or {"assembly": model.retained},
        kept or {"assembly": model.modes},
        _stay(model),
        model.cpu_s,
        model.wall_s,
        frequencies,
        errors,
        mac,
        matrix,
        _newton(case, base, model.coupled or model.system),
        loads,
        freq.tolist(),
        list(base.gaps.names),
    )


def with_reduction(setup: Setup, case: Case) -> Setup:
    """The setup reduced as the case says."""
    return setup.with_tables(reduction=ReductionTable.model_validate(case.reduction))


def _stay(model: ReducedModel) -> int:
    """Dofs of the nodes of unreduced elements."""
    ending = UNREDUCED.format(part="")
    return sum(6 * p.nodes_idx.size for p in model.model.parts if p.name.endswith(ending))


def _modes(
    setup: Setup, base: Base, model: ReducedModel
) -> tuple[list[float], list[float], list[float], list[list[float]]]:
    """Reference frequencies, relative errors, MAC of the pairs, MAC matrix."""
    found = compare_modes(setup, base.reference, model, base.gaps)
    if found is None:
        return [], [], [], []
    partner = found.pairs.partner
    mates = np.where(partner >= 0, found.freq_reduced[np.maximum(partner, 0)], np.inf)
    errors = mates / found.freq_reference - 1.0
    matrix = np.round(found.pairs.matrix, 4).tolist()
    return found.freq_reference.tolist(), errors.tolist(), found.pairs.mac.tolist(), matrix


def _load_outcome(case: Case, bay: Bay, load: str, run: Run) -> tuple[FloatArray, LoadOutcome]:
    """Figures of a run, against the unreduced run of the same load; and the frequencies of the spectra."""
    setup = bay.base(case).under(load)
    window = excitation_window(setup.study, output_times(setup))
    freq, spectra = _spectra(setup, run, window)
    rows = [
        EventRow(e.t_start, e.t_peak, e.force_peak_filtered, e.force_peak, e.impulse, e.group)
        for e in events_in(run.events, window)
    ]
    pairs: list[list[int]] = []
    fit: dict[str, float | None] = {}
    against = bay.cases[case.against]
    if against.name != case.name:
        other = bay.unreduced(against, load)
        theirs = bay.base(against).under(load)
        fit = nrmse_by_axis(_spectra(theirs, other, window)[1], spectra)
        v = setup.study.config.verification
        match = match_events(other.events, run.events, v.event_tolerance, window)
        first, second = (events_in(r.events, window) for r in (other, run))
        pairs = [[first.index(a), second.index(b)] for a, b in match.pairs if a in first and b in second]
    history = run.history
    mean_square = np.sqrt((np.abs(spectra) ** 2).mean(axis=1))
    return freq, LoadOutcome(
        run.cost.cpu_s,
        run.cost.wall_s,
        history.time.size - 1,
        history.contact_steps,
        history.energy_created,
        rows,
        pairs,
        fit,
        [[float(f"{x:.4g}") for x in row] for row in mean_square.tolist()],
    )


def _spectra(setup: Setup, run: Run, window: tuple[float, float]) -> tuple[FloatArray, ComplexArray]:
    found = compare_spectra(setup, {"reduced": run}, window)
    assert found is not None
    return found.freq, found.spectra["reduced"]


def _newton(case: Case, base: Base, system: System) -> dict[str, float] | None:
    if not case.newton:
        return None
    gaps: GapOperator = base.gaps
    return asdict(newton_cost(system, gaps, base.under("A4").loads, base.scheme, TIMED_STEPS))
