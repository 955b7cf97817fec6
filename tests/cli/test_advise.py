"""`creak advise` through the command."""

import json
import tomllib

import pytest

from creak.studies.file.reader import read_study
from helpers_decks import STUDY, write_strips
from helpers_ties import sections, sheet


def test_advice_on_two_strips(creak, tmp_path):
    study = write_strips(tmp_path)
    before = sorted(p.name for p in tmp_path.iterdir())
    said = creak("advise", study).done()
    for text in ("excitation to 60 Hz (stated)", "UPPER", "gap-modes", "because", "lines of the study file to change"):
        assert text in said.out
    assert sorted(p.name for p in tmp_path.iterdir()) == before
    machines = creak("advise", study, "--json").done()
    advice = json.loads(machines.out)["advice"]
    assert tomllib.loads(advice["toml"])["reduction"]["method"] == advice["method"] == "gap-modes"
    assert advice["toml"].strip() in said.out


def test_the_advised_study_runs_as_it_is(creak, tmp_path):
    """The lines, put into the study: nothing is left to change, and creak takes the file."""
    path = write_strips(tmp_path)
    said = creak("advise", path, "--quiet").done()
    lines = tomllib.loads(said.out.partition("change:\n")[2])
    study = STUDY.replace(
        "f_max = 3000", f'method = "{lines["reduction"]["method"]}"\nf_max = {lines["reduction"]["f_max"]}'
    )
    study = study.replace("step = 5e-4", f"step = {lines['time']['step']}")
    path.write_text(study, encoding="utf-8")
    assert read_study(path).config.reduction.method == "gap-modes"
    again = creak("advise", path, "--quiet").done()
    assert "the study file can stay as it is" in again.out


def test_another_value_is_looked_at_without_a_change_of_the_file(creak, tmp_path):
    study = write_strips(tmp_path)
    before = study.read_text(encoding="utf-8")
    said = creak("advise", study, "--set", "reduction.f_max=2000", "--json").done()
    found = json.loads(said.out)
    assert 2000.0 in [option["f_max"] for option in found["reductions"] if option["method"] == "craig-bampton"]
    assert study.read_text(encoding="utf-8") == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nothing.toml"], "no such study file"),
        (["strips.inp"], "is a deck"),
        (["study.toml", "--set", "reduction.f_mx=700"], "Did you mean 'f_max'"),
        (["study.toml", "--quiet", "--verbose"], "both --quiet and --verbose"),
    ],
)
def test_wrong_input_is_one_message_and_status_2(creak, monkeypatch, tmp_path, arguments, words):
    write_strips(tmp_path)
    monkeypatch.chdir(tmp_path)
    said = creak("advise", *arguments)
    said.refuses(words)


def test_a_small_model_whose_matrices_are_full(creak, tmp_path):
    """A block of two elements, half of its dofs held: no zero is worth leaving out. Its only contact is tied."""
    study = tmp_path / "study.toml"
    (tmp_path / "lap.inp").write_text(
        "*HEADING\nlap\n"
        + sheet("LOWER", 1, (1, 1), (0.0, 0.0, 0.0), (10.0, 10.0))
        + sheet("UPPER", 10_001, (1, 1), (0.0, 0.0, 2.0), (10.0, 10.0))
        + sections("LOWER", "UPPER", thickness=2.0)
        + "*TIE, NAME=T\nUPPER_FACE, LOWER_FACE\n*NSET, NSET=ROOT\n1\n*BOUNDARY\nROOT, 1, 2\nROOT, 4, 6\n",
        encoding="utf-8",
    )
    study.write_text(
        '[model]\ndeck = "lap.inp"\nunits = "mm-t-s"\n[contact.c]\nsecondary = "UPPER_FACE"\nmain = "LOWER_FACE"\n'
        '[excitation.road]\nnode_set = "ROOT"\ndof = "z"\nkind = "displacement"\n'
        'signal = { type = "sine", frequency = 20, amplitude = 0.1 }\n[damping]\nmodal = 0.02\n[time]\nend = 0.1\n',
        encoding="utf-8",
    )
    said = creak("advise", study).done()
    said = creak("run", study, "--quick", "--out", tmp_path / "results")
    assert "contacts only where ties hold both sides together, so nothing can rattle" in said.out
