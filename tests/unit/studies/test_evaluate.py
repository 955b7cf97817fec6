"""What is told of a run costs no run: each of it may fail, and is then left out with a warning."""

from __future__ import annotations

import json
import os
import re

import pytest

import creak
from creak.errors import NumericalError
from helpers_decks import STUDY, write_strips

TOLD = {
    "creak.studies.sound.heard.hear": "sound",
    "creak.studies.cause.effects.causes_of": "causes",
    "creak.studies.converge.repeats.converge": "repeated runs",
    "creak.studies.run.job.compare_lines": "E-lines",
    "creak.studies.run.job.compare_modes": "modes of both models",
    "creak.studies.run.job.compare_spectra": "spectra of both runs",
    "creak.studies.models.health.checked": "health of the superelements",
}
SHORT = STUDY.replace("periods = 2", "end = 0.02") + "[reference]\nrun = false\n[precheck]\nmargin = 0.5\n"


def failing(problem: BaseException):
    def fail(*_, **__):
        raise problem

    return fail


@pytest.fixture
def setup(tmp_path):
    return creak.set_up(write_strips(tmp_path, study=SHORT))


def test_all_that_is_told_may_fail_at_once(setup, tmp_path, monkeypatch):
    for k, place in enumerate(TOLD):
        problem = [ValueError("zip() is shorter"), MemoryError(), NumericalError("singular"), KeyError("x")][k % 4]
        monkeypatch.setattr(place, failing(problem))
    result = creak.run_setup(setup, converge=True)
    warned = [text for text in result.summary["warnings"] if "left out" in text]
    assert [text.partition(":")[0] for text in warned] == [
        "health of the superelements",
        "E-lines",
        "modes of both models",
        "spectra of both runs",
        "sound",
        "repeated runs",
        "causes",
    ]
    assert sum("report it" in text for text in warned) == 3
    written = result.save(tmp_path / "out")
    assert [path.name for path in written] == ["summary.json", "results.h5"]
    assert json.loads(written[0].read_text())["runs"]["reduced"]["verdict"] == "unsettled"


@pytest.mark.parametrize("place", ["creak.studies.sound.heard.hear", "creak.studies.cause.effects.causes_of"])
def test_ctrl_c_after_the_run_leaves_the_run(setup, monkeypatch, place):
    monkeypatch.setattr(place, failing(KeyboardInterrupt()))
    result = creak.run_setup(setup, converge=False, changes="predicted")
    (warned,) = [text for text in result.summary["warnings"] if "Ctrl-C" in text]
    assert warned.startswith(TOLD[place])
    assert result.runs["reduced"].history.time[-1] == pytest.approx(0.02)


def test_nothing_more_is_tried_after_ctrl_c(setup, monkeypatch):
    """One sentence tells of all that was left out; each would have taken its time, or another Ctrl-C."""
    monkeypatch.setattr("creak.studies.sound.heard.hear", failing(KeyboardInterrupt()))
    for place in ("creak.studies.converge.repeats.converge", "creak.studies.cause.effects.causes_of"):
        monkeypatch.setattr(place, failing(AssertionError("it was tried")))
    result = creak.run_setup(setup, converge=True, changes="predicted")
    (warned,) = [text for text in result.summary["warnings"] if "Ctrl-C" in text]
    told = re.match(r"sound, .*repeated runs and causes: left out, stopped by Ctrl-C\. The run itself is comp", warned)
    assert told, warned


def test_ctrl_c_in_the_run_keeps_its_beginning_and_ends(setup, tmp_path, monkeypatch):
    for place in ("creak.studies.run.job.compare_modes", "creak.studies.models.health.checked"):
        monkeypatch.setattr(place, failing(AssertionError("it was tried")))

    def press(stage: str, done: int, _: int) -> None:
        if stage == "reduced run" and done:
            raise KeyboardInterrupt

    result = creak.run_setup(setup, press, converge=True)
    (warned,) = [text for text in result.summary["warnings"] if "Ctrl-C" in text]
    assert warned.startswith("the rest of the run, health of the superelements, modes of both models")
    assert "complete" not in warned
    assert "reduced run: stopped at" in result.stopped
    assert [path.name for path in result.save(tmp_path / "out")] == ["summary.json", "results.h5"]


def test_a_run_is_kept_before_it_is_repeated(setup, tmp_path, monkeypatch):
    seen = []
    keep = tmp_path / "out"
    monkeypatch.setattr(
        "creak.studies.converge.repeats.converge",
        lambda *_: seen.append(sorted(os.listdir(keep)) if keep.exists() else None),
    )
    creak.run_setup(setup, converge=True, first=lambda so_far: so_far.save(keep))
    assert seen.pop() is None, "a short run is sooner run again than written twice"
    monkeypatch.setattr("creak.studies.evaluate.LONG", 0.0)
    result = creak.run_setup(setup, converge=True, first=lambda so_far: so_far.save(keep))
    assert seen == [["results.h5", "summary.json"]]
    assert creak.open_result(keep).summary["runs"]["reduced"]["events"] == result.summary["runs"]["reduced"]["events"]


def test_a_page_that_cannot_be_made_costs_no_results(setup, tmp_path, monkeypatch):
    monkeypatch.setattr("creak.report.drawn.drawn_of", failing(ZeroDivisionError("no size")))
    result = creak.run_setup(setup, converge=False)
    with pytest.raises(NumericalError, match=r"what a page shows: left out, ZeroDivisionError.* its results are in"):
        result.save(tmp_path / "out")
    assert sorted(os.listdir(tmp_path / "out")) == ["results.h5", "summary.json"]
