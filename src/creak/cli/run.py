"""`creak run`: the main job."""

from __future__ import annotations

from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table

from creak.cli.output import ProgressBars, writable_folder
from creak.errors import InputError


def run(
    study_file: Path = typer.Argument(..., metavar="STUDY.toml", help="The study to run."),
    out: Path | None = typer.Option(None, "--out", help="Folder for results; default: results/ beside the study."),
    quiet: bool = typer.Option(False, "--quiet", help="No progress, no table."),
    superelements: Path | None = typer.Option(
        None, "--superelements", help="Folder that `creak reduce` wrote; default: superelements/ beside the study."
    ),
    ignore: list[str] = typer.Option([], "--ignore", help="Keyword of the deck that may go unread."),
) -> None:
    """Run a study: reduced and unreduced model, their comparison, summary.json, results.h5, report.html."""
    from creak.report.html import write_report
    from creak.studies.run import run_study
    from creak.studies.save import save
    from creak.studies.setup import set_up
    from creak.studies.study_file import read_study
    from creak.studies.summary import summarise
    from creak.studies.superelements import store_of

    if study_file.suffix.lower() in (".inp", ".bdf", ".dat", ".nas"):
        raise InputError(
            f"{study_file.name} is a deck; this version of creak does not run a deck's own *DYNAMIC step",
            expected="a study file (.toml)", fix="Write a study that names the deck in [model].",
        )  # fmt: skip
    study = read_study(study_file)
    folder = out if out is not None else study_file.parent / "results"
    writable_folder(folder)
    console = Console(quiet=quiet)
    setup = set_up(study, ignore)
    _list_unread(console, setup.model.unread)
    with ProgressBars(quiet) as progress:
        result = run_study(setup, progress, superelements if superelements is not None else store_of(study))
        summary = summarise(result)
        progress("write results", 0, 2)
        written = save(result, summary, folder)
        progress("write results", 1, 2)
        write_report(result, summary, folder / "report.html")
        progress("write results", 2, 2)
    for note in summary["notes"]:
        console.print(f"note: {note}", markup=False)
    _print_tables(console, summary)
    for path in [*written, folder / "report.html"]:
        console.print(f"wrote {path}", markup=False, soft_wrap=True)


def _list_unread(console: Console, unread: tuple[object, ...]) -> None:
    for u in unread:
        console.print(f"not read: *{str(getattr(u, 'keyword', u)).lstrip('*')} ({getattr(u, 'where', '')}): "
                      f"{getattr(u, 'why', '')}", markup=False)  # fmt: skip


def _print_tables(console: Console, summary: dict[str, object]) -> None:
    from creak.report.terminal import run_rows, verification_rows

    runs = Table(title="Runs", title_justify="left")
    rows = run_rows(summary)
    for i, head in enumerate(rows[0]):
        runs.add_column(head, justify="left" if i == 0 else "right")
    for row in rows[1:]:
        runs.add_row(*row)
    console.print(runs)
    checks = verification_rows(summary)
    if checks:
        table = Table(title="Reduced against reference", title_justify="left")
        table.add_column("")
        table.add_column("value", justify="right")
        for row in checks:
            table.add_row(*row)
        console.print(table)
