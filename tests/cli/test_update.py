"""`creak update`: ranking, tables, page and the changed study; one message for each wrong input, and nothing written."""

from __future__ import annotations

import json
import tomllib

import pytest

from creak.studies.file.reader import read_study
from helpers_cli import say
from helpers_decks import write_strips
from helpers_modal import csv_text, measured_strip, strip_deck
from helpers_update import KEYS, STUDY, true_modes, write_plate, write_plate_test

BOUNDED = ("--parameter", "section.left.thickness=1:3", "--parameter", KEYS[1], "--parameter", KEYS[2])


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    return true_modes(tmp_path_factory.mktemp("truth"))


@pytest.fixture
def plate(truth, tmp_path):
    return write_plate(tmp_path), write_plate_test(truth, tmp_path / "test.csv", seed=3, count=12)


@pytest.fixture(scope="module")
def updated(truth, tmp_path_factory):
    """A folder with study, test, and all that the command writes; what it says."""
    folder = tmp_path_factory.mktemp("updated")
    study, test = write_plate(folder), write_plate_test(truth, folder / "test.csv", seed=3, count=12)
    files = ("--page", folder / "new" / "page.html", "--json", folder / "update.json")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "90")
        said = say("update", study, "--test", test, *BOUNDED, *files)
    assert said.status == 0, said.words
    return folder, said


def files(folder):
    return sorted(p.name for p in folder.iterdir())


@pytest.mark.slow
def test_tables_page_and_the_changed_study(creak, updated):
    folder, said = updated
    assert (folder / "study.toml").read_text(encoding="utf-8") == STUDY
    text = (folder / "study_updated.toml").read_text(encoding="utf-8")
    head = text.splitlines()[:2]
    assert head[0].startswith("# study.toml, written by creak with what `creak update` found beside test.csv:")
    assert head[1].startswith("# section.left.thickness: 1.")
    data = json.loads((folder / "update.json").read_text())
    tables = tomllib.loads(text)
    assert tables["section"]["left"]["thickness"] == pytest.approx(data["parameters"][0]["after"], rel=1e-6)
    assert tables["model"] == {"deck": "plate.inp"}
    assert read_study(folder / "study_updated.toml").config.section["FEET"].stiffness == pytest.approx(2.0, rel=0.05)
    assert data["rms_after"] < 0.02 < 0.1 < data["rms_before"]
    assert [p["key"] for p in data["parameters"]] == ["section.left.thickness", *KEYS[1:]]
    assert all(p["low_95"] < p["after"] < p["high_95"] for p in data["parameters"])
    assert len(data["fitted"]) == len(data["slopes"]) == len(data["after"]["pairs"])
    assert " ".join(data["sentence"].split()) in said.words
    shown = (folder / "new" / "page.html").read_text(encoding="utf-8")
    assert 'id="parameters"' in shown
    assert "section.left.thickness" in shown
    words = ("update", folder / "study.toml", "--test", folder / "test.csv", *BOUNDED[:2])
    assert creak(*words, "-q").status == 0  # its own file is replaced
    assert (folder / "study_updated.toml").read_text(encoding="utf-8") != text
    (folder / "study_updated.toml").write_text(text, encoding="utf-8")


@pytest.mark.slow
def test_the_updated_study_has_the_modes_that_were_promised(creak, updated, tmp_path):
    """Begun from the changed study, the update changes nothing more."""
    folder, _ = updated
    keys, figures = [word.replace("=1:3", "") for word in BOUNDED], tmp_path / "again.json"
    words = ("update", folder / "study_updated.toml", "--test", folder / "test.csv", *keys, "-q", "--json", figures)
    assert creak(*words).status == 0
    for p in json.loads(figures.read_text())["parameters"]:
        assert p["after"] == pytest.approx(p["before"], rel=1e-4)


def test_without_parameters_nothing_is_changed(creak, plate, tmp_path):
    study, test = plate
    before = files(tmp_path)
    said = creak("update", study, "--test", test).done()
    assert "section.FEET.stiffness alone would leave" in said.words
    assert "Nothing was changed." in said.words
    assert files(tmp_path) == before
    ranked = json.loads(creak("update", study, "--test", test, "--json", "-").out)
    assert ranked["sensitivities"][0]["key"] == "section.FEET.stiffness"
    assert ranked["written"] == []


@pytest.mark.slow
def test_what_cannot_be_believed_is_told(creak, plate, truth, tmp_path):
    """Thickness, modulus and density of one half: two combinations of three."""
    study, test = plate
    keys = [f"--parameter={k}" for k in ("section.LEFT.thickness", "material.STEEL.youngs_modulus=2e5:2.2e5")]
    said = creak("update", study, "--test", test, *keys).done()
    assert "has stopped at its bound" in said.err
    assert "something else differs too" in said.err
    few = write_plate_test(truth, tmp_path / "few.csv", count=4)
    said = creak("update", study, "--test", few, *BOUNDED, "--out", tmp_path / "few.toml").done()
    assert "over-fitted: 3 parameters from 4 modes, with 1 left to check by" in " ".join(said.err.split())


WRONG = {
    "section.LEFT.thicknes": "section.LEFT.thicknes is no number of the study or its deck",
    "section.LEF.thickness": "Did you mean 'section.LEFT.thickness'?",
    "time.end": "time.end is no number of the study or its deck",
    "model.units": "model.units is 'mm-t-s' in the study; expected a number above 0",
    "verification.f_max": "verification.f_max moves no mode that has a partner: no stiffness and no mass depends on it",
    "section.LEFT.thickness=2:3": "section.LEFT.thickness is 1.8 in the study, which the bounds leave out",
    "section.LEFT.thickness=3:2": "has bounds that are none; expected 0 < LOW < HIGH",
    "section.LEFT.thickness=a:3": "has no bounds; expected KEY, or KEY=LOW:HIGH",
    "section.LEFT.thickness=": "is no parameter; expected KEY, or KEY=LOW:HIGH",
}


@pytest.mark.parametrize("key", WRONG)
def test_wrong_parameters_are_one_message(creak, plate, tmp_path, key):
    study, test = plate
    refused(creak, tmp_path, WRONG[key], study, test, "--parameter", key)


def refused(creak, folder, what, study, test, *words):
    before = files(folder)
    said = creak("update", study, "--test", test, *words)
    said.refuses(what)
    assert said.words.count("creak:") == 1
    assert files(folder) == before


def test_a_number_that_moves_other_modes_alone_is_told_with_the_one_it_moves_most(creak, tmp_path):
    """The test knows the lower strip, the thickness is that of the upper one."""
    study, test = write_strips(tmp_path), tmp_path / "test.csv"
    rows = "".join(f"88,{node},z,{value}\n" for node, value in ((1004, 0.06), (1007, 0.25), (1010, 0.56), (1013, 1.0)))
    test.write_text(f"frequency_hz,sensor,direction,value\n{rows}")
    told = "section.UPPER.thickness moves no mode that has a partner; of the others most mode 1 at 58.78 Hz"
    refused(creak, tmp_path, told, study, test, "--parameter", "section.UPPER.thickness")


def test_other_mistakes_are_one_message(creak, plate, truth, tmp_path):
    study, test = plate
    key = ("--parameter", KEYS[0])
    one = write_plate_test(truth, tmp_path / "one.csv", count=2)
    refused(creak, tmp_path, "3 parameters are more than the 2 measured modes with a partner", study, one, *BOUNDED)
    refused(creak, tmp_path, f"the parameter {KEYS[0]} is given twice", study, test, *key, *key)
    other = ("--parameter", KEYS[0].replace("LEFT", "left"))
    refused(creak, tmp_path, "is given twice", study, test, *key, *other)
    refused(creak, tmp_path, "lies in another folder", study, test, *key, "--out", tmp_path / "new" / "a.toml")
    refused(creak, tmp_path, "it is the same file as an input", study, test, *key, "--out", study)
    refused(creak, tmp_path, "expected a file name that ends in .toml", study, test, *key, "--out", tmp_path / "a.txt")
    same = tmp_path / "same.toml"
    refused(creak, tmp_path, "two outputs are written to", study, test, *key, "--out", same, "--page", same)
    refused(creak, tmp_path, "--out without --parameter", study, test, "--out", tmp_path / "a.toml")
    refused(creak, tmp_path, "--page without --parameter", study, test, "--page", tmp_path / "a.html")
    refused(creak, tmp_path, "--uncertainty 0; expected per cent", study, test, *key, "--uncertainty", "0")
    refused(creak, tmp_path, "no contact, connector or clip 'x' that touches", study, test, *key, "--closed", "x")
    refused(creak, tmp_path, "plate.inp is a deck", tmp_path / "plate.inp", test, *key)


def test_a_test_of_another_structure_is_one_message(creak, plate, tmp_path):
    study, _ = plate
    (tmp_path / "strip").mkdir()
    _, other = measured_strip(strip_deck(tmp_path / "strip"))
    test = tmp_path / "strip.csv"
    test.write_text(csv_text(other))
    refused(
        creak,
        tmp_path,
        "the shapes of 3 pairs agree too little to follow them: their mean MAC is 0.",
        study,
        test,
        "--parameter",
        KEYS[0],
    )
    other.points[:] += 1000.0
    other.labels[:] = [f"S{k}" for k in other.labels]
    test.write_text(csv_text(other))
    refused(creak, tmp_path, "sensors are not on the model", study, test, "--parameter", KEYS[0])
