"""`creak reduce`: the superelements of a study, saved for reuse."""

from __future__ import annotations

from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table

from creak.cli.output import ProgressBars, writable_folder
from creak.errors import InputError, suggest


def reduce(
    study_file: Path = typer.Argument(..., metavar="STUDY.toml", help="The study whose parts to reduce."),
    out: Path | None = typer.Option(
        None, "--out", help="Folder for the superelements; default: superelements/ beside the study, where run looks."
    ),
    export: list[str] = typer.Option(
        [], "--export", help="Also write them as op4, dmig, abaqus, matrix-market or npz, into the same folder."
    ),
    quiet: bool = typer.Option(False, "--quiet", help="No progress, no table."),
    ignore: list[str] = typer.Option([], "--ignore", help="Keyword of the deck that may go unread."),
) -> None:
    """Reduce the parts of a study and save them; parts that did not change since the last time are kept.

    Example: creak reduce door/door.toml --export op4
    """
    from creak.formats.matrices.superelements import FORMATS, write_superelement
    from creak.reduction.health import health_rows
    from creak.studies.run import prepare
    from creak.studies.setup import set_up
    from creak.studies.study_file import read_study
    from creak.studies.superelements import as_superelement, save_superelement, store_of

    unknown = [e for e in export if e not in FORMATS]
    if unknown:
        expected, fix = ", ".join(FORMATS), suggest(unknown[0], FORMATS)
        raise InputError(f"unknown format {unknown[0]!r}", expected=expected, fix=fix)
    study = read_study(study_file)
    method = study.config.reduction.method
    if method not in ("craig-bampton", "guyan"):
        raise InputError(
            f"method = {method!r} makes no superelements", where=study.where("reduction", "method"),
            expected='"craig-bampton" or "guyan"', fix="`creak run` reduces the whole assembly with it.",
        )  # fmt: skip
    folder = out if out is not None else store_of(study)
    writable_folder(folder)
    console = Console(quiet=quiet)
    setup = set_up(study, ignore)
    with ProgressBars(quiet) as progress:
        from creak.studies.health import checked
        from creak.studies.reduced_model import reduce_model

        reference, gaps, notes = prepare(setup, progress)
        model = reduce_model(setup, reference, gaps, progress, folder)
        checks = checked(setup, model, progress)
        written = []
        for reduced in model.superelements:
            if not reduced.reused:
                about = {"deck": str(setup.model.source), "health": checks[reduced.system.name].as_dict()}
                written.append(save_superelement(folder, reduced, setup.model, about))
            for name in export:
                written += write_superelement(as_superelement(reduced, setup.model), folder, name)
    for note in [*setup.notes, *notes, *model.notes]:
        console.print(f"note: {note}", markup=False)
    for name, health in checks.items():
        table = Table(title=name, title_justify="left")
        for head in ("", "value", "remark"):
            table.add_column(head)
        for row in health_rows(health):
            table.add_row(*row)
        console.print(table)
    for path in written:
        console.print(f"wrote {path}", markup=False, soft_wrap=True)
