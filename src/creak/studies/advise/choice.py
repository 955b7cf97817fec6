"""From the facts to settings: what to change in the study, and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from creak.studies.advise import words
from creak.studies.advise.contact import StepAdvice, substeps_for
from creak.studies.advise.evidence import DOOR, case, record
from creak.studies.advise.facts import Facts, Option
from creak.studies.models.reduced import WHOLE
from creak.studies.prepare.setup import Setup
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
class Choice:
    """The advice."""

    option: Option | None
    """None: run the unreduced model."""
    exact: bool
    """No step is forced, so none is advised."""
    step: StepAdvice
    substeps: int
    changes: tuple[Change, ...]
    because: tuple[str, ...]
    warnings: tuple[str, ...]


def choose(setup: Setup, facts: Facts) -> Choice:
    """Settings for this study; what it has already is kept where it is good enough."""
    step = _step(setup, facts)
    option, why = _option(setup, facts, step)
    own = setup.study.config.time.substeps
    substeps = max(own, min(substeps_for(step.step, step.fixed), MOST_SUBSTEPS))
    exact, forced = (
        setup.study.config.time.exact,
        [
            *words.why_step(setup, step),
            *words.why_substeps(step, substeps),
            *words.why_stiffness(setup, step, substeps),
        ],
    )
    because = [
        why,
        *words.why_f_max(facts, option),
        *(words.why_exact(setup, facts) if exact else forced),
        *words.why_retained(setup, facts),
        *words.why_unreduced(facts, step),
    ]
    changes = tuple(_changes(setup, option, step, substeps))
    return Choice(option, exact, step, substeps, changes, tuple(because), tuple(words.warnings(setup, facts, option)))


def _step(setup: Setup, facts: Facts) -> StepAdvice:
    """The study's own where it is short enough, else the longest that is."""
    fine = [s for s in facts.steps if s.per_period >= PER_PERIOD * 0.999]
    own = [s for s in fine if abs(s.step / setup.study.config.time.step - 1.0) < 1e-6]
    return own[0] if own else fine[0]


def _option(setup: Setup, facts: Facts, step: StepAdvice) -> tuple[Option | None, str]:
    """How to reduce, and why so."""
    table = setup.study.config.reduction
    if table.method == "none" and step.unreduced_s <= words.AFFORDABLE_S:
        return None, f"method: none as in the study, because the run takes at most {duration(step.unreduced_s)}"
    if facts.unreduced is None:
        return _by_parts(facts, setup.f_max), (
            "method: craig-bampton, because memory does not hold a factor of the whole model, which modes of the "
            "assembly take"
        )
    if table.substructures or table.unreduced or setup.superelements:
        return _by_parts(facts, setup.f_max), (
            "method: craig-bampton, because the study has substructures, unreduced sets or imported parts; one "
            "assembly without them would be smaller with gap-modes"
        )
    if any(t.stiffness == "hard" for t in setup.study.config.contact.values()):
        return _by_parts(facts, setup.f_max), (
            "method: craig-bampton, because contact is hard: the static shapes of gap-modes have hardly any mass, and "
            "hard contact on them takes very short steps"
        )
    keep = f"keep craig-bampton with f_max = {_by_parts(facts, setup.f_max).f_max:g} where parts are exchanged or saved"
    if facts.gaps.m == 0:
        return _whole(facts, 0.0), (
            f"method: gap-modes, because no channel closes and modes of the assembly are exact below f_max; {keep}"
        )
    return _whole(facts, setup.f_max if table.method == WHOLE else 0.0), (
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


def _changes(setup: Setup, option: Option | None, step: StepAdvice, substeps: int) -> Iterator[Change]:
    """Lines that differ from the study."""
    c, wanted = setup.study.config, dict[str, tuple[Any, Any]]()
    if option is not None:
        wanted |= _reduction(setup, option)
    if not c.time.exact:
        wanted["time.step"] = (c.time.step, step.step)
        wanted["time.substeps"] = (c.time.substeps, substeps)
    wanted["precheck.enabled"] = (c.precheck.enabled, True)
    if step.unreduced_s > LONG_S and option is not None:
        wanted["reference.run"] = (c.proof, "spots")
    for key, (old, new) in wanted.items():
        if old != new:
            yield Change(key, old, new)


def _reduction(setup: Setup, option: Option) -> dict[str, tuple[Any, Any]]:
    table = setup.study.config.reduction
    wanted: dict[str, tuple[Any, Any]] = {
        "reduction.method": (table.method, option.method),
        "reduction.keep_out": (table.keep_out, 0.0),
    }
    if not setup.auto or option.method != table.method:
        wanted["reduction.f_max"] = (table.f_max, float(f"{option.f_max:.6g}"))
    if table.interface.type in ("spacing", "participation") or (
        option.method == WHOLE and table.interface.type != "full"
    ):
        wanted["reduction.interface"] = (table.interface.model_dump(exclude_unset=True), {"type": "full"})
    return wanted
