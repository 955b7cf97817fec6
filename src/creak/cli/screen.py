"""`creak screen`: E-lines from modes alone, ranked."""

from __future__ import annotations

from pathlib import Path

import typer

from creak.cli.details import setup_detail, tell_notes, tell_warnings
from creak.cli.output import IGNORE, OUTPUT, Output, writable_file


def screen(
    study_file: Path = typer.Argument(..., metavar="STUDY.toml", help="The study to look at."),
    csv: Path | None = typer.Option(None, "--csv", metavar="FILE", help="Write every point of every line here."),
    ignore: list[str] = IGNORE,
    output: Output = OUTPUT,
) -> None:
    """Rank the E-lines of a study by the margin of their gaps and by their in-plane motion, from modes alone.

    Nothing is reduced and nothing touches: the modes of the assembly are driven by the study's excitation. Lines are
    the points of every contact and those that [eline.NAME] draws (docs/elines.md).

    Example: creak screen door/door.toml
    """
    from creak.formats.complete_file import write_text
    from creak.formats.deck.command_files import will_read
    from creak.model.units import UNITS
    from creak.report.tables.elines import screen_rows
    from creak.studies.file.reader import read_study
    from creak.studies.findings.elines import RISK, as_dict, line_rows, point_csv
    from creak.studies.prepare.setup import set_up
    from creak.studies.run.screen import left_out
    from creak.studies.run.screen import screen as look
    from creak.studies.warned import warnings_of
    from creak.verify.elines import DEFINITION

    will_read(study_file)
    if csv is not None:
        writable_file(csv)
    told: set[str] = set()
    with output:
        with output.progress as progress:
            with progress.phase("read the model and find the lines"):
                setup = set_up(read_study(study_file), ignore)
            setup_detail(output, setup)
            tell_warnings(output, setup.notes, told)
            found = look(setup, progress)
            config, model = setup.study.config, setup.model
            if csv is not None:
                csv.parent.mkdir(parents=True, exist_ok=True)
                write_text(csv, point_csv(found, model, UNITS[config.model.units].length))
                output.wrote(csv)
        rows = line_rows(found, config.limit, config.model.units)
        table = screen_rows(rows, model, found.percentile)
        output.table(f"E-lines, {found.without}, no contact; {UNITS[config.model.units].length}", table)
        output.say(f"{RISK}. {DEFINITION}")
        tell_notes(output, [*setup.notes, *left_out(setup)], told)
        output.tell_written()
        data = as_dict(found, config.limit, config.model.units, model)
        written = [str(path) for path in output.written]
        output.result({"units": config.model.units, **data, "warnings": warnings_of(setup.notes), "written": written})
