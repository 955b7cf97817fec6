"""The sentence and the checks say what the numbers say."""

from dataclasses import replace

import numpy as np
import pytest

from creak.model.units import UNITS
from creak.report.tables.checks import checks, moving_axes
from creak.report.words.text import THIN
from creak.report.words.verdict import penetration, sentence, warnings
from creak.studies.findings.gather import findings_of
from creak.verify.events import Event
from creak.verify.matching import EventMatch
from helpers_findings import summarised


def event(start: float, force: float) -> Event:
    return Event("tip", "tip:110", 0, start, start, start + 0.002, 1.5 * force, force, 0.001 * force, 30.0, 1, force)


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
    text = sentence(result, summarised(result), UNITS["mm-t-s"])
    assert text.startswith(
        "2 rattle events in the last 0.02 s, the hardest 101 N and 0.101 N s around node 1, closing at 30.0 mm/s; "
    )
    assert "the reduced model found both within 12.5 ms, mean force +1.3" in text
    apart = summarised(result)
    apart["runs"]["reduced"]["places"] = [{"force": 51.0}, {"force": 50.0}]
    told = sentence(result, apart, UNITS["mm-t-s"])
    assert "the hardest 101 N at several places together and 0.101 N s around node 1" in told
    status = [c.passed for c in checks(result, summarised(result))]
    assert status[2:5] == [True, True, True]


def test_missed_extra_and_wrong_forces_want_attention(with_events):
    pairs = [(event(0.021, 100.0), event(0.0211, 130.0))]
    result = with_events(EventMatch(pairs, [event(0.03, 10.0)], [event(0.035, 20.0)]))
    text = sentence(result, summarised(result), UNITS["mm-t-s"])
    assert "found 1 of 2 within 12.5 ms and 1 more, mean force +30.0" in text
    status = [c.passed for c in checks(result, summarised(result))]
    assert status[2:5] == [False, False, False]


def test_axes_without_motion_do_not_decide_the_fit(result_of):
    result = result_of("both runs")
    assert "z" in moving_axes(result)
    assert "y" not in moving_axes(result)
    assert "no motion along y" in checks(result, summarised(result))[1].found


def test_created_energy_wants_attention(result_of):
    result = result_of("both runs")
    summary = summarised(result)
    for created, passed in ((0.004, True), (0.006, False)):
        for run in summary["runs"].values():
            run["energy_created"] = created
        assert checks(result, summary)[-1].passed is passed


def test_nothing_to_check_is_neither_pass_nor_attention(result_of):
    result = result_of("unreduced only")
    status = [c.passed for c in checks(findings_of(result), summarised(result))]
    assert status[:5] == [None] * 5


def test_created_energy_is_said_in_the_first_sentence(result_of):
    result = result_of("both runs")
    summary = summarised(result)
    assert "Do not rely on it" not in sentence(result, summary, UNITS["mm-t-s"])
    summary["runs"]["reference"]["energy_created"] = 0.02
    text = sentence(result, summary, UNITS["mm-t-s"])
    assert "Do not rely on it: the unreduced run created 2.0" in text


# --- chaotic motion -------------------------------------------------------------------------------------------------


def many(count: int, scale: float, seed: int) -> list[Event]:
    rng = np.random.default_rng(seed)
    starts = np.sort(rng.uniform(0.02, 0.04, count))
    return [event(t, f) for t, f in zip(starts.tolist(), rng.exponential(scale, count).tolist(), strict=True)]


@pytest.mark.parametrize(("scale", "alike"), [(5.0, True), (50.0, False)])
def test_chaotic_motion_is_judged_by_its_statistics(with_events, scale, alike):
    """200 events in 20 ms, none of them in common: rate and distributions decide, and the words say why."""
    result = with_events(EventMatch([], many(200, 5.0, 1), many(195, scale, 2)))
    found = checks(result, summarised(result))
    assert [c.passed for c in found[2:5]] == [None] * 3
    assert all("motion is chaotic" in c.found for c in found[2:5])
    assert [c.name for c in found[5:8]] == [
        "Event rate",
        "Distribution of the event force",
        "Distribution of the event impulse",
    ]
    assert [c.passed for c in found[5:8]] == [True, alike, alike]
    assert found[-1].name == "Energy created by the integration"
    assert any("chaotic" in text and "statistics" in text for text in warnings(findings_of(result)))
    assert "motion is chaotic: 9" in sentence(result, summarised(result), UNITS["mm-t-s"])  # 9 750 per second


def test_few_events_are_judged_one_by_one(with_events):
    result = with_events(EventMatch([(event(0.021, 100.0), event(0.0211, 101.0))], [], []))
    assert len(checks(result, summarised(result))) == 6
    assert not any("chaotic" in text for text in warnings(findings_of(result)))


# --- penetration ----------------------------------------------------------------------------------------------------


def with_history(result, **changes):
    run = result.runs["reduced"]
    return replace(result, runs={**result.runs, "reduced": replace(run, history=replace(run.history, **changes))})


def test_penetration_is_held_against_the_clearance(result_of):
    result = result_of("both runs")
    h = result.runs["reduced"].history
    clearance = float(result.gaps.gap0.mean())
    view = findings_of(result)
    run = view.runs["reduced"]
    found = penetration(view, run, "tip")
    assert found is not None
    assert found.smallest == pytest.approx(h.gap.min(), rel=6e-8)  # half a digit of single precision
    assert found.of_clearance == pytest.approx(max(0.0, -h.gap.min()) / clearance, rel=6e-8)
    shallow = np.maximum(h.gap, 0.0)
    deep = shallow.copy()
    deep[10, 0] = -0.3 * clearance
    text = f"penetrate each other by 30{THIN}% of the clearance"
    assert any(text in t for t in warnings(findings_of(with_history(result, gap=deep))))
    assert not any("penetrate" in t for t in warnings(findings_of(with_history(result, gap=shallow))))
    forced = result.setup.study.config.time
    assert not forced.exact
    for time, fix in (
        (forced, "A shorter step"),
        (forced.model_copy(update={"integrator": "exact"}), "Raise its stiff"),
    ):
        setup = result.setup.with_tables(time=time)
        pressed = findings_of(replace(with_history(result, gap=deep), setup=setup))
        assert any(fix in t for t in warnings(pressed) if "penetrate" in t)
    assert penetration(view, run, "no such contact") is None
