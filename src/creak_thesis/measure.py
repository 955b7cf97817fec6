"""One case measured: reduction, modes, runs under its loads, and what the usual way costs: steps of plain Newton with
refactorisation, timed and scaled to a whole run.

Plain Newton is the twin of `simulate` for tests and the yardstick of benchmarks: iterations on the whole structure,
refactorised whenever the contact changes; the same scheme, and the same result to round-off. Beside its steps the
condensed ones on the same matrices."""

from __future__ import annotations

import hashlib
import json
import time as clock
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak import Bench, GapOperator, Loads, NumericalError, Run, Scheme, System, match_events, nrmse_by_axis
from creak.stepping import (
    CondensedStepper,
    Factor,
    Instant,
    LinearTerms,
    StepFactor,
    Stepper,
    begin,
    channel_matrices,
    factor,
    first_instant,
    one_blas_thread,
    step_matrix,
    to_dense,
)
from creak_thesis.arrays import FloatArray
from creak_thesis.doors import Benches, under
from creak_thesis.outcome import EventRow, LoadOutcome, Outcome
from creak_thesis.plan import Case, Setting

MAX_ITERATIONS = 50


@dataclass(frozen=True)
class NewtonCost:
    """CPU time of plain Newton's steps on one model, and of condensed ones."""

    flight_s: float
    """A step without contact, s."""
    contact_s: float
    """A step with contact, s."""
    factorisations: float
    """Of a step, on average over all that were made with contact about."""
    condensed_flight_s: float
    condensed_contact_s: float
    steps: int
    """That were timed of each kind."""


def touching(gaps: GapOperator) -> GapOperator:
    """The same channels without clearance: they touch within a few steps."""
    return replace(gaps, gap0=np.zeros(gaps.m))


def newton_cost(system: System, gaps: GapOperator, loads: Loads, scheme: Scheme, steps: int) -> NewtonCost:
    """Time `steps` steps in flight, and as many in contact on the same channels without clearance.

    Every iteration of a step factorises anew, as an implicit code without condensation does.
    """
    closed = touching(gaps)
    flight = _timed(PlainNewton(system, gaps.without_force(), loads, scheme), steps, pressed=False)
    newton = PlainNewton(system, closed, loads, scheme)
    contact = _timed(newton, steps, pressed=True)
    condensed = CondensedStepper(system, closed, loads, scheme)
    again = _timed(CondensedStepper(system, gaps.without_force(), loads, scheme), 5 * steps, pressed=False)
    return NewtonCost(
        flight, contact, newton.factorisations / newton.steps, again, _timed(condensed, 5 * steps, pressed=True), steps
    )


def _timed(stepper: Stepper, steps: int, *, pressed: bool) -> float:
    """Median CPU time of `steps` steps that end with or without contact."""
    now, seconds = stepper.start(), []
    with one_blas_thread():
        for _ in range(20 * steps):
            started = clock.process_time()
            for now in stepper.advance(now):  # noqa: B007, B020
                pass
            if bool(now.p.any()) == pressed:
                seconds.append(clock.process_time() - started)
            if len(seconds) == steps:
                break
    return float(np.median(seconds)) if seconds else float("nan")


class PlainNewton:
    """One step by Newton's method: (S + (1 - af) beta h^2 G' k G) da = residual, k the tangent of the channels.

    Normal laws with a tangent: penalty, damper, pressure curve. Exact contact and friction have none.
    """

    def __init__(self, system: System, gaps: GapOperator, loads: Loads, scheme: Scheme) -> None:
        if system.damping.modal_shapes is not None or gaps.rubbing or not np.isfinite(gaps.stiffness).all():
            raise ValueError("plain Newton handles neither modal damping nor friction nor exact contact")
        started = clock.perf_counter()
        self.scheme, self.gaps, self.loads, self.h, self.substeps = scheme, gaps, loads, loads.step, 1
        S = step_matrix(system, scheme, self.h)
        self.S: Any = S if sp.issparse(S) else to_dense(S)
        self.on = channel_matrices(system, gaps)
        self.terms = LinearTerms(system, loads)
        self.factorisations, self.steps, self.residual = 0, 0, 0.0
        self._start = StepFactor(system, scheme, self.h)
        self.setup_s = clock.perf_counter() - started

    def start(self) -> Instant:
        """As the condensed stepper starts."""
        return first_instant(self.terms, self._start, self.scheme, self.gaps, self.on)

    def advance(self, now: Instant) -> Iterator[Instant]:
        """One step."""
        self.steps += 1
        scheme, h, on, gaps = self.scheme, self.h, self.on, self.gaps
        begun = begin(self.terms, gaps, on, scheme, h, now)
        half, support = begun.half, begun.support
        base = gaps.gap0 + on.G @ half.u + on.G_s @ support[0]
        base_rate = on.G @ half.v + on.G_s @ support[1]
        a, gain = now.x.a, scheme.gamma / (scheme.beta * h)
        gap, rate = self._at(a, base, base_rate)
        p, tangent = _normal_law(gaps, gap, rate, gain)
        for _ in range(MAX_ITERATIONS):
            residual = begun.right_side + (1.0 - scheme.alpha_f) * np.asarray(on.G.T @ p) - self.S @ a
            a = a + self._tangent(tangent).solve(residual)
            before = tangent
            gap, rate = self._at(a, base, base_rate)
            p, tangent = _normal_law(gaps, gap, rate, gain)
            if np.array_equal(tangent, before):  # every channel stayed on its piece: the step is solved
                break
        else:
            raise NumericalError(f"Newton did not converge at t = {self.loads.time[begun.row]:.6g} s")
        x = self.terms.advance(half, a, scheme, h, begun.fresh)
        yield Instant(begun.row, x, support, gap, rate, p, np.zeros(0), np.zeros(0, dtype=bool))

    def _at(self, a: FloatArray, base: FloatArray, base_rate: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gaps and their rates for an acceleration."""
        h, G = self.h, self.on.G
        move = np.asarray(G @ a)
        return base + self.scheme.beta * h * h * move, base_rate + self.scheme.gamma * h * move

    def _tangent(self, k: FloatArray) -> Factor:
        """A factor of the step matrix with the channels' tangent stiffness k (m,)."""
        self.factorisations += 1
        k = (1.0 - self.scheme.alpha_f) * self.scheme.beta * self.h**2 * k
        G = self.on.G
        if sp.issparse(self.S):
            G = sp.csr_matrix(G)
            return factor(sp.csr_matrix(self.S + G.T @ sp.diags_array(k) @ G))
        G = to_dense(G)
        return factor(to_dense(self.S) + (G.T * k) @ G)


def _normal_law(
    gaps: GapOperator, gap: FloatArray, rate: FloatArray, rate_gain: float
) -> tuple[FloatArray, FloatArray]:
    """Forces (m,) and -dp/dg, with the damper's share by rate = rate_gain g + ..."""
    elastic, slope = gaps.stiffness * -gap, gaps.stiffness.copy()
    if gaps.curves is not None:
        for j in np.flatnonzero((gaps.curves.of >= 0) & (gap < 0.0)):
            x, y = gaps.curves.points[gaps.curves.of[j]].T
            k = int(np.clip(np.searchsorted(x, -gap[j], side="right") - 1, 0, x.size - 2))
            slope[j] = gaps.curves.scale[j] * (y[k + 1] - y[k]) / (x[k + 1] - x[k])
            elastic[j] = gaps.curves.scale[j] * y[k] + slope[j] * (-gap[j] - x[k])
    p = elastic - gaps.damping * rate
    pressing = (gap < 0.0) & (p > 0.0)
    return np.where(pressing, p, 0.0), np.where(pressing, slope + gaps.damping * rate_gain, 0.0)


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
