"""Sobol indices of draws of which too few rattle, or too few do not, are left out with a note; bounds are shares.

What of a run counts in the odds is told where it is not all of it.
"""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.odds import DECK, STOPPED_BEAM

import creak
from creak.report.tables.robust import sentence
from creak.studies.robust.findings import SHOWN, _valid
from creak.verify.odds import Index, sobol_index
from helpers_decks import STUDY, write_strips, write_study

VARY = """[scatter.vary]
"connector.0.upper" = { type = "normal", mean = 16.0, sigma = 1.5 }
"excitation.tip.signal.amplitude" = { type = "uniform", low = 0.4, high = 0.9 }
"""


def test_indices_of_few_hits_are_left_out(tmp_path):
    found = creak.robust(write_study(tmp_path, STOPPED_BEAM + VARY, {"beam.inp": DECK}), 32, threads=1)
    assert 0 < found.rattle.hits < 10
    assert found.as_dict()["indices"] == {}
    (note,) = (n for n in found.notes if n.startswith("Sobol indices"))
    assert note.startswith("Sobol indices of rattle, events, impulse and force are left out: ")
    assert f"{found.rattle.hits} of 32 draws rattle" in note
    assert "most of the scatter" not in sentence(found)
    assert found.tornado["force"]


@pytest.mark.parametrize(
    ("hits", "kept"),
    [(0, ()), (9, ()), (10, SHOWN), (54, SHOWN), (55, ("events", "impulse", "force")), (64, SHOWN[1:])],
)
def test_which_indices_hold(hits, kept):
    """All figures are zero in draws that do not rattle; what does not is counted in the odds alone."""
    of = {name: {"key": Index(0.5, (0.4, 0.6), 0.5, (0.4, 0.6))} for name in SHOWN}
    valid, notes = _valid(of, np.arange(64) < hits)
    assert tuple(valid) == kept
    assert len(notes) == (len(kept) < len(SHOWN))
    assert _valid({}, np.zeros(64)) == ({}, [])


def test_shares_and_their_bounds_lie_between_none_and_all():
    """Of f(a) + noise of few draws: an estimate of a first index may fall below 0, one of a total above 1."""
    random, ends = np.random.default_rng(2), []
    for _ in range(100):
        A, B = random.random((2, 8)) < 0.3
        mixed = random.random(8) < 0.3
        index = sobol_index((A.astype(float), B.astype(float), mixed.astype(float)))
        if index is not None:
            assert 0.0 <= index.first_bounds[0] <= index.first <= index.first_bounds[1] <= 1.0
            assert 0.0 <= index.total_bounds[0] <= index.total <= index.total_bounds[1] <= 1.0
            ends += [*index.first_bounds, *index.total_bounds]
    assert {0.0, 1.0} <= {*ends}


SPREAD = '[scatter.vary]\n"contact.tip.clearance" = { type = "uniform", low = 0.4, high = 0.6 }\n'
PERIODS = STUDY.replace("step = 5e-4\n", "").replace("f_min = 5", "f_min = 20").replace("period = 0.2", "period = 0.05")
PERIODS += SPREAD


def test_odds_of_the_last_period_say_so(tmp_path):
    """Two periods of .05 s, of which the second counts."""
    found = creak.robust(write_strips(tmp_path, None, PERIODS), 4, indices=False, threads=1)
    assert " of 4 draws (what touches from 0.05 to 0.1 s of 0.1 s counts)" in sentence(found)
    assert found.as_dict()["window"] == pytest.approx([0.05, 0.1])


def test_odds_of_a_whole_run_need_no_word(tmp_path):
    text = PERIODS.replace("periods = 2", "end = 0.02")
    found = creak.robust(write_strips(tmp_path, None, text), 4, indices=False, threads=1)
    assert "counts" not in sentence(found)
    assert found.as_dict()["window"] == pytest.approx([0.0, 0.02])
