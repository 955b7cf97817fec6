"""Advice before a run: retained dofs, f_max, step and substeps, contact stiffness, with their errors and costs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from creak.studies.advise.choice import Change, Choice
from creak.studies.advise.facts import Facts
from creak.studies.file.toml_text import toml_value


@dataclass(frozen=True)
class Advice:
    """What is known of a study that was not run, and what follows from it.

    Errors are those that the same settings left on other structures (`advise_evidence`), not estimates for this one;
    `bound` alone holds for any. Costs are of this machine: a factorisation and back-substitutions of the model, and
    the memory a reduced step reads, both times counts. Expect a factor of two.
    """

    facts: Facts
    choice: Choice

    @property
    def toml(self) -> str:
        """The lines of the study file to change; empty where nothing is to be changed."""
        return changes_toml(self.choice.changes)


def changes_toml(changes: tuple[Change, ...]) -> str:
    """The new lines as TOML, table by table."""
    tables: dict[str, list[str]] = {}
    for change in changes:
        table, key = change.key.rsplit(".", 1)
        tables.setdefault(table, [f"[{table}]"]).append(f"{key} = {toml_value(change.new)}")
    return "\n\n".join("\n".join(lines) for lines in tables.values()) + "\n" if tables else ""


def as_dict(advice: Advice) -> dict[str, Any]:
    """For a JSON file: no arrays, undefined figures are null."""
    f, c = advice.facts, advice.choice
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
            "toml": advice.toml,
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
