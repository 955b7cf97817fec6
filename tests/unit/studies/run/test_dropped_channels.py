"""What the linear pre-check drops is watched: a strip thrown into a third is caught, and the run made again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import creak
from creak.studies.file.config import PrecheckTable
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run import precheck
from creak.studies.run.job import StudyResult, run_study
from creak.studies.run.precheck import prechecked
from creak.verify.reliability import reasons_against
from helpers_core import channels
from helpers_decks import STEEL, strip, write_strips
from helpers_decks import STUDY as TWO
from helpers_findings import summarised

RECORDED = {"section": "contact"}

DECK = (
    "*HEADING\nthree strips\n"
    + strip(1, 1, "UPPER", 1.5, n=6)
    + strip(1001, 1001, "LOWER", 0.0, n=6)
    + strip(2001, 2001, "THIRD", -2.5, n=6)
    + STEEL
    + "".join(f"*SHELL SECTION, ELSET={name}, MATERIAL=STEEL\n1.0,\n" for name in ("UPPER", "LOWER", "THIRD"))
    + "*SURFACE, NAME=UNDER\nUPPER, SNEG\n*SURFACE, NAME=OVER\nLOWER, SPOS\n"
    + "*SURFACE, NAME=BELOW\nLOWER, SNEG\n*SURFACE, NAME=FLOOR\nTHIRD, SPOS\n"
    + "*BOUNDARY\nROOT_LOWER, 1, 6\nROOT_THIRD, 1, 6\nROOT_UPPER, 1, 2\nROOT_UPPER, 4, 6\n"
)
STUDY = """
[model]
deck = "strips.inp"

[contact.tip]
secondary = "UNDER"
main = "OVER"

[contact.back]
secondary = "BELOW"
main = "FLOOR"

[excitation.root]
node_set = "ROOT_UPPER"
dof = "z"
kind = "displacement"
signal = { type = "sine", frequency = 50, amplitude = 0.8 }

[reduction]
f_max = 1500

[precheck]
margin = 0.2

[time]
end = 0.08

[reference]
run = false
"""
"""In the linear run the lower strip is at rest: nothing touches it."""


def run(folder: Path, study: str = STUDY) -> StudyResult:
    return run_study(set_up(read_study(write_strips(folder, DECK, study))), lambda *_: None)


@pytest.fixture(scope="module")
def thrown(tmp_path_factory) -> StudyResult:
    return run(tmp_path_factory.mktemp("thrown"))


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> StudyResult:
    return run(tmp_path_factory.mktemp("whole"), STUDY.replace("margin = 0.2", "enabled = false"))


def test_a_strip_thrown_into_a_third_is_caught(thrown, whole, measured):
    """It hits when and as hard as with every channel kept from the start; how the blows part is a matter of microseconds."""
    first = [min(e.t_start for e in r.runs["reduced"].events if e.group == "back") for r in (thrown, whole)]
    measured("strip thrown into a third: first hit", *first, abs=1e-6, unit="s", source="every channel kept")
    a, b = (r.runs["reduced"].history for r in (thrown, whole))
    assert (a.weights @ a.force).sum() == pytest.approx((b.weights @ b.force).sum(), rel=0.02)
    assert a.extremes.gap.min() > 0.0


def test_it_is_told_and_counted(thrown):
    (note,) = [n for n in thrown.notes if "let stay open closed in the nonlinear one" in n]
    assert "farthest back:" in note
    assert "the run was made again with" in note
    counts = summarised(thrown)["precheck"]
    assert 0 < counts["closed_later"] <= counts["kept"] < counts["candidates"]
    assert reasons_against(thrown.runs["reduced"].history) == []


def test_what_still_closes_in_the_last_run_is_a_red_verdict(tmp_path, monkeypatch):
    monkeypatch.setattr(precheck, "MOST_RUNS", 1)
    result = run(tmp_path)
    out = summarised(result)
    assert out["runs"]["reduced"]["verdict"] == "unreliable"
    (reason,) = out["runs"]["reduced"]["reasons"]
    assert "parts pass through each other" in reason
    assert any("parts pass through each other" in w for w in out["warnings"])


def test_the_unreduced_model_alone_is_watched_too(tmp_path):
    forced = 'end = 0.03\nintegrator = "hht"\nstep = 1e-4'
    study = STUDY.replace("f_max = 1500", 'method = "none"').replace("end = 0.08", forced)
    result = run(tmp_path, study)
    assert result.closed_later > 0
    assert any(e.group == "back" for e in result.runs["reference"].events)


def test_a_gap_that_shrinks_from_period_to_period_is_kept(tmp_path):
    """Six periods at the resonance of the upper strip: nothing comes within the margin yet."""
    short = STUDY.replace("frequency = 50", "frequency = 59.07").replace("amplitude = 0.8", "amplitude = 0.01")
    short = short.replace("margin = 0.2", "margin = 0.01").replace("end = 0.08", "periods = 6")
    short += "[damping]\nmodal = 0.01\n"
    result = run(tmp_path, short)
    assert result.runs["reduced"].history.gap.min() > 0.25
    verdict = summarised(result)["runs"]["reduced"]
    assert verdict["verdict"] == "unsettled"
    assert "may close in a longer run" in verdict["reasons"][0]
    long = run(tmp_path, short.replace("periods = 6", "periods = 80"))
    assert long.runs["reduced"].events


@pytest.mark.parametrize(("smallest", "tested", "kept", "told"), [
    ([2.0, 0.0, 2.0], "b", [1, 2], 1), ([2.0, 2.0, 2.0], "a", [0, 1], 2),
    ([2.0, 0.0, 2.0], "a", [1], 0), ([0.0, 2.0, 2.0], "", [0], 0),
])  # fmt: skip
def test_a_contact_that_a_test_asks_for_keeps_its_channels(smallest, tested, kept, told):
    """Where none of them closes; one that closes has those that do."""
    table, gaps = PrecheckTable(margin=0.5), channels(np.eye(3), 2.0, 1e3)
    gaps = replace(gaps, names=("A:1", "A:2", "B:3"), group=("A", "A", "B"))
    found, notes = prechecked(table, gaps, np.array(smallest), "mm", {tested})
    assert found.names == tuple(gaps.names[k] for k in kept)
    assert "(linear gap falls to 0.5 mm or less)" in notes[0]
    assert [f"{told} channels that cannot close are kept" in n for n in notes].count(True) == bool(told)


def test_nothing_closes_nothing_is_run_again(thrown):
    setup, gaps, h = thrown.setup, thrown.gaps, thrown.runs["reduced"].history
    every = setup.study.config.precheck, setup.contacts, setup.connectors, "mm"
    assert precheck.with_closed(*every, gaps, h) is None
    assert h.extremes.gap.size == setup.contacts.m - (gaps.m - setup.connectors.m)
    assert np.isfinite(h.extremes.gap_at).all()
    assert precheck.with_closed(*every, gaps, replace(h, extremes=None)) is None


@pytest.mark.parametrize("accuracy", ["settled", "quick"])
@pytest.mark.parametrize("kept", [False, True])
def test_a_run_in_which_nothing_touches_needs_no_proof(tmp_path, accuracy, kept):
    """Without the unreduced model: settled where no channel is kept, and where those that are kept stay open in repeats."""
    far = TWO.replace('method = "surface', 'clearance = 0.75\nmethod = "surface')
    text = far.replace("step = 5e-4\nperiods = 2", f'accuracy = "{accuracy}"\nend = 0.05')
    watched = "[precheck]\nenabled = false\n" if kept else ""
    found = creak.run(write_strips(tmp_path, study=f'{text}[reference]\nrun = "none"\n{watched}')).summary
    run = found["runs"]["reduced"]
    assert bool(found["precheck"]["kept"]) == kept
    assert not run["events"]
    if kept and accuracy == "quick":  # not repeated
        assert "verdict" not in run
        assert run["reasons"] == ["not checked: it was not repeated with other settings of the run"]
    else:
        assert (run["verdict"], run["reasons"]) == ("settled", [])
