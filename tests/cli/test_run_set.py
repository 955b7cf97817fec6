"""`creak run --set`: a study with other values, its file as it is."""

import json

import pytest

from creak.errors import InputError
from creak.studies.file.changes import read_changes
from creak.studies.models import superelements
from helpers_decks import STUDY, write_strips

pytestmark = pytest.mark.usefixtures("no_page")

SHORT = ("--quiet", "--no-converge", "--animation-mb", 0)


@pytest.fixture
def study(tmp_path):
    return write_strips(tmp_path, study=STUDY + "[reference]\nrun = false\n")


def summary_of(folder):
    return json.loads((folder / "summary.json").read_text())


def test_values_are_read_as_in_a_study_file():
    found = read_changes(["a.b=3.2", "c=true", "d = [1, 2]", "e=guyan", 'f="x=y"', 'g={ type = "full" }'])
    assert found == {"a.b": 3.2, "c": True, "d": [1, 2], "e": "guyan", "f": "x=y", "g": {"type": "full"}}


@pytest.mark.parametrize("text", ["a", "=1", "a=", "a..b=1"])
def test_what_is_no_change_is_refused(text):
    with pytest.raises(InputError, match="is no change"):
        read_changes([text])


def test_a_changed_run_is_that_of_a_file_with_the_value(study, creak):
    before = study.read_bytes()
    assert creak("run", study, "--set", "contact.tip.clearance=0.4", "--set", "time.periods=1", *SHORT).status == 0
    changed = summary_of(study.parent / "results_clearance=0.4,periods=1")
    assert study.read_bytes() == before
    assert changed["changes"] == {"contact.tip.clearance": 0.4, "time.periods": 1}
    text = (
        study.read_text()
        .replace("[excitation", "clearance = 0.4\n[excitation", 1)
        .replace("periods = 2", "periods = 1")
    )
    study.write_text(text)
    assert creak("run", study, "--out", study.parent / "written", *SHORT).status == 0
    written = summary_of(study.parent / "written")
    assert changed["runs"]["reduced"]["events"], "nothing to compare"
    assert changed["runs"]["reduced"]["events"] == written["runs"]["reduced"]["events"]
    assert written["changes"] == {}


@pytest.mark.parametrize(("count", "told"), [(1, "expected static.0"), (3, "expected static.0 to static.2")])
def test_a_row_that_is_not_there_is_told_with_those_that_are(study, creak, count, told):
    push = '[[static]]\nnode_set = "TIP_UPPER"\ndof = "z"\nforce = 0.1\n'
    study.write_text(study.read_text() + count * push)
    said = creak("run", study, "--set", "static.3.force=1", *SHORT)
    said.refuses(f"the study has {count} [[static]]; {told}")
    assert ("static.0 to" in said.words) == (count > 1)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("contact.tap.clearance=1",), "contact.tap"),
        (("connector.0.stiffness=1",), "the study has no [[connector]]. It has contact, excitation, model,"),
        (("reduction.fmax=700",), "f_max"),
        (("reduction.f_max=lots",), "reduction.f_max"),
        (("time.periods=1", "time.periods=2"), "twice"),
        (("contact.tip.friction=.2", "contact.tip={}"), "change the same"),
        (("contact.tip.main=NOWHERE",), "contact.tip.main = 'NOWHERE'"),
        (("model.units=inch",), "model.units = 'inch'"),
        (("excitation.root.signal={type='psd', unit='g/Hz', values=[[5,1],[50,1]], end=1}",), "unit"),
    ],
)
def test_a_change_that_cannot_be_made_is_named(study, creak, words, told):
    options = [w for word in words for w in ("--set", word)]
    said = creak("run", study, *options, *SHORT)
    said.refuses(told)
    assert [p.name for p in study.parent.iterdir() if p.is_dir()] == []


def test_a_deck_has_nothing_to_set(study, creak):
    said = creak("run", study.parent / "strips.inp", "--set", "time.end=1", *SHORT)
    said.refuses("creak new strips.inp")


def superelements_of(folder):
    """Those of the strips UPPER and LOWER."""
    return sorted((folder / "superelements" / "solved").glob("[UL]*.h5"))


def test_the_second_run_takes_what_the_first_one_kept(study, creak, tmp_path, monkeypatch):
    here = study.parent
    text = study.read_text().replace("[excitation", "clearance = 0.4\n[excitation", 1)
    study.write_text(text.replace("periods = 2", "periods = 1"))
    assert creak("run", study, "--out", here / "alone", "--no-keep", *SHORT).status == 0
    assert not (here / "superelements").exists()
    assert creak("run", study, "--out", here / "first", *SHORT).status == 0
    kept = superelements_of(here)
    assert len(kept) == 2
    dates = [path.stat().st_mtime_ns for path in kept]
    creak("run", study, "--out", here / "again", *SHORT).done()
    assert [path.stat().st_mtime_ns for path in superelements_of(here)] == dates
    notes = summary_of(here / "again")["notes"]
    assert sum(f"taken from solved/{path.name}" in str(notes) for path in kept) == 2
    runs = [summary_of(here / name)["runs"]["reduced"]["events"] for name in ("alone", "first", "again")]
    assert runs[0] == runs[1] == runs[2]
    assert runs[0]
    for path in kept:
        path.write_bytes(path.read_bytes()[:2000])  # damaged: made anew
    assert creak("run", study, "--out", here / "mended", *SHORT).status == 0
    assert summary_of(here / "mended")["runs"]["reduced"]["events"] == runs[0]
    monkeypatch.setattr(superelements, "SPARED", 1)  # of each part
    assert creak("run", study, "--set", "reduction.f_max=3001", "--out", here / "other", *SHORT).status == 0
    assert len(superelements_of(here)) == 2
    assert not {*kept} & {*superelements_of(here)}


def test_a_run_that_cannot_begin_leaves_no_folder(study, creak):
    study.write_text(study.read_text().replace("[contact.tip]", "[contact.tip]\nnonsense = 1"))
    assert creak("run", study, "--quiet").status == 2
    assert not (study.parent / "superelements").exists()
    (study.parent / "superelements").mkdir()  # by another run: it is not this one's to remove
    assert creak("run", study, "--quiet").status == 2
    assert (study.parent / "superelements").exists()
