"""From the facts to settings: what to change in the study, and why; as TOML, and as plain data."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from creak.model.units import UNITS
from creak.studies.advise import words
from creak.studies.advise.contact import StepAdvice, substeps_for
from creak.studies.advise.evidence import DOOR, case, record
from creak.studies.advise.facts import Facts, Option
from creak.studies.file.config import PrecheckTable, Proof, TimeTable
from creak.studies.file.contact_tables import ContactTable
from creak.studies.file.toml_text import toml_value
from creak.studies.models.reduced import WHOLE
from creak.studies.prepare.reduction import Reduction
from creak.words import duration, percent

ENOUGH, ALL = 11.0, 15.0
"""f_max of fixed-interface modes over the excitation that is good enough, and that is advised (docs/guidelines.md).
Thesis 4.1: no gain beyond 11, for the hardest load 13."""
ASSEMBLY = 7.0
"""The same for modes of the assembly."""
PER_PERIOD = 40.0
"""Forced steps in a period of the excitation's highest frequency at which events are found."""
LONG_S = 3600.0
"""An unreduced run beyond this is not worth being part of every run."""
MOST_SUBSTEPS = 100


@dataclass(frozen=True)
class Change:
    """A line of the study file."""

    key: str
    """Dotted."""
    old: Any
    new: Any


@dataclass(frozen=True)
class Settings:
    """What a study says already of all that is advised."""

    reduction: Reduction
    time: TimeTable
    precheck: PrecheckTable
    proof: Proof
    until: float | None
    """s, where the study ends the unreduced run early."""
    contacts: Mapping[str, ContactTable]

    @property
    def stiffness(self) -> set[str]:
        """How that of its contacts is given: auto, hard, number, table."""
        tables = self.contacts.values()
        named = {t.stiffness if isinstance(t.stiffness, str) else "number" for t in tables if t.overclosure is None}
        return named | {"table" for t in tables if t.overclosure is not None}


@dataclass(frozen=True)
class Choice:
    """The advice on a study that was not run.

    Errors are those that the same settings left on other structures (`advise_evidence`), not estimates for this one;
    `bound` alone holds for any. Costs are of this machine: a factorisation and back-substitutions of the model, and
    the memory a reduced step reads, both times counts. Expect a factor of two.
    """

    facts: Facts
    option: Option | None
    """None: run the unreduced model."""
    exact: bool
    """No step is forced, so none is advised."""
    step: StepAdvice
    substeps: int
    changes: tuple[Change, ...]
    because: tuple[str, ...]
    warnings: tuple[str, ...]


def choose(own: Settings, facts: Facts) -> Choice:
    """Settings for a study; what it has already is kept where it is good enough."""
    time, units = own.time, UNITS[own.reduction.driving.units]
    # The study's own step where it is short enough, else the longest that is.
    fine = [s for s in facts.steps if s.per_period >= PER_PERIOD * 0.999]
    step = next((s for s in fine if abs(s.step / time.step - 1.0) < 1e-6), fine[0])
    option, why = _option(own, facts, step)
    substeps = max(time.substeps, min(substeps_for(step.step, step.fixed), MOST_SUBSTEPS))
    if time.exact:
        of_time = [*words.why_exact(time.accuracy, own.stiffness, facts)]
    else:
        of_time = [
            *words.why_step(step, time.step, facts.channels.contacts),
            *words.why_substeps(step, substeps),
            *words.why_stiffness(own.stiffness, step, substeps, units.stiffness),
        ]
    because = [
        why,
        *words.why_f_max(facts, option),
        *of_time,
        *words.why_retained(own.reduction.table, facts),
        *words.why_unreduced(facts, step),
    ]
    changes = _changes(own, option, step, substeps)
    warnings = words.warnings(own.precheck.words(units.length), units.length, facts, option)
    return Choice(facts, option, time.exact, step, substeps, tuple(changes), tuple(because), tuple(warnings))


def _option(own: Settings, facts: Facts, step: StepAdvice) -> tuple[Option | None, str]:
    """How to reduce, and why so."""
    table, f_max = own.reduction.table, own.reduction.band.f_max
    if table.method == "none" and step.unreduced_s <= words.AFFORDABLE_S:
        return None, f"method: none as in the study, because the run takes at most {duration(step.unreduced_s)}"
    if facts.unreduced is None:
        return _by_parts(facts, f_max), (
            "method: craig-bampton, because memory does not hold a factor of the whole model, which modes of the "
            "assembly take"
        )
    if table.substructures or table.unreduced or own.reduction.structure.superelements:
        return _by_parts(facts, f_max), (
            "method: craig-bampton, because the study has substructures, unreduced sets or imported parts; one "
            "assembly without them would be smaller with gap-modes"
        )
    if "hard" in own.stiffness:
        return _by_parts(facts, f_max), (
            "method: craig-bampton, because contact is hard: the static shapes of gap-modes have hardly any mass, and "
            "hard contact on them takes very short steps"
        )
    keep = f"keep craig-bampton with f_max = {_by_parts(facts, f_max).f_max:g} where parts are exchanged or saved"
    if facts.gaps.m == 0:
        return _whole(facts, 0.0), (
            f"method: gap-modes, because no channel closes and modes of the assembly are exact below f_max; {keep}"
        )
    return _whole(facts, f_max if table.method == WHOLE else 0.0), (
        f"method: gap-modes, because for one assembly it is the smallest: {_against_craig_bampton()} ({DOOR}); {keep}"
    )


def _against_craig_bampton() -> str:
    """Size and error of both, each with the multiple that is advised."""
    modes, parts = (case(record(), f"{name} {m:g} x") for name, m in (("gap modes", ASSEMBLY), ("Craig-Bampton", ALL)))
    return (
        f"{modes['unknowns']:,} unknowns and {percent(modes['impulse_error'])} in the impulse of an event with "
        f"{ASSEMBLY:g} times the excitation, against {parts['unknowns']:,} and {percent(parts['impulse_error'])} of "
        f"Craig-Bampton with {ALL:g} times"
    )


def _by_parts(facts: Facts, own: float) -> Option:
    """Craig-Bampton with the study's f_max where that is high enough, else with `ALL` times the excitation."""
    fit = [o for o in facts.options if o.method == "craig-bampton"]
    good = [o for o in fit if o.f_max == own and o.multiple >= ENOUGH * 0.999]
    return good[0] if good else next(o for o in fit if o.multiple >= ALL * 0.999)


def _whole(facts: Facts, own: float) -> Option:
    """The smallest option of gap modes with at least `ASSEMBLY`; the study's own where it is one."""
    fit = [o for o in facts.options if o.method == WHOLE and o.multiple >= ASSEMBLY * 0.999]
    return next((o for o in fit if o.f_max == own), fit[0])


def _changes(own: Settings, option: Option | None, step: StepAdvice, substeps: int) -> Iterator[Change]:
    """Lines that differ from the study."""
    wanted, time = dict[str, tuple[Any, Any]](), own.time
    if option is not None:
        wanted |= _reduction(own.reduction, option)
    if not time.exact:
        wanted["time.step"] = (time.step, step.step)
        wanted["time.substeps"] = (time.substeps, substeps)
    wanted["precheck.enabled"] = (own.precheck.enabled, True)
    kept = own.until is not None and math.isfinite(step.unreduced_s)
    if step.unreduced_s > LONG_S and option is not None and not kept:
        wanted["reference.run"] = (own.proof, "spots")
    for key, (old, new) in wanted.items():
        if old != new:
            yield Change(key, old, new)


def _reduction(own: Reduction, option: Option) -> dict[str, tuple[Any, Any]]:
    table = own.table
    wanted: dict[str, tuple[Any, Any]] = {
        "reduction.method": (table.method, option.method),
        "reduction.keep_out": (table.keep_out, 0.0),
    }
    if not own.band.auto or option.method != table.method:
        wanted["reduction.f_max"] = (table.f_max, float(f"{option.f_max:.6g}"))
    if table.interface.type in ("spacing", "participation") or (
        option.method == WHOLE and table.interface.type != "full"
    ):
        wanted["reduction.interface"] = (table.interface.model_dump(exclude_unset=True), {"type": "full"})
    return wanted


def changes_toml(changes: tuple[Change, ...]) -> str:
    """The new lines as TOML, table by table."""
    tables: dict[str, list[str]] = {}
    for change in changes:
        table, key = change.key.rsplit(".", 1)
        tables.setdefault(table, [f"[{table}]"]).append(f"{key} = {toml_value(change.new)}")
    return "\n\n".join("\n".join(lines) for lines in tables.values()) + "\n" if tables else ""


def as_dict(c: Choice) -> dict[str, Any]:
    """For a JSON file: no arrays, undefined figures are null."""
    f = c.facts
    data = {
        "excitation": dataclasses.asdict(f.excitation),
        "channels": dataclasses.asdict(f.channels),
        "parts": [{**dataclasses.asdict(p), "boundary": p.boundary} for p in f.sizes.parts],
        "coupled_dofs": f.sizes.coupled,
        "reductions": [dataclasses.asdict(o) for o in f.options],
        "unreduced": None if f.unreduced is None else dataclasses.asdict(f.unreduced),
        "sound": None if f.sound is None else dataclasses.asdict(f.sound) | {"dof_times": f.sound.dof_times},
        "steps": [dataclasses.asdict(s) for s in f.steps],
        "memory": {
            "stages": [dataclasses.asdict(s) for s in f.memory.run],
            "reduce_gb": f.memory.reduce_peak.gb,
            "run_gb": f.memory.run_peak.gb,
            "free_gb": f.memory.free_gb,
        },
        "advice": {
            "method": "none" if c.option is None else c.option.method,
            "f_max": None if c.option is None else c.option.f_max,
            "step": None if c.exact else c.step.step,
            "substeps": None if c.exact else c.substeps,
            "changes": [dataclasses.asdict(x) for x in c.changes],
            "toml": changes_toml(c.changes),
            "because": list(c.because),
            "warnings": list(c.warnings),
        },
    }
    return _plain(data)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {f"{k:g}" if isinstance(k, float) else str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
