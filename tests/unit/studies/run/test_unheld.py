"""Structures that only contact holds: reductions of the whole run, or say why they cannot."""

from __future__ import annotations

from pathlib import Path

import pytest

from creak.errors import InputError
from creak.formats.decks import read_model
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up_model
from creak.studies.run.job import StudyResult, run_study
from helpers_decks import two_strips, write_strips

THROWN = "*INITIAL CONDITIONS, TYPE=VELOCITY\n" + "".join(f"{i}, 3, -100.\n" for i in range(1, 40)) + "*BOUNDARY\n"
DECK = two_strips().replace("ROOT_UPPER, 1, 2\nROOT_UPPER, 4, 6\n", "").replace("*BOUNDARY\n", THROWN)
FORCE = """[excitation.tip]
node_set = "TIP_UPPER"
dof = "z"
kind = "force"
signal = { type = "sine", frequency = 20, amplitude = 0.1 }
"""


def run(folder: Path, method: str, excitation: str = "") -> StudyResult:
    study = (
        '[model]\ndeck = "strips.inp"\n[contact.tip]\nsecondary = "UNDER"\nmain = "OVER"\n'
        f'{excitation}[reduction]\nmethod = "{method}"\nf_max = 1500\n[time]\nend = 0.01\n[reference]\nrun = false\n'
    )
    read = read_study(write_strips(folder, DECK, study))
    return run_study(set_up_model(read, read_model(read.places.sibling("strips.inp")), free=True), lambda *_: None)


def test_a_strip_thrown_freely_bounces_and_is_told_to_be_free(tmp_path):
    result = run(tmp_path, "gap-modes")
    assert result.runs["reduced"].events
    assert any("only contact holds the structure" in note for note in result.notes)


def test_a_force_on_it_is_refused_with_the_way_out(tmp_path):
    with pytest.raises(InputError, match=r"'gap-modes'.*only contact holds the structure.*craig-bampton"):
        run(tmp_path, "gap-modes", FORCE)
