"""`creak update`: which numbers of a study would bring its modes to those of a test, and the study with them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from creak.cli.details import tell_notes
from creak.cli.modes import LengthName
from creak.cli.output import IGNORE, JSON_FILE, QUIET, VERBOSE, Output, is_stdout, writable_files
from creak.errors import InputError

if TYPE_CHECKING:
    from creak.studies.models.update import ModelUpdate, Sensitivities


def update(
    study_file: Path = typer.Argument(..., metavar="STUDY.toml", help="The study whose model is updated."),
    test: Path = typer.Option(..., "--test", metavar="MEASURED", help="Modes of a test, universal file (55) or CSV."),
    parameter: list[str] = typer.Option(
        [], "--parameter", metavar="KEY[=LOW:HIGH]", help="A number that may change; without one all are ranked."
    ),
    uncertainty: float = typer.Option(1.0, "--uncertainty", help="Of the measured frequencies, %, one sigma."),
    closed: list[str] = typer.Option(
        [], "--closed", metavar="NAME", help="A contact, connector or clip that stays closed in the test."
    ),
    out: Path | None = typer.Option(
        None, "--out", metavar="NEW.toml", help="The changed study; default: STUDY_updated.toml beside the study."
    ),
    page: Path | None = typer.Option(None, "--page", help="Write parameters, pairs and shapes as a page."),
    test_units: LengthName | None = typer.Option(
        None, "--test-units", help="Length of the test's points; default: as its file says, or the deck's."
    ),
    sensors: Path | None = typer.Option(None, "--sensors", help="CSV with the columns sensor,node."),
    ignore: list[str] = IGNORE,
    quiet: bool = QUIET,
    verbose: bool = VERBOSE,
    json_file: Path | None = JSON_FILE,
) -> None:
    """Bring the modes of a study to those of a test, by a few of its numbers; the study itself stays as it is.

    Without --parameter it tells which number would mend most, and changes nothing.

    Example: creak update study.toml --test test.unv
    """
    from creak.api.study import read_study
    from creak.formats.deck.command_files import will_read
    from creak.studies.models import update as studies

    on_stdout = is_stdout(json_file)
    _check(uncertainty, parameter, out, page)
    will_read(study_file, test, *([sensors] if sensors is not None else []))
    study = read_study(study_file)
    target = _target(study_file, out) if parameter else None
    writable_files((target, page, None if on_stdout else json_file))
    with Output(quiet, verbose, on_stdout) as output:
        with output.progress as progress:
            case = studies.update_case(
                study, test, test_units=test_units, sensors=sensors, ignore=ignore, closed=closed
            )
            if target is None:
                ranked = studies.sensitivities(case, progress)
                data = {"update_of": study.path.name, **_ranking_data(ranked)}
            else:
                found = studies.update(case, parameter, sigma=uncertainty / 100.0, progress=progress)
                data = {"update_of": study.path.name, **_data(found)}
                _write(output, found, target, page)
            if json_file is not None and not on_stdout:
                output.write(data, json_file)
        if target is None:
            _print_ranking(output, ranked)
        else:
            _print(output, found)
        output.tell_written()
        output.result({**data, "written": [str(path) for path in output.written]})


def _check(uncertainty: float, parameter: list[str], out: Path | None, page: Path | None) -> None:
    from creak.api.extras import need_report

    if not 0.0 < uncertainty < 100.0:
        raise InputError(f"--uncertainty {uncertainty:g}", expected="per cent of a frequency, above 0 and below 100")
    alone = [name for name, value in (("--out", out), ("--page", page)) if value is not None]
    if not parameter and alone:
        raise InputError(
            f"{alone[0]} without --parameter", expected="--parameter KEY", fix="Name what may change; nothing is else."
        )
    if page is not None:
        need_report("--json")


def _target(study_file: Path, out: Path | None) -> Path:
    """Where the changed study goes: beside the old one, since it names its files from there."""
    target = study_file.with_name(f"{study_file.stem}_updated.toml") if out is None else out
    if target.suffix.lower() != ".toml":
        raise InputError(f"--out {target}", expected="a file name that ends in .toml")
    if target.parent.resolve() != study_file.parent.resolve():
        raise InputError(
            f"--out {target} lies in another folder than {study_file}",
            expected="a file beside the study, which names its deck and tables from there",
            fix=f"Write to {study_file.with_name(target.name)}.",
        )
    return target


def _write(output: Output, found: ModelUpdate, target: Path, page: Path | None) -> None:
    from creak.formats.complete_file import write_text
    from creak.report.words.update import file_head

    test = found.after.measured.path.name
    write_text(target, file_head(found, found.study.path.name, test) + found.study.text)
    output.wrote(target)
    if page is not None:
        from creak.report.correlation_page import write_update

        page.parent.mkdir(parents=True, exist_ok=True)
        with output.progress.phase("write the page"):
            write_update(found, page)
        output.wrote(page)


def _ranking_data(found: Sensitivities) -> dict[str, Any]:
    from creak.report.words.update import sensitivity_sentence

    return {"sentence": sensitivity_sentence(found), **found.as_dict()}


def _data(found: ModelUpdate) -> dict[str, Any]:
    from creak.report.words.update import gained_note, update_notes, update_sentence

    return {
        "sentence": update_sentence(found),
        "warnings": update_notes(found),
        "notes": gained_note(found),
        **found.as_dict(),
    }


def _print_ranking(output: Output, found: Sensitivities) -> None:
    from creak.report.words.update import sensitivity_rows, sensitivity_sentence

    rows = sensitivity_rows(found)
    if len(rows) > 1:
        output.table("What each number would mend alone, and its largest slope d(ln f)/d(ln p)", rows)
    output.say(sensitivity_sentence(found))
    tell_notes(output, found.before.notes, set())


def _print(output: Output, found: ModelUpdate) -> None:
    from creak.report.words.update import gained_note, mode_rows, parameter_rows, update_notes, update_sentence

    output.table("Parameters", parameter_rows(found))
    output.table(f"Modes of {found.after.measured.path.name} and of the model", mode_rows(found))
    output.say(update_sentence(found))
    for note in update_notes(found):
        output.warn(note)
    tell_notes(output, [*gained_note(found), *found.after.notes], set())
