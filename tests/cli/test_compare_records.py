"""`creak compare RESULTS TEST`: table, page, figures, and one message where nothing can be compared."""

from __future__ import annotations

import json

import pytest

from creak.formats.measured.histories import read_histories
from helpers_decks import STUDY, write_strips

LATE = 0.73123
"""s by which the clock of the test is ahead."""


def test_the_command_prints_and_writes_a_page(creak, tmp_path):
    results, test = tmp_path / "out", tmp_path / "test.csv"
    assert creak("run", write_strips(tmp_path, study=STUDY), "--out", results, "-q").status == 0
    run = read_histories(results / "results.h5")
    rows = zip(run.time + LATE, run.normal_force.sum(axis=1), run.gap.min(axis=1), strict=True)
    test.write_text("\n".join(["time,tip force [N],tip gap [mm]", *(",".join(f"{x:.9g}" for x in r) for r in rows)]))
    said = creak("compare", results, test, "--out", tmp_path / "page.html", "--json")
    assert said.status == 0, said.words
    data = json.loads(said.out)
    assert data["shift"] == pytest.approx(-LATE, abs=5e-6)
    assert [c["name"] for c in data["channels"]] == ["tip force", "tip gap"]
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "tip force, N" in text
    assert "best" in text
    (tmp_path / "test.csv").write_text("time,odd\n0,1\n1,2\n")
    said = creak("compare", results, test, "--out", tmp_path / "other.html")
    assert said.status == 2
    assert sum(line.startswith("creak: ") for line in said.err.splitlines()) == 1
    assert not (tmp_path / "other.html").exists()
