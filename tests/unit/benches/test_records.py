"""Records that a benchmark writes and the package shows: each says where it comes from."""

import json
import re
import subprocess
from pathlib import Path

import pytest
from benchmarks import evidence, ranking, unreduced
from benchmarks.stamp import command, commit, stamp

from creak.studies.advise.evidence import record
from creak_thesis.report.facts import million

FIELDS = {"creak", "commit", "date", "machine", "command"}


def test_a_stamp_has_no_empty_field():
    made = stamp()
    assert made.keys() == FIELDS
    assert all(made.values())
    assert re.fullmatch(r"[0-9a-f]{7,}\+?|unknown", made["commit"])
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", made["date"])


@pytest.mark.parametrize(("changed", "mark"), [("src/creak/version.py", "+"), ("src/creak/studies/evidence.json", "")])
def test_changed_sources_mark_a_record(changed, mark, monkeypatch):
    """Paths that git is asked for are those of the whole repository; the record itself is no source."""
    asked = []

    def run(words, cwd, **_):
        asked.append([Path(cwd) / word for word in words[words.index("--") + 1 :]] if "--" in words else [])
        return subprocess.CompletedProcess(words, 0, stdout=f" M {changed}\n" if asked[-1] else "abcdef1\n")

    monkeypatch.setattr(subprocess, "run", run)
    assert commit() == f"abcdef1{mark}"
    assert all(path.is_dir() for path in asked[-1])


def test_a_command_is_given_without_paths_of_the_interpreter():
    assert re.match(r"python (-m )?\S", command())


def test_the_record_of_million_dofs_has_what_the_benchmark_writes():
    """Field by field; a note may say what it could not know."""
    found = million()
    assert found is not None
    assert found.keys() == unreduced.record(stamp(), "a door", []).keys()
    assert found["made"].keys() - {"note"} == FIELDS
    assert all(found["made"].values())
    assert re.search(r"--out src/\S+/million\.json", found["made"]["command"])
    for run in found["runs"]:
        assert run["integrator"]


def test_tables_of_the_docs_are_those_of_the_ranking_record():
    docs = Path(__file__).parents[3] / "docs"
    record = json.loads((docs / "ranking.json").read_text(encoding="utf-8"))
    assert record.keys() == ranking.PARTS.keys()
    pages = {part: (docs / ("elines.md" if part == "alarms" else "sound.md")).read_text("utf-8") for part in record}
    for part, of in record.items():
        assert of["made"].keys() == FIELDS
        assert "\n".join(ranking.TABLES[part](of["found"])) in pages[part]


def test_the_evidence_has_the_cases_that_the_benchmark_runs():
    """Nothing that a page names would be missing from a record made today."""
    for part, names in (("door", evidence.CASES), ("fine", evidence.FINE)):
        assert {row["name"] for row in record()[part]["reductions"]} == {*names}
