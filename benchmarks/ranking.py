"""What is heard of the door, how far it has settled, and what linear screening calls: `python -m benchmarks.ranking`.

* places of the door at 20 mm under loads A2 to A4, and with play in its hooks: ranked by force, impulse and N5;
* N5 of each place of load A3, and with play, with twice the f_max, and with contact resolved four times as finely;
* false alarms and misses of the linear E-line at 40 mm, loads A2 to A4 and eight seeds of the phases;
* the changes that are tried for load A4 at 40 mm: as predicted on the reduced model, and by full runs.

`--out docs/ranking.json` keeps the record, part by part; `--tables docs/ranking.json` prints what docs/sound.md and
docs/elines.md have of it.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import creak
from benchmarks.door import door_study
from benchmarks.stamp import stamp
from creak.studies.cause.decompose import find_causes
from creak.studies.cause.effects import change_dict, checked_by_run, try_changes
from creak.studies.findings.sound import heard_places
from creak.studies.sound.heard import Sound
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
    return creak.change_study(door_study(folder), {"reference.run": False})


def places(study: creak.Study) -> dict[str, Any]:
    """What a run says of each place, and the band."""
    found = creak.run(study, converge=False, record=False).summary
    sound = found["sound"]
    return {
        "places": [_computed({key: p[key] for key in PLACE}, p) for p in found["runs"]["reduced"]["places"]],
        "band": sound.get("band"),
        "missing": sound.get("missing"),
    }


def _computed(figures: dict[str, Any], place: Mapping[str, Any]) -> dict[str, Any]:
    """With the N5 of what is computed alone: the statistical part says nothing of how far modes and steps settle it."""
    return figures if place["n5_computed"] is None else {**figures, "n5": place["n5_computed"]}


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
    result, places = run.found, heard_places(run.found.scope, run.main, run.sound)
    setup = result.setup
    causes = find_causes(setup.marching, setup.reduction, run.main, places)
    ear = replace(run.sound.ear, statistics=None) if isinstance(run.sound, Sound) else None
    assert not isinstance(causes, str), causes
    now, tried = try_changes(result, ear, places[0], causes[0])
    return [change_dict(c, now, e, checked_by_run(setup, ear, lambda *_: None, places[0], c)) for c, e in tried]


def ranked(folder: Path, mesh_size: float) -> dict[str, Any]:
    """Places under each load, and with play in the hooks."""
    found = {load: places(door(folder / load, mesh_size, load)) for load in LOADS}
    return found | {WITH_PLAY: places(door(folder / "play", mesh_size, "A3", PLAY))}


def settling(folder: Path, mesh_size: float) -> dict[str, Any]:
    """Places of load A3, hooks without and with play: as the study is, with more modes, with contact resolved finer."""
    doors = {"A3": door(folder / "A3", mesh_size, "A3"), WITH_PLAY: door(folder / "play", mesh_size, "A3", PLAY)}
    return {
        load: {name: places(creak.change_study(base, what) if what else base) for name, what in SETTLING.items()}
        for load, base in doors.items()
    }


def called(folder: Path, mesh_size: float) -> list[dict[str, Any]]:
    """Linear against contact under each load and seed."""
    studies = {load: door(folder / load, mesh_size, load) for load in LOADS}
    return [alarms(study, load, seed) for load, study in studies.items() for seed in SEEDS]


def changed(folder: Path, mesh_size: float) -> list[dict[str, Any]]:
    """Changes under load A4."""
    return changes(door(folder / "A4", mesh_size, "A4"))


PARTS: Mapping[str, Callable[[Path, float], Any]] = {
    "ranked": ranked,
    "settling": settling,
    "alarms": called,
    "changes": changed,
}
MESH_SIZES = {"ranked": 20.0, "settling": 20.0, "alarms": 40.0, "changes": 40.0}
"""mm"""


def order(found: Sequence[Mapping[str, Any]], key: str) -> list[int]:
    """Rank of each place by a figure, 1 for the largest."""
    return [1 + sum(other[key] > p[key] for other in found) for p in found]


def tables(record: Mapping[str, Any]) -> str:
    """Markdown of docs/sound.md, and of docs/elines.md (alarms), of the parts that there are."""
    return "\n\n".join("\n".join(TABLES[part](record[part]["found"])) for part in PARTS if part in record) + "\n"


def _ranked_table(found: Mapping[str, Any]) -> list[str]:
    lines = ["| load | place | events | force, N | impulse, N s | N5, sone | by force, impulse, N5 |", "|" + "---|" * 7]
    for load, run in found.items():
        ranks = zip(*(order(run["places"], key) for key in BY), strict=True)
        for p, rank in zip(run["places"], ranks, strict=True):
            figures = f"{p['events']} | {p['force']:.3g} | {p['impulse']:.3g} | {p['n5']:.3g}"
            lines.append(f"| {load} | {p['name']} | {figures} | {', '.join(map(str, rank))} |")
    return lines


def _settling_table(found: Mapping[str, Any]) -> list[str]:
    lines = [f"| load | place | N5, sone | {' | '.join([*SETTLING][1:])} |", "|" + "---|" * 5]
    for load, variants in found.items():
        # Without their number in the ranking, which may change.
        runs = [{p["name"].rpartition(" ")[0]: p["n5"] for p in run["places"]} for run in variants.values()]
        for place, n5 in runs[0].items():
            moved = [f"{100 * (run[place] / n5 - 1):+.2g} %" if place in run else "gone" for run in runs[1:]]
            lines.append(f"| {load} | {place} | {n5:.3f} | {' | '.join(moved)} |")
    return lines


def _alarms_table(found: Sequence[Mapping[str, Any]]) -> list[str]:
    lines = ["| load | runs | line called and touched | points called | touched | false alarms | misses |"]
    lines.append("|" + "---|" * 7)
    for load in LOADS:
        own = [a for a in found if a["load"] == load]
        both = sum(a["outcome"] == "both" for a in own)
        points = " | ".join(str(sum(a[key] for a in own)) for key in ("linear", "contact", "false_alarms", "misses"))
        lines.append(f"| {load} | {len(own)} | {both} | {points} |")
    return lines


def _changes_table(found: Sequence[Mapping[str, Any]]) -> list[str]:
    lines = ["| change | N5 of the place | predicted | full run |", "|" + "---|" * 4]
    for c in found:
        checked = c["checked"] if isinstance(c["checked"], Mapping) else {"n5": None}
        lines.append(f"| {c['words']} | {' | '.join(_known(e['n5']) for e in (c['now'], c['predicted'], checked))} |")
    return lines


TABLES: Mapping[str, Callable[[Any], list[str]]] = {
    "ranked": _ranked_table,
    "settling": _settling_table,
    "alarms": _alarms_table,
    "changes": _changes_table,
}


def _known(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def main() -> None:
    """Measure and write, or print tables of a record."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ranking")
    parser.add_argument("--part", choices=PARTS, action="append", help="one of them, again for more; else all")
    parser.add_argument("--out", type=Path, help="JSON file for the figures; other parts in it stay")
    parser.add_argument("--tables", type=Path, help="print the tables of such a file")
    given = parser.parse_args()
    if given.tables is not None:
        sys.stdout.write(tables(json.loads(given.tables.read_text(encoding="utf-8"))))
        return
    record = json.loads(given.out.read_text(encoding="utf-8")) if given.out is not None and given.out.exists() else {}
    for part in given.part or PARTS:
        made = stamp()
        with tempfile.TemporaryDirectory() as folder:
            found = PARTS[part](Path(folder), MESH_SIZES[part])
        record[part] = {"made": made, "mesh_size": MESH_SIZES[part], "found": found}
        if given.out is not None:
            given.out.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    sys.stdout.write(tables(record))


if __name__ == "__main__":
    main()
