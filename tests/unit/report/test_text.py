"""Numbers read as people write them.

Clips and supports of a study in the words of the page.
"""

from __future__ import annotations

import math

import pytest

from creak.model.units import UNITS
from creak.report.words.method import _clip, _connector, _support
from creak.report.words.text import (
    MINUS,
    NONE,
    THIN,
    fixed,
    four,
    number,
    percent,
    ratio,
    share,
    tidy,
    times,
    with_minus,
)
from creak.studies.file.contact_tables import ClipTable, ConnectorTable
from creak.studies.file.model_tables import SupportTable


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (14859, f"14{THIN}859"),
        (0.0123456, "0.01235"),
        (-2.5, f"{MINUS}2.500"),
        (1.2e-9, f"1.20e{MINUS}9"),
        (0.0, "0"),
        (99999.6, f"100{THIN}000"),
        (None, NONE),
        (math.nan, NONE),
        (math.inf, NONE),
    ],
)
def test_number(value, shown):
    assert number(value) == shown


def test_minus_signs_of_a_sentence_are_no_hyphens_and_names_keep_theirs():
    said = with_minus("LID-1 moves -0.4 mm (-2e-05 more), clip=-3, from 2-3 to panel-7")
    assert said == f"LID-1 moves {MINUS}0.4 mm ({MINUS}2e-05 more), clip={MINUS}3, from 2-3 to panel-7"


def test_per_cent_of_a_ratio():
    assert percent(1.005) == f"+0.5{THIN}%"
    assert percent(0.9) == f"{MINUS}10.0{THIN}%"
    assert percent(1.00001) == f"0.0{THIN}%"
    assert percent(None) == NONE


def test_a_value_below_its_bar_never_reads_as_the_bar():
    assert four(0.98999) == "0.9899"
    assert four(0.9999999) == "1.0000"
    assert four(0.99) == "0.9900"


def test_tiny_shares_are_bounds_and_written_numbers_stay_as_written():
    assert share(1e-10) == f"below 0.001{THIN}%"
    assert share(0.005) == f"0.50{THIN}%"
    assert tidy(10.0) == "10"
    assert tidy(0.0115) == "0.0115"
    assert tidy(-0.05) == f"{MINUS}0.05"
    assert fixed(-0.0004, 2) == "0.00"


def test_speed_ups_and_ratios():
    assert times(190.4) == "190 times"
    assert times(1.66) == "1.7 times"
    assert ratio(1.0, 0.0) is None
    assert ratio(3.0, 2.0) == 1.5


def test_clips_and_supports_are_told():
    stop = ClipTable(type="stop", nodes="TIP", axis=(0, 0, 1), stiffness=40.0, ageing=0.8)
    assert _clip(stop, UNITS["mm-t-s"]) == "stop, TIP to ground, stiffness 40 N/mm, 80 % left by age"
    pair = ClipTable(use="A-pillar", at=[(0, 0, 0)], parts=["FRAME", "PANEL"], axis=(0, 0, 1))
    assert _clip(pair, UNITS["mm-t-s"]) == "A-pillar of the library, FRAME to PANEL"
    assert _support(SupportTable(nodes="*", free=["z"])) == "*: z freed"
    assert _support(SupportTable(nodes="ROOT", free=["z"], hold=["x", "y"])) == "ROOT: z freed and x, y held"


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"dof": "z", "lower": -0.3, "stiffness": 40.0}, "A to B, z from −0.3 mm to free, stiffness 40 N/mm"),
        ({"dof": "rx", "upper": 0.1, "stiffness": 40.0}, "A to B, rx from free to 0.1 rad, stiffness 40 N mm/rad"),
        (
            {"axis": (0.0, 0.6, 0.8), "lower": 0.0, "stiffness": "hard", "friction": 0.3},
            "A to B, along (0, 0.6, 0.8) from 0 mm to free, hard, friction 0.3",
        ),
    ],
)
def test_a_connector_in_words(more, words):
    table = ConnectorTable.model_validate({"type": "play", "nodes": ["A", "B"], **more})
    assert _connector(table, UNITS["mm-t-s"]) == words
