"""Do the bars and verdicts hold? Random models against an independent integration of their full matrices.

    python -m benchmarks.coverage [--n 200] [--first 0] [--only SEED] [--few] [--out build/coverage]

Each seed is a deck of two parts and a study that says nothing numerical. A row for each goes to random.jsonl as it is
found, and a seed that is there is not run again; random.json has the counts. `--only` runs one seed anew, keeps its
deck and study, and prints its row. The models are small and get all modes; with `--few` they are reduced as large ones
are. Closed forms: `python -m benchmarks.coverage.closed`; the door against its unreduced
model: `python -m benchmarks.coverage.door`.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.coverage.study import row
from benchmarks.coverage.table import is_wrong, lines, summary
from benchmarks.stamp import stamp
from creak.studies.converge import auto_band


def main() -> None:
    """Run what is not in the file yet, and print the counts."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.coverage")
    options.add_argument("--n", type=int, default=200, help="models")
    options.add_argument("--first", type=int, default=0, help="first seed")
    options.add_argument("--only", type=int, help="one seed alone, run anew")
    options.add_argument("--few", action="store_true", help="the models get as few modes as large ones do")
    options.add_argument("--out", type=Path, default=Path("build/coverage"))
    given = options.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    if given.few:
        auto_band.SMALL = auto_band.WORTH = 0.0
    if given.only is not None:
        print(json.dumps(row(given.only, given.out / f"seed_{given.only}"), indent=1))
        return
    log = given.out / "random.jsonl"
    rows = known(log)
    for seed in range(given.first, given.first + given.n):
        if seed not in rows:
            with tempfile.TemporaryDirectory() as folder:
                rows[seed] = row(seed, Path(folder))
            with log.open("a", encoding="utf-8") as file:
                file.write(json.dumps(rows[seed]) + "\n")
            print(line(rows[seed]), flush=True)
    chosen = [rows[s] for s in sorted(rows) if given.first <= s < given.first + given.n]
    found = summary(chosen)
    (given.out / "random.json").write_text(json.dumps({"made": stamp(), **found}, indent=1), encoding="utf-8")
    print("\n".join(lines(found)))


def known(log: Path) -> dict[int, dict[str, Any]]:
    """Rows of an earlier call; a last line that was cut short is made again."""
    rows = {}
    for text in log.read_text(encoding="utf-8").splitlines() if log.exists() else []:
        try:
            r = json.loads(text)
        except ValueError:
            continue
        rows[r["seed"]] = r
    return rows


def line(r: dict[str, Any]) -> str:
    """One model in a line."""
    if "failed" in r:
        return f"{r['seed']:>4} failed: {r['failed']}"
    own, found = r["own"], r["reduced"]
    mark = "WRONG" if r["verdict"] == "settled" and own["settled"] and is_wrong(r) else ""
    off = found["impulse"] / own["impulse"] - 1.0 if own["impulse"] else 0.0
    return (
        f"{r['seed']:>4} {r['verdict']!s:<10} {mark:<5} events {own['events']:>3} -> {found['events']:>3}, "
        f"impulse {off:+8.2%} (own {own['error']:.1e}), CPU {own['cpu_s']:.1f} + {r['cpu_s']:.1f} s  {r['words']}"
    )


if __name__ == "__main__":
    main()
