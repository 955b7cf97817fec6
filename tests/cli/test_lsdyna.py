"""`creak info`, `modes`, `new`, `run` and `convert` on an LS-DYNA deck; the same strips as an Abaqus deck."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from creak.assembly.part import Rayleigh
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, write_strips, write_study
from helpers_lsdyna import fixed_width, held, shells

pytestmark = pytest.mark.usefixtures("no_page")

SHORT = STUDY.replace("periods = 2", "periods = 1")
CHANGES = {
    'deck = "strips.inp"': 'deck = "strips.k"',
    '"UNDER"': '"UPPER.SNEG"',
    '"OVER"': '"PART_2.SPOS"',
    "[verification]": "[damping]\nrayleigh = { alpha = 5.0, beta = 2e-6 }\n\n[verification]",
}
"""What changes in the study file: a part has its id and its title for names."""


def _strip(first, pid, name, z, thickness, n=12):
    rows = [(first + j * (n + 1) + i, 10.0 * i, 10.0 * j) for j in range(3) for i in range(n + 1)]
    quads = {}
    for j in range(2):
        for i in range(n):
            a = first + j * (n + 1) + i
            quads[first + j * n + i] = (a, a + 1, a + n + 2, a + n + 1)
    return "*NODE\n" + "".join(f"{i},{x},{y},{z}\n" for i, x, y in rows) + shells(quads, thickness, pid, name).k


def strips(extra="", gap=0.5):
    """An upper strip (1 mm, moving root: nodes 1, 14, 27) above a lower one (1.5 mm), as in `helpers_decks`."""
    roots = f"*SET_NODE_LIST_TITLE\nroot upper\n{fixed_width(1)}{fixed_width(1, 14, 27)}"
    pairs = f"*SET_NODE_LIST_TITLE\nPAIRS\n{fixed_width(2)}{fixed_width(1039, 39, 1013, 13)}"
    return (
        f"*KEYWORD\n*TITLE\ntwo strips\n{_strip(1, 1, 'Upper', gap + 1.25, 1.0)}{_strip(1001, 2, 'Lower', 0.0, 1.5)}"
        f"*MAT_ELASTIC\n1,7.85e-9,210000.,.3\n{roots}{pairs}{held([1001, 1014, 1027]).k}"
        f"*BOUNDARY_SPC_SET\n{fixed_width(1, 0, 1, 1, 0, 1, 1, 1)}{extra}*END\n"
    )


def lsdyna_study(folder: Path, deck: str) -> Path:
    study = SHORT
    for old, new in CHANGES.items():
        assert old in study
        study = study.replace(old, new)
    return write_study(folder, study, {"strips.k": deck})


def test_info_and_modes(creak, tmp_path):
    lsdyna_study(tmp_path, strips("*CONTROL_TERMINATION\n0.01\n"))
    text = creak("info", tmp_path / "strips.k", "--sets").words
    assert "78 nodes, 48 elements" in text
    assert "not read: *CONTROL_TERMINATION" in text
    assert all(name in text for name in ("PART_1.SPOS", "UPPER", "SET_NODE_1", "ROOT_UPPER", "SPC.12456"))
    write_strips(tmp_path)
    found = [creak("modes", tmp_path / f"strips.{k}", "--count", 4, "--json", "-", "--quiet") for k in ("k", "inp")]
    ours, theirs = (json.loads(said.words) for said in found)
    assert ours["frequencies"] == pytest.approx(theirs["frequencies"], rel=1e-9)
    assert ours["mass"] == pytest.approx(theirs["mass"])


def test_run(creak, tmp_path):
    """The run is that of the Abaqus deck: the same places, forces and events."""
    creak("run", lsdyna_study(tmp_path, strips()), "--quiet", "--out", tmp_path / "lsdyna").done()
    ours = json.loads((tmp_path / "lsdyna" / "summary.json").read_text())
    creak("run", write_strips(tmp_path, study=SHORT), "--quiet", "--out", tmp_path / "abaqus")
    theirs = json.loads((tmp_path / "abaqus" / "summary.json").read_text())
    for name, run in theirs["runs"].items():
        assert ours["runs"][name]["max_force"] == pytest.approx(run["max_force"], rel=1e-6)
        assert len(ours["runs"][name]["events"]) == len(run["events"])


def test_a_first_study_is_written_and_takes_the_deck(creak, tmp_path):
    lsdyna_study(tmp_path, strips())
    creak("new", tmp_path / "strips.k", "--units", "mm-t-s", "--out", tmp_path / "new.toml").done()
    written = (tmp_path / "new.toml").read_text(encoding="utf-8")
    assert 'deck = "strips.k"' in written
    assert "PART_2" in written or "LOWER" in written
    assert "ROOT_UPPER" in written or "SET_NODE_1" in written or "SPC.12456" in written


def test_what_changes_the_answer_stops_the_run(creak, tmp_path):
    study = lsdyna_study(tmp_path, strips("*INITIAL_STRESS_SHELL\n1,1,1\n"))
    said = creak("run", study)
    said.refuses(
        "*INITIAL_STRESS_SHELL is not read by creak and would change the answer", "--ignore 'INITIAL_STRESS_SHELL'"
    )
    assert creak("modes", tmp_path / "strips.k", "--ignore", "INITIAL_STRESS_SHELL", "--quiet").status == 0


def test_a_speed_at_the_start_that_is_not_read_stops_a_run_and_no_modes(creak, tmp_path):
    """Modes have none; a run would be another one without it."""
    study = lsdyna_study(tmp_path, strips("*INITIAL_VELOCITY_RIGID_BODY\n1,,,9.\n"))
    creak("run", study).refuses("creak reads *INITIAL_VELOCITY, _NODE and _GENERATION")
    assert creak("modes", tmp_path / "strips.k", "--quiet").status == 0


def test_damping_of_the_deck_is_that_of_the_run(creak, tmp_path):
    """alpha and beta of the deck are those that a study would give."""
    damped = "*DAMPING_GLOBAL\n0,5.\n*DAMPING_PART_STIFFNESS\n1,-2.e-6\n2,-2.e-6\n"
    given = lsdyna_study(tmp_path, strips(damped))
    deck = tmp_path / "deck.toml"
    deck.write_text(given.read_text().replace(CHANGES["[verification]"], "[verification]"))
    assert creak("screen", deck, "--quiet").status == 0
    assert (
        set_up(read_study(deck)).structure.rayleigh
        == set_up(read_study(given)).structure.rayleigh
        == Rayleigh(5.0, 2e-6)
    )


def test_damping_that_is_not_read_stops_a_study_without_damping(creak, tmp_path):
    """Not one that has its own; `creak new` writes one that has."""
    given = lsdyna_study(tmp_path, strips("*DAMPING_GLOBAL\n0,5.\n*DAMPING_PART_STIFFNESS\n1,.1\n"))
    assert "changes the answer: COEF above 0 is a share" in creak("info", tmp_path / "strips.k").words
    assert creak("screen", given, "--quiet").status == 0
    deck = tmp_path / "deck.toml"
    deck.write_text(given.read_text().replace(CHANGES["[verification]"], "[verification]"))
    said = creak("screen", deck)
    said.refuses(
        "*DAMPING_PART_STIFFNESS is not read by creak and would change the answer",
        "[damping] in a study stands in its place",
    )
    assert creak("new", tmp_path / "strips.k", "--units", "mm-t-s", "--out", tmp_path / "new.toml").status == 0
    written = (tmp_path / "new.toml").read_text(encoding="utf-8")
    assert "# Damping: creak does not read *DAMPING_PART_STIFFNESS of the deck.\n# 2 % of critical" in written
    assert "\n[damping]\n" in written
    assert "--ignore" not in written


def test_the_decks_own_analysis_is_refused(creak, tmp_path):
    lsdyna_study(tmp_path, strips())
    said = creak("run", tmp_path / "strips.k")
    said.refuses("creak does not run an LS-DYNA deck by its own controls")


def test_convert_to_abaqus(creak, tmp_path):
    lsdyna_study(tmp_path, strips())
    creak("convert", tmp_path / "strips.k", tmp_path / "other.inp").done()
    found = [
        creak("modes", tmp_path / name, "--count", 4, "--json", "-", "--quiet") for name in ("strips.k", "other.inp")
    ]
    ours, theirs = (json.loads(said.words)["frequencies"] for said in found)
    assert ours == pytest.approx(theirs, rel=1e-9)
