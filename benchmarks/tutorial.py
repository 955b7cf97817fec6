"""What the commands of docs/tutorial.md print and find: `python -m benchmarks.tutorial` runs them, some two minutes.

Tests hold the page to this record, and the record to the files that `creak example` writes today. Times are those of a
machine, and are not compared.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1] / "docs"
RECORD = DOCS / "tutorial.json"
PAGE = (DOCS / "tutorial.md").read_text(encoding="utf-8")
PRINTED = ("modes", "run")
"""Commands of which the record keeps what they print."""


def commands() -> list[list[str]]:
    """The commands of sections 2 to 4, in order, without the program's name."""
    part = PAGE[PAGE.index("## 2.") : PAGE.index("## 5.")]
    return [shlex.split(line)[1:] for line in re.findall(r"^ {4}(creak .*)$", part, flags=re.MULTILINE)]


def written(folder: Path) -> dict[str, Any]:
    """What tells whether the example is the same: its study, line by line, and how long its deck is."""
    deck, study = ((folder / f"door.{kind}").read_text(encoding="utf-8").splitlines() for kind in ("inp", "toml"))
    return {"door.inp": len(deck), "door.toml": study}


def followed(folder: Path) -> dict[str, Any]:
    """The record: all commands are run in a folder."""
    said, files = {}, {}
    for words in commands():
        more = ["--verbose"] if words[0] == "run" else []  # the page shows tables as well
        print("creak", *words, flush=True)
        ran = subprocess.run(
            [sys.executable, "-m", "creak.cli.main", *words, *more],
            cwd=folder,
            env={**os.environ, "COLUMNS": "160"},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=True,
        )
        said[words[0]] = ran.stdout.splitlines()
        if words[0] == "example":
            files = written(folder / "door")
    summary = json.loads((folder / "door" / "results" / "summary.json").read_text(encoding="utf-8"))
    run, verification = summary["runs"]["reduced"], summary["verification"]
    return {
        "files": files,
        "printed": {name: said[name] for name in PRINTED},
        "dof": summary["model"]["dof"],
        "channels": run["channels"],
        "verdict": run["verdict"],
        "t_start": [e["t_start"] for e in run["events"]],
        "window": verification["window"],
        "frequencies": verification["frequencies"],
        "spots": len(verification["spots"]),
    }


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        record = followed(Path(folder))
    RECORD.write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"wrote {RECORD}")


if __name__ == "__main__":
    main()
