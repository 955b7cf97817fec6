"""The event table as CSV, in full precision, for the report's download."""

from __future__ import annotations

import csv
import io
from typing import Any

from creak.formats.measured.csv_rows import plain_row
from creak.model.units import Units
from creak.studies.findings.places import place_of
from creak.studies.findings.tree import Findings
from creak.verify.events import Event, events_in


def event_csv(result: Findings, units: Units) -> str:
    """A line per event of the verification window and run; `match` numbers those that are the same event."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(
        [
            "run",
            "match",
            "contact",
            "place",
            "node",
            "channel",
            "t_start_s",
            "t_peak_s",
            "t_end_s",
            f"force_{_unit(units.force)}",
            f"node_force_low_passed_{_unit(units.force)}",
            f"node_force_raw_{_unit(units.force)}",
            f"impulse_{_unit(units.impulse)}",
            f"closing_speed_{_unit(units.speed)}",
            "micro_contacts",
            "unfinished",
        ]
    )
    numbers = _matches(result)
    for name, run in result.runs.items():
        for e in events_in(run.events, result.window):
            writer.writerow(plain_row(_row(name, e, numbers.get((name, id(e)), ""), result)))
    return out.getvalue()


def _unit(text: str) -> str:
    return text.replace("/", "_per_").replace(" ", "_")


def _matches(result: Findings) -> dict[tuple[str, int], int]:
    """(run, event) -> number of the pair."""
    if result.events is None:
        return {}
    out = {}
    for k, (reference, reduced) in enumerate(result.events.pairs, start=1):
        out[("reference", id(reference))] = k
        out[("reduced", id(reduced))] = k
    return out


def _row(name: str, e: Event, match: Any, result: Findings) -> list[Any]:
    place = place_of(result.places, e)
    return [
        name,
        match,
        e.group,
        "" if place is None else place.number,
        result.setup.model.nodes.label(e.node_idx),
        e.channel,
        *(f"{x:.9g}" for x in (e.t_start, e.t_peak, e.t_end)),
        *(f"{x:.9g}" for x in (e.force_place, e.force_peak_filtered, e.force_peak, e.impulse, e.closing_speed)),
        e.contacts,
        "yes" if e.unfinished else "",
    ]
