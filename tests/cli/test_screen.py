"""`creak screen`: lines ranked from modes alone."""

from __future__ import annotations

import csv
import json

import pytest

from helpers_cli import caller
from helpers_decks import STUDY, two_strips, write_strips

LINES = """
[limit]
in_plane = "0.01 mm"
[eline.tips]
main = "TIP_LOWER"
secondary = "TIP_UPPER"
[eline.roots]
main = "OVER"
secondary = "ROOT_UPPER"
"""


@pytest.fixture
def say(monkeypatch, capsys):
    return caller(monkeypatch, capsys)


def test_lines_are_ranked_by_margin(say, tmp_path, monkeypatch):
    study = write_strips(tmp_path, two_strips(3.0), STUDY.replace("amplitude = 0.05", "amplitude = 0.06") + LINES)
    said = say("screen", study, "--json", "--csv", tmp_path / "made" / "points.csv").done()
    found = json.loads(said.out)
    lines = found["lines"]
    assert [line["name"] for line in lines] == sorted(
        (line["name"] for line in lines), key=lambda n: next(x["linear"]["margin"] for x in lines if x["name"] == n)
    )
    assert {line["name"]: line["points"] for line in lines} == {"tip": 39, "tips": 3, "roots": 3}
    for line in lines:
        f = line["linear"]
        assert f["margin"] == pytest.approx(f["gap"] - line["tolerance"] - f["closing"], abs=1e-12)
        assert f["margin"] <= f["margin_percentile"]
        assert f["squeak"] == "no"  # the strips move across the gap alone
        assert line["contact"] is line["outcome"] is None
    assert found["false_alarms"] is None
    rows = list(csv.DictReader((tmp_path / "made" / "points.csv").read_text().splitlines()))
    assert len(rows) == 45
    tightest = min(rows, key=lambda row: float(row["linear_margin_mm"]))
    assert tightest["line"] == lines[0]["name"]
    assert float(tightest["linear_margin_mm"]) == pytest.approx(lines[0]["linear"]["margin"], rel=1e-8)
    monkeypatch.setenv("COLUMNS", "140")
    table = say("screen", study).done()
    assert "can touch" in table.words
    assert "margin = gap - tolerance" in table.words


def test_many_lines(say, tmp_path):
    """Each node of the upper strip a line of its own, many times over: the modes are found once."""
    more = "".join(
        f'[eline.l{k}]\nmain = "LOWER"\nsecondary = "UPPER"\npoints = [[{k % 120}, {k % 20}, 0], [60, 10, 0]]\n'
        for k in range(60)
    )
    study = write_strips(tmp_path, two_strips(3.0), STUDY + "\n" + more)
    said = say("screen", study, "--json").done()
    assert len(json.loads(said.out)["lines"]) == 61


def test_wrong_input_is_one_message(say, tmp_path):
    deck = write_strips(tmp_path).with_name("strips.inp")
    said = say("screen", deck)
    said.refuses("is a deck")
    study = write_strips(tmp_path, study=STUDY + "\n[limit]\ntolerance = 0.3\n")
    said = say("screen", study)
    said.refuses("without its unit")
    assert not (tmp_path / "points.csv").exists()


def test_stops_that_are_on_no_line_are_told(say, tmp_path):
    stop = '[[connector]]\ntype = "play"\nnodes = ["TIP_LOWER", "TIP_UPPER"]\ndof = "z"\nlower = -0.1\nstiffness = 10\n'
    assert "on no line" not in say("screen", write_strips(tmp_path, None, STUDY)).done().words
    said = say("screen", write_strips(tmp_path, None, STUDY + stop)).done()
    assert "1 [[connector]] of the study is on no line, so it is not ranked here" in said.words
