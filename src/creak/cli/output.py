"""What every command shares: where its words go, progress on the way, and results for machines."""

from __future__ import annotations

import json
import math
import os
import sys
import tempfile
import textwrap
import threading
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import typer
from rich.cells import cell_len
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from creak.cli.console import Terminal, printable
from creak.cli.joined import joined
from creak.errors import CreakError, InputError, told_apart
from creak.formats.destination import Destination, descriptor_of, destination
from creak.progress import Sentence

QUIET = typer.Option(False, "--quiet", "-q", help="No progress and no tables; warnings and errors stay.")
VERBOSE = typer.Option(False, "--verbose", "-v", help="More lines: seconds of each phase, sizes, choices made.")
AS_JSON = typer.Option(False, "--json", help="The result as JSON on stdout, nothing else there.")
JSON_FILE = typer.Option(
    None, "--json", metavar="FILE", help="Write the result here as JSON; - is stdout, with nothing else there."
)
IGNORE = typer.Option([], "--ignore", metavar="KEYWORD", help="Keyword of the deck that may go unread.")
STDOUT = 1
"""Its number: --json /dev/stdout is --json -."""
SHOWN_AFTER = 2.0
"""s after which a phase gets a plain line where there is no terminal."""
NAME = 48
"""Characters of a name in a table."""
FRAME = 3
"""Characters that a table adds to each column."""
WORDS = 16
"""Longer cells of a table are texts, and may break between words."""
EVERY = 10.0
"""s between further lines of the same phase."""
ALIKE = 10
"""Steps of a phase from which on they are taken to last equally long, so that the time left is told."""


def writable_folder(folder: Path, fix: str = "Name another folder with --out.") -> None:
    """Check that results can be written into `folder`, without creating it; `fix` is what to do where not.

    Raises
    ------
    InputError : it is a file, or it (or the folder it would be made in) cannot be written.
    """
    existing = folder
    while not existing.exists():
        if existing.parent == existing:
            break
        existing = existing.parent
    if not existing.is_dir():
        raise InputError(f"cannot write to {folder}: {existing} is a file", fix=fix)
    try:
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise InputError(
            f"cannot write to {folder}: {reason.lower()} ({existing})",
            expected="a folder that can be written",
            fix=fix,
        ) from error


def writable_file(path: Path, *, stream: bool = True, kept: bool = False) -> Destination:
    """Check that an output can be written to `path`, without touching it.

    Parameters
    ----------
    stream : whether the format can be written into a pipe or a device. kept : what is there is judged when it is
        written, but for inputs.

    Raises
    ------
    InputError : it is a folder or another node that cannot be replaced, or its folder cannot be written.
    """
    found = destination(path, stream=stream, kept=kept)
    if not found.stream:
        writable_folder(found.path.parent, "Name another file.")
    return found


def writable_files(paths: Iterable[Path | None]) -> list[Path]:
    """Those outputs that are asked for, each looked at by `writable_file`.

    Raises
    ------
    InputError : as `writable_file`; two of them are one file, of which the last would stay.
    """
    asked, seen = [path for path in paths if path is not None], set()
    for path in asked:
        found = writable_file(path)
        real = found.path.resolve()
        if real in seen and not found.stream:
            raise InputError(f"two outputs are written to {path}", expected="a file for each", fix="Name another one.")
        seen.add(real)
    return asked


def broken(text: str, width: int) -> str:
    """A text of lines no longer than `width` where there are blanks to break them at."""

    def lines(line: str) -> list[str]:
        long = cell_len(line) > width
        return textwrap.wrap(line, max(width, 20), break_long_words=False, break_on_hyphens=False) if long else [line]

    return "\n".join(one for line in text.split("\n") for one in lines(line))


def pieces(cells: Sequence[Sequence[str]], width: int) -> list[list[int]]:
    """Columns of a table, in tables that stand below each other, each no wider than `width`.

    Each begins with the first column, and with the second one where the first does not tell rows apart. A column may be
    as narrow as its longest word, and is no narrower.
    """
    need = [max(_widest(row[i]) if i else cell_len(row[i]) for row in cells) + FRAME for i in range(len(cells[0]))]
    first = [row[0] for row in cells]
    lead = [0] if len(set(first)) == len(first) or len(need) < 3 else [0, 1]
    found = [lead.copy()]
    for i in range(len(lead), len(need)):
        if len(found[-1]) > len(lead) and 1 + sum(need[k] for k in found[-1]) + need[i] > width:
            found.append(lead.copy())
        found[-1].append(i)
    return found


def _widest(cell: str) -> int:
    """Cells of the longest word; of short texts, whole figures with their units, all of it."""
    return cell_len(cell) if len(cell) <= WORDS else max(map(cell_len, cell.split()))


class Interrupted(CreakError):
    """Ctrl-C; the message says what is there."""


class Output:
    """The words of a command: results on stdout, progress, details and warnings on stderr.

    As a context it tells an interrupted user which files were written already.

    Parameters
    ----------
    quiet : no progress, no tables. verbose : details as well. as_json : stdout carries JSON alone.

    Raises
    ------
    InputError : both quiet and verbose.
    """

    def __init__(self, quiet: bool = False, verbose: bool = False, as_json: bool = False) -> None:
        if quiet and verbose:
            raise InputError("both --quiet and --verbose", expected="one of them")
        self.quiet, self.verbose, self.as_json = quiet, verbose, as_json
        self.console = Terminal(quiet=quiet or as_json)
        self._error = Terminal(stderr=True, soft_wrap=True)
        self.progress = ProgressBars(self._error, quiet, verbose)
        self.written: list[Path] = []

    def __enter__(self) -> Output:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        if kind is KeyboardInterrupt and self.written:
            raise Interrupted(f"written before: {', '.join(map(str, self.written))}") from error

    def say(self, text: str) -> None:
        """A line of the result; none with --quiet or --json. On a terminal it breaks between words alone."""
        if self.console.is_terminal:
            text = broken(printable(text), self.console.width)
        self.console.print(text, soft_wrap=True)

    def command(self, text: str) -> None:
        """A line that is to be copied: never broken."""
        self.console.print(text, soft_wrap=True)

    def table(self, title: str, rows: Sequence[Sequence[str]], left: Sequence[int] = (0,)) -> None:
        """A table: the first of `rows` is its header, columns `left` stand to the left.

        Where it is wider than the terminal it goes on below, with the first column again.
        """
        names = [rows[0][0], *told_apart([row[0] for row in rows[1:]], NAME)]
        cells = [[printable(c) for c in (name, *row[1:])] for name, row in zip(names, rows, strict=True)]
        for k, columns in enumerate(pieces(cells, self.console.width)):
            table = Table(title=None if k else Text(printable(title)), title_justify="left")
            for i in columns:
                table.add_column(Text(cells[0][i]), justify="left" if i in left else "right", no_wrap=i == 0)
            for row in cells[1:]:
                table.add_row(*(Text(row[i]) for i in columns))
            self.console.print(table)

    def warn(self, text: str) -> None:
        """What the user should look at, on stderr."""
        self._error.print(f"warning: {text}", style="yellow")

    def alarm(self, text: str) -> None:
        """What makes a result worthless, on stderr."""
        self._error.print(f"warning: {text}", style="bold red")

    def detail(self, text: str) -> None:
        """A line for --verbose, on stderr."""
        if self.verbose:
            self._error.print(text)

    def wrote(self, *paths: Path) -> None:
        """Files that lie there now; `tell_written` names them, and so does an interruption."""
        self.written.extend(paths)

    def tell_written(self) -> None:
        """A line for each file."""
        for path in self.written:
            self.say(f"wrote {path}")

    def write(self, data: Mapping[str, Any], path: Path) -> None:
        """The result for machines as a file; figures that are not finite are null."""
        from creak.formats.complete_file import write_text

        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, json.dumps(finite(data), indent=2, allow_nan=False) + "\n")
        self.wrote(path)

    def result(self, data: Mapping[str, Any]) -> None:
        """The result for machines: printed with --json only; figures that are not finite are null."""
        if self.as_json:
            sys.stdout.write(json.dumps(finite(data), indent=2, allow_nan=False) + "\n")


def output_of(quiet: bool = QUIET, verbose: bool = VERBOSE, as_json: bool = AS_JSON) -> Output:
    """What the options say."""
    return Output(quiet, verbose, as_json)


OUTPUT = joined(output_of)


def is_stdout(path: Path | None) -> bool:
    """Whether the file that --json names is standard output."""
    return path is not None and (path == Path("-") or descriptor_of(path) == STDOUT)


def finite(data: Any) -> Any:
    """Plain data with None for numbers that JSON does not know."""
    if isinstance(data, Mapping):
        return {key: finite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [finite(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data


@dataclass
class _Stage:
    """What is known of a phase under way."""

    started: float
    told: float
    """When its last plain line came."""
    begun: int = 0
    """Of its steps, done before: by a run that this one goes on from, and with the first word of more than these."""
    counted: float | None = None
    """When that word came: what comes before it waits for compilers and factors, and is no measure of a step."""
    done: int = 0
    total: int = 0
    finished: bool = False
    bar: TaskID | None = None


class ProgressBars:
    """A bar with elapsed and remaining time for each phase; plain lines where there is no terminal.

    Without a terminal a phase is named once it has taken `SHOWN_AFTER` s, then every `EVERY` s, and when it ends;
    with --verbose every phase when it ends.
    """

    def __init__(self, console: Terminal, quiet: bool = False, verbose: bool = False) -> None:
        self._console, self._quiet, self._verbose = console, quiet, verbose
        self._plain = not console.is_terminal
        self._bars = Progress(
            TextColumn("{task.description:<42}", markup=False),
            BarColumn(bar_width=28),
            TextColumn("{task.percentage:>3.0f} %", markup=False),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=console,
            disable=quiet or self._plain,
        )
        self._stages: dict[str, _Stage] = {}

    def __enter__(self) -> ProgressBars:
        self._bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bars.stop()

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Report that `done` of `total` of a phase is finished, or a sentence (`creak.progress.Sentence`)."""
        if isinstance(stage, Sentence):
            if not self._quiet:
                self._console.print(stage)
            return
        now, known = time.monotonic(), self._stages.get(stage)
        if known is not None and known.finished and (done, total) == (known.done, known.total):
            return
        if known is None or (known.finished and (done < known.done or total != known.total)):
            known = self._stages[stage] = self._started(stage, done, now, known)
        if known.counted is None and done > known.begun:
            known.begun, known.counted = done, now
        known.done, known.total, known.finished = done, total, done >= total
        if self._plain:
            self._tell(stage, known, done, total, now)
        elif known.bar is not None:
            unknown = total <= 1 and not known.finished
            self._bars.update(known.bar, completed=done, total=None if unknown else total)

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """A phase of which nothing is known but that it goes on."""
        self(name, 0, 1)
        timer = threading.Timer(SHOWN_AFTER, self._console.print, (f"{name} ...",))
        timer.daemon = True
        if self._plain and not self._quiet:
            timer.start()
        try:
            yield
        finally:
            timer.cancel()
        self(name, 1, 1)

    def _started(self, stage: str, done: int, now: float, before: _Stage | None) -> _Stage:
        """A phase that begins, or begins again, with so much of it done."""
        if self._plain:
            return _Stage(now, now + SHOWN_AFTER - EVERY, done)
        if before is None or before.bar is None:
            bar = self._bars.add_task(printable(stage), total=None, completed=done)
            return _Stage(now, now, done, bar=bar)
        self._bars.reset(before.bar, total=None, completed=done)
        return _Stage(now, now, done, bar=before.bar)

    def _tell(self, stage: str, known: _Stage, done: int, total: int, now: float) -> None:
        from creak.words import duration

        took = now - known.started
        if self._quiet:
            return
        if known.finished:
            if took >= SHOWN_AFTER or self._verbose:
                self._console.print(f"{stage}: {took:.1f} s")
        elif now - known.told >= EVERY:
            known.told = now
            rest = (now - (known.counted or now)) * (total - done) / max(done - known.begun, 1)
            left = f", about {duration(rest)} left" if done > known.begun and total >= ALIKE and rest >= 1.0 else ""
            share = f"{100 * done // max(total, 1)} % after " if total > 1 else ""
            self._console.print(f"{stage}: {share}{duration(took)}{left}")
