"""report.html: one file that holds everything and opens anywhere, offline too."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from creak.arrays import IntArray
from creak.formats.complete_file import complete_file
from creak.report import event_tables, figures, method, tables, verdict
from creak.report.convergence import convergence_parts
from creak.report.picture import Loaded, contact_picture, data_uri, model_picture, standard_marks
from creak.report.text import UNITS, Units
from creak.report.view import outward
from creak.studies.converge import Convergence
from creak.studies.run import Run, StudyResult


@dataclass(frozen=True)
class Picture:
    """A PNG as a data URI, or why there is none."""

    uri: str
    caption: str


def write_report(
    result: StudyResult, summary: dict[str, Any], path: Path, convergence: Convergence | None = None
) -> None:
    """Write the report of a study as one self-contained HTML file.

    Parameters
    ----------
    summary : what `creak.studies.summary.summarise` makes of the result.
    path : the file; it appears whole or not at all.
    convergence : what `creak.studies.converge` found, where it was looked at.
    """
    text = report_text(result, summary, convergence)
    with complete_file(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")


def report_text(result: StudyResult, summary: dict[str, Any], convergence: Convergence | None = None) -> str:
    """The report as HTML."""
    from plotly.offline import get_plotlyjs

    units = UNITS[result.setup.study.config.model.units]
    environment = Environment(
        loader=PackageLoader("creak.report", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    template = environment.get_template("report.html.j2")
    parts = _verdict_parts(result, summary, units) | _drawn_parts(result, units) | _table_parts(result, summary, units)
    settling = None if convergence is None else convergence_parts(
        convergence, summary["convergence"]["findings"], units
    )  # fmt: skip
    return template.render(**parts, convergence=settling, plotly=Markup(get_plotlyjs()))


def _verdict_parts(result: StudyResult, summary: dict[str, Any], units: Units) -> dict[str, Any]:
    checks = verdict.checks(result, summary)
    config = result.setup.study.config
    return {
        "title": config.title or result.setup.study.path.stem,
        "version": summary["creak"],
        "sentence": verdict.sentence(result, summary, units),
        "checks": checks,
        "all_passed": all(c.passed is not False for c in checks),
        "compared": {"reduced", "reference"} <= result.runs.keys(),
        "warnings": verdict.warnings(result),
        "notes": summary["notes"],
        "unread": tables.unread_rows(summary),
        "method": method.paragraph(result),
        "parameters": method.parameters(result, summary, units),
    }


def _drawn_parts(result: StudyResult, units: Units) -> dict[str, Any]:
    drawn = {
        "force": figures.force_figure(result, units),
        "mac": figures.mac_figure(result),
        "spectra": figures.spectra_figure(result, units),
        "energy": figures.energy_figure(result, units),
    }
    specs = {name: figure.spec for name, figure in drawn.items() if figure.spec is not None}
    pictures = {"model_picture": _model_picture(result), "contact_picture": _contact_picture(result, units)}
    return {"figures": drawn, "specs": _script_json(specs), **pictures}


def _table_parts(result: StudyResult, summary: dict[str, Any], units: Units) -> dict[str, Any]:
    return {
        "events": event_tables.event_table(result, units),
        "statistics": event_tables.statistics_table(result, units),
        "counted": event_tables.counted_events(result),
        "agreement": event_tables.agreement_table(result),
        "slips": event_tables.slip_table(result, units),
        "squeak": event_tables.squeak_sentence(result),
        "balance": tables.balance_table(result, units),
        "frequencies": tables.frequency_table(result),
        "gaps": tables.gap_table(result, units),
        "parts": tables.part_table(summary, units),
        "costs": tables.cost_table(result, summary),
        "health": tables.health_tables(result),
        "energy_words": tables.energy_sentence(result),
    }


def _script_json(value: Any) -> Markup:
    """JSON that may stand inside a script element: no `<` that could end it."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029"))


def _model_picture(result: StudyResult) -> Picture:
    setup = result.setup
    moved = [*setup.driven.labels.values(), *setup.loads.force_labels]
    marks = standard_marks(
        np.unique(result.gaps.nodes_idx), np.unique(setup.pairs), _nodes([a // 6 for a in moved]),
        _nodes([f.nodes_idx for f in setup.model.fixed]),
    )  # fmt: skip
    png = model_picture(setup.model, marks, outward(result.setup.contacts, result.setup.model.nodes.coords))
    if png is None:
        return Picture("", "No picture: the model has no extent to draw.")
    caption = "The model from three-quarters and from the front, on the side of the secondary surface."
    return Picture(data_uri(png), caption)


def _contact_picture(result: StudyResult, units: Units) -> Picture:
    run = verdict.main_run(result)
    if run is None or result.gaps.m == 0:
        return Picture("", "No contact picture: there is no channel that can close.")
    loaded = _impulses(result, run, units)
    if not loaded.values.any():
        return Picture("", "No contact picture: nothing touched during the run.")
    png = contact_picture(result.setup.model, loaded, outward(result.setup.contacts, result.setup.model.nodes.coords))
    if png is None:
        return Picture("", "No contact picture: the model has no extent to draw.")
    who = "reduced" if run.name == "reduced" else "unreduced"
    return Picture(data_uri(png), f"Where contact happened: impulse at each contact node over the whole {who} run.")


def _impulses(result: StudyResult, run: Run, units: Units) -> Loaded:
    nodes, row = np.unique(result.gaps.nodes_idx, return_inverse=True)
    impulse = run.history.weights @ run.history.force
    total = np.bincount(row, impulse, nodes.size).astype(np.float64)
    return Loaded(nodes, total, f"impulse, {units.impulse}", units.impulse)


def _nodes(rows: list[IntArray]) -> IntArray:
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *rows]))
