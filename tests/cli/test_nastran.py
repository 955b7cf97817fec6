"""`creak info`, `creak modes` and `creak run` on a Nastran deck; the same strips as an Abaqus deck."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from helpers_decks import STUDY, write_strips, write_study
from helpers_nastran_strips import STUDY as CHANGES
from helpers_nastran_strips import strips

pytestmark = pytest.mark.usefixtures("no_page")


def nastran_study(folder: Path, deck: str) -> Path:
    study = STUDY.replace("periods = 2", "periods = 1")
    for old, new in CHANGES.items():
        assert old in study
        study = study.replace(old, new)
    return write_study(folder, study, {"strips.bdf": deck})


def test_info_and_modes(creak, tmp_path):
    nastran_study(tmp_path, strips(extra="EIGRL,1,,,10"))
    text = creak("info", tmp_path / "strips.bdf").words
    assert "78 nodes, 48 elements" in text
    assert "not read: EIGRL" in text
    write_strips(tmp_path)
    found = [creak("modes", tmp_path / f"strips.{k}", "--count", 4, "--json", "-", "--quiet") for k in ("bdf", "inp")]
    ours, theirs = (json.loads(said.words) for said in found)
    # Linear mass and residual bending flexibility against the consistent mass: both are good to (kh)^4 or (kh)^2/100.
    assert ours["frequencies"] == pytest.approx(theirs["frequencies"], rel=0.01)
    assert ours["mass"] == pytest.approx(theirs["mass"])


@pytest.mark.parametrize("coupled", [True, False])
def test_run(creak, tmp_path, coupled):
    """A study with contact runs reduced and unreduced, with coupled and with lumped mass (massless rotations)."""
    deck = strips() if coupled else strips().replace("PARAM,COUPMASS,1\n", "")
    creak("run", nastran_study(tmp_path, deck), "--quiet").done()
    summary = json.loads((tmp_path / "results" / "summary.json").read_text())
    assert summary["verification"]


def test_what_changes_the_answer_stops_the_run(creak, tmp_path):
    study = nastran_study(tmp_path, strips(extra="CGAP,901,9,1013,13\nPGAP,9,1.75,,1.+4"))
    said = creak("run", study)
    said.refuses(
        "CGAP is not read by creak and would change the answer",
        "--ignore 'CGAP'",
        'nodes = ["GAP_9.A", "GAP_9.B"], dof = "z", lower = -1.75, stiffness = 10000',
    )
    assert not (tmp_path / "results" / "summary.json").exists()
    said = creak("run", study, "--ignore", "CGAP", "--ignore", "NOSUCH", "--quiet")
    assert "--ignore 'NOSUCH' names nothing that was left unread" in said.words
    assert "--ignore 'CGAP'" not in said.words
    assert (tmp_path / "results" / "summary.json").exists()


def test_a_first_study_has_the_gaps_of_the_deck(creak, tmp_path):
    """Tips 1.75 mm apart that part by .05 mm more: the study names the stop, of 10 N/mm, and runs with it."""
    (tmp_path / "strips.bdf").write_text(strips(extra="CGAP,901,9,1013,13\nPGAP,9,.05,,10."))
    said = creak("new", tmp_path / "strips.bdf", "--distance", "0.1").done()
    assert "connector GAP_9: 1 gap(s) of the deck" in said.words
    assert "to be filled in" not in said.words
    study = tmp_path / "strips.toml"
    (table,) = tomllib.loads(study.read_text())["connector"]
    assert table == {
        "type": "play",
        "name": "GAP_9",
        "nodes": ["GAP_9.A", "GAP_9.B"],
        "dof": "z",
        "lower": -0.05,
        "stiffness": 10.0,
    }
    said = creak("run", study, "--quick", "--set", "excitation.road.signal.amplitude=0.05", "--quiet").done()
    (found,) = tmp_path.rglob("summary.json")
    assert json.loads(found.read_text())["runs"]["reduced"]["events"]
    study.write_text(
        study.read_text().replace('"GAP_9.A"', '"GAP_9.B"').replace('["GAP_9.B", "GAP_9.B"]', '["GAP_9.B"]')
    )
    said = creak("run", study)
    said.refuses("CGAP is not read by creak and would change the answer")


def test_a_gap_of_a_deck_with_a_dashpot_closes_and_is_heard(creak, tmp_path):
    """The dashpot couples the modes of the reduced model."""
    extra = "CGAP,901,9,1013,13\nPGAP,9,.05,,10.,,,.3\nCDAMP2,902,1.-4,1013,3,13,3"
    (tmp_path / "strips.bdf").write_text(strips(extra=extra))
    assert creak("new", tmp_path / "strips.bdf", "--distance", "0.1", "--quiet").status == 0
    (table,) = tomllib.loads((tmp_path / "strips.toml").read_text())["connector"]
    assert table["friction"] == 0.3
    said = creak("run", tmp_path / "strips.toml", "--quick", "--set", "excitation.road.signal.amplitude=0.05")
    assert said.status == 0, said.words
    (found,) = tmp_path.rglob("summary.json")
    assert "missing" not in json.loads(found.read_text())["sound"], said.words


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("BEGIN BULK\n", "", ["strips.bdf: the deck has CEND but no BEGIN BULK", "Add BEGIN BULK before"]),
        ("PSHELL,2,", "PSHEL,2,", ["CQUAD4 1001 uses property 2", "Note that PSHEL at", "Did you mean 'PSHELL'?"]),
        ("MAT1,1,", "MAT1,7,", ["PSHELL 1 uses material 1, which is not defined"]),
        ("GRID,2,,10.0,0.0,1.75\n", "GRID,2,,1O.0,0.0,1.75\n", ["field 4 of GRID is '1O.0'", "a real number"]),
        ("GRID,2,,10.0,0.0,1.75\n", "GRID,2,7,10.0,0.0,1.75\n", ["GRID 2 needs coordinate system 7", "CORD card"]),
        ("SPC = 1\n", "SPC = 5\n", ["strips.bdf:3: SPC = 5 in the case control, but no card has this set"]),
    ],
)
def test_mistake_in_the_deck_is_named(creak, tmp_path, old, new, words):
    assert old in strips()
    study = nastran_study(tmp_path, strips().replace(old, new, 1))
    said = creak("run", study, "--quiet")
    assert said.status == 2
    assert said.out == ""
    for word in words:
        assert word in said.words, said.words
    assert sorted(p.name for p in tmp_path.iterdir()) == ["strips.bdf", "study.toml"]


def test_a_material_without_density_is_told(creak, tmp_path):
    """Nastran takes MAT1 without RHO. So it is where there are no modes."""
    (tmp_path / "light.bdf").write_text(strips().replace(",.3,7.85-9", ",.3"), encoding="utf-8")
    for command in ("info", "modes"):
        assert "material MAT1 1 has no density: 48 element(s)" in creak(command, tmp_path / "light.bdf").err
    said = creak("run", nastran_study(tmp_path, strips().replace(",.3,7.85-9", ",.3")), "--quiet")
    assert "warning: material MAT1 1 has no density: 48 element(s) have no mass of their own" in said.err
