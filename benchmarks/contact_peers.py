"""One small contact case in creak, CalculiX and OpenSees: `python -m benchmarks.contact_peers`.

Two steel strips of shells with a gap between their faces. The upper one is a cantilever whose root moves by a sine
that swells over its first period; its tip comes down on the middle of the lower one, which is clamped at both ends.
All programs get the same mesh, step, HHT parameter, stiffness-proportional damping and contact pressure per depth;
facing nodes lie opposite each other. Every run is a process of its own with a limit on time.

- creak: `creak run`, surface-to-surface contact; unreduced and reduced.
- CalculiX (`ccx`, called as a program): S4 shells, which it expands to solids; node-to-face contact pairs, and gap
  elements (GAPUNI) between facing nodes.
- OpenSees (openseespy, in the interpreter named by --opensees or CREAK_OPENSEES_PYTHON): ShellMITC4, a
  compression-only gap spring between facing nodes.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.integrate import trapezoid

from creak.arrays import FloatArray

E, NU, RHO = 210000.0, 0.3, 7.85e-9
"""Steel in mm, t, s."""
LENGTH, WIDTH, THICKNESS, SHIFT, GAP = 100.0, 20.0, 1.0, 50.0, 0.5
"""mm; the lower strip starts SHIFT further along x."""
AMPLITUDE, FREQUENCY = 0.5, 60.0
"""mm, Hz of the root; the cantilever's first mode lies at 84 Hz."""
BETA = 1e-5
"""s; C = BETA K: 0.3 % of critical in the first mode, 3 % at 1 kHz."""
STIFFNESS = 30.0
"""N/mm^3 of contact; the facing shells bounce on it with a period of 2 pi sqrt(rho t / STIFFNESS) = 0.1 ms."""
STEP, END, ALPHA = 2e-5, 0.05, -0.05
"""s, s, HHT."""
SIZES = ((30, 6), (44, 9), (90, 18))
"""Elements along and across a strip; 2,604, 5,400 and 20,748 dofs."""
F_MAX = 5000.0
"""Hz of the modes that the reduced run keeps."""
REFINED = 4
"""The run that all others are judged by takes so many steps to one of theirs."""
LIMITS_S = (400.0, 100.0, 100.0)
"""CPU seconds of one run, size by size: unlike wall time they do not depend on who else uses the machine."""
PATIENCE = 5.0
"""Wall-clock limit over that of CPU time."""
MERGE_S = 1e-3
"""Contact lost for less is the same contact."""
LEAST_FORCE = 0.01
"""N, of both strips together, that counts as contact."""
OPENSEES_PYTHON = "CREAK_OPENSEES_PYTHON"


@dataclass(frozen=True)
class Strip:
    """A strip of quads, the `rank`th. Labels have no holes: CalculiX makes room for every label below the last."""

    name: str
    rank: int
    origin: float
    """x of its left end, mm."""
    height: float
    """z of the mid-surface, mm."""
    nx: int
    ny: int

    @property
    def nodes(self) -> list[tuple[int, float, float, float]]:
        """Label, x, y, z."""
        dx, dy = LENGTH / self.nx, WIDTH / self.ny
        return [
            (self.label(i, j), self.origin + i * dx, j * dy, self.height)
            for j in range(self.ny + 1)
            for i in range(self.nx + 1)
        ]

    @property
    def quads(self) -> list[tuple[int, ...]]:
        """Label, four nodes; the normal is +z."""
        return [
            (self.quad(i, j), *(self.label(i + a, j + b) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))))
            for j in range(self.ny)
            for i in range(self.nx)
        ]

    def label(self, i: int, j: int) -> int:
        """Of the node i along, j across."""
        return self.rank * (self.nx + 1) * (self.ny + 1) + 1 + j * (self.nx + 1) + i

    def quad(self, i: int, j: int) -> int:
        """Label of the element i along, j across."""
        return self.rank * self.nx * self.ny + 1 + j * self.nx + i

    def column(self, i: int) -> list[int]:
        """Labels of the nodes across the strip."""
        return [self.label(i, j) for j in range(self.ny + 1)]

    def facing(self, first: int, last: int) -> list[int]:
        """Labels of the quads between two columns."""
        return [self.quad(i, j) for j in range(self.ny) for i in range(first, last)]


@dataclass(frozen=True)
class Case:
    """The mesh and the time axis."""

    nx: int
    ny: int
    step: float = STEP
    end: float = END

    @property
    def upper(self) -> Strip:
        return Strip("UPPER", 0, 0.0, GAP + THICKNESS, self.nx, self.ny)

    @property
    def lower(self) -> Strip:
        return Strip("LOWER", 1, SHIFT, 0.0, self.nx, self.ny)

    @property
    def shift(self) -> int:
        """Columns by which the lower strip is shifted."""
        return round(self.nx * SHIFT / LENGTH)

    @property
    def dofs(self) -> int:
        return 12 * (self.nx + 1) * (self.ny + 1)

    @property
    def times(self) -> FloatArray:
        return self.step * np.arange(round(self.end / self.step) + 1)

    @property
    def base(self) -> FloatArray:
        """Displacement of the upper root at the steps, mm: a sine that swells over its first period."""
        x = np.clip(self.times * FREQUENCY, 0.0, 1.0)
        swell = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
        base: FloatArray = AMPLITUDE * swell * np.sin(2.0 * np.pi * FREQUENCY * self.times)
        return base

    @property
    def pairs(self) -> list[tuple[int, int, float]]:
        """Facing nodes, upper and lower, and their tributary area, mm^2."""
        cell = LENGTH / self.nx * WIDTH / self.ny
        along = np.r_[0.5, np.ones(self.nx - self.shift - 1), 0.5]
        across = np.r_[0.5, np.ones(self.ny - 1), 0.5]
        return [
            (self.upper.label(i + self.shift, j), self.lower.label(i, j), float(cell * along[i] * across[j]))
            for j in range(self.ny + 1)
            for i in range(self.nx - self.shift + 1)
        ]

    @property
    def watched(self) -> tuple[int, int]:
        """Middle of the upper tip and the node of the lower strip that it faces."""
        return self.upper.label(self.nx, self.ny // 2), self.lower.label(self.nx - self.shift, self.ny // 2)


@dataclass(frozen=True)
class Trace:
    """What a run left; `failed` says why it did not reach the end."""

    time: FloatArray
    tip: FloatArray
    """mm, z of the watched node of the upper strip."""
    middle: FloatArray
    """mm, of the lower strip."""
    force: FloatArray
    """N, sum over the contact."""
    failed: str = ""
    wall_s: float = np.nan
    """Of the whole process."""
    step_s: float = np.nan
    """CPU time of the time integration over its steps (CalculiX: of the whole run)."""
    cpu_s: float = np.nan
    """Of the whole process, all threads."""
    peak_gb: float = np.nan


@dataclass(frozen=True)
class Ended:
    """How a process ended."""

    code: int
    late: bool
    """Over the limit."""
    wall_s: float
    cpu_s: float
    peak_gb: float
    log: str


@dataclass(frozen=True)
class Contact:
    """One contact of the strips."""

    start: float
    peak: float
    """N"""
    impulse: float
    """N s"""


Program = Callable[[Case, Path, float], Trace]


def failure(why: str, ended: Ended | None = None) -> Trace:
    """A run without any answer."""
    none = np.zeros(0)
    empty = Trace(none, none, none, none, why)
    if ended is None:
        return empty
    return replace(empty, wall_s=ended.wall_s, cpu_s=ended.cpu_s, peak_gb=ended.peak_gb)


def bounded(command: Sequence[str], folder: Path, limit_s: float) -> Ended:
    """Run a program in a folder; it is killed at a limit of CPU seconds (or PATIENCE times as long by the clock)."""
    log = folder / "log.txt"
    started = time.perf_counter()
    with log.open("w", encoding="utf-8") as out:
        process = subprocess.Popen(command, cwd=folder, stdout=out, stderr=subprocess.STDOUT)
        resource.prlimit(process.pid, resource.RLIMIT_CPU, (int(limit_s), int(limit_s) + 1))
        timer = threading.Timer(PATIENCE * limit_s, process.kill)
        timer.start()
        _, status, used = os.wait4(process.pid, 0)
        timer.cancel()
    wall = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    text = log.read_text(encoding="utf-8", errors="replace")
    cpu = used.ru_utime + used.ru_stime
    late = process.returncode in (-signal.SIGXCPU, -signal.SIGKILL) and max(cpu + 2.0, wall / PATIENCE) >= limit_s
    return Ended(process.returncode, late, wall, cpu, used.ru_maxrss * 1024e-9, text)


def mesh_text(case: Case) -> str:
    """Nodes, S4, sets, surfaces, section and material: what creak and CalculiX read alike."""
    lines: list[str] = []
    for strip in (case.upper, case.lower):
        lines += ["*NODE", *(f"{n}, {x:.9g}, {y:.9g}, {z:.9g}" for n, x, y, z in strip.nodes)]
        lines += [f"*ELEMENT, TYPE=S4, ELSET={strip.name}", *(", ".join(map(str, quad)) for quad in strip.quads)]
    n, shift = case.nx, case.shift
    paired = [label for upper, lower, _ in case.pairs for label in (upper, lower)]
    sets = {
        "MOVING": case.upper.column(0),
        "FIXED": [*case.lower.column(0), *case.lower.column(n)],
        "WATCHED": list(case.watched),
        "PAIRED": paired,
    }
    for name, labels in sets.items():
        lines += [f"*NSET, NSET={name}", *(f"{label}," for label in labels)]
    for name, labels in (("OVER", case.upper.facing(shift, n)), ("UNDER", case.lower.facing(0, n - shift))):
        lines += [f"*ELSET, ELSET={name}", *(f"{label}," for label in labels)]
    lines += ["*SURFACE, NAME=HITS, TYPE=ELEMENT", "OVER, SNEG", "*SURFACE, NAME=HIT, TYPE=ELEMENT", "UNDER, SPOS"]
    lines += [
        "*MATERIAL, NAME=STEEL",
        "*ELASTIC",
        f"{E}, {NU}",
        "*DENSITY",
        f"{RHO},",
        f"*DAMPING, ALPHA=0., BETA={BETA}",
    ]
    for name in ("UPPER", "LOWER"):
        lines += [f"*SHELL SECTION, ELSET={name}, MATERIAL=STEEL", f"{THICKNESS},"]
    return "\n".join([*lines, "*BOUNDARY", "FIXED, 1, 6", "MOVING, 1, 2", "MOVING, 4, 6", ""])


def study_text(case: Case, reduction: str) -> str:
    """The study; `reduction` is the body of that table."""
    return f"""title = "Two strips"

[model]
deck = "strips.inp"

[damping]
rayleigh = {{ beta = {BETA} }}

[contact.tip]
secondary = "HITS"
main = "HIT"
stiffness = {STIFFNESS}

[excitation.root]
node_set = "MOVING"
dof = "z"
signal = {{ type = "table", file = "base.csv" }}

[reduction]
{reduction}

[reference]
run = false

[precheck]
enabled = false

[time]
step = {case.step}
end = {case.end}
alpha = {ALPHA}

[output]
nodes = "WATCHED"
"""


UNREDUCED = 'method = "none"'
CRAIG_BAMPTON = f'method = "craig-bampton"\nf_max = {F_MAX}'
GAP_MODES = f'method = "gap-modes"\nf_max = {F_MAX}'


def creak_run(reduction: str) -> Program:
    """creak through its command line."""

    def run(case: Case, folder: Path, limit_s: float) -> Trace:
        (folder / "strips.inp").write_text("*HEADING\ntwo strips\n" + mesh_text(case))
        np.savetxt(folder / "base.csv", np.c_[case.times, case.base], "%.12g", ",", header="time,value", comments="")
        (folder / "study.toml").write_text(study_text(case, reduction))
        command = [sys.executable, "-m", "creak.cli.main", "run", "study.toml", "--out", "results", "--quiet"]
        ended = bounded(command, folder, limit_s)
        if ended.late or ended.code:
            return failure(f"over {limit_s:.0f} s of CPU" if ended.late else last_line(ended.log), ended)
        return _creak_trace(case, folder / "results", ended)

    return run


def _creak_trace(case: Case, results: Path, ended: Ended) -> Trace:
    ((name, figures),) = json.loads((results / "summary.json").read_text())["runs"].items()
    with h5py.File(results / "results.h5") as file:
        run = file[f"runs/{name}"]
        labels = run["node_ids"][:].tolist()
        tip, middle = (run["displacement"][:, labels.index(label), 2] for label in case.watched)
        force = run["normal_force"][:].sum(axis=1)
        step_s = figures["cpu_s"] / figures["steps"]
        return Trace(run["time"][:], tip, middle, force, "", ended.wall_s, step_s, ended.cpu_s, ended.peak_gb)


def last_line(log: str) -> str:
    """The last words of a program."""
    lines = [line.strip() for line in log.splitlines() if line.strip()]
    return lines[-1][:100] if lines else "no message"


SIGMA_INFINITY = 0.01
"""N/mm^2: rounds the corner of CalculiX's linear law over SIGMA_INFINITY pi / STIFFNESS = 1 um."""
PULL = 1e-4
"""N with which the open gap elements of CalculiX pull, all together."""
LEAST_STEP = 1e-9
"""s, for CalculiX's automatic steps."""


def contact_pair(case: Case) -> list[str]:
    """CalculiX's node-to-face penalty contact."""
    return [
        "*SURFACE INTERACTION, NAME=PRESSES",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
        f"{STIFFNESS}, {SIGMA_INFINITY}",
        "*CONTACT PAIR, INTERACTION=PRESSES, TYPE=NODE TO SURFACE",
        "HITS, HIT",
    ]


def gap_elements(case: Case) -> list[str]:
    """CalculiX's GAPUNI between facing nodes, with the stiffness of their area."""
    lines, label = [], 2 * case.nx * case.ny
    for k, area in enumerate(sorted({area for *_, area in case.pairs})):
        lines.append(f"*ELEMENT, TYPE=GAPUNI, ELSET=GAP{k}")
        for upper, lower, its_area in case.pairs:
            if its_area == area:
                label += 1
                lines.append(f"{label}, {lower}, {upper}")
        law = f"{STIFFNESS * area:.9g}, {PULL / len(case.pairs):.9g}"  # CalculiX reads 20 characters of a number
        lines += [f"*GAP, ELSET=GAP{k}", f"{GAP}, 0., 0., 1., , {law}"]
    return lines


def calculix_text(case: Case, contact: list[str], fixed_step: bool) -> str:
    """The same strips, contact, and the step that CalculiX is to take."""
    base = [f"{t:.9e}, {z:.9e}" for t, z in zip(case.times, case.base, strict=True)]
    steps = [f"*DYNAMIC, ALPHA={ALPHA}, DIRECT", f"{case.step}, {case.end}"]
    if not fixed_step:
        steps = [f"*DYNAMIC, ALPHA={ALPHA}", f"{case.step}, {case.end}, {LEAST_STEP}, {case.step}"]
    return mesh_text(case) + "\n".join(
        [
            *contact,
            "*AMPLITUDE, NAME=BASE",
            *base,
            "*STEP, INC=1000000",
            *steps,
            "*BOUNDARY, AMPLITUDE=BASE",
            "MOVING, 3, 3, 1.",
            "*NODE PRINT, NSET=PAIRED",
            "U",
            "*END STEP",
            "",
        ]
    )


def calculix_run(program: str | None, contact: Callable[[Case], list[str]], fixed_step: bool) -> Program:
    """CalculiX; its progress up to the limit counts."""

    def run(case: Case, folder: Path, limit_s: float) -> Trace:
        if program is None:
            return failure("not installed: no ccx on the path, see --ccx")
        (folder / "strips.inp").write_text(calculix_text(case, contact(case), fixed_step))
        ended = bounded([program, "-i", "strips"], folder, limit_s)
        late = f"over {limit_s:.0f} s of CPU"
        return _calculix_trace(case, folder / "strips.dat", ended, late if ended.late else calculix_error(ended))

    return run


def calculix_error(ended: Ended) -> str:
    """Its error message, or how it ended."""
    found = re.search(r"\*ERROR:?(.*?)\n\s*\n", ended.log, re.DOTALL)
    if found:
        return " ".join(found.group(1).split())[:120]
    return f"status {ended.code}: {last_line(ended.log)}" if ended.code else ""


def _calculix_trace(case: Case, path: Path, ended: Ended, failed: str) -> Trace:
    """Displacements from the .dat file; forces from the gaps by the linear law."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    labels = sorted({label for upper, lower, _ in case.pairs for label in (upper, lower)})
    times, moved = [0.0], [np.zeros(len(labels))]
    for block in text.split("displacements (vx,vy,vz) for set PAIRED and time")[1:]:
        words = block.split()
        if len(words) == 1 + 4 * len(labels):  # the last block may have been cut off
            table = np.array(words[1:], dtype=float).reshape(-1, 4)
            times.append(float(words[0]))
            moved.append(table[np.argsort(table[:, 0]), 3])
    z = np.array(moved)
    upper, lower = (np.searchsorted(labels, [pair[k] for pair in case.pairs]) for k in (0, 1))
    area = np.array([pair[2] for pair in case.pairs])
    force = STIFFNESS * np.maximum(0.0, -(GAP + z[:, upper] - z[:, lower])) @ area
    tip, middle = (z[:, labels.index(label)] for label in case.watched)
    step_s = ended.cpu_s / max(1, len(times) - 1)
    return Trace(np.array(times), tip, middle, force, failed, ended.wall_s, step_s, ended.cpu_s, ended.peak_gb)


OPENSEES_SOLVER = "BandSPD"
"""The fastest here of those that OpenSees brings (ProfileSPD, SparseSYM, UmfPack, SuperLU were tried)."""


def opensees_run(python: str | None) -> Program:
    """OpenSees in its own interpreter; it stops itself at the limit."""

    def run(case: Case, folder: Path, limit_s: float) -> Trace:
        if python is None:
            return failure(f"not installed: no interpreter given, see --opensees and {OPENSEES_PYTHON}")
        (folder / "case.json").write_text(json.dumps(opensees_case(case, limit_s)))
        script = Path(__file__).with_name("contact_peers_opensees.py")
        ended = bounded([python, str(script), "case.json", "result.json"], folder, 2.0 * limit_s)
        if ended.late or ended.code:
            return failure(f"status {ended.code}: {last_line(ended.log)}", ended)
        said = json.loads((folder / "result.json").read_text())
        times, tip, middle, force = np.array(said["rows"]).T
        step_s = (said["cpu_s"] - said["setup_s"]) / max(1, times.size - 1)
        return Trace(times, tip, middle, force, said["failed"], ended.wall_s, step_s, ended.cpu_s, ended.peak_gb)

    return run


def opensees_case(case: Case, limit_s: float) -> dict[str, object]:
    """What `contact_peers_opensees` reads."""
    upper, lower = case.upper, case.lower
    return {
        "E": E,
        "nu": NU,
        "rho": RHO,
        "thickness": THICKNESS,
        "gap": GAP,
        "stiffness": STIFFNESS,
        "beta": BETA,
        "alpha": ALPHA,
        "step": case.step,
        "base": case.base.tolist(),
        "limit": limit_s,
        "solver": OPENSEES_SOLVER,
        "nodes": upper.nodes + lower.nodes,
        "quads": upper.quads + lower.quads,
        "pairs": case.pairs,
        "moving": upper.column(0),
        "fixed": [*lower.column(0), *lower.column(case.nx)],
        "watched": case.watched,
    }


def contacts(trace: Trace) -> list[Contact]:
    """Contacts of the strips in time; contact lost for less than MERGE_S goes on."""
    closed = np.flatnonzero(trace.force > LEAST_FORCE)
    if not closed.size:
        return []
    pieces = np.split(closed, 1 + np.flatnonzero(np.diff(trace.time[closed]) > MERGE_S))
    return [_contact(trace, slice(piece[0], piece[-1] + 1)) for piece in pieces]


def _contact(trace: Trace, when: slice) -> Contact:
    t, p = trace.time, trace.force
    wide = slice(max(when.start - 1, 0), when.stop + 1)
    return Contact(float(t[when][0]), float(p[when].max()), float(trapezoid(p[wide], t[wide])))


def difference(trace: Trace, reference: Trace, until: float) -> float:
    """Root mean square of the tip's difference over that of the tip itself, up to a time."""
    use = (trace.time <= min(until, reference.time[-1])) & (trace.time > 0.0)
    if not use.any():
        return np.nan
    expected = np.interp(trace.time[use], reference.time, reference.tip)
    return float(np.linalg.norm(trace.tip[use] - expected) / np.linalg.norm(expected))


@dataclass(frozen=True)
class Entry:
    """A row of the table."""

    name: str
    run: Program
    every_size: bool = True
    limit_s: float = np.inf


CRAWL_S = 60.0
"""Limit for contact pairs with automatic steps, which never get far."""


def entries(ccx: str | None, opensees: str | None) -> list[Entry]:
    """All runs of the comparison."""
    return [
        Entry("creak, unreduced", creak_run(UNREDUCED)),
        Entry("creak, gap modes", creak_run(GAP_MODES)),
        Entry("creak, Craig-Bampton", creak_run(CRAIG_BAMPTON)),
        Entry("CalculiX, contact pair, fixed steps", calculix_run(ccx, contact_pair, True), False),
        Entry("CalculiX, contact pair, automatic steps", calculix_run(ccx, contact_pair, False), False, CRAWL_S),
        Entry("CalculiX, gap elements, fixed steps", calculix_run(ccx, gap_elements, True), False),
        Entry("CalculiX, gap elements, automatic steps", calculix_run(ccx, gap_elements, False)),
        Entry("OpenSees, gap springs", opensees_run(opensees)),
    ]


HEAD = (
    "",
    "to ms",
    "tip rms: flight",
    "to 2nd, end",
    "contacts: start ms",
    "impulse mN s",
    "peak N",
    "CPU ms/step",
    "wall (CPU) s",
    "GB",
    "stopped by",
)


def row(name: str, trace: Trace, reference: Trace) -> tuple[str, ...]:
    """A line of the table."""
    if not trace.time.size:
        return (name, *("-",) * 7, _seconds(trace), _memory(trace), trace.failed)
    hits, expected = contacts(trace), [hit.start for hit in contacts(reference)]
    end = reference.time[-1]
    first, second = (*expected, end, end)[:2]
    errors = [difference(trace, reference, until) for until in (first, second, end)]
    reached = [True, *(trace.time[-1] > until - STEP for until in (second, end))]
    shown = [f"{100 * e:.2f} %" if ok else "-" for e, ok in zip(errors, reached, strict=True)]
    return (
        name,
        f"{1e3 * trace.time[-1]:.2f}",
        shown[0],
        ", ".join(shown[1:]),
        " ".join(f"{1e3 * hit.start:.2f}" for hit in hits),
        " ".join(f"{1e3 * hit.impulse:.3f}" for hit in hits),
        " ".join(f"{hit.peak:.1f}" for hit in hits),
        f"{1e3 * trace.step_s:.2f}",
        _seconds(trace),
        _memory(trace),
        trace.failed,
    )


def _memory(trace: Trace) -> str:
    return "-" if np.isnan(trace.peak_gb) else f"{trace.peak_gb:.2f}"


def _seconds(trace: Trace) -> str:
    return "-" if np.isnan(trace.wall_s) else f"{trace.wall_s:.0f} ({trace.cpu_s:.0f})"


def measure(
    chosen: Sequence[Entry], sizes: Sequence[Case], limits: Sequence[float], keep: Path
) -> Iterator[tuple[str, ...]]:
    """Rows of the table, mesh by mesh; the first mesh is judged by creak with steps REFINED times shorter."""
    for k, (case, limit_s) in enumerate(zip(sizes, limits, strict=True)):
        yield (f"{case.nx} x {case.ny} shells a strip, {case.dofs:,} dofs", *("",) * (len(HEAD) - 1))
        judged_by = replace(case, step=case.step / REFINED) if k == 0 else case
        reference = _in_folder(Entry("reference", creak_run(UNREDUCED)), judged_by, limit_s, keep)
        if not reference.time.size:
            yield row("reference", reference, reference)
            continue
        if k == 0:
            yield row(f"creak, unreduced, step / {REFINED}", reference, reference)
        for entry in chosen:
            if k == 0 or entry.every_size:
                yield row(entry.name, _in_folder(entry, case, min(limit_s, entry.limit_s), keep), reference)


def _in_folder(entry: Entry, case: Case, limit_s: float, keep: Path) -> Trace:
    """Run an entry in a folder of its own and keep what it found."""
    folder = keep / f"{case.nx}x{case.ny}" / re.sub(r"\W+", "-", entry.name)
    folder.mkdir(parents=True, exist_ok=True)
    trace = entry.run(case, folder, limit_s)
    np.savez(folder / "trace.npz", time=trace.time, tip=trace.tip, middle=trace.middle, force=trace.force)
    return trace


def versions(ccx: str | None, opensees: str | None) -> str:
    """Of the peers, as they say."""
    said = []
    if ccx is not None:
        said.append("CalculiX: " + _says([ccx, "-v"]))
    if opensees is not None:
        said.append("OpenSees: " + _says([opensees, "-c", "import openseespy.opensees as o; print(o.version())"]))
    return "; ".join(said)


def _says(command: Sequence[str]) -> str:
    return " ".join(subprocess.run(command, capture_output=True, text=True, check=False).stdout.split())


def main() -> None:
    """Run all and print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.contact_peers")
    parser.add_argument("--ccx", default=shutil.which("ccx"), help="CalculiX, the program")
    parser.add_argument("--opensees", default=os.environ.get(OPENSEES_PYTHON), help="a Python that has openseespy")
    parser.add_argument("--sizes", type=int, nargs="+", default=range(len(SIZES)), help="which of 0, 1, 2")
    parser.add_argument("--limits", type=float, nargs="+", default=LIMITS_S, help="CPU s of a run, size by size")
    parser.add_argument("--only", default="", help="rows whose name contains this")
    parser.add_argument("--keep", type=Path, help="folder for decks, logs and time histories")
    given = parser.parse_args()
    chosen = [entry for entry in entries(given.ccx, given.opensees) if given.only in entry.name]
    console, table = Console(width=230), Table(*HEAD)
    console.print(versions(given.ccx, given.opensees), f"; load {os.getloadavg()[0]:.1f} at the start")
    with tempfile.TemporaryDirectory() as scratch:
        cases = [Case(*SIZES[k]) for k in given.sizes]
        for line in measure(chosen, cases, [given.limits[k] for k in given.sizes], given.keep or Path(scratch)):
            table.add_row(*line)
            print(*line, sep=" | ", file=sys.stderr, flush=True)
    console.print(table)


if __name__ == "__main__":
    main()
