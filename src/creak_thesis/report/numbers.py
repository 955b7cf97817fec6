"""The thesis's own numbers, from the data file beside this module."""

from __future__ import annotations

import json
import tomllib
from functools import cache
from importlib import resources
from typing import Any


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
