"""report.html: one file that holds everything and opens anywhere, offline too."""

from __future__ import annotations

import base64
import functools
import gzip
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup, escape

from creak.formats.complete_file import write_text
from creak.formats.stored.run_identity import META
from creak.model.units import UNITS, Units
from creak.report.beside_tests import MeasuredPart, measured_parts
from creak.report.drawn import Drawn
from creak.report.figures import gaps as gap_figures
from creak.report.figures import palette, scene
from creak.report.figures import run as figures
from creak.report.figures.gaps import eline_figure
from creak.report.figures.picture import Loaded, contact_picture, data_uri, model_picture, standard_marks
from creak.report.figures.spots import spots_figure
from creak.report.figures.view import Surface, outward
from creak.report.sound_parts import loudness_figure, sound_tables
from creak.report.tables import checks
from creak.report.tables import events as event_tables
from creak.report.tables import run as tables
from creak.report.tables.convergence import convergence_parts
from creak.report.tables.elines import eline_table, eline_words, material_table
from creak.report.tables.events import event_csv
from creak.report.tables.places import place_parts
from creak.report.templates import page_templates, script_json
from creak.report.words import answer, method, verdict
from creak.studies.findings.elines import line_rows, point_csv
from creak.studies.findings.summary import summary_of
from creak.studies.findings.tree import Findings

SECTIONS = {
    "top": "Verdict",
    "places": "Places",
    "checks": "Trust",
    "motion": "Motion",
    "loudness": "Loudness",
    "force": "Force and gap",
    "events": "Events",
    "elines": "E-lines",
    "tests": "Test",
    "expert": "For experts",
}
FILES = Path(__file__).parent
SCRIPTS = ("shaders.js", "viewer.js", "report.js")


@dataclass(frozen=True)
class Picture:
    """A PNG as a data URI, or why there is none."""

    uri: str
    caption: str


def write_page(result: Findings, drawn: Drawn, path: Path) -> None:
    """Write the report of a study as one self-contained HTML file.

    Parameters
    ----------
    result : of a run that has just ended, or read back from results.h5.
    drawn : what is drawn of its model and motion.
    path : the file; it appears whole or not at all.
    """
    text = report_text(result, drawn)
    write_text(path, text)


def report_text(result: Findings, drawn: Drawn) -> str:
    """The report as HTML."""
    summary = summary_of(result)
    units = UNITS[result.setup.study.config.model.units]
    template = page_templates("creak.report").get_template("report.html.j2")
    motions = scene.animations(result, drawn, units)
    tests = measured_parts(result)
    parts = (
        _verdict_parts(result, summary, units)
        | place_parts(result, summary, motions, units)
        | _drawn_parts(result, drawn.surface, units, tests)
        | _motion_parts(result, motions, scene.scene(result, drawn))
        | _table_parts(result, summary, units)
        | _eline_parts(result, summary, units)
        | file_parts()
        | {
            "provenance": [*result.provenance, ("Report written", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"))],
            "study_text": result.setup.study.text,
        }
    )
    settling = (
        None
        if result.convergence is None
        else convergence_parts(result.convergence, summary["convergence"]["findings"], units)
    )
    return template.render(**parts, convergence=settling, units=units, sections=_sections(parts))


def _sections(parts: dict[str, Any]) -> list[tuple[str, str]]:
    """What the bar at the top leads to."""
    needed = {
        "loudness": parts["figures"]["loudness"].spec,
        "elines": parts["elines"],
        "tests": parts["tests"],
    }
    skipped = {name for name, there in needed.items() if not there}
    return [(name, text) for name, text in SECTIONS.items() if name not in skipped]


def _verdict_parts(result: Findings, summary: dict[str, Any], units: Units) -> dict[str, Any]:
    judged = [*checks.checks(result, summary), *checks.against_tests(result)]
    config = result.setup.study.config
    return {
        "title": config.title or result.setup.study.path.stem,
        "version": summary["creak"],
        "run_meta": Markup(META.format(escape(summary["run"]["id"]))),
        "answer": (said := answer.answer(summary)),
        "tiles": answer.tiles(said, verdict.trust(summary)),
        "sentence": verdict.sentence(result, summary, units),
        "checks": judged,
        "trust": verdict.trust(summary),
        "mark": verdict.mark(judged, summary),
        "compared": {"reduced", "reference"} <= result.runs.keys(),
        "alarms": [*result.alarms, *verdict.first_mistakes(result, units)],
        "warnings": verdict.warnings(result),
        "notes": list(result.notes),
        "unread": tables.unread_rows(result),
        "method": method.paragraph(result),
        "parameters": method.parameters(result, summary, units),
    }


def _drawn_parts(result: Findings, surface: Surface | None, units: Units, tests: list[MeasuredPart]) -> dict[str, Any]:
    every = {
        "force": figures.force_figure(result, units),
        "gap": gap_figures.gap_figure(result, units),
        "precheck": gap_figures.precheck_figure(result, surface, units),
        "mac": figures.mac_figure(result),
        "spectra": figures.spectra_figure(result, units),
        "energy": figures.energy_figure(result, units),
        "elines": eline_figure(result, surface, units),
        "loudness": loudness_figure(result),
        "spots": spots_figure(result, units),
        **{plot.name: plot.figure for test in tests for plot in test.plots},
    }
    specs = {name: figure.spec for name, figure in every.items() if figure.spec is not None}
    pictures = {"model_picture": _model_picture(result), "contact_picture": _contact_picture(result, units)}
    return {"figures": every, "specs": script_json(specs), "tests": tests, **pictures}


def _motion_parts(result: Findings, motions: scene.Animations, shape: dict[str, Any] | None) -> dict[str, Any]:
    run = result.main
    every = [*motions.shown, *motions.modes]
    return {
        "has_scene": shape is not None,
        "scene": script_json(shape),
        "motions": every,
        "motions_json": script_json(every),
        "motion_labels": [m["label"] for m in every],
        "motion_words": motions.words,
        "motion_run": "unreduced" if run is None else checks.RUN_WORDS[run.name],
        "size_words": f"Animations take {motions.size / 1e6:.2g} MB of this file." if motions.shown else "",
    }


def file_parts() -> dict[str, Any]:
    """Style, scripts and colours that a page with plots and a 3-D view holds."""
    own = {name.replace(".", "_"): Markup((FILES / name).read_text(encoding="utf-8")) for name in SCRIPTS}
    return own | {
        "css": Markup((FILES / "report.css").read_text(encoding="utf-8")),
        "plotly": _plotly(),
        "colours": script_json(palette.DARK),
    }


@functools.cache
def _plotly() -> Markup:
    """The library of the plots."""
    from plotly.offline import get_plotlyjs

    return Markup(base64.b64encode(gzip.compress(get_plotlyjs().encode("utf-8"), mtime=0)).decode("ascii"))


def _table_parts(result: Findings, summary: dict[str, Any], units: Units) -> dict[str, Any]:
    return {
        "csv_events": script_json(event_csv(result, units)),
        "fits": tables.fit_table(result),
        "energy_created": checks.created(summary),
        "events": event_tables.event_table(result, units),
        "statistics": event_tables.statistics_table(result, units),
        "counted": event_tables.counted_events(result),
        "agreement": event_tables.agreement_table(result),
        "slips": event_tables.slip_table(result, units),
        "squeaks": event_tables.squeak_table(result, units),
        "squeak": event_tables.squeak_sentence(result),
        "balance": tables.balance_table(result, units),
        "frequencies": tables.frequency_table(result),
        "gaps": tables.gap_table(result, units),
        "parts": tables.part_table(result.setup, units),
        "costs": tables.cost_table(result),
        "health": tables.health_tables(result, units),
        "energy_words": tables.energy_sentence(result),
        "sounds": sound_tables(summary),
    }


def _eline_parts(result: Findings, summary: dict[str, Any], units: Units) -> dict[str, Any]:
    found, told = result.elines, summary.get("elines")
    if found is None or told is None:
        return {"elines": None, "eline_words": "", "eline_notes": "", "csv_elines": "", "materials": None}
    config, model = result.setup.study.config, result.setup.model
    rows = line_rows(found, config.limit, config.model.units)
    return {
        "elines": eline_table(rows, model, units, found.percentile),
        "eline_words": eline_words(told),
        "eline_notes": f"{told['risk']}. {told['definition']}",
        "materials": material_table(found, config.material_pairs),
        "csv_elines": script_json(point_csv(found, model, units.length)),
    }


def _model_picture(result: Findings) -> Picture:
    setup = result.setup
    marks = standard_marks(np.unique(result.gaps.nodes_idx), np.unique(setup.pairs), setup.driven, setup.held)
    png = model_picture(setup.model, marks, outward(result.setup.contacts, result.setup.model.nodes.coords))
    if png is None:
        return Picture("", "No picture: the model has no extent to draw.")
    caption = "The model from three-quarters and from the front, on the side of the secondary surface."
    return Picture(data_uri(png), caption)


def _contact_picture(result: Findings, units: Units) -> Picture:
    run = result.main
    if run is None or result.gaps.m == 0:
        return Picture("", "No contact picture: there is no channel that can close.")
    nodes, total = scene.node_impulses(result, run, (-np.inf, np.inf))
    loaded = Loaded(nodes, total, f"impulse, {units.impulse}", units.impulse)
    if not loaded.values.any():
        return Picture("", "No contact picture: nothing touched during the run.")
    png = contact_picture(result.setup.model, loaded, outward(result.setup.contacts, result.setup.model.nodes.coords))
    if png is None:
        return Picture("", "No contact picture: the model has no extent to draw.")
    who = "reduced" if run.name == "reduced" else "unreduced"
    return Picture(data_uri(png), f"Where contact happened: impulse at each contact node over the whole {who} run.")
