"""What of a run counts in the odds is told where it is not all of it."""

from __future__ import annotations

import pytest

import creak
from creak.report.tables.robust import sentence
from helpers_decks import STUDY, write_strips

VARY = '[scatter.vary]\n"contact.tip.clearance" = { type = "uniform", low = 0.4, high = 0.6 }\n'
PERIODS = STUDY.replace("step = 5e-4\n", "").replace("f_min = 5", "f_min = 20").replace("period = 0.2", "period = 0.05")
PERIODS += VARY


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
