"""`creak thesis`: every study of a thesis on reduced door models, and one page with both results."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from creak.cli.console import Terminal
from creak.cli.output import QUIET, Output, writable_file, writable_folder
from creak.errors import CreakError, NumericalError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from creak_thesis.doors import Doors
    from creak_thesis.outcome import Outcome

CASE = "case "
"""Begins the stage that counts the cases; other stages are steps of the case under way."""


def thesis(
    mesh_size: float = typer.Option(
        20.0,
        "--mesh-size",
        help="Mesh size of the door, mm: 40 for a first look, 20 for the page, 4.22 for the "
        "thesis's 1.17 million dofs (days).",
    ),
    out: Path = typer.Option(Path("thesis"), "--out", help="Folder for the page and the results of the cases."),
    quiet: bool = QUIET,
) -> None:
    """Run the studies of a thesis on reduced door models with contact on creak's door; write thesis.html.

    Each case is kept as soon as it is done: after a stop the same command goes on from there.
    """
    from creak.api.extras import need_report

    need_report()
    from creak_thesis.door import LOADS
    from creak_thesis.door.assembly import checked_mesh_size
    from creak_thesis.record import study_record
    from creak_thesis.report.page import Inputs, write_thesis_page
    from creak_thesis.run import run_thesis

    size = checked_mesh_size(mesh_size)
    writable_folder(out)
    writable_file(out / "thesis.html", stream=False)
    out.mkdir(parents=True, exist_ok=True)
    output = Output(quiet)
    with ThesisProgress(quiet) as progress:
        try:
            outcomes = run_thesis(size, out, progress).outcomes
        except KeyboardInterrupt:
            raise NumericalError(
                f"stopped with {progress.done} of {progress.total} cases finished; the same command goes on from there"
            ) from None
        progress("write the page", 0, 2)
        record = study_record()
        progress("write the page", 1, 2)
        channels = outcomes["Ref StS"].channel_names if "Ref StS" in outcomes else ()
        page = Inputs(size, outcomes, record, _doors(size, out, channels, output), LOADS)
        write_thesis_page(page, out / "thesis.html")
        progress("write the page", 2, 2)
    output.say(f"wrote {out / 'thesis.html'}")
    _stop_on_failed(outcomes)


def _doors(size: float, out: Path, channels: Sequence[str], output: Output) -> Doors | None:
    """The doors for pictures and tables; None, with a line, where they cannot be built."""
    from creak_thesis.doors import open_doors

    try:
        return open_doors(size, out, channels)
    except CreakError as error:
        output.say(f"no pictures of the door: {error}")
        return None


def _stop_on_failed(outcomes: Mapping[str, Outcome]) -> None:
    failed = {name: o.reason for name, o in outcomes.items() if o.reason}
    if failed:
        lines = [f"  {name}: {reason}" for name, reason in failed.items()]
        raise NumericalError("\n".join([f"{len(failed)} of {len(outcomes)} cases have no result", *lines]))


class ThesisProgress:
    """Bars for the cases and for the step under way on a terminal, else a line for each case; silent when asked."""

    def __init__(self, quiet: bool) -> None:
        self._console = Terminal(stderr=True, soft_wrap=True, quiet=quiet)
        self._plain = not quiet and not self._console.is_terminal
        self._bar = Progress(
            TextColumn("{task.description:<38}", markup=False),
            BarColumn(bar_width=28),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]}", markup=False),
            console=self._console,
            disable=quiet or self._plain,
        )
        self._cases = self._bar.add_task("cases", total=None, left="")
        self._step: TaskID | None = None
        self._stage = ""
        self._started = time.monotonic()
        self.done, self.total = 0, 0

    def __enter__(self) -> ThesisProgress:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Report that `done` of `total` of a stage is finished; stages `case NAME` count the cases."""
        if stage.startswith(CASE) or stage == "cases":
            self._case(stage, done, total)
        else:
            self._inner(stage, done, total)

    def _case(self, stage: str, done: int, total: int) -> None:
        self.done, self.total = done, total
        self._bar.update(self._cases, description=stage, completed=done, total=total, left=self._left(done, total))
        if self._plain:
            text = f"{done}/{total} {stage}, {time.monotonic() - self._started:.0f} s {self._left(done, total)}"
            self._console.print(text.rstrip())

    def _left(self, done: int, total: int) -> str:
        """Time left, from the mean of the cases so far; the first ones of a kind cost more."""
        if done == 0 or done >= total:
            return ""
        left = (time.monotonic() - self._started) / done * (total - done)
        return f"about {left / 60.0:.0f} min left" if left >= 90.0 else f"about {left:.0f} s left"

    def _inner(self, stage: str, done: int, total: int) -> None:
        if self._plain:
            return
        if stage != self._stage:
            if self._step is not None:
                self._bar.remove_task(self._step)
            self._step, self._stage = self._bar.add_task(f"  {stage}", total=total, left=""), stage
        assert self._step is not None
        self._bar.update(self._step, completed=done, total=total)
