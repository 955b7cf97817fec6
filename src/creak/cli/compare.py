"""`creak compare`: two results side by side, or a result and time histories of a test."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from creak.cli.details import tell_notes, tell_warnings
from creak.cli.output import OUTPUT, Output, writable_file, writable_folder
from creak.cli.run import results_name
from creak.errors import InputError

if TYPE_CHECKING:
    from creak.report.tables.comparison import Comparison
    from creak.studies.file.reader import Study


def compare(
    first: Path = typer.Argument(..., metavar="A", help="Folder that `creak run` wrote."),
    second: Path | None = typer.Argument(
        None, metavar="[B]", help="Another one, or a file of time histories of a test; or give --set."
    ),
    changes: list[str] = typer.Option(
        [],
        "--set",
        metavar="KEY=VALUE",
        help="Instead of B: run the study of A, which must lie beside the folder, with this value. Repeatable.",
    ),
    out: Path | None = typer.Option(None, "--out", metavar="FILE", help="The page; default: comparison.html beside A."),
    output: Output = OUTPUT,
) -> None:
    """Put two results side by side: settings, events, force, impulse, gaps and relative motion, place by place.

    With a file of time histories of a test as B: measured over computed courses, aligned in time.

    Example: creak compare door/results --set contact.flange.clearance=3.2
    """
    from creak.api.compare import compare as compare_results
    from creak.api.extras import missing_for_report, no_report_text
    from creak.studies.findings.beside_records import holds_records

    if (second is None) == (not changes):
        raise InputError(
            "one result has nothing to be compared with" if second is None else "B and --set were both given",
            expected="a second folder, or --set KEY=VALUE",
            fix="creak compare A B, or creak compare A --set contact.NAME.clearance=3.2",
        )
    page = out if out is not None else first.parent / "comparison.html"
    writable_file(page)
    with output:
        if second is not None and holds_records(second):
            _with_test(first, second, page, output)
            return
        if second is None:
            second = _run_changed(first, changes, output)
        found = compare_results(first, second)
        _print(output, found)
        if missing_for_report():
            output.warn(no_report_text())
        else:
            from creak.report.comparison_page import write_comparison

            write_comparison(found, page)
            output.wrote(page)
        output.tell_written()
        output.result({**found.as_dict(), "written": [str(path) for path in output.written]})


def _with_test(results: Path, test: Path, page: Path, output: Output) -> None:
    """The time histories of a test over those of a result."""
    from creak.api.compare import compare_records
    from creak.api.extras import missing_for_report, no_report_text
    from creak.report.words.correlation import record_rows, record_sentence

    found = compare_records(results, test)
    output.table(f"{test.name} over the {found.run} run of {results.name}", record_rows(found))
    output.say(record_sentence(found))
    tell_notes(output, found.notes, set())
    if missing_for_report():
        output.warn(no_report_text())
    else:
        from creak.report.correlation_page import write_records

        write_records(found, page)
        output.wrote(page)
    output.tell_written()
    output.result({**found.as_dict(), "written": [str(path) for path in output.written]})


def _print(output: Output, found: Comparison) -> None:
    from creak.report import comparison_page as shown

    for title, table, left in (
        ("Settings that differ", shown.settings_table(found), (0, 1, 2)),
        ("The whole run", shown.figures_table(found), (0,)),
        (shown.places_title(found), shown.places_table(found), (0, 1)),
    ):
        if table.rows:
            output.table(title, shown.rows(table), left)
    output.say(shown.sentence(found))
    for text in shown.verdicts(found):
        output.say(text)


def _run_changed(folder: Path, changes: list[str], output: Output) -> Path:
    """Run the study of a result with changes; returns the folder of the new result."""
    from creak.api.study import run_setup, set_up
    from creak.studies.findings.save import check_folder

    study = _changed_study_of(folder, changes)
    results = folder.parent / results_name(study)
    writable_folder(results)
    check_folder(results)
    with output.progress as progress:
        with progress.phase("read the model and find the contacts"):
            setup = set_up(study)
        tell_warnings(output, setup.notes, set())
        result = run_setup(setup, progress, record=False)
        output.wrote(*result.save(results))
    return results


def _changed_study_of(folder: Path, changes: list[str]) -> Study:
    """The study that a result was made from, changed.

    Raises
    ------
    InputError : the study file is not beside the folder, or it, its deck or another file that it names is no longer
        what was run.
    """
    from creak.api.saved import open_result
    from creak.api.study import read_study
    from creak.studies.file.changes import read_changes, with_changes
    from creak.studies.file.paths import digests_of

    wanted = read_changes(changes)
    found = open_result(folder).findings
    stored, run = found.setup.study, found.identity
    path = folder.parent / stored.path.name
    if not path.is_file():
        raise InputError(
            f"the study of {folder} is not beside it: no {path}",
            expected="the study file in the folder above the results",
            fix="Run the changed study by itself (creak run STUDY.toml --set ...), then give both folders.",
        )
    study = read_study(path)
    again = f"Run it again (creak run {path}), then compare."
    if study.text != stored.text:
        raise InputError(f"{path} is no longer the study that {folder} was made from", fix=again)
    whats = f"the deck of {path} has", f"the other files that {path} names have"
    for what, was, now in zip(whats, (run.deck_sha256, run.files_sha256), digests_of(study), strict=True):
        if was != now:
            raise InputError(
                f"{what} changed since {folder} was made: the two would differ by more than --set says",
                expected="the files as they were",
                fix=again,
            )
    return with_changes(study, wanted)
