"""`creak compare`: two results side by side.

`creak compare RESULTS TEST`: table, page, figures, and one message where nothing can be compared.
"""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from types import SimpleNamespace

import pytest

import creak as api
from creak.errors import InputError
from creak.formats.measured.histories import read_histories
from creak.model.units import UNITS
from creak.report.tables.comparison import _flat, _places
from helpers_cli import empty_reports, say
from helpers_decks import STUDY, write_strips
from helpers_docs import ROOT

SHORT = STUDY.replace("f_min = 5", "f_min = 20").replace("period = 0.2", "period = 0.05") + "[reference]\nrun = false\n"
GAPS = SHORT.replace('main = "OVER"', 'main = "OVER"\nclearance = "gaps.csv"')
QUIET = ("--quiet", "--no-converge", "--animation-mb", 0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study, its result, and one with half the friction-free gap and another load."""
    folder = tmp_path_factory.mktemp("compared")
    study = write_strips(folder, study=SHORT)
    softer = ("--set", "contact.tip.clearance=0.4", "--set", "excitation.root.signal.amplitude=0.06")
    with pytest.MonkeyPatch.context() as patch:
        empty_reports(patch)
        assert say("run", study, *QUIET).status == 0
        assert say("run", study, "--out", folder / "closer", *softer, *QUIET).status == 0
        assert say("run", study, "--out", folder / "rubbing", "--set", "contact.tip.friction=0.3", *QUIET).status == 0
    return folder


def test_figures_are_those_of_the_two_summaries(folder, creak, tmp_path):
    said = creak("compare", folder / "results", folder / "closer", "--out", tmp_path / "c.html", "--json").done()
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


def test_friction_is_compared_where_anything_rubs(folder, creak, tmp_path):
    words = ("compare", folder / "results", folder / "rubbing", "--out", tmp_path / "c.html")
    found = json.loads(creak(*words, "--json").out)
    run = json.loads((folder / "rubbing" / "summary.json").read_text())["runs"]["reduced"]
    most = max(run["places"], key=lambda p: p["friction_energy"])
    figures = found["figures"]
    assert figures["hardest rub"] == {"a": None, "b": most["name"], "change": None}
    assert figures["friction there"]["b"] == most["friction"]
    assert figures["slip path there"]["b"] == most["slip_path"] > 0.0
    assert figures["friction energy"]["b"] == run["energies"]["friction"] > 0.0
    place = next(p["figures"] for p in found["places"] if p["figures"]["friction"]["b"] is not None)
    assert place["friction"]["a"] is None
    assert place["friction_energy"]["b"] > 0.0
    assert f"hardest rub none before, {most['friction']} after" in creak(*words).words
    page = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    for name in [name for name in figures if re.search("rub|friction|slip", name)]:
        assert f"`{name}`" in page, name
    smooth = json.loads(creak("compare", folder / "results", folder / "closer", *words[3:], "--json").out)
    assert not [name for name in smooth["figures"] if re.search("rub|friction|slip", name)]
    assert not [p for p in smooth["places"] if "friction" in p["figures"]]


def rub(state, path, energy, **more):
    known = {"contact": "base", "nodes": [1, 2], "friction": state, "slips": 1, "slip_rate": None}
    return {**known, "slip_path": path, "friction_energy": energy, **more}


def test_what_slides_in_one_result_and_rests_in_the_other_is_one_place():
    """With more friction a block sticks, and is no place: how far it slides before and after is told all the same."""
    slides = SimpleNamespace(run={"places": [rub("sliding", 4.0, 6.0, name="base 1", events=0, impulse=0)]})
    rests = SimpleNamespace(run={"places": [], "resting": [rub("stick", 0.5, 0.25)]})
    for a, b, told in ((slides, rests, (4.0, 0.5)), (rests, slides, (0.5, 4.0))):
        (place,) = _places(a, b, UNITS["mm-t-s"])
        path = next(f for f in place.figures if f.name == "slip_path")
        assert (place.name, path.a, path.b, path.unit) == ("base 1", *told, "mm")
        state = next(f for f in place.figures if f.name == "friction")
        assert {state.a, state.b} == {"sliding", "stick"}
        assert state.change is None


def test_a_result_beside_itself_does_not_differ(folder):
    one = api.open_result(folder / "results")
    found = api.compare(one, folder / "results")
    assert found.settings == ()
    assert {f.change for f in found.figures if f.change is not None} == {0.0}
    assert not found.events.missed
    assert not found.events.extra


def test_the_page_is_one_file_with_both(folder, creak, tmp_path):
    page = tmp_path / "page.html"
    said = creak("compare", folder / "results", folder / "closer", "--out", page).done()
    assert "contact.tip.clearance" in said.words
    text = page.read_text()
    assert "<svg" in text
    assert "contact.tip.clearance" in text
    assert not re.search(r'(src|href)="https?:', text)


def test_rows_of_clips_are_compared_number_by_number():
    """By the keys that --set takes; points of a table are one value."""
    study = {"clip": [{"gap": 0.4, "table": [[0, 0], [1, 2]]}, {"gap": 0.6}], "static": [], "end": 2.0}
    values = {"clip.0.gap": 0.4, "clip.0.table": [[0, 0], [1, 2]], "clip.1.gap": 0.6, "end": 2.0}
    assert dict(_flat(study)) == values


def test_a_changed_study_is_run_and_compared(folder, creak, no_page, tmp_path):
    said = creak(
        "compare", folder / "results", "--set", "time.periods=1", "--out", tmp_path / "c.html", "--json"
    ).done()
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
    said.refuses(told)
    assert not (folder / "comparison.html").exists()


COMMENTS = {"strips.inp": b"** a word\n", "gaps.csv": b"14,0.3\n"}


@pytest.fixture(scope="module")
def of_files(tmp_path_factory):
    """A study with a table, its results, and those with either file changed, in a folder of the file's name in `after`."""
    folder = tmp_path_factory.mktemp("files")
    study = write_strips(folder, study=GAPS)
    (folder / "gaps.csv").write_text("node,clearance\n13,0.4\n")
    with pytest.MonkeyPatch.context() as patch:
        empty_reports(patch)
        assert say("run", study, *QUIET).status == 0
        for name, comment in COMMENTS.items():
            kept = (folder / name).read_bytes()
            (folder / name).write_bytes(kept + comment)
            assert say("run", study, "--out", folder / "after" / name, *QUIET).status == 0
            (folder / name).write_bytes(kept)
    return folder


@pytest.mark.parametrize(("name", "what"), [("strips.inp", "deck"), ("gaps.csv", "other files")])
def test_files_of_other_content_are_told(creak, of_files, tmp_path, name, what):
    """The digests are those of the files themselves; a study that is run again with a change needs them as they were."""
    kept = (of_files / name).read_bytes()
    shown = [f"SHA-256 {hashlib.sha256(text).hexdigest()[:12]}" for text in (kept, kept + COMMENTS[name])]
    words = ("compare", of_files / "results", of_files / "after" / name, "--out", tmp_path / "c.html")
    found = json.loads(creak(*words, "--json").out)
    assert found["settings"] == [{"key": f"content of the {what}", "a": shown[0], "b": shown[1]}]
    assert f"content of the {what}" in creak(*words).words


@pytest.mark.parametrize(("name", "what"), [("strips.inp", "the deck of"), ("gaps.csv", "the other files that")])
def test_a_study_is_not_run_with_a_change_on_other_files(creak, no_page, of_files, tmp_path, name, what):
    file, out = of_files / name, of_files / "results_periods=1"
    words = ("compare", of_files / "results", "--set", "time.periods=1", "--out", tmp_path / "c.html")
    kept = file.read_bytes()
    file.write_bytes(kept + b"\n")
    said = creak(*words)
    file.write_bytes(kept)
    said.refuses(what, "changed since")
    assert not out.exists()
    assert creak(*words).status == 0
    shutil.rmtree(out)


def test_results_in_other_units_are_not_compared(folder):
    one, other = api.open_result(folder / "results"), api.open_result(folder / "closer")
    config = other.findings.setup.study.config
    object.__setattr__(config.model, "units", "m-kg-s")
    with pytest.raises(InputError, match=r"is in mm-t-s, .* in m-kg-s"):
        api.compare(one, other)


LATE = 0.73123
"""s by which the clock of the test is ahead."""


def test_the_command_prints_and_writes_a_page(creak, tmp_path):
    results, test = tmp_path / "out", tmp_path / "test.csv"
    assert creak("run", write_strips(tmp_path, study=STUDY), "--out", results, "-q").status == 0
    run = read_histories(results / "results.h5")
    rows = zip(run.time + LATE, run.normal_force.sum(axis=1), run.gap.min(axis=1), strict=True)
    test.write_text("\n".join(["time,tip force [N],tip gap [mm]", *(",".join(f"{x:.9g}" for x in r) for r in rows)]))
    said = creak("compare", results, test, "--out", tmp_path / "page.html", "--json").done()
    data = json.loads(said.out)
    assert data["shift"] == pytest.approx(-LATE, abs=5e-6)
    assert [c["name"] for c in data["channels"]] == ["tip force", "tip gap"]
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "tip force, N" in text
    assert "best" in text
    (tmp_path / "test.csv").write_text("time,odd\n0,1\n1,2\n")
    creak("compare", results, test, "--out", tmp_path / "other.html").refuses()
    assert not (tmp_path / "other.html").exists()
