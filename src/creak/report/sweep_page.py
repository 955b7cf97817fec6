"""The cases of a sweep, as rows for terminal and page, and as one HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from markupsafe import Markup

from creak.formats.complete_file import write_text
from creak.report.tables.run import Table
from creak.report.templates import page_templates
from creak.report.words.text import number, plural, setting
from creak.studies.sweep.figures import RUNS, unit_of
from creak.studies.sweep.job import Row
from creak.version import version

FILES = Path(__file__).parent
FIGURES = {
    "events": "events",
    "force": "force of the hardest place",
    "impulse_total": "impulse",
    "n5": "N5 of the loudest",
}
"""Of a run -> their names."""
FRICTION = {
    "friction": "hardest rub",
    "slips": "its slips",
    "slip_rate": "its slip rate",
    "slip_path": "its slip path",
    "friction_energy_total": "friction energy",
}
"""The same of what rubs; those that no case has are left out."""
COMPARED = {"impulse_total": "impulse", "friction_energy_total": "friction energy"}
"""What the sentence tells the least and the most of."""
SAME = 1e-9
"""Share by which impulses differ that are the same."""
MOST = 40
"""Rows in the terminal."""


def write_sweep_page(title: str, rows: Sequence[Row], path: Path) -> None:
    """Write the page as one self-contained HTML file, with links to the cases; it appears whole or not at all."""
    head, *cells = sweep_rows(rows)
    linked = [[_linked(row), *line[1:]] for row, line in zip(rows, cells, strict=True)]
    text = (
        page_templates("creak.report")
        .get_template("sweep.html.j2")
        .render(
            version=version(),
            title=title,
            sentence=sentence(rows),
            cases=Table(head, linked, text_columns=1 + len(rows[0].case.changes)),
            errors=[f"{r.case.name}: {r.outcome.error}" for r in rows if r.outcome.error],
            css=Markup((FILES / "report.css").read_text(encoding="utf-8")),
        )
    )
    write_text(path, text)


def sweep_rows(rows: Sequence[Row]) -> list[list[str]]:
    """Header, and of each case its name, what it changes, how it ended and the figures of its run."""
    run = next((r for r in RUNS if any(f"{r}.events" in row.outcome.record for row in rows)), RUNS[0])
    units = next((row.outcome.record["units"] for row in rows if "units" in row.outcome.record), None)
    keys = list(rows[0].case.changes)
    short = [key.rpartition(".")[2] for key in keys]
    names = [s if short.count(s) == 1 else key for s, key in zip(short, keys, strict=True)]
    rubbing = {
        key: name
        for key, name in FRICTION.items()
        if any(row.outcome.record.get(f"{run}.{key}") is not None for row in rows)
    }
    told = FIGURES | rubbing
    figures = [_with_unit(name, unit_of(key, units)) for key, name in told.items()]
    seeded = any(row.case.seed is not None for row in rows) and len({row.case.seed for row in rows}) > 1
    fitted = any(row.outcome.record.get("nrmse_all") is not None for row in rows)
    head = ["case", *names, *["seed"] * seeded, "status", *figures, *["fit"] * fitted]
    out = [head]
    for row in rows:
        record = row.outcome.record
        cells = [row.case.name, *(setting(row.case.changes[key]) for key in keys)]
        cells += [setting(row.case.seed)] * seeded
        cells += [row.outcome.status, *(_figure(record.get(f"{run}.{key}")) for key in told)]
        out.append([*cells, *[number(record.get("nrmse_all"))] * fitted])
    return out


def sentence(rows: Sequence[Row]) -> str:
    """How many cases there are, and which has the least and the most of impulse and friction."""
    said = [plural(len(rows), "case")]
    for run in RUNS:
        said += filter(None, (_between(rows, f"{run}.{key}", name) for key, name in COMPARED.items()))
        if len(said) > 1:
            break
    said += [f"{key} changes nothing" for key in idle_keys(rows)]
    return f"{'; '.join(said)}."


def idle_keys(rows: Sequence[Row]) -> list[str]:
    """Keys whose values change the impulse of no case, all others being the same: what they belong to does not move, or
    nothing that touches hangs on it."""
    run = next((r for r in RUNS if any(f"{r}.impulse_total" in row.outcome.record for row in rows)), RUNS[0])
    known = [row for row in rows if row.outcome.record.get(f"{run}.impulse_total")]
    idle = []
    for key in rows[0].case.changes if known else ():
        groups: dict[str, dict[str, float]] = {}
        for row in known:
            others = repr([row.case.seed, *(value for k, value in row.case.changes.items() if k != key)])
            groups.setdefault(others, {})[repr(row.case.changes[key])] = row.outcome.record[f"{run}.impulse_total"]
        several = [list(impulses.values()) for impulses in groups.values() if len(impulses) > 1]
        if several and all(max(x) - min(x) <= SAME * max(x) for x in several):
            idle.append(key)
    return idle


def _between(rows: Sequence[Row], column: str, name: str) -> str:
    """The least and the most of a column; nothing where fewer than two cases have one."""
    known = [(value, r) for r in rows if (value := r.outcome.record.get(column)) is not None]
    if len(known) < 2:
        return ""
    low, high = (choose(known, key=lambda pair: pair[0]) for choose in (min, max))
    unit = unit_of(column, high[1].outcome.record["units"])
    least, most = (f"{number(value)} {unit} ({r.case.name})" for value, r in (low, high))
    return f"{name} from {least} to {most}"


def _linked(row: Row) -> Any:
    if not row.outcome.record.get("case_wall_s"):
        return row.case.name
    return Markup('<a href="{}/report.html">{}</a>').format(quote(row.case.folder_name), row.case.name)


def _with_unit(name: str, unit: str) -> str:
    return f"{name}, {unit}" if unit else name


def _figure(value: Any) -> str:
    return value if isinstance(value, str) else number(value)
