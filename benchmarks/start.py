"""How long the first words of short commands take: `python -m benchmarks.start [--runs N]`.

Each command runs in a process of its own on the door's deck at 40 mm, after one that is not counted. The best of N is
told beside the time of an empty Python and of what such a command cannot do without (NumPy, SciPy's sparse matrices,
Numba's cached code, the terminal), and what takes longest to import, as `python -X importtime` says.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from creak_thesis.door import write_door

MESH = 40.0
"""mm"""
NEEDED = "import numpy, scipy.sparse, scipy.sparse.csgraph, numba, typer, rich.table"
SHOWN = 3
"""Imports that are named."""


def best_of(command: Sequence[str], runs: int) -> tuple[float, float]:
    """Shortest wall time and the CPU time of that run, s."""
    found = []
    for _ in range(runs + 1):
        before, begin = _cpu(), time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        found.append((time.perf_counter() - begin, _cpu() - before))
    return min(found[1:])


def _cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def imported(command: Sequence[str]) -> tuple[int, list[str]]:
    """How many modules a command of Python imports, and which of creak's own rooms take longest, `name ms`."""
    told = subprocess.run([command[0], "-X", "importtime", *command[1:]], check=True, capture_output=True, text=True)
    lines = [line.split("|") for line in told.stderr.splitlines() if line.startswith("import time:")][1:]
    own = sorted(((int(total), name.strip()) for _, total, name in lines if "creak." in name), reverse=True)
    return len(lines), [f"{name} {total / 1e3:.0f}" for total, name in own[:SHOWN]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition(":")[0])
    parser.add_argument("--runs", type=int, default=5)
    runs = parser.parse_args().runs
    python, table = sys.executable, Table("command", "s", "CPU s", "modules", "longest to import, ms")
    with tempfile.TemporaryDirectory() as folder:
        write_door(MESH, Path(folder))
        deck = str(Path(folder) / "door.inp")
        creak = [python, "-m", "creak"]
        for name, command in {
            "an empty Python": [python, "-c", ""],
            "what it cannot do without": [python, "-c", NEEDED],
            "creak --help": [*creak, "--help"],
            "creak info": [*creak, "info", deck],
            "creak modes": [*creak, "modes", deck],
        }.items():
            wall, cpu = best_of(command, runs)
            count, longest = imported(command)
            table.add_row(name, f"{wall:.2f}", f"{cpu:.2f}", str(count), ", ".join(longest))
    Console().print(table)


if __name__ == "__main__":
    main()
