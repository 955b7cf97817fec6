"""`creak sweep`: many cases of one study."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from creak.cli.cluster import (
    Distribution,
    check_cluster,
    distribution_of,
    workers_of,
)
from creak.cli.console import Terminal
from creak.cli.joined import joined
from creak.cli.output import IGNORE, OUTPUT, Interrupted, Output, writable_file, writable_folder
from creak.errors import NumericalError, Unreliable

if TYPE_CHECKING:
    from creak.studies.evaluate import Evaluation
    from creak.studies.sweep.case import Outcome, Task
    from creak.studies.sweep.cases import Case
    from creak.studies.sweep.job import Row


def sweep(
    sweep_file: Path = typer.Argument(..., metavar="SWEEP.toml", help="Base study, grid of changes, seeds."),
    out: Path | None = typer.Option(
        None, "--out", help="Folder for the results; default: <sweep file>_sweep beside the sweep file."
    ),
    where: Distribution = joined(
        distribution_of,
        workers=typer.Option(
            None,
            "--workers",
            min=1,
            help="Worker processes on this machine; default: one per core. They share the cores.",
        ),
    ),
    dry_run: bool = typer.Option(False, "--dry-run", help="List the cases, run nothing."),
    reports: bool = typer.Option(True, "--reports/--no-reports", help="Write report.html of every case."),
    converge: bool | None = typer.Option(
        None,
        "--converge/--no-converge",
        help="Repeat each case to tell how far it has settled, as creak run does; by default where creak run would. "
        "Without it a case takes about a fifth of the time, and nothing has checked it.",
    ),
    ignore: list[str] = IGNORE,
    output: Output = OUTPUT,
) -> None:
    """Run every case of a sweep: a folder each, all figures in sweep.csv and sweep.h5.

    It ends with a table, and with a page, sweep.html, that leads to the reports of the cases. A case that has its
    result is not run again: after a stop the same command goes on.

    Example: creak sweep door_sweep.toml --workers 2
    """
    from creak.api.extras import need_report
    from creak.report.words.text import plural
    from creak.studies.sweep.cases import resolve
    from creak.studies.sweep.file import read_sweep
    from creak.studies.sweep.job import finished, tasks_of

    read = read_sweep(sweep_file)
    folder = out if out is not None else sweep_file.parent / f"{sweep_file.stem}_sweep"
    writable_folder(folder)
    for name in ("sweep.csv", "sweep.h5", "sweep.html"):
        writable_file(folder / name, stream=False)
    cases = resolve(read, folder, converge)
    output.detail(f"{plural(len(cases), 'case')} of {read.base}; results in {folder}")
    if dry_run:
        ways = {way: finished([replace(c, converge=way) for c in cases], folder, rename=False) for way in WAYS}
        _list(output, cases, ways.pop(converge))
        for way, found in ways.items():
            if found:
                output.say(f"finished with {WAYS[way]}: {len(found)}")
        return
    check_cluster(where, output)
    if reports:
        need_report("--no-reports")
    folder.mkdir(parents=True, exist_ok=True)
    known = finished(cases, folder)
    tasks = tasks_of(cases, folder, ignore, write_case if reports else write_case_alone)
    with _Drawn(output.quiet, len(cases), len(known)) as progress:
        try:
            rows = _rows(read, cases, folder, known, progress, where, tasks)
        except KeyboardInterrupt:
            raise Interrupted(
                f"{progress.done} of {len(cases)} cases are finished, the same command goes on from there"
            ) from None
    _show(output, read, rows, folder, reports)
    _finish(output, rows, folder, len(known))


def _rows(
    read: Any,
    cases: Sequence[Case],
    folder: Path,
    known: dict[str, Outcome],
    progress: Any,
    where: Distribution,
    tasks: Mapping[str, Task],
) -> list[Row]:
    from creak.formats.destination import remove_dead
    from creak.linalg.threads import cores
    from creak.studies.sweep.job import Row, run_sweep, write_table

    remove_dead(folder)
    left = len(cases) - len(known)
    if not left:
        rows = [Row(c, known[c.name]) for c in cases]
        write_table(read, rows, folder)
        return rows
    try:
        with workers_of(where, min(where.workers or cores(), left)) as runner:
            return run_sweep(read, cases, folder, runner, tasks, known, progress)
    finally:
        remove_dead(folder)


def write_case(case: Evaluation, folder: Path) -> None:
    """Results and page of a case, as those of `creak run`; called in the workers."""
    from creak.api.result import Result

    result = Result.of(case)
    result.save(folder, 0.0, result.page(0.0))


def write_case_alone(case: Evaluation, folder: Path) -> None:
    """The same without the page, which `creak report` makes of them."""
    from creak.api.result import Result

    Result.of(case).save(folder, 0.0)


WAYS = {None: "neither --converge nor --no-converge", True: "--converge", False: "--no-converge"}
"""Ways to run the cases of a sweep."""


def _list(output: Output, cases: Sequence[Case], known: dict[str, Outcome]) -> None:
    from creak.report.words.text import plural

    status = {case.name: "finished" if case.name in known else "to run" for case in cases}
    output.say(f"{plural(len(cases), 'case')}, {len(known)} of them finished")
    for name, word in status.items():
        output.say(f"  {word:<10}{name}")
    output.result({"cases": [{"case": name, "status": word} for name, word in status.items()]})


def _show(output: Output, read: Any, rows: Sequence[Row], folder: Path, reports: bool) -> None:
    """The table on the terminal and, with reports, the page."""
    output.wrote(folder / "sweep.csv", folder / "sweep.h5")
    if not reports:
        return
    from creak.report.sweep_page import MOST, idle_keys, sweep_rows, write_sweep_page

    write_sweep_page(read.config.title or read.path.name, rows, folder / "sweep.html")
    output.wrote(folder / "sweep.html")
    output.table("Cases", sweep_rows(rows)[: MOST + 1])
    if len(rows) > MOST:
        output.say(f"and {len(rows) - MOST} more, in {folder / 'sweep.csv'}")
    for key in idle_keys(rows):
        output.say(f"note: {key} changes nothing of what touches")


def _finish(output: Output, rows: Sequence[Row], folder: Path, known: int) -> None:
    from creak.studies.sweep.case import DONE
    from creak.verify.reliability import UNRELIABLE

    failed = [r for r in rows if r.outcome.status not in (DONE, UNRELIABLE)]
    doubtful = [r for r in rows if r.outcome.status == UNRELIABLE]
    output.say(f"{len(rows) - len(failed)} of {len(rows)} cases have results, {known} from before")
    for r in doubtful:
        output.warn(f"{r.case.name} is unreliable: {r.outcome.error}")
    output.tell_written()
    output.result(
        {
            "cases": [
                {
                    "case": r.case.name,
                    "status": r.outcome.status,
                    "error": r.outcome.error or None,
                    "wall_s": r.outcome.record.get("case_wall_s"),
                    "folder": str(folder / r.case.folder_name),
                }
                for r in rows
            ],
            "from_before": known,
            "written": [str(path) for path in output.written],
        }
    )
    if failed:
        lines = [f"  {r.case.name}: {r.outcome.error}" for r in failed]
        raise NumericalError("\n".join([f"{len(failed)} of {len(rows)} cases failed", *lines]))
    if doubtful:
        raise Unreliable(f"{len(doubtful)} of {len(rows)} cases: {', '.join(r.case.name for r in doubtful)}")


class _Drawn:
    """A bar on a terminal, a line with the time left for each case that ends; silent when asked."""

    def __init__(self, quiet: bool, total: int, done: int) -> None:
        self._console = Terminal(stderr=True, soft_wrap=True, quiet=quiet)
        self._bar = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=28),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=self._console,
            disable=quiet or not self._console.is_terminal,
        )
        self._task = self._bar.add_task("cases", total=total, completed=done)
        self._before, self._started = done, time.monotonic()
        self.done = done

    def __enter__(self) -> _Drawn:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def __call__(self, row: Row, done: int, total: int) -> None:
        from creak.studies.sweep.case import FAILED

        seconds, error = row.outcome.record.get("case_wall_s", 0.0), row.outcome.error
        self.done += row.outcome.status != FAILED
        text = f"{done}/{total} {row.case.name}: {row.outcome.status}, {seconds:.1f} s{self._left(done, total)}"
        self._console.print(f"{text}: {error}" if error else text)
        self._bar.update(self._task, completed=done)

    def _left(self, done: int, total: int) -> str:
        """Time left, from the mean of the cases that ended since the start."""
        from creak.words import duration

        if done >= total:
            return ""
        each = (time.monotonic() - self._started) / max(done - self._before, 1)
        return f", about {duration(each * (total - done))} left"
