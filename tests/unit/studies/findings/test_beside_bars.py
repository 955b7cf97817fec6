"""A change that alters a place by less than its bar is told as such."""

from __future__ import annotations

import pytest

from creak.studies.findings.spots import beside_bars


def cause(now: dict, *then: dict) -> dict:
    changes = [{"now": now, "predicted": t} for t in then]
    return {"words": "mode", "changes": changes, "changes_words": [f"change {k}" for k in range(len(then))]}


def test_a_small_change_is_told_as_one():
    told = beside_bars(cause({"n5": 10.0, "impulse": 1.0}, {"n5": 9.2, "impulse": 0.1}, {"n5": 5.0}), {"n5": 0.1})
    assert told["changes_words"] == ["change 0; within the uncertainty of the place, 10 %", "change 1"]


@pytest.mark.parametrize(("bar", "small"), [(0.2, True), (0.05, False), (None, False)])
def test_without_sound_the_impulse_decides(bar, small):
    told = beside_bars(cause({"n5": None, "impulse": 1.0}, {"n5": None, "impulse": 0.9}), {"n5": 0.9, "impulse": bar})
    assert ("uncertainty" in told["changes_words"][0]) is small


def test_nothing_is_said_where_nothing_is_told():
    assert beside_bars(None, {"n5": 0.1}) is None
    assert beside_bars({"words": "mode"}, {"n5": 0.1}) == {"words": "mode"}
    same = cause({"n5": 10.0}, {"n5": None})
    assert beside_bars(same, {"n5": 0.5}) == same
