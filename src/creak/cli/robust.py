"""`creak robust`: how likely it rattles when gaps, friction and loads scatter."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from creak.cli.cluster import Distribution, check_cluster, distribution_of
from creak.cli.details import tell_notes, tell_warnings
from creak.cli.joined import joined
from creak.cli.output import OUTPUT, Output, writable_file, writable_folder

if TYPE_CHECKING:
    from creak.studies.robust.findings import Robustness
    from creak.studies.tasks.queue import Runner


def robust(
    study_file: Path = typer.Argument(..., metavar="STUDY.toml", help="A study with [scatter]."),
    n: int = typer.Option(
        256, "--n", min=4, max=1_000_000, help="Draws behind the probabilities; rounded up to a power of two."
    ),
    out: Path | None = typer.Option(None, "--out", help="Folder for results; default: robust/ beside the study."),
    indices: bool = typer.Option(
        True, "--indices/--no-indices", help="Sobol indices: half as many runs more for each cause."
    ),
    where: Distribution = joined(
        partial(distribution_of, own="--threads"),
        workers=typer.Option(None, "--threads", min=1, help="Default: all cores of this process."),
    ),
    output: Output = OUTPUT,
) -> None:
    """Draw the numbers that scatter and run each draw: probability of rattle, causes, the gap that is needed.

    Each finished draw is kept: the same command goes on after an interruption, and takes what is there.

    Example: creak robust scatter.toml --n 16
    """
    from creak.api.extras import missing_for_report, no_report_text
    from creak.api.robust import robust as find
    from creak.formats.complete_file import write_text
    from creak.formats.stored.sealed import sealed_text
    from creak.report.tables.robust import write_draws

    folder = out if out is not None else study_file.parent / "robust"
    with output:
        from creak.api.study import read_study

        study = read_study(study_file)
        writable_folder(folder)
        for name in ("robust.json", "draws.csv", "robust.html"):
            writable_file(folder / name, stream=False)
        before = _logs(folder)
        check_cluster(where, output)
        with _runner(where) as runner, output.progress as progress:
            try:
                found = find(
                    study,
                    n,
                    out=folder,
                    indices=indices,
                    threads=where.workers,
                    runner=runner,
                    progress=progress,
                )
            except KeyboardInterrupt:
                output.wrote(*(path for path, when in _logs(folder).items() if before.get(path) != when))
                raise
        data = found.as_dict()
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / "robust.json", sealed_text(data))
        write_draws(found, folder / "draws.csv")
        output.wrote(folder / "robust.json", folder / "draws.csv")
        if missing_for_report():
            output.warn(no_report_text())
        else:
            from creak.report.robust_page import write_robust

            write_robust(found, folder / "robust.html")
            output.wrote(folder / "robust.html")
        told: set[str] = set()
        tell_warnings(output, found.notes, told)
        tell_notes(output, found.notes, told)
        _print(output, found)
        output.tell_written()
        output.result({**data, "written": [str(path) for path in output.written]})


def _logs(folder: Path) -> dict[Path, int]:
    """Files of finished draws, and when they were written."""
    from creak.studies.robust.job import LOG

    return {path: path.stat().st_mtime_ns for path in sorted(folder.glob(f"{LOG}-*.bin"))}


def _runner(where: Distribution) -> AbstractContextManager[Runner | None]:
    from creak.studies.tasks.cluster import running_cluster

    return nullcontext() if where.scheduler is None else running_cluster(where.scheduler, where.certificates)


def _print(output: Output, found: Robustness) -> None:
    from creak.report.tables import robust as rows

    output.table("Places", rows.place_rows(found))
    if found.indices:
        output.table("Causes: Sobol indices", rows.index_rows(found))
    output.say(rows.sentence(found))
