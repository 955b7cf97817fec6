"""The sentence and the checks say what the numbers say."""

from dataclasses import replace

import pytest

from creak.report.text import UNITS
from creak.report.verdict import checks, moving_axes, sentence
from creak.studies.summary import summarise
from creak.verify.events import Event, EventMatch


def event(start: float, force: float) -> Event:
    return Event("tip", "tip:110", 0, start, start, start + 0.002, 1.5 * force, force, 0.001 * force, 30.0, 1)


@pytest.fixture
def with_events(result_of):
    """The two-plate study with made-up events in both runs."""
    result = result_of("both runs")

    def made(match: EventMatch):
        reference = [a for a, _ in match.pairs] + match.missed
        reduced = [b for _, b in match.pairs] + match.extra
        runs = {
            "reduced": replace(result.runs["reduced"], events=reduced),
            "reference": replace(result.runs["reference"], events=reference),
        }
        return replace(result, runs=runs, events=match, window=(0.02, 0.04))

    return made


def test_all_events_found_with_close_forces_pass(with_events):
    pairs = [(event(0.021, 100.0), event(0.0211, 101.0)), (event(0.03, 50.0), event(0.03, 51.0))]
    result = with_events(EventMatch(pairs, [], []))
    text = sentence(result, summarise(result), UNITS["mm-t-s"])
    assert text.startswith("2 rattle events in the last 0.02 s, the hardest 100 N at node 1; ")
    assert "the reduced model found both within 10 ms, mean force +1.3" in text
    status = [c.passed for c in checks(result, summarise(result))]
    assert status[2:5] == [True, True, True]


def test_missed_extra_and_wrong_forces_want_attention(with_events):
    pairs = [(event(0.021, 100.0), event(0.0211, 130.0))]
    result = with_events(EventMatch(pairs, [event(0.03, 10.0)], [event(0.035, 20.0)]))
    text = sentence(result, summarise(result), UNITS["mm-t-s"])
    assert "found 1 of 2 within 10 ms and 1 more, mean force +30.0" in text
    status = [c.passed for c in checks(result, summarise(result))]
    assert status[2:5] == [False, False, False]


def test_axes_without_motion_do_not_decide_the_fit(result_of):
    result = result_of("both runs")
    assert "z" in moving_axes(result)
    assert "y" not in moving_axes(result)
    assert "no motion along y" in checks(result, summarise(result))[1].found


def test_created_energy_wants_attention(result_of):
    result = result_of("both runs")
    summary = summarise(result)
    for created, passed in ((0.004, True), (0.006, False)):
        for run in summary["runs"].values():
            run["energy_created"] = created
        assert checks(result, summary)[-1].passed is passed


def test_nothing_to_check_is_neither_pass_nor_attention(result_of):
    result = result_of("unreduced only")
    status = [c.passed for c in checks(result, summarise(result))]
    assert status[:5] == [None] * 5
