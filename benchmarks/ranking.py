"""What is heard of the door, how far it has settled, and what linear screening calls: `python -m benchmarks.ranking`.

* places of the door at 20 mm under loads A2 to A4, and with play in its hooks: ranked by force, impulse and N5;
* N5 of each place of load A3 with twice the f_max, and with contact resolved four times as finely;
* false alarms and misses of the linear E-line at 40 mm, loads A2 to A4 and eight seeds of the phases;
* the changes that are tried for load A4 at 40 mm: as predicted on the reduced model, and by full runs.

`--out docs/ranking.json` keeps the record; `--tables docs/ranking.json` prints the tables of docs/sound.md and
docs/elines.md.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import creak
from benchmarks.stamp import stamp
from creak.studies.cause.decompose import find_causes
from creak.studies.cause.effects import checked_by_run, ear_of, try_changes
from creak.studies.cause.told import change_dict
from creak.studies.results.sound import heard_places
from creak_thesis.door import write_door

LOADS, SEEDS, PLAY = ("A2", "A3", "A4"), range(1, 9), 0.2
"""Play of the hooks, mm to either side."""
WITH_PLAY = "A3, hooks with play"
SETTLING: Mapping[str, Mapping[str, Any]] = {
    "as it is": {},
    "f_max doubled": {"reduction.f_max": 3000.0},
    "contact four times as fine": {"time.accuracy": "fine"},
}
PLACE = ("name", "events", "force", "impulse", "n5", "n_max", "level")
BY = ("force", "impulse", "n5")


def door(folder: Path, mesh_size: float, load: str, play: float | None = None) -> creak.Study:
    """The study of a door, its unreduced run left out."""
    write_door(mesh_size, folder, 1, load, play)
    return creak.change_study(creak.read_study(folder / "door.toml"), {"reference.run": False})


def places(study: creak.Study) -> dict[str, Any]:
    """What a run says of each place, and the band."""
    found = creak.run(study, converge=False, record=False).summary
    sound = found["sound"]
    return {
        "places": [{key: p[key] for key in PLACE} for p in found["runs"]["reduced"]["places"]],
        "band": sound.get("band"),
        "missing": sound.get("missing"),
    }


def alarms(study: creak.Study, load: str, seed: int) -> dict[str, Any]:
    """What the linear E-line says against what the one with contact says."""
    changed = creak.change_study(study, {"excitation.hinge.signal.seed": seed})
    found = creak.run(changed, converge=False, record=False).summary["elines"]
    line = found["lines"][0]
    return {
        "load": load,
        "seed": seed,
        "outcome": line["outcome"],
        "points": line["points"],
        "linear": line["linear"]["points_at_risk"],
        "contact": line["contact"]["points_at_risk"],
        "false_alarms": found["points_false_alarms"],
        "misses": found["points_misses"],
    }


def changes(study: creak.Study) -> list[dict[str, Any]]:
    """Every change that is tried of the first place: now, predicted, checked."""
    run = creak.run(study, converge=False, record=False)
    result, places = run.found, heard_places(run.found, run.main, run.sound)
    causes, ear = find_causes(result, places), ear_of(result, run.sound)
    assert not isinstance(causes, str), causes
    now, tried = try_changes(result, places[0], causes[0], ear)
    return [change_dict(c, now, e, checked_by_run(result, places[0], c, ear, lambda *_: None)) for c, e in tried]


def measured(folder: Path, mesh_size: float, coarse: float, seeds: Sequence[int]) -> dict[str, Any]:
    """All of it."""
    tell = sys.stderr.write
    record: dict[str, Any] = {
        "made": stamp(),
        "mesh_size": mesh_size,
        "coarse": coarse,
        "play": PLAY,
        "ranked": {},
        "settling": {},
    }
    for load in LOADS:
        record["ranked"][load] = places(door(folder / load, mesh_size, load))
        tell(f"{load}: {record['ranked'][load]}\n")
    record["ranked"][WITH_PLAY] = places(door(folder / "play", mesh_size, "A3", PLAY))
    tell(f"play: {record['ranked'][WITH_PLAY]}\n")
    for model, play in (("A3", None), (WITH_PLAY, PLAY)):
        base = door(folder / model, mesh_size, "A3", play)
        record["settling"][model] = {
            name: places(creak.change_study(base, what)) if what else record["ranked"][model]
            for name, what in SETTLING.items()
        }
        tell(f"settling: {record['settling'][model]}\n")
    record["alarms"] = []
    for load in LOADS:
        study = door(folder / f"{load}c", coarse, load)
        record["alarms"] += [alarms(study, load, seed) for seed in seeds]
        tell(f"alarms: {record['alarms'][-len(seeds) :]}\n")
    record["changes"] = changes(door(folder / "A4c", coarse, "A4"))
    return record


def order(found: Sequence[Mapping[str, Any]], key: str) -> list[int]:
    """Rank of each place by a figure, 1 for the largest."""
    return [1 + sum(other[key] > p[key] for other in found) for p in found]


def tables(record: Mapping[str, Any]) -> str:
    """Markdown of docs/sound.md (ranking, settling, changes) and of docs/elines.md (alarms)."""
    lines = [f"<!-- {record['made']['command']}, {record['made']['commit']}, {record['made']['date']} -->", ""]
    lines += [
        "| load | place | events | force, N | impulse, N s | N5, sone | by force, impulse, N5 |",
        "|" + "---|" * 7,
    ]
    every = [(load, p) for load, found in record["ranked"].items() for p in found["places"]]
    ranks = list(zip(*(order([p for _, p in every], key) for key in BY), strict=True))
    for (load, p), rank in zip(every, ranks, strict=True):
        figures = f"{p['events']} | {p['force']:.3g} | {p['impulse']:.3g} | {p['n5']:.3g}"
        lines.append(f"| {load} | {p['name']} | {figures} | {', '.join(map(str, rank))} |")
    lines += ["", f"| run | place | N5, sone | {' | '.join([*SETTLING][1:])} |", "|" + "---|" * 5]
    for model, runs in record["settling"].items():
        for k, place in enumerate(sorted(p["name"] for p in runs["as it is"]["places"])):
            values = [next((p["n5"] for p in r["places"] if p["name"] == place), None) for r in runs.values()]
            moved = [f"{100 * (v / values[0] - 1):+.2g} %" if v else "gone" for v in values[1:]]
            lines.append(f"| {'' if k else model} | {place} | {values[0]:.3g} | {' | '.join(moved)} |")
    lines += ["", "| change | place, now | predicted | full run | all places, now | predicted | full run |"]
    lines.append("|" + "---|" * 7)
    for c in record["changes"]:
        checked = c["checked"] if isinstance(c["checked"], Mapping) else {"n5": None, "total_n5": None}
        figures = " | ".join(_known(e[key]) for key in ("n5", "total_n5") for e in (c["now"], c["predicted"], checked))
        lines.append(f"| {c['words']} | {figures} |")
    lines += [
        "",
        "| load | runs | linear and contact | false alarms | misses | points called, touched | wrongly | missed |",
    ]
    lines.append("|" + "---|" * 8)
    for load in LOADS:
        own = [a for a in record["alarms"] if a["load"] == load]
        word = [sum(a["outcome"] == name for a in own) for name in ("both", "false alarm", "miss")]
        point = [sum(a[key] for a in own) for key in ("linear", "contact", "false_alarms", "misses")]
        both = " | ".join(map(str, word))
        lines.append(f"| {load} | {len(own)} | {both} | {point[0]}, {point[1]} | {point[2]} | {point[3]} |")
    return "\n".join(lines) + "\n"


def _known(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def main() -> None:
    """Measure and write, or print tables of a record."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ranking")
    parser.add_argument("--mesh-size", type=float, default=20.0, help="mm")
    parser.add_argument("--coarse", type=float, default=40.0, help="mm, of the many runs")
    parser.add_argument("--seeds", type=int, default=len(SEEDS))
    parser.add_argument("--out", type=Path, help="JSON file for the figures")
    parser.add_argument("--tables", type=Path, help="print the tables of such a file")
    given = parser.parse_args()
    if given.tables is None:
        with tempfile.TemporaryDirectory() as folder:
            record = measured(Path(folder), given.mesh_size, given.coarse, range(1, given.seeds + 1))
        if given.out is not None:
            given.out.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    else:
        record = json.loads(given.tables.read_text(encoding="utf-8"))
    sys.stdout.write(tables(record))


if __name__ == "__main__":
    main()
