"""The figures of a summary that go into the table of a sweep, as one flat row."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from creak.model.units import UNITS

OF_A_PLACE = ("friction", "slips", "slip_rate", "slip_path", "friction_energy")
"""Of the place that turns most into heat, as summary.json names them."""
OF_FRICTION = ("rubbing_place", *OF_A_PLACE, "stick_slip_events", "friction_energy_total")
OF_A_RUN = (
    *("dof", "retained", "modes", "channels", "wall_s", "cpu_s", "offline_cpu_s", "peak_rss_gb", "events"),
    *("max_force", "impulse_total", "energy_error"),
)
RUNS = ("reduced", "reference")
OF_PLACES: dict[str, Callable[[list[dict[str, Any]]], Any]] = {
    "places": len,
    "first_place": lambda places: places[0]["name"] if places else None,
    "force": lambda places: max((p["force"] for p in places), default=0.0),
    "n5": lambda places: max((p["n5"] for p in places if p["n5"] is not None), default=None),
}
"""Number of places, the one that is ranked first, the largest force of any, low-passed, and the loudest one's N5."""
VERDICT = "verdict"
OF_RUNS = (*OF_A_RUN, *OF_PLACES, *OF_FRICTION, VERDICT)
"""Columns of a run, in order."""
OF_EVENTS = {
    "events_matched": "matched",
    "events_missed": "missed",
    "events_extra": "extra",
    "amplitude_ratio": "amplitude_ratio_mean",
    "impulse_ratio": "impulse_ratio_mean",
}
OF_COLUMNS = {
    "wall_s": "s",
    "cpu_s": "s",
    "offline_cpu_s": "s",
    "peak_rss_gb": "GiB",
    "case_wall_s": "s",
    "n5": "sone",
    "slip_rate": "1/s",
}
"""Units of columns that do not depend on those of the deck."""
OF_THE_DECK = {
    "max_force": "force",
    "force": "force",
    "impulse_total": "impulse",
    "slip_path": "length",
    "friction_energy": "energy",
    "friction_energy_total": "energy",
}
"""Columns in units of the deck -> their quantity."""


def flat_figures(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Run and figure -> number; what a study did not look at is left out, what is undefined is None."""
    out: dict[str, Any] = {"units": summary["units"]}
    for name in RUNS:
        run = summary["runs"].get(name)
        if run is not None:
            out |= {f"{name}.{key}": len(run[key]) if key == "events" else run[key] for key in OF_A_RUN}
            out |= {f"{name}.{key}": of(run["places"]) for key, of in OF_PLACES.items()}
            out |= {f"{name}.{key}": value for key, value in friction_of(run).items()}
            out[f"{name}.{VERDICT}"] = run.get(VERDICT)
    verification = summary["verification"]
    if verification.get("mac"):
        out["worst_mac"] = min(verification["mac"])
    out |= {f"nrmse_{axis}": value for axis, value in (verification.get("nrmse") or {}).items()}
    events = verification.get("events")
    if events is not None:
        out |= {column: events[key] for column, key in OF_EVENTS.items()}
    return out


def unit_of(column: str, units: str | None) -> str:
    """Unit of a column; empty for pure numbers and words."""
    figure = column.rpartition(".")[2]
    if figure in OF_THE_DECK and units in UNITS:
        return str(getattr(UNITS[units], OF_THE_DECK[figure]))
    return OF_COLUMNS.get(figure, "")


def friction_of(run: Mapping[str, Any]) -> dict[str, Any]:
    """Figures of `OF_FRICTION`; None where nothing rubs. What rests is called by its contact."""
    out: dict[str, Any] = dict.fromkeys(OF_FRICTION)
    places = [p for p in (*run.get("places", ()), *run.get("resting", ())) if p["friction"] is not None]
    total = (run.get("energies") or {}).get("friction")
    if places:
        most = max(places, key=lambda p: p["friction_energy"] or 0.0)
        out |= {"rubbing_place": most.get("name", most["contact"])} | {key: most[key] for key in OF_A_PLACE}
    if places or total:
        out |= {"stick_slip_events": len(run.get("slip_events", ())), "friction_energy_total": total}
    return out
