"""Rattling places: which channels belong together, and what is told of them."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from creak.api.result import Result
from creak.model.units import UNITS
from creak.report.figures.scene import animations, node_impulses
from creak.report.tables.events import event_csv, event_table, slips_in
from creak.report.tables.places import _settled, place_parts
from creak.report.words.terminal import run_rows, verification_rows
from creak.report.words.text import number
from creak.report.words.verdict import sentence
from creak.studies.file.eline_tables import LimitTable
from creak.studies.findings import places as module
from creak.studies.findings.gather import findings_of
from creak.studies.findings.limits import judged
from creak.studies.findings.places import find_places, place_of
from creak.studies.sweep.figures import flat_figures
from creak.verify.events import events_in, find_events
from creak.verify.matching import match_events
from creak.verify.slips import SlipEvent
from creak.verify.statistics import compare_statistics
from helpers_findings import summarised, to_draw


@pytest.fixture(scope="module")
def result(result_of):
    return result_of("both runs")


def struck(result, nodes, *, force=2.0):
    """The reduced run with one pulse of five samples at each of these nodes, inside the window."""
    run = result.runs["reduced"]
    h = run.history
    pulse, gap = np.zeros_like(h.force), np.abs(h.gap) + 0.1
    rows = np.flatnonzero(h.time >= result.window[0])[5:10]
    for k, node in enumerate(nodes):
        j = int(np.flatnonzero(result.gaps.nodes_idx == node)[0])
        pulse[rows, j] = force + k
        gap[rows, j] = -0.01
    return replace(run, history=replace(h, force=pulse, gap=gap))


def node(result, label):
    return int(np.flatnonzero(result.setup.model.nodes.ids == label)[0])


def test_nodes_of_one_element_are_one_place_and_others_are_not(result):
    # The upper strip has nodes 101 to 105 in its first row, 20 mm apart.
    near, far = [node(result, k) for k in (101, 102)], [node(result, k) for k in (104, 105)]
    places = find_places(result.scope, struck(result, near + far))
    assert [set(p.nodes_idx.tolist()) for p in places] == [set(far), set(near)]
    assert [p.number for p in places] == [1, 2]
    assert places[0].node_idx == far[1]
    assert [len(p.events) for p in places] == [1, 1]
    # 2, 3, 4, 5 N: the raw peak of the hardest channel of each place.
    assert [max(e.force_peak for e in p.events) for p in places] == [5.0, 3.0]


def test_a_chain_of_neighbours_is_one_place(result):
    places = find_places(result.scope, struck(result, [node(result, k) for k in (101, 102, 103, 104, 105)]))
    assert len(places) == 1
    assert places[0].nodes_idx.size == 5


def test_places_are_looked_for_once_for_each_run(result, monkeypatch):
    looked, find = [], module.find_events
    monkeypatch.setattr(module, "find_events", lambda h, *more: looked.append(h) or find(h, *more))
    fresh = replace(result, runs={name: replace(run) for name, run in result.runs.items()})
    first = summarised(fresh)
    assert summarised(replace(fresh, notes=[*fresh.notes])) == first
    assert len(looked) == len(fresh.runs) == 2
    # Another run, or another window, is looked at anew.
    run = fresh.runs["reduced"]
    find_places(fresh.scope, replace(run))
    find_places(replace(fresh.scope, window=(0.0, 0.5 * fresh.window[1])), run)
    assert len(looked) == 4


def test_places_share_all_events_of_a_contact_among_them(result):
    run = result.runs["reduced"]
    places = find_places(result.scope, run)
    total = sum(e.impulse for p in places for e in p.events)
    h = run.history
    inside = (h.time >= result.window[0]) & (h.time <= result.window[1])
    whole = float(h.weights[inside] @ h.force[inside].sum(axis=1))
    # An event that lasts beyond an end of the window counts as a whole or not at all.
    assert total == pytest.approx(whole, rel=0.2)
    assert places[0].force == max(p.force for p in places)
    for event in events_in(run.events, result.window):
        assert place_of(places, event) is not None


def test_a_hit_counts_whole_wherever_an_edge_of_the_window_cuts_it(result):
    """One rule for all figures: what touches at any time of the window counts, with all that it has."""
    run = struck(result, [node(result, 103)])
    t = run.history.time
    hit = find_events(run.history, result.gaps, f_max=result.setup.study.config.verification.f_max)
    run = replace(run, events=hit)
    (hit,) = hit
    length, whole = hit.t_end - hit.t_start, float((run.history.weights @ run.history.force).sum())
    assert whole > 0.0
    shares = np.linspace(-1.45, 2.45, 15)  # where the edge lies, in lengths of the hit from its start
    cuts = [(hit.t_start + s * length, t[-1]) for s in shares] + [(0.0, hit.t_start + s * length) for s in shares]
    limit = LimitTable(force=f"{0.5 * hit.force_place} N")
    inside = []
    for window in cuts:
        cut = replace(result, window=window, runs={"reduced": run, "reference": run}, events=None)
        summary = summarised(cut)
        (own,) = summary["runs"]["reduced"]["places"] or [None]
        counts = hit.t_end >= window[0] and hit.t_start <= window[1]
        inside.append(counts)
        assert (own is not None) == counts == bool(events_in(run.events, window))
        assert bool(judged(limit, summary)[0]["failed"]) == counts
        statistics = compare_statistics(run.events, run.events, window)
        assert statistics.count == (counts, counts)
        assert len(match_events(run.events, run.events, 1e-3, window).pairs) == counts
        _, sums = node_impulses(findings_of(cut), run, window)
        assert sums.sum() == pytest.approx(whole if counts else 0.0, rel=1e-12)
        if counts:
            assert own["impulse"] == pytest.approx(whole, rel=1e-12)
            assert (own["events"], own["force"], own["share"]) == (1, hit.force_place, pytest.approx(1.0, rel=1e-12))
    assert 0 < sum(inside) < len(cuts) == 30


def test_force_is_one_number_wherever_it_is_told(result):
    """That of the place, low-passed: in the sentence, the list, the tables, the CSV, on the terminal, in Python."""
    summary, units = summarised(result), UNITS["mm-t-s"]
    told, drawn = to_draw(result)
    force = max(p["force"] for p in summary["runs"]["reduced"]["places"])
    inside = events_in(result.runs["reduced"].events, result.window)
    assert force == pytest.approx(max(e.force_place for e in inside), rel=1e-9)
    word = number(force, 3)
    assert f"the hardest {word} N and" in sentence(told, summary, units)
    assert place_parts(told, summary, animations(told, drawn, units), units)["places"][0].force == word
    table = event_table(told, units)
    at = 4  # time, where, time apart, the unreduced model's force, that of the reduced one
    assert table.groups[1] == ("force, N", 3)
    assert word in [row[at] for row in table.rows]
    rows = [r for r in csv.DictReader(event_csv(told, units).splitlines()) if r["run"] == "reduced"]
    assert max(float(r["force_N"]) for r in rows) == pytest.approx(force, rel=1e-8)
    (terminal,) = [row for row in run_rows(summary) if row[0] == "hardest place: force"]
    assert float(terminal[1]) == pytest.approx(force, rel=1e-3)
    within = next(row for row in verification_rows(summary) if row[0] == "events with force within 5 %")
    small = sum(abs(b.force_place / a.force_place - 1.0) <= 0.05 for a, b in result.events.pairs)
    assert within[1] == f"{small} of {len(result.events.pairs)}"
    assert max(r["force"] for r in Result(result, told).events.rows()) == max(
        e.force_place for e in result.runs["reduced"].events
    )
    assert flat_figures(summary)["reduced.force"] == force


def test_nothing_touched_is_no_place(result):
    run = result.runs["reduced"]
    still = replace(run, history=replace(run.history, force=np.zeros_like(run.history.force)))
    assert find_places(result.scope, still) == ()


def test_csv_numbers_matched_events_alike(result):
    rows = list(csv.DictReader(event_csv(findings_of(result), UNITS["mm-t-s"]).splitlines()))
    for name in ("reduced", "reference"):
        assert len([r for r in rows if r["run"] == name]) == len(events_in(result.runs[name].events, result.window))
    matched = [r["match"] for r in rows if r["match"]]
    assert sorted(matched) == sorted(2 * [f"{k + 1}" for k in range(len(result.events.pairs))])
    first = events_in(result.runs["reduced"].events, result.window)[0]
    row = next(r for r in rows if r["run"] == "reduced")
    assert float(row["impulse_N_s"]) == pytest.approx(first.impulse, rel=1e-8)
    assert float(row["closing_speed_mm_per_s"]) == pytest.approx(first.closing_speed, rel=1e-8)


def test_a_place_may_only_squeak(result):
    """Channels that press all the time: no event begins in the window, but they stick and slip."""
    run, label = result.runs["reduced"], 102
    pressed = struck(result, [node(result, label)])
    h = pressed.history
    j = int(np.flatnonzero(h.force.any(axis=0))[0])
    force, gap = np.zeros_like(h.force), np.abs(h.gap) + 0.1
    force[:, j], gap[:, j] = 1.0, -0.01
    start = result.window[0] + 1e-3
    slip = SlipEvent(
        result.gaps.group[j], "", node(result, label), start, start + 1e-3, 0.1, 1.0, 1.0, ((start, start + 1e-3),)
    )
    end = result.window[1] + 1.0
    late = replace(slip, t_start=end, slips=((end, end + 1e-3),))
    squeaks = replace(run, history=replace(h, force=force, gap=gap), slips=(slip, late))
    places = find_places(result.scope, squeaks)
    assert [(p.events, p.slips, p.force, p.number) for p in places] == [((), (slip,), 0.0, 1)]
    rattles = replace(pressed, slips=(slip,))
    assert [(len(p.events), p.slips) for p in find_places(result.scope, rattles)] == [(1, (slip,))]


def test_a_chain_of_slips_is_shown_where_one_of_them_begins_in_the_window():
    chain = SlipEvent("trim", "trim:1", 0, 0.1, 0.7, 0.2, 1.0, 1.0, ((0.1, 0.2), (0.6, 0.7)))
    assert slips_in((chain,), (0.5, 1.0)) == [chain]
    assert slips_in((chain,), (0.25, 0.5)) == []


@pytest.mark.parametrize(
    ("to", "told"), [(0.013, "within 1.3\u202f%"), (1e-9, "below 0.001\u202f%"), (2.0, "not settled"), (None, "")]
)
def test_how_far_a_figure_has_settled_is_said_in_words_that_fit(to, told):
    assert _settled({"slips": 86, "settled_to": {"slips": to}}, "slips") == told
