"""`creak run DECK.inp`: files, words, exit status."""

import json

import h5py
import pytest

from helpers_dynamic_decks import STEP, cantilever_deck, stop_deck

SHORT = STEP.replace("1.E-5", "1.E-4")


def test_the_three_files(creak, tmp_path):
    deck = tmp_path / "stop.inp"
    deck.write_text(stop_deck(step=SHORT))
    out = creak("run", deck, "--out", tmp_path / "out", "--units", "m-kg-s").done().out
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["report.html", "results.h5", "summary.json"]
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert list(summary["runs"]) == ["reference"]
    assert (summary["title"], summary["units"]) == ("HIT", "m-kg-s")
    # (w h)^2 / 12 = 8e-6 of the force, at a step of 1e-4
    assert summary["runs"]["reference"]["max_force"] == pytest.approx(9950.37, rel=2e-5)
    with h5py.File(tmp_path / "out" / "results.h5") as file:
        assert file["runs/reference/displacement"].shape == (401, 1, 6)
        assert "excitation" not in json.loads(file.attrs["study"])
        assert json.loads(file.attrs["study"])["contact"]["POINT-TABLE"]["stiffness"] == 1e6
    assert "stop.inp" in (tmp_path / "out" / "report.html").read_text()
    assert "*NODE OUTPUT" in out


def test_results_lie_beside_the_deck(creak, tmp_path):
    deck = tmp_path / "stop.inp"
    deck.write_text(stop_deck(step=SHORT))
    creak("run", deck, "--quiet").done()
    assert (tmp_path / "results" / "summary.json").exists()


def test_report_names_every_kind_of_signal(creak, tmp_path):
    amplitudes = (
        "*AMPLITUDE, NAME=P, DEFINITION=PERIODIC\n1, 100., 0., 1.\n-1., 0.\n"
        "*AMPLITUDE, NAME=S, DEFINITION=SMOOTH STEP\n0., 0., 0.01, 1.\n*AMPLITUDE, NAME=T\n0., 0., 0.01, 1.\n"
    )
    step = (
        "*STEP\n*DYNAMIC, DIRECT\n1.E-3, 0.02\n*BOUNDARY, AMPLITUDE=P\nROOT, 3, 3, 0.001\n"
        "*BOUNDARY, TYPE=VELOCITY, AMPLITUDE=S\nROOT, 2, 2, 0.001\n*CLOAD, AMPLITUDE=T\nTIP, 3, 1.\n*END STEP\n"
    )
    deck = tmp_path / "beam.inp"
    deck.write_text(cantilever_deck(step, amplitudes, "ROOT, 1\nROOT, 4, 6\n"))
    out = creak("run", deck).done().out
    assert "no node set" in out.replace("\n", " ")
    report = (tmp_path / "results" / "report.html").read_text()
    for words in (
        "periodic, 15.9",
        "enforced velocity of ROOT y velocity",
        "smooth step through 2 points",
        "2 point(s)",
    ):
        assert words in report


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("*STEP\n*FREQUENCY\n5\n*END STEP\n", "creak modes"),
        ("*STEP, NLGEOM\n*DYNAMIC\n1.E-4, 0.01\n*END STEP\n", "--ignore 'STEP, NLGEOM'"),
        ("*STEP\n*DYNAMIC, EXPLICIT\n, 0.01\n*END STEP\n", "implicit"),
        ("*STEP\n*DYNAMIC\n-1.E-4, 0.01\n*END STEP\n", "greater than zero"),
        ("*STEP\n*VISCO\n*END STEP\n*STEP\n*DYNAMIC\n1.E-4, 0.01\n*END STEP\n", "*VISCO"),
        ("", "no *STEP"),
    ],
)
def test_wrong_decks_end_with_status_2(creak, tmp_path, lines, words):
    deck = tmp_path / "wrong.inp"
    deck.write_text(stop_deck(step=lines))
    creak("run", deck).refuses(words, "wrong.inp")
    assert not (tmp_path / "results" / "summary.json").exists()


def test_a_nastran_deck_of_modes_is_not_run(creak, tmp_path):
    (tmp_path / "deck.bdf").write_text("SOL 103\nCEND\nBEGIN BULK\nGRID,1\nCONM2,1,1,,1.\nENDDATA\n")
    creak("run", tmp_path / "deck.bdf").refuses("study")
