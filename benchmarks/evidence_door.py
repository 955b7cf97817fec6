"""The door of `benchmarks.evidence`: models kept by their reduction, runs under any load, figures of two runs."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.door import door_study, silent
from creak.contact.gap_operator import GapOperator
from creak.studies.file.config import ReductionTable, StudyConfig
from creak.studies.models.reduced import ReducedModel, reduce_model
from creak.studies.models.reference import ReferenceModel, build_reference
from creak.studies.prepare.excitation import loads_over
from creak.studies.prepare.marching import Observed
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.run.agreement import compare_modes
from creak.studies.run.one_run import Run, march_run
from creak.studies.run.precheck import with_linear_gaps
from creak.studies.sweep.cases import changed
from creak.verify.matching import match_events
from creak_thesis.door import LOADS, write_door

SIGNAL, WHOLE = "excitation.hinge.signal", (0.0, np.inf)
ALPHA, BETA = 1.82784, 7.23432e-05
"""Rayleigh damping of the door's deck, 2 % at 8 and 80 Hz."""


class Bench:
    """A door, its channels under the hardest load, and the models made of it."""

    def __init__(self, mesh_size: float, changes: Mapping[str, Any] | None = None, load: str = "A4") -> None:
        self.mesh_size, self.load, self._changes = mesh_size, load, dict(changes or {})
        self.setup = self._set_up({f"{SIGNAL}.amplitude": LOADS[load]})
        self.reference: ReferenceModel = build_reference(self.setup.structure, self.setup.band, silent)
        self._closest = {load: self._linear(load) for load in ("A2", "A3", "A4")}
        self.gaps: GapOperator = self.setup.contacts.select(np.flatnonzero(self._closest[load] <= self._margin))
        self._models: dict[str, ReducedModel] = {}

    @property
    def _margin(self) -> float:
        return self.setup.study.config.precheck.margin

    @property
    def tolerance(self) -> float:
        return self.setup.study.config.verification.event_tolerance

    def _set_up(self, changes: Mapping[str, Any]) -> Setup:
        with tempfile.TemporaryDirectory() as folder:
            write_door(self.mesh_size, Path(folder))
            study = door_study(Path(folder))
            data = changed(study.config.model_dump(exclude_unset=True), {**self._changes, **changes}, None)
            return set_up(replace(study, config=StudyConfig.model_validate(data)))

    def _linear(self, load: str) -> Any:
        setup = self.under(LOADS[load])
        of = setup.study.config.precheck, setup.reduction, setup.marching
        return with_linear_gaps(*of, self.reference, silent).linear_gaps

    def kept(self, load: str) -> int:
        """Channels that the pre-check keeps under a load."""
        return int(np.count_nonzero(self._closest[load] <= self._margin))

    def damped(self, factor: float) -> Bench:
        """The same door with its damping times a factor."""
        rayleigh = {"alpha": factor * ALPHA, "beta": factor * BETA}
        other = Bench(self.mesh_size, {**self._changes, "damping": {"rayleigh": rayleigh}}, self.load)
        other.gaps = self.gaps
        return other

    def under(self, amplitude: float, seed: int = 1, base: Setup | None = None) -> Setup:
        """The setup under another load."""
        setup = self.setup if base is None else base
        data = setup.study.config.model_dump(exclude_unset=True)
        data = changed(data, {f"{SIGNAL}.amplitude": amplitude, f"{SIGNAL}.seed": seed}, None)
        study = replace(setup.study, config=StudyConfig.model_validate(data))
        return replace(setup, study=study, loads=loads_over(setup.model, study.driving, study.course))

    def model(self, table: Mapping[str, Any]) -> ReducedModel:
        """A reduced model, made once."""
        key = repr(sorted(table.items()))
        if key not in self._models:
            setup = self.setup.with_tables(reduction=ReductionTable.model_validate(table))
            self._models[key] = reduce_model(setup.reduction, self.reference, self.gaps, silent)
        return self._models[key]

    def run(
        self,
        load: str,
        model: ReducedModel,
        *,
        gaps: GapOperator | None = None,
        amplitude: float | None = None,
        seed: int = 1,
        base: Setup | None = None,
    ) -> Run:
        """A run of a reduced model; with other channels, another amplitude, phases or setup."""
        setup = self.under(LOADS[load] if amplitude is None else amplitude, seed, base)
        return self._march("reduced", setup, model, gaps)

    def unreduced(
        self, load: str, end: float | None = None, *, gaps: GapOperator | None = None, base: Setup | None = None
    ) -> Run:
        """A run of the unreduced model."""
        setup = self.under(LOADS[load], base=base)
        if end is not None:
            table = setup.study.config.time.model_copy(update={"periods": None, "end": end})
            setup = setup.with_tables(time=table)
            setup = replace(setup, loads=loads_over(setup.model, setup.study.driving, setup.study.course))
        return self._march("unreduced", setup, self.reference, gaps)

    def _march(self, name: str, setup: Setup, model: ReducedModel | ReferenceModel, gaps: GapOperator | None) -> Run:
        observed = Observed(setup.study.config.verification, setup.static, setup.watch.nodes)
        return march_run(name, setup.marching, observed, model, self.gaps if gaps is None else gaps, silent)

    def forced(self, time: Mapping[str, Any]) -> Setup:
        """The setup with a forced step."""
        return self._set_up({f"{SIGNAL}.amplitude": LOADS[self.load], "time": {"periods": 5, **time}})


def rattle(run: Run) -> dict[str, Any]:
    """What a run found."""
    events = run.events
    return {
        "events": len(events),
        "impulse": sum(e.impulse for e in events),
        "force": max((e.force_place for e in events), default=0.0),
        "energy_created": run.history.energy_created,
    }


def figures(pairs: Sequence[tuple[Run, Run]], tolerance: float) -> dict[str, Any]:
    """Events of runs against those of their references, all together.

    Errors are the mean size (`force_error`, `impulse_error`) and the mean (`_bias`) of the difference over the mean of
    the reference's events in common; forces are those of the place, low-passed.
    """
    matches = [match_events(a.events, b.events, tolerance, WHOLE) for a, b in pairs]
    both = [pair for m in matches for pair in m.pairs]
    found: dict[str, Any] = {
        "reference": sum(len(m.pairs) + len(m.missed) for m in matches),
        "matched": len(both),
        "missed": sum(len(m.missed) for m in matches),
        "extra": sum(len(m.extra) for m in matches),
    }
    for name, key in (("force", "force_place"), ("impulse", "impulse")):
        a, b = (np.array([getattr(pair[k], key) for pair in both]) for k in (0, 1))
        whole = float(a.sum())
        found[f"{name}_error"] = float(np.abs(b - a).sum()) / whole if whole else None
        found[f"{name}_bias"] = float((b - a).sum()) / whole if whole else None
    starts = np.array([b.t_start - a.t_start for a, b in both])
    found["start_error"] = float(np.abs(starts).mean()) if starts.size else None
    found["start_bias"] = float(starts.mean()) if starts.size else None
    single = np.array([abs(b.impulse / a.impulse - 1.0) for a, b in both if a.impulse > 0.0])
    found["single_impulse_median"] = float(np.median(single)) if single.size else None
    total = sum(e.impulse for a, _ in pairs for e in a.events)
    found["total_impulse_ratio"] = sum(e.impulse for _, b in pairs for e in b.events) / total if total else None
    return found


def worst(bench: Bench, table: Mapping[str, Any], model: ReducedModel) -> tuple[float | None, float]:
    """Largest relative error of a frequency to 100 Hz (None: a mode has no partner), and the lowest MAC."""
    setup = bench.setup.with_tables(reduction=ReductionTable.model_validate(table))
    found = compare_modes(setup.watch, setup.study.config.verification.mac_f_max, bench.reference, model, bench.gaps)
    assert found is not None
    partner = found.pairs.partner
    lowest = float(found.pairs.mac.min())
    if (partner < 0).any():
        return None, lowest
    return float(np.abs(found.freq_reduced[partner] / found.freq_reference - 1.0).max()), lowest
