"""The page of `creak compare RESULTS TEST`: measured courses over computed ones, one channel at a time."""

from __future__ import annotations

from pathlib import Path

from creak.formats.complete_file import write_text
from creak.report.figures.beside_test import records_figure
from creak.report.html import file_parts, script_json
from creak.report.tables.beside_test import record_table
from creak.report.templates import page_templates
from creak.report.words.records import record_sentence
from creak.report.words.text import as_sentence
from creak.studies.findings.beside_records import RecordComparison
from creak.version import version


def write_records(found: RecordComparison, path: Path) -> None:
    """Write the page as one self-contained HTML file; it appears whole or not at all."""
    figure, choices = records_figure(found)
    drawn = {"records": figure}
    text = (
        page_templates("creak.report")
        .get_template("records.html.j2")
        .render(
            **file_parts(),
            version=version(),
            title=f"{found.results.name} beside {found.test.name}",
            sentence=record_sentence(found),
            channels=record_table(found),
            choices=choices,
            notes=[as_sentence(note) for note in found.notes],
            figures=drawn,
            specs=script_json({name: figure.spec for name, figure in drawn.items()}),
        )
    )
    write_text(path, text)
