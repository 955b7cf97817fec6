"""Friction of a run, as its summary has it: of the place that rubs most, and of the whole run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

OF_A_PLACE = ("friction", "slips", "slip_rate", "slip_path", "friction_energy")
"""Of the place that turns most into heat, as summary.json names them."""
OF_A_RUN = ("rubbing_place", *OF_A_PLACE, "stick_slip_events", "friction_energy_total")


def friction_of(run: Mapping[str, Any]) -> dict[str, Any]:
    """Figures of `OF_A_RUN`; None where nothing rubs. What rests is called by its contact."""
    out: dict[str, Any] = dict.fromkeys(OF_A_RUN)
    places = [p for p in (*run.get("places", ()), *run.get("resting", ())) if p["friction"] is not None]
    total = (run.get("energies") or {}).get("friction")
    if places:
        most = max(places, key=lambda p: p["friction_energy"] or 0.0)
        out |= {"rubbing_place": most.get("name", most["contact"])} | {key: most[key] for key in OF_A_PLACE}
    if places or total:
        out |= {"stick_slip_events": len(run.get("slip_events", ())), "friction_energy_total": total}
    return out
