"""`creak run`: the main job."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import typer
from rich.console import Console
from rich.table import Table

from creak.cli.output import ProgressBars, writable_folder
from creak.errors import InputError, NumericalError

if TYPE_CHECKING:
    from creak.studies.converge import Convergence
    from creak.studies.setup import Setup


def run(
    study_file: Path = typer.Argument(
        ..., metavar="STUDY.toml|DECK.inp", help="The study to run, or a deck whose own *DYNAMIC step is run unreduced."
    ),
    out: Path | None = typer.Option(None, "--out", help="Folder for results; default: results/ beside the study."),
    quiet: bool = typer.Option(False, "--quiet", help="No progress, no table."),
    superelements: Path | None = typer.Option(
        None, "--superelements", help="Folder that `creak reduce` wrote; default: superelements/ beside the study."
    ),
    units: Literal["mm-t-s", "m-kg-s"] = typer.Option(
        "mm-t-s", "--units", help="Units of a deck that is run by itself, for the report; a study names its own."
    ),
    ignore: list[str] = typer.Option([], "--ignore", help="Keyword of the deck that may go unread."),
    converge: bool = typer.Option(
        False, "--converge", help="Repeat the run with shorter steps, stiffer contact and more modes (about 15 times "
        "its cost) and tell which figures of each event have settled; also in convergence.csv. Ctrl-C ends the "
        "repeated run that is under way, the next one follows."
    ),
) -> None:
    """Run a study: reduced and unreduced model, their comparison, summary.json, results.h5, report.html."""
    from creak.report.html import write_report
    from creak.studies.converge import converge as repeat
    from creak.studies.run import run_study
    from creak.studies.save import save, save_convergence
    from creak.studies.summary import summarise
    from creak.studies.superelements import store_of

    folder = out if out is not None else study_file.parent / "results"
    writable_folder(folder)
    console = Console(quiet=quiet)
    setup = _set_up(study_file, ignore, units)
    _list_unread(console, setup.model.unread)
    with ProgressBars(quiet) as progress:
        result = run_study(setup, progress, superelements if superelements is not None else store_of(setup.study))
        convergence = repeat(result, progress) if converge else None
        summary = summarise(result, convergence)
        progress("write results", 0, 2)
        written = save(result, summary, folder)
        if convergence is not None:
            written.append(save_convergence(convergence, folder))
        progress("write results", 1, 2)
        write_report(result, summary, folder / "report.html", convergence)
        progress("write results", 2, 2)
    for note in summary["notes"]:
        console.print(f"note: {note}", markup=False)
    _print_tables(console, summary)
    if convergence is not None:
        _print_convergence(console, convergence, summary)
    for path in [*written, folder / "report.html"]:
        console.print(f"wrote {path}", markup=False, soft_wrap=True)
    if result.stopped is not None:
        raise NumericalError(f"{result.stopped}. What was computed until then is in {folder}")


def _set_up(path: Path, ignore: list[str], units: Literal["mm-t-s", "m-kg-s"]) -> Setup:
    """A study file, or a deck by its own step."""
    from creak.studies.deck_study import set_up_deck
    from creak.studies.setup import set_up
    from creak.studies.study_file import read_study

    if path.suffix.lower() in (".bdf", ".dat", ".nas"):
        raise InputError(
            f"{path.name} is a Nastran deck; creak runs the step of Abaqus decks (.inp) only",
            expected="a study file (.toml)", fix="Write a study that names the deck in [model].",
        )  # fmt: skip
    if path.suffix.lower() == ".inp":
        return set_up_deck(path, ignore, units)
    return set_up(read_study(path), ignore)


def _list_unread(console: Console, unread: tuple[object, ...]) -> None:
    for u in unread:
        console.print(f"not read: {getattr(u, 'keyword', u)} ({getattr(u, 'where', '')}): "
                      f"{getattr(u, 'why', '')}", markup=False)  # fmt: skip


def _print_tables(console: Console, summary: dict[str, object]) -> None:
    from creak.report.terminal import run_rows, verification_rows

    console.print(_table("Runs", run_rows(summary)))
    checks = verification_rows(summary)
    if checks:
        console.print(_table("Reduced against reference", [["", "value"], *checks]))


def _print_convergence(console: Console, convergence: Convergence, summary: dict[str, Any]) -> None:
    from creak.report.convergence import ON_TERMINAL, run_rows, settled_rows
    from creak.report.text import UNITS

    console.print(_table("Convergence: the runs", run_rows(convergence, UNITS[summary["units"]])))
    rows = settled_rows(convergence)
    if len(rows) > 1:
        cut = f" (the first {ON_TERMINAL})" if len(convergence.events) > ON_TERMINAL else ""
        console.print(_table(f"Convergence: what the events have settled to{cut}", rows))
    for text in summary["convergence"]["findings"]:
        console.print(f"convergence: {text}", markup=False)


def _table(title: str, rows: list[list[str]]) -> Table:
    """A table with a header, the first column to the left."""
    table = Table(title=title, title_justify="left")
    for i, text in enumerate(rows[0]):
        table.add_column(text, justify="left" if i == 0 else "right", no_wrap=i == 0)
    for row in rows[1:]:
        table.add_row(*row)
    return table
