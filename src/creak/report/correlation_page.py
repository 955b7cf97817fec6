"""Pages of what was measured over what was computed: modes and functions of a deck, and courses of a run."""

from __future__ import annotations

from pathlib import Path

from creak.formats.complete_file import write_text
from creak.model.units import UNITS
from creak.report.beside_tests import frf_table, pair_table, record_table
from creak.report.figures import beside_test as beside
from creak.report.figures.beside_test import records_figure
from creak.report.figures.correlated import correlated_scene
from creak.report.html import file_parts
from creak.report.tables.run import Table
from creak.report.templates import page_templates, script_json
from creak.report.words.correlation import frf_sentence, sentence
from creak.report.words.records import record_sentence
from creak.report.words.text import as_sentence, number
from creak.report.words.update import gained_note, mode_rows, parameter_rows, update_notes, update_sentence
from creak.studies.findings.beside_records import RecordComparison
from creak.studies.models.beside_test import BesideTest
from creak.studies.models.update import ModelUpdate
from creak.studies.warned import plain_notes, warnings_of
from creak.version import version


def write_update(found: ModelUpdate, path: Path) -> None:
    """Write the page of a changed study: its modes beside the test, and what was changed."""
    units = found.study.config.model.units
    write_correlation(BesideTest(found.after.found, found.after, None), path, units, found)


def write_correlation(found: BesideTest, path: Path, units: str = "mm-t-s", update: ModelUpdate | None = None) -> None:
    """Write the page as one self-contained HTML file; it appears whole or not at all.

    Parameters
    ----------
    update : what brought the modes there.
    """
    modes, frfs = found.modes, found.frfs
    test = next(side.measured.path.name for side in (modes, frfs) if side is not None)
    shape, motions = (None, []) if modes is None else correlated_scene(modes)
    drawn = {} if modes is None else {"mac": beside.mac_figure(modes), "auto": beside.auto_figure(modes)}
    choices: list[tuple[str, str]] = []
    if frfs is not None:
        drawn["frfs"], choices = beside.frf_figure(frfs)
    pairs = None if modes is None else pair_table(modes)
    functions = None if frfs is None else frf_table(frfs)
    sentences = [*([] if modes is None else [sentence(modes)]), *([] if frfs is None else [frf_sentence(frfs)])]
    all_good = not any(flag for table in (pairs, functions) if table is not None for flag in table.flags)
    title = Path(found.found.model.source).name
    parameters = changes = None
    notes = [*([] if update is None else gained_note(update)), *plain_notes(found.notes)]
    doubts = warnings_of(found.notes)
    if update is not None:
        parameters, changes = (Table(rows[0], rows[1:]) for rows in (parameter_rows(update), mode_rows(update)))
        sentences, title = [update_sentence(update), *sentences], update.study.path.name
        doubts = [*update_notes(update), *doubts]
    text = (
        page_templates("creak.report")
        .get_template("correlation.html.j2")
        .render(
            **file_parts(),
            version=version(),
            title=f"{title} beside {test}",
            sentences=sentences,
            mark="good" if all_good else "look",
            parameters=parameters,
            changes=changes,
            pairs=pairs,
            functions=functions,
            choices=choices,
            error=None if frfs is None else number(frfs.error, 2),
            doubts=[as_sentence(doubt) for doubt in doubts],
            notes=[as_sentence(note) for note in notes],
            figures=drawn,
            specs=script_json({name: figure.spec for name, figure in drawn.items()}),
            scene=script_json(shape),
            motions=script_json(motions),
            motion_labels=[m["label"] for m in motions],
            units=UNITS[units],
        )
    )
    write_text(path, text)


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
