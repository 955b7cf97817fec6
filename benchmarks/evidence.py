"""What the advice and its pages rest on, measured on today's door: `python -m benchmarks.evidence [--mesh-size H]`.

Writes `studies/advise/evidence.json`; `python -m tools.evidence_pages` makes the pages of it. Every run is one of the
default accuracy unless a forced step is what is looked at. Reductions are held to modes of the assembly up to
`REFERENCE` times the excitation, and those to a stretch of the unreduced run.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from rich.console import Console

from benchmarks.evidence_contact import forced_steps, node_contact, penalties
from benchmarks.evidence_door import Bench, figures, rattle, worst
from benchmarks.stamp import stamp
from creak.contact.step_problem import compile_kernels
from creak.dynamics.flow.ahead import compile_flow
from creak.errors import CreakError
from creak.studies.run.one_run import Run
from creak_thesis.door import LOADS

FILE = Path(__file__).parents[1] / "src" / "creak" / "studies" / "advise" / "evidence.json"
RATTLING = ("A2", "A3", "A4")
LOAD = "A3"
"""Of what is looked at under one load only."""
REFERENCE, CHOSEN = 20, 15
"""Multiples of the excitation: assembly modes of the reference, fixed-interface modes of all that is not about them."""
F = 100.0
"""Hz, highest frequency of the door's excitation."""
CASES: dict[str, dict[str, Any]] = {
    "Guyan": {"method": "guyan"},
    **{f"Craig-Bampton {m} x": {"f_max": F * m} for m in (3, 5, 7, 11, 15, 20)},
    **{f"keep_out {d}": {"keep_out": d} for d in (8, 40, 90)},
    **{f"spacing {n}": {"keep_out": 8, "interface": {"type": "spacing", "n": n}} for n in (2, 4)},
    **{
        f"participation {eta:.2f}": {"keep_out": 8, "interface": {"type": "participation", "eta": eta}}
        for eta in (0.10, 0.15, 0.35)
    },
    **{f"interpolation {n}": {"keep_out": 8, "interface": {"type": "interpolation", "n": n}} for n in (2, 3)},
    **{f"characteristic {n}": {"keep_out": 8, "interface": {"type": "characteristic", "n": n}} for n in (50, 100, 200)},
    **{f"gap modes {m} x": {"method": "gap-modes", "f_max": F * m} for m in (3, 7, 11)},
}
"""Name -> [reduction]; fixed-interface modes to `CHOSEN` times the excitation unless said."""
FINE = (*(f"Craig-Bampton {m} x" for m in (3, 5, 7, 11, 15, 20)), "keep_out 8", "gap modes 7 x")
"""What is looked at on the finer door too: what the pages name of it."""
AMPLITUDES = (0.9, 0.95, 1.05, 1.1)
SEEDS = (2, 3, 4)
DAMPINGS = (0.5, 2.0)
UNREDUCED_S = 1.0
"""s of the unreduced run."""


PARTS = ("door", "fine", "contact")
"""Of the record; each has its own stamp."""


def main() -> None:
    """Measure all parts, or those asked for, and write each into the record when it is there."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.evidence")
    options.add_argument("--mesh-size", type=float, default=40.0, help="mm, of the door")
    options.add_argument("--fine", type=float, default=20.0, help="mm, of the door on which modes are counted again")
    options.add_argument("--part", choices=PARTS, action="append", help="only this one; the others stay as they are")
    options.add_argument("--out", type=Path, default=FILE)
    given = options.parse_args()
    console = Console(width=160)
    compile_kernels()
    compile_flow()
    for part in given.part or PARTS:
        made = stamp()
        console.print(f"{part}:")
        if part == "contact":
            found = contact_record(given.mesh_size, console)
        else:
            names = tuple(CASES) if part == "door" else FINE
            found = door_record(Bench(given.mesh_size if part == "door" else given.fine), names, console)
        before = json.loads(given.out.read_text(encoding="utf-8")) if given.out.exists() else {}
        record = before | {part: {"made": made, **found}}
        given.out.write_text(json.dumps(record, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        console.print(f"wrote {given.out}")


def contact_record(mesh_size: float, console: Console) -> dict[str, Any]:
    """What load, damping, stiffness, forced steps and the method of contact do to the answer."""
    bench, found = Bench(mesh_size), {}
    model = bench.model({"f_max": F * CHOSEN})
    for name, measure in (
        ("physics", lambda: list(physics(bench))),
        ("penalties", lambda: penalties(bench, model, LOAD)),
        ("steps", lambda: forced_steps(bench, model, RATTLING)),
        ("node", lambda: node_contact(mesh_size, F * CHOSEN, LOAD)),
    ):
        console.print(name)
        found[name] = measure()
    return found


def door_record(bench: Bench, names: Sequence[str], console: Console) -> dict[str, Any]:
    """A door, its reference and its reductions."""
    reference = bench.model({"method": "gap-modes", "f_max": F * REFERENCE})
    exact = {load: bench.run(load, reference) for load in RATTLING}
    rows = []
    for row in reductions(bench, exact, names):
        console.print(row["name"], row.get("impulse_error", row.get("failed")))
        rows.append(row)
    return {
        "mesh_size": bench.mesh_size,
        "dofs": 6 * bench.setup.model.nodes.count,
        "free": bench.reference.system.n,
        "channels": bench.gaps.m,
        "of": bench.setup.contacts.m,
        "checked_by": bench.load,
        "kept": {load: bench.kept(load) for load in RATTLING},
        "amplitudes": {load: LOADS[load] for load in RATTLING},
        "reference_multiple": REFERENCE,
        "reference_unknowns": reference.system.n,
        "chosen_multiple": CHOSEN,
        "runs": {load: rattle(run) for load, run in exact.items()},
        "unreduced": unreduced(bench, exact[LOAD]),
        "reductions": rows,
    }


def reductions(bench: Bench, exact: Mapping[str, Run], names: Sequence[str]) -> Iterator[dict[str, Any]]:
    """One row a reduction: size, frequencies, events under all loads, times."""
    for name in names:
        table = {"f_max": F * CHOSEN} | CASES[name]
        row: dict[str, Any] = {"name": name, "reduction": table, "multiple": table["f_max"] / F}
        started = time.process_time()
        try:
            model = bench.model(table)
            offline, runs = time.process_time() - started, {load: bench.run(load, model) for load in exact}
        except CreakError as error:
            yield row | {"failed": str(error)}
            continue
        frequency, mac = worst(bench, table, model)
        size = {"retained": model.retained, "modes": model.modes, "unknowns": model.system.n}
        cost = {"offline_s": offline, "online_s": sum(r.cost.cpu_s for r in runs.values()) / len(runs)}
        pairs = [(exact[load], runs[load]) for load in exact]
        yield row | size | {"frequency_error": frequency, "lowest_mac": mac} | figures(pairs, bench.tolerance) | cost


def unreduced(bench: Bench, exact: Run) -> dict[str, Any]:
    """The reference's events of the first seconds against the unreduced model's."""
    full = bench.unreduced(LOAD, UNREDUCED_S)
    cost = {"end": UNREDUCED_S, "cpu_s": full.cost.cpu_s, "load": LOAD}
    early = replace(exact, events=[e for e in exact.events if e.t_start < UNREDUCED_S - bench.tolerance])
    known = replace(full, events=[e for e in full.events if e.t_start < UNREDUCED_S - bench.tolerance])
    return cost | rattle(known) | figures([(known, early)], bench.tolerance)


def physics(bench: Bench) -> Iterator[dict[str, Any]]:
    """What damping, load and phases do to the answer."""
    table = {"f_max": F * CHOSEN}
    base = bench.run(LOAD, bench.model(table))
    yield {"kind": "base", "factor": 1.0, **rattle(base)}
    for by in AMPLITUDES:
        run = bench.run(LOAD, bench.model(table), amplitude=by * LOADS[LOAD])
        yield {"kind": "load", "factor": by, **rattle(run), **figures([(base, run)], bench.tolerance)}
    for seed in SEEDS:
        yield {"kind": "seed", "factor": float(seed), **rattle(bench.run(LOAD, bench.model(table), seed=seed))}
    for by in DAMPINGS:
        other = bench.damped(by)
        run = other.run(LOAD, other.model(table))
        yield {"kind": "damping", "factor": by, **rattle(run), **figures([(base, run)], bench.tolerance)}


if __name__ == "__main__":
    main()
