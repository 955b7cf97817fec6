"""`creak compare`: two results side by side."""

import json
import re

import pytest

import creak as api
from creak.errors import InputError
from helpers_cli import say
from helpers_decks import STUDY, write_strips

QUIET = ("--quiet", "--no-converge", "--animation-mb", 0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study, its result, and one with half the friction-free gap and another load."""
    folder = tmp_path_factory.mktemp("compared")
    study = write_strips(folder, study=STUDY + "[reference]\nrun = false\n")
    assert say("run", study, *QUIET).status == 0
    softer = ("--set", "contact.tip.clearance=0.4", "--set", "excitation.root.signal.amplitude=0.06")
    assert say("run", study, "--out", folder / "closer", *softer, *QUIET).status == 0
    return folder


def test_figures_are_those_of_the_two_summaries(folder, creak, tmp_path):
    said = creak("compare", folder / "results", folder / "closer", "--out", tmp_path / "c.html", "--json")
    assert said.status == 0
    found = json.loads(said.out)
    one, other = (
        json.loads((folder / n / "summary.json").read_text())["runs"]["reduced"] for n in ("results", "closer")
    )
    assert [s["key"] for s in found["settings"]] == ["contact.tip.clearance", "excitation.root.signal.amplitude"]
    assert found["settings"][1] == {"key": "excitation.root.signal.amplitude", "a": 0.05, "b": 0.06}
    impulse = found["figures"]["impulse"]
    assert (impulse["a"], impulse["b"]) == (one["impulse_total"], other["impulse_total"])
    assert impulse["change"] == pytest.approx(other["impulse_total"] / one["impulse_total"] - 1.0)
    assert found["figures"]["events"]["b"] == len(other["events"])
    assert found["events"]["both"] + found["events"]["only_a"] == len(one["events"])
    assert found["events"]["both"] + found["events"]["only_b"] == len(other["events"])
    assert found["places"][0]["figures"]["impulse"]["a"] == pytest.approx(one["places"][0]["impulse"])


def test_a_result_beside_itself_does_not_differ(folder):
    one = api.open_result(folder / "results")
    found = api.compare(one, folder / "results")
    assert found.settings == ()
    assert {f.change for f in found.figures if f.change is not None} == {0.0}
    assert not found.events.missed
    assert not found.events.extra


def test_the_page_is_one_file_with_both(folder, creak, tmp_path):
    page = tmp_path / "page.html"
    said = creak("compare", folder / "results", folder / "closer", "--out", page)
    assert said.status == 0
    assert "contact.tip.clearance" in said.words
    text = page.read_text()
    assert "<svg" in text
    assert "contact.tip.clearance" in text
    assert not re.search(r'(src|href)="https?:', text)


def test_a_changed_study_is_run_and_compared(folder, creak, tmp_path):
    said = creak("compare", folder / "results", "--set", "time.periods=1", "--out", tmp_path / "c.html", "--json")
    assert said.status == 0
    found = json.loads(said.out)
    assert found["settings"] == [{"key": "time.periods", "a": 2.0, "b": 1.0}]
    assert (folder / "results_periods=1" / "summary.json").is_file()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("results",), "nothing to be compared with"),
        (("results", "results"), "the same folder"),
        (("results", "closer", "--set", "time.periods=1"), "both given"),
        (("results", "nowhere"), "nowhere"),
        (("results", "--set", "contact.tap.friction=1"), "contact.tap"),
        (("closer", "--set", "time.periods=1"), "no longer the study"),
    ],
)
def test_mistakes_are_named(folder, creak, words, told):
    places = [w if w.startswith("--") or "=" in w else folder / w for w in words]
    said = creak("compare", *places)
    assert said.status == 2
    assert told in said.words
    assert not (folder / "comparison.html").exists()


def test_results_in_other_units_are_not_compared(folder):
    one, other = api.open_result(folder / "results"), api.open_result(folder / "closer")
    config = other.findings.setup.study.config
    object.__setattr__(config.model, "units", "m-kg-s")
    with pytest.raises(InputError, match=r"is in mm-t-s, .* in m-kg-s"):
        api.compare(one, other)
