"""`creak run`: the main job."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import typer

from creak.cli.cluster import (
    Distribution,
    check_cluster,
    check_method,
    distribution_of,
    workers_of,
)
from creak.cli.details import list_unread, setup_detail, tell_notes, tell_setup
from creak.cli.joined import joined
from creak.cli.output import IGNORE, OUTPUT, Output, writable_folder
from creak.errors import InputError, NumericalError, Unreliable
from creak.model.units import UnitsName

if TYPE_CHECKING:
    from creak.api.result import Result
    from creak.progress import Progress
    from creak.studies.converge.settling import Convergence
    from creak.studies.file.reader import Study
    from creak.studies.run.checkpoint import Checkpoints

QUICK = {"time.accuracy": "quick", "reference.run": "none"}
"""Changes of a first look."""


def run(
    study_file: Path = typer.Argument(
        ...,
        metavar="STUDY.toml|DECK",
        help="The study to run, or a deck whose own transient step is run unreduced: *DYNAMIC of Abaqus .inp "
        "(*MODAL DYNAMIC reduced); SOL 109, 112 or 129 of Nastran .bdf, .dat, .nas, .fem.",
    ),
    out: Path | None = typer.Option(
        None,
        "--out",
        help="Folder for results; default: results/ beside the study, with --set results_KEY=VALUE/.",
    ),
    changes: list[str] = typer.Option(
        [],
        "--set",
        metavar="KEY=VALUE",
        help="Run the study with another value, as contact.flange.clearance=3.2; the file stays as it is. Repeatable.",
    ),
    superelements: Path | None = typer.Option(
        None, "--superelements", help="Folder of saved superelements; default: superelements/ beside the study."
    ),
    keep: bool = typer.Option(
        True,
        "--keep/--no-keep",
        help="Save superelements, and what else the next run may need again, in solved/ there.",
    ),
    units: UnitsName | None = typer.Option(
        None,
        "--units",
        help="Units of a deck that is run by itself; default: guessed from materials and size. A study names its own.",
    ),
    ignore: list[str] = IGNORE,
    converge: bool | None = typer.Option(
        None,
        "--converge/--no-converge",
        help="Repeat the run with contact resolved twice as finely, half and twice "
        "its stiffness and 1.5 times the modes (with a forced scheme: shorter steps, stiffer contact, more modes), and "
        "tell how far each event has settled; also in convergence.csv. By default where no scheme is forced, the model "
        "is reduced and the accuracy is not quick. Ctrl-C leaves these runs out.",
    ),
    changes_wanted: bool = typer.Option(
        False,
        "--changes",
        help="For the first three places: the single changes of gap, contact stiffness, damping, mass or fastening "
        "that would help most, tried on the reduced model.",
    ),
    check_changes: bool = typer.Option(
        False, "--check-changes", help="The same, each checked by a full run of the changed model."
    ),
    animation_mb: float = typer.Option(
        5.0,
        "--animation-mb",
        min=0.0,
        help="Megabytes that the 3-D motion of the hardest events may add to report.html; 0: none.",
    ),
    force: bool = typer.Option(
        False, "--force", help="Replace the results of another study, and files that creak did not write."
    ),
    quick: bool = typer.Option(
        False,
        "--quick",
        help="A first look: rougher contact, no repeated runs, no unreduced model. The verdict then says that nothing "
        "was checked, unless nothing can touch.",
    ),
    where: Distribution = joined(distribution_of),
    show: bool = typer.Option(False, "--open", help="Open report.html in the browser at the end."),
    output: Output = OUTPUT,
) -> None:
    """Run a study: reduced and unreduced model, their comparison, summary.json, results.h5, report.html.

    Ctrl-C during a run ends it there: what was computed until then is written, without the page, and nothing more is
    tried. An unreduced run keeps a checkpoint every five minutes beside the results: the same command goes on from it,
    after a kill as well. Earlier results of the same study are replaced; those of another study, and files that creak
    did not write, are not, unless --force says so.

    Example: creak run door/door.toml --out door/results
    """
    from creak.api.study import run_setup, set_up
    from creak.formats.deck.command_files import replace_foreign, will_read
    from creak.formats.endings import is_deck
    from creak.studies.file.paths import STORE
    from creak.studies.findings.save import check_folder, refuse_other_study
    from creak.studies.run.checkpoint import Checkpoints
    from creak.studies.solved import opened

    will_read(study_file)
    given = changed_study(study_file, changes) if changes else study_file
    folder = out if out is not None else study_file.parent / results_name(given)
    if quick:
        given, converge = first_look(given), False
    writable_folder(folder)
    replace_foreign("--force", force)
    check_folder(folder)
    if not force:
        refuse_other_study(folder, study_file.name)
    told: set[str] = set()
    checkpoints, beside = Checkpoints(folder), None if is_deck(study_file) else study_file.parent / STORE
    spread = where.workers is not None or where.scheduler is not None
    if spread and (not keep or beside is None):
        raise InputError(
            f"workers with {'--no-keep' if beside else 'a deck of its own'}",
            expected="a study whose superelements are kept: workers hand over what they reduce in that folder",
        )
    with output, ExitStack() as pool:
        check_cluster(where, output)
        runner = pool.enter_context(workers_of(where, where.workers or 1)) if spread else None
        with output.progress as progress, opened(superelements or beside if keep else None):
            with progress.phase("read the model and find the contacts"):
                setup = set_up(given, ignore, units, superelements)
            if spread:
                check_method(setup.study.config.reduction.method, setup.study.places)
            check_folder(folder)  # once more: what has been read meanwhile stays
            setup_detail(output, setup)
            tell_setup(output, setup.no_contact, setup.notes, told)
            result = run_setup(
                setup,
                progress,
                superelements=superelements,
                converge=converge,
                record=animation_mb > 0.0,
                changes="checked" if check_changes else "predicted" if changes_wanted else "none",
                keep=keep,
                checkpoints=checkpoints,
                first=lambda so_far: so_far.save(folder, 0.0),
                runner=runner,
                ignore=ignore,
            )
            page = _write(output, progress, result, checkpoints, animation_mb)
        list_unread(output, setup.model.unread)
        if (why := result.summary["unanswered"]) and not setup.no_contact:
            output.alarm(why)
        tell_notes(output, result.notes, told)
        _tell(output, result, folder)
        if show and page is not None:
            typer.launch(str(folder / "report.html"))
        output.result({**result.summary, "written": [str(path) for path in output.written]})
    if result.stopped is not None:
        raise NumericalError(f"{result.stopped}. What was computed until then is in {folder}")
    if result.unreliable:
        raise Unreliable(f"{'; '.join(result.unreliable)}. The results are in {folder}")


def _write(
    output: Output, progress: Progress, result: Result, checkpoints: Checkpoints, animation_mb: float
) -> str | None:
    """Write results and page beside the checkpoints, which go; the page, where it can be drawn and nobody waits for the
    end. Its failure, or an interruption, costs no results."""
    from creak.api.extras import missing_for_report
    from creak.studies.warned import is_asked_to_end

    progress("write results", 0, 2)
    page = None
    try:
        if not missing_for_report() and not is_asked_to_end(result.found.notes):
            page = result.page(animation_mb)
        progress("write results", 1, 2)
    finally:
        output.wrote(*result.save(checkpoints.folder, animation_mb, page))
        if result.stopped is None:
            checkpoints.remove()
    progress("write results", 2, 2)
    return page


def _tell(output: Output, result: Result, folder: Path) -> None:
    """Tables where they are asked for, the answer, what was written, and the verdict."""
    from creak.api.extras import missing_for_report, no_report_text
    from creak.report.words.terminal import answer_lines
    from creak.report.words.verdict import verdict_line
    from creak.studies.run.compared import main_of
    from creak.studies.warned import is_asked_to_end

    if missing_for_report():
        output.warn(no_report_text())
    if output.verbose:
        _print_tables(output, result.summary)
        if result.convergence is not None:
            _print_convergence(output, result.convergence, result.summary)
    for line in answer_lines(result.summary):
        output.say(line)
    output.say(f"wrote {folder}: {', '.join(path.name for path in output.written)}")
    if is_asked_to_end(result.found.notes):
        output.command(f"no report.html yet: creak report {quote(str(folder))}")
    if said := verdict_line(main_of(result.summary)):
        output.say(f"verdict: {said}")


def changed_study(study_file: Path, changes: list[str]) -> Study:
    """The study of a file with the changes of `--set`.

    Raises
    ------
    InputError : a deck, or a change that cannot be made.
    """
    from creak.api.study import read_study
    from creak.studies.file.changes import read_changes, with_changes

    wanted = read_changes(changes)
    return with_changes(read_study(study_file), wanted)


def first_look(given: Study | Path) -> Study | Path:
    """The study with the changes of --quick; a deck, and steps that a study forces, stay as they are."""
    from creak.api.study import read_study
    from creak.formats.endings import is_deck
    from creak.studies.file.changes import with_changes

    if isinstance(given, Path) and is_deck(given):
        return given
    study = read_study(given) if isinstance(given, Path) else given
    wanted: dict[str, Any] = {k: x for k, x in QUICK.items() if study.config.time.exact or k != "time.accuracy"}
    if study.config.reference.until is not None:  # it belongs to the run from rest, which is not made
        wanted["reference"] = {"run": wanted.pop("reference.run")}
    return with_changes(study, wanted)


def results_name(study: Study | Path) -> str:
    """Folder for the results of a study: those of a changed one do not replace those of its file."""
    from creak.studies.file.changes import change_words, short_keys
    from creak.studies.sweep.cases import folder_names

    if isinstance(study, Path) or not study.places.changes:
        return "results"
    return folder_names([f"results_{change_words(study.places.changes, short_keys([*study.places.changes]))}"])[0]


def _print_tables(output: Output, summary: dict[str, Any]) -> None:
    from creak.report.tables.elines import eline_words
    from creak.report.words.terminal import cause_lines, place_table, run_rows, verification_rows
    from creak.studies.findings.limits import limit_words

    output.table("Runs", run_rows(summary))
    places = place_table(summary)
    if len(places) > 1:
        output.table("Places", places)
    checks = verification_rows(summary)
    if checks:
        output.table("Reduced against reference", [["", "value"], *checks])
    if summary["elines"] is not None:
        output.say(f"E-lines: {eline_words(summary['elines'])}")
    for text in [*cause_lines(summary), *limit_words(summary["limits"])]:
        output.say(text)


def _print_convergence(output: Output, convergence: Convergence, summary: dict[str, Any]) -> None:
    from creak.model.units import UNITS
    from creak.report.tables.convergence import ON_TERMINAL, run_rows, settled_rows

    output.table("Convergence: the runs", run_rows(convergence, UNITS[summary["units"]]))
    rows = settled_rows(convergence)
    if len(rows) > 1:
        cut = f" (the first {ON_TERMINAL})" if len(convergence.events) > ON_TERMINAL else ""
        output.table(f"Convergence: within what the events have settled{cut}", rows)
    for text in summary["convergence"]["findings"]:
        output.say(f"convergence: {text}")
