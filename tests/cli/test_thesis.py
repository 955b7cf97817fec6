"""`creak thesis`: the page is written with what there is; progress lines; exit status."""

import pytest
from typer.testing import CliRunner

import creak_thesis.doors
import creak_thesis.record
import creak_thesis.run
from creak.cli.main import app
from creak.cli.thesis import ThesisProgress
from creak.errors import InputError, NumericalError
from creak_thesis.run import ThesisResult
from helpers_thesis import failed, fake_outcomes


@pytest.fixture
def measured(monkeypatch):
    """Runs nothing: outcomes are made up, the record is short, the doors cannot be built."""
    outcomes = fake_outcomes()

    def run_thesis(mesh_size, out, progress, cases=None):
        progress("case D8", 0, 2)
        progress("D8 run", 1, 10)
        progress("case D40", 1, 2)
        progress("cases", 2, 2)
        return ThesisResult(mesh_size, outcomes, out)

    def no_door(mesh_size, folder, channels):
        raise InputError("no door today")

    short = creak_thesis.record.study_record
    monkeypatch.setattr(creak_thesis.run, "run_thesis", run_thesis)
    monkeypatch.setattr(creak_thesis.doors, "open_doors", no_door)
    monkeypatch.setattr(creak_thesis.record, "study_record", lambda: short(1, duration=4.0, rate=4800.0))
    return outcomes


def run(*args):
    return CliRunner().invoke(app, ["thesis", *map(str, args)])


def test_page_is_written_and_progress_comes_in_lines(measured, tmp_path):
    result = run("--out", tmp_path / "th")
    assert result.exit_code == 0, result.output
    assert "0/2 case D8" in result.output
    assert "D8 run" not in result.output
    assert "no door today" in result.output
    text = (tmp_path / "th" / "thesis.html").read_text(encoding="utf-8")
    assert "Figure 4.16" in text
    assert "the door was not built" in text


def test_failed_case_leaves_the_page_and_a_failure(measured, tmp_path):
    measured["P40"] = failed(measured["P40"], "nothing left to retain")
    result = run("--out", tmp_path, "--quiet")
    assert isinstance(result.exception, NumericalError)
    assert "P40: nothing left to retain" in str(result.exception)
    assert "nothing left to retain" in (tmp_path / "thesis.html").read_text(encoding="utf-8")
    assert result.output == ""


def test_mesh_size_out_of_range_is_refused_before_anything_is_written(tmp_path):
    result = run("--mesh-size", "100", "--out", tmp_path / "th")
    assert isinstance(result.exception, InputError)
    assert not (tmp_path / "th").exists()


def test_stop_tells_how_to_go_on(measured, monkeypatch, tmp_path):
    def stopped(mesh_size, out, progress, cases=None):
        progress("case D8", 3, 40)
        raise KeyboardInterrupt

    monkeypatch.setattr(creak_thesis.run, "run_thesis", stopped)
    result = run("--out", tmp_path, "--quiet")
    assert "3 of 40 cases finished; the same command goes on" in str(result.exception)


def test_time_left_is_the_mean_of_the_cases_so_far(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("creak.cli.thesis.time.monotonic", lambda: now[0])
    progress = ThesisProgress(True)
    now[0] = 130.0
    assert progress._left(0, 10) == ""
    assert progress._left(3, 10) == "about 70 s left"
    now[0] = 400.0
    assert progress._left(3, 10) == "about 12 min left"
    assert progress._left(10, 10) == ""
