"""Repeated runs with other steps, stiffness and modes: what has settled, and what is said of it."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from creak.contact.laws.parameters import Curves
from creak.dynamics.history import Diverged
from creak.errors import InputError
from creak.model.units import UNITS
from creak.report.tables.convergence import event_table as settling_table
from creak.report.tables.events import event_csv, event_table
from creak.studies.converge import repeats as module
from creak.studies.converge.compared import assess
from creak.studies.converge.repeats import converge, repeated_setup, scaled_contact
from creak.studies.converge.settled import _of_convergence, _of_repeats, is_chaotic, settled_to
from creak.studies.converge.settling import (
    BASE,
    FINER,
    HALF,
    HARDER,
    LAST_TWO,
    LEAST,
    MORE_MODES,
    QUARTER,
    SETTLED,
    SOFTER,
    STIFFER,
    TENFOLD,
    TWICE,
    YIELDING,
    Outcome,
    Repeat,
)
from creak.studies.converge.words import as_dict, csv_rows, findings
from creak.studies.file.reader import read_study
from creak.studies.findings.gather import findings_of
from creak.studies.findings.save import save_convergence
from creak.studies.prepare.setup import set_up
from creak.studies.run import one_run as running
from creak.studies.run.job import run_study
from creak.verify.events import Event
from creak.verify.matching import FIGURES, change
from creak.verify.rubbing import Pressing, Rub
from helpers_decks import STOP, STUDY, stop_study, write_strips
from helpers_findings import summarised

OMEGA = math.sqrt(1.01e6 / 100.0)
"""Of the mass while it presses: half a period of contact, F = K v / omega, then the spring brings it back."""


def silent(*_):
    pass


def solved(folder, study, deck=None):
    return run_study(set_up(read_study(write_strips(folder, deck=deck, study=study))), silent)


def event(t, force=1.0, impulse=1e-3, duration=2e-3, speed=5.0):
    return Event("c", "c:1", 0, t, t + 0.5 * duration, t + duration, force, force, impulse, speed, 1, force)


def outcomes(stopped=(), **events):
    """Outcomes of runs named by their families' letters: base, h2, h4, k2, k10, f."""
    names = {"base": BASE, "h2": HALF, "h4": QUARTER, "k2": TWICE, "k10": TENFOLD, "f": MORE_MODES}
    family = {name: key for key, pair in list(LAST_TWO.items()) for name in pair if name != BASE} | {BASE: ""}
    out = {}
    for key, found in events.items():
        name = names[key]
        early = key in stopped
        out[name] = Outcome(
            Repeat(name, family[name], 1e-3),
            tuple(found),
            sum(e.impulse for e in found),
            0.0,
            0.01,
            1000,
            0.15 if early else 1.0,
            0.1,
            f"{name} run: diverged" if early else None,
        )
    return out


@pytest.fixture(scope="module")
def strips(tmp_path_factory):
    return solved(
        tmp_path_factory.mktemp("strips"), STUDY.replace("periods = 2", "periods = 1") + "\n[reference]\nrun = false\n"
    )


@pytest.fixture(scope="module")
def repeated(strips):
    return converge(strips, silent)


@pytest.fixture(scope="module")
def brief(tmp_path_factory):
    """The first half of a period, with one blow."""
    study = STUDY.replace("periods = 2", "end = 0.1") + "\n[reference]\nrun = false\n"
    return solved(tmp_path_factory.mktemp("brief"), study)


# --- a case that settles, one that does not --------------------------------------------------------------------------


def test_mass_on_a_stop_settles_to_the_exact_blow(tmp_path):
    """Trapezoidal rule, omega h = 0.05 at h: period and force are off by (omega h)^2 / 12 = 2e-4, far below 5 %."""
    c = converge(solved(tmp_path, stop_study(5e-4, 0.1), STOP), silent)
    assert list(c.outcomes) == [BASE, HALF, QUARTER]  # a connector, and nothing reduced: only the step varies
    assert c.model == "reference"
    first = c.events[0]
    assert first.settled
    assert first.figures["force"].settled_to < 1e-3 + LEAST["force"]
    assert first.figures["force"].values[QUARTER] == pytest.approx(1e6 / OMEGA, rel=1e-3)
    assert first.figures["duration"].values[QUARTER] == pytest.approx(math.pi / OMEGA, rel=1e-3)
    assert c.totals["impulse"].settled
    assert any("connectors" in text for text in c.notes)


def test_a_coarse_step_does_not_settle(tmp_path):
    """omega h = 6, 3, 1.5: one or two instants in contact; exact is 2 K v / omega^2 = 198 N s."""
    c = converge(solved(tmp_path, stop_study(0.06, 0.48), STOP), silent)
    first = c.events[0]
    assert not first.settled
    assert not first.figures["impulse"].settled
    assert first.figures["impulse"].worst == "step"
    values = first.figures["impulse"].values
    assert first.figures["impulse"].base_error == pytest.approx(values[BASE] / values[QUARTER] - 1.0)
    assert first.figures["impulse"].base_error > SETTLED
    assert any("shorter [time] step" in text for text in findings(c))


# --- the runs that are made ------------------------------------------------------------------------------------------


def test_every_family_is_run_on_the_same_time_and_channels(strips, repeated):
    h = strips.setup.study.config.time.step
    assert list(repeated.outcomes) == [BASE, HALF, QUARTER, TWICE, TENFOLD, MORE_MODES]
    made = {name: (o.repeat.step / h, o.repeat.stiffness, o.modes, o.steps) for name, o in repeated.outcomes.items()}
    n, kept = strips.setup.loads.n_step, strips.reduced.modes
    more = sum(max(3, math.ceil(r.system.stats.modes / 2)) for r in strips.reduced.superelements)
    assert repeated.outcomes[MORE_MODES].modes >= kept + more
    assert made == {
        BASE: (1.0, 1.0, kept, n),
        HALF: (0.5, 1.0, kept, 2 * n),
        QUARTER: (0.25, 1.0, kept, 4 * n),
        TWICE: (0.25, 2.0, kept, 4 * n),
        TENFOLD: (0.25, 10.0, kept, 4 * n),
        MORE_MODES: (1.0, 1.0, repeated.outcomes[MORE_MODES].modes, n),
    }
    end = float(strips.setup.loads.time[-1])
    assert [o.end for o in repeated.outcomes.values()] == pytest.approx([end] * 6, rel=1e-12)
    assert repeated.families == {name: LAST_TWO[name] for name in ("step", "stiffness", "modes")}


def test_the_base_run_is_that_of_the_study(strips, repeated):
    summary = summarised(strips)["runs"]["reduced"]
    base = as_dict(repeated)["runs"][BASE]
    assert base["impulse_total"] == summary["impulse_total"]
    assert base["max_force_filtered"] == max(e["force_place"] for e in summary["events"])
    assert len(repeated.events) == sum(strips.window[0] <= e["t_start"] <= strips.window[1] for e in summary["events"])


def test_refinement_changes_what_the_names_say(strips, repeated):
    """A run repeated at h/2 is that of a study with half the step and the base run's contact stiffness."""
    setup = repeated_setup(strips.setup, Repeat(HALF, "step", 2.5e-4, f_max=3000.0), 1)
    again = running.march_run("again", setup.marching, setup.observed(strips.gaps), strips.reduced, strips.gaps, silent)
    assert tuple(again.events) == repeated.outcomes[HALF].events
    assert setup.loads.time[-1] == strips.setup.loads.time[-1]
    np.testing.assert_allclose(setup.loads.support[0, ::2], strips.setup.loads.support[0], rtol=0, atol=1e-12)
    assert again.history.output_index.tolist() == list(range(0, 801, 2))  # the output interval of the base run


def test_contact_stiffness_and_curves_are_scaled_hard_ones_are_not(strips):
    gaps = strips.gaps
    curves = Curves(np.zeros(gaps.m, dtype=np.int64), gaps.area.copy(), (np.array([[0.0, 0.0], [1.0, 2.0]]),))
    k = gaps.stiffness.copy()
    k[0] = np.inf
    channels = np.arange(0, gaps.m, 2)
    scaled = scaled_contact(replace(gaps, stiffness=k, curves=curves), channels, 10.0)
    by = np.where(np.arange(gaps.m) % 2, 1.0, 10.0)
    np.testing.assert_array_equal(scaled.stiffness, k * by)
    assert np.isinf(scaled.stiffness[0])
    np.testing.assert_array_equal(scaled.curves.scale, gaps.area * by)


def test_hard_contact_and_guyan_leave_out_what_they_do_not_have(strips):
    c = strips.setup.study.config
    config = c.model_copy(update={"reduction": c.reduction.model_copy(update={"method": "guyan"})})
    base, hard = Repeat(BASE, "", c.time.step), replace(strips.gaps, stiffness=np.full(strips.gaps.m, np.inf))
    repeats, notes = module.plan(base, c.contact, hard, strips.setup.connectors, exact=False)
    assert [v.name for v in repeats] == [HALF, QUARTER]
    assert not module.with_modes(base, config.reduction, strips.reduced)[0]
    for word in (f"{strips.gaps.m} hard channels", "no contact has a stiffness"):
        assert any(word in note for note in notes)
    assert "Guyan" in module.not_looked_at(config.reduction, strips.reduced)[0]


def test_the_spring_that_stands_for_hard_contact_is_halved_and_doubled(strips):
    c, base = strips.setup.study.config, Repeat(BASE, "", strips.setup.study.config.time.step)
    hard = {"tip": c.contact["tip"].model_copy(update={"stiffness": "hard"})}
    gaps = replace(strips.gaps, stiffness=np.full(strips.gaps.m, np.inf))
    repeats, _ = module.plan(base, hard, gaps, strips.setup.connectors, exact=True)
    varied = {r.name: r for r in repeats if r.judged}
    assert {*varied} == {FINER, YIELDING, HARDER}
    factors = [module.repeated_setup(strips.setup, r, 1).marching.resolution.hard for r in varied.values()]
    assert factors == [strips.setup.marching.resolution.hard * r.harder for r in varied.values()]
    assert sorted(r.harder for r in varied.values()) == [0.5, 1.0, 2.0]
    both = hard | {"seal": c.contact["tip"].model_copy(update={"stiffness": "auto"})}
    mixed = replace(strips.gaps, stiffness=np.where(np.arange(gaps.m) % 2, np.inf, strips.gaps.stiffness))
    repeats, _ = module.plan(base, both, mixed, strips.setup.connectors, exact=True)
    assert {r.name for r in repeats if r.judged} == {FINER, SOFTER, STIFFER, YIELDING, HARDER}


def test_only_what_creak_chose_is_varied_where_others_are_given(strips):
    c, half = strips.setup.study.config, strips.gaps.m // 2
    group = ("tip",) * half + ("seal",) * (strips.gaps.m - half)
    gaps, tip = replace(strips.gaps, group=group), c.contact["tip"]
    tables = {"tip": tip.model_copy(update={"stiffness": "auto"}), "seal": tip.model_copy(update={"stiffness": 7.0})}
    np.testing.assert_array_equal(module._scaled(gaps, tables), np.arange(half))
    both = {"tip": tables["seal"], "seal": tables["seal"]}
    np.testing.assert_array_equal(module._scaled(gaps, both), np.arange(gaps.m))


@pytest.mark.parametrize(
    ("given", "own"),
    [({"stiffness": "auto"}, False), ({"stiffness": 50.0}, True), ({"overclosure": [(0, 0), (1, 9)]}, True)],
)
def test_only_a_stiffness_that_creak_chose_is_judged(given, own, strips):
    c = strips.setup.study.config
    table = c.contact["tip"].model_copy(update={"stiffness": "auto", **given})
    base = Repeat(BASE, "", c.time.step)
    repeats, notes = module.plan(base, {"tip": table}, strips.gaps, strips.setup.connectors, exact=False)
    judged = {v.name: v.judged for v in repeats}
    assert judged[TWICE] is judged[TENFOLD] is not own
    assert judged[HALF]
    assert (module.GIVEN in notes) == own


def test_runs_side_by_side_are_those_one_by_one(brief, monkeypatch):
    found = []
    for threads in (1, 3):
        monkeypatch.setattr(module, "cores", lambda threads=threads: threads)
        found.append(converge(brief, silent).outcomes)
    one, three = found
    assert list(one) == list(three)
    assert all(o.events == three[name].events != () for name, o in one.items())


def test_where_memory_is_short_runs_march_one_by_one(brief, monkeypatch):
    """Each holds twice its histories while it puts them together."""
    asked = []

    def counted(work, items, most, halt):
        asked.append(most)
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "at_once", counted)
    monkeypatch.setattr(module, "cores", lambda: 4)
    each = 2.0 * brief.runs["reduced"].history.nbytes
    for free in (9.0 * each, 2.5 * each, 0.1 * each):
        monkeypatch.setattr(module, "free_bytes", lambda free=free: free)
        with pytest.raises(KeyboardInterrupt):
            converge(brief, silent)
    assert asked == [4, 2, 1]
    history = brief.runs["reduced"].history
    assert history.nbytes >= history.gap.nbytes + history.force.nbytes


def test_an_interruption_ends_those_that_are_under_way(brief, monkeypatch):
    """Ctrl-C reaches the calling thread alone: the others end where they next tell how far they are."""
    ended = []

    def interrupted(work, items, most, halt):
        halt()
        for item in items:
            with pytest.raises(KeyboardInterrupt) as end:
                work(item)
            ended.append(end)
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "at_once", interrupted)
    with pytest.raises(KeyboardInterrupt):
        converge(brief, silent)
    assert len(ended) > 1


# --- runs that stop --------------------------------------------------------------------------------------------------


def test_a_run_that_stops_is_reported_and_the_rest_goes_on(strips, repeated, monkeypatch):
    whole = running.integrate

    def until_0_15(marching, system, gaps, *options):
        history, *rest = whole(marching, system, gaps, *options)
        if marching.table.step > 1.3e-4 or gaps.stiffness[0] > strips.gaps.stiffness[0]:
            return history, *rest
        n = int(np.searchsorted(history.time, 0.15))
        cut = replace(
            history, time=history.time[:n], gap=history.gap[:n], force=history.force[:n], energy=history.energy[:n]
        )
        raise Diverged(float(history.time[n]), cut)

    monkeypatch.setattr(running, "integrate", until_0_15)
    c = converge(strips, silent)
    assert [name for name, o in c.outcomes.items() if o.stopped] == [QUARTER]
    assert c.outcomes[QUARTER].end == pytest.approx(0.15, abs=2e-4)
    for name in (HALF, TWICE, TENFOLD, MORE_MODES):
        assert c.outcomes[name].events == repeated.outcomes[name].events
    before = [e for e in c.events if e.event.t_end < 0.14]
    after = [e for e in c.events if e.event.t_start > 0.155]
    assert before
    assert after
    whole_run = {e.event.t_start: e for e in repeated.events}
    found = [QUARTER in e.figures["force"].values for e in before]
    assert found == [QUARTER in whole_run[e.event.t_start].figures["force"].values for e in before]
    assert any(found)
    assert all(f"{QUARTER} stopped before" in e.problem and not e.settled for e in after)
    assert not c.totals["impulse"].settled
    assert any("h/4 run: the motion is no longer finite" in text for text in findings(c))


def test_a_run_that_cannot_be_made_says_why(brief, monkeypatch):
    def refuse(*_):
        raise InputError("no such modes")

    monkeypatch.setattr(module, "with_more_modes", refuse)
    c = converge(brief, silent)
    assert c.outcomes[MORE_MODES].stopped == "more modes was not run: no such modes"
    assert c.outcomes[TENFOLD].stopped is None


def test_a_base_run_that_stopped_is_not_repeated(strips):
    base = replace(strips.runs["reduced"], stopped="reduced run: diverged")
    c = converge(replace(strips, runs={"reduced": base}), silent)
    assert list(c.outcomes) == [BASE]
    assert findings(c) == ["convergence was not looked at: the reduced run: diverged"]


# --- the comparison --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("modes", "settled"), [(0.995, True), (0.98, False)])
def test_what_an_event_hangs_on_adds_up(modes, settled):
    """1 % by the step and 2 % by the stiffness, neither too much; .5 or 2 % more by the modes, which count twice."""
    c = assess(
        outcomes(
            base=[event(0.5, force=1.0)],
            h2=[event(0.5, force=1.01)],
            h4=[event(0.5, force=1.0)],
            k2=[event(0.5, force=0.98)],
            k10=[event(0.5, force=1.0)],
            f=[event(0.5, force=modes)],
        ),
        "reduced",
        (0.0, 1.0),
        0.01,
    )
    force = c.events[0].figures["force"]
    more = 1.0 / modes - 1.0
    assert force.changes == pytest.approx({"step": -0.01, "stiffness": 0.02, "modes": -more})
    assert force.sources == pytest.approx(
        {"time": 0.01, "stiffness": 0.02, "modes": 2.0 * more, "unseen": LEAST["force"]}
    )
    assert (force.settled_to, force.settled) == (pytest.approx(0.03 + LEAST["force"] + 2.0 * more), settled)
    assert force.worst == ("stiffness" if settled else "modes")
    assert c.events[0].settled is settled


@pytest.mark.parametrize(("moved", "settled"), [(0.00065, True), (0.0007, False)])
def test_times_may_move_by_a_third_of_the_duration(moved, settled):
    """Of 2 ms."""
    c = assess(outcomes(base=[event(0.5)], h2=[event(0.5)], h4=[event(0.5 + moved)]), "reduced", (0.0, 1.0), 0.01)
    start = c.events[0].figures["start"]
    assert start.settled is settled
    assert start.settled_to == pytest.approx(moved + LEAST["start"] * 2e-3, rel=0.01)
    assert c.events[0].figures["duration"].settled


def test_absent_events_are_not_settled_and_new_ones_are_counted():
    c = assess(
        outcomes(
            base=[event(0.3), event(0.6)],
            h2=[event(0.3)],
            h4=[event(0.3), event(0.6), event(0.9)],
        ),
        "reduced",
        (0.0, 1.0),
        0.01,
    )
    assert [e.settled for e in c.events] == [True, False]
    assert c.events[1].problem == "absent with h/2"
    assert np.isnan(c.events[1].figures["force"].settled_to)
    assert {name: len(found) for name, found in c.new.items()} == {HALF: 0, QUARTER: 1}
    assert any("h/4 1" in text for text in findings(c))


@pytest.mark.parametrize(
    ("open_ones", "said"),
    [
        ({}, ()),
        ({3: 0.4}, ("event at 3.0000 s: force to 150 %",)),
        ({3: 0.4, 7: 1.6}, ("2 of 60 events have not, the hardest of them the event at 7.0000 s: force to 25 %",)),
    ],
)
def test_few_events_that_have_not_settled_are_told_in_one_sentence(open_ones, said):
    """1 N in all runs, 2 N at 7 s and 3 N at 9 s; the finest has the forces of the table."""
    force = {t: {7: 2.0, 9: 3.0}.get(t, 1.0) for t in range(60)}
    before = [event(float(t), force=f) for t, f in force.items()]
    last = [event(float(t), force=f) for t, f in (force | open_ones).items()]
    c = assess(outcomes(base=before, h2=before, h4=last), "reduced", (0.0, 60.0), 0.01)
    assert not c.chaotic
    assert "part from repeat" not in settling_table(c, UNITS["mm-t-s"]).note
    verdict = _of_convergence(c)
    assert (verdict.word, verdict.reasons) == ("settled", said)


@pytest.mark.parametrize(
    ("faint", "hard", "word"),
    [(0.05, 8, "settled"), (0.05, 4, "settled"), (0.2, 8, "statistics"), (0.2, 4, "unsettled")],
)
def test_faint_events_decide_nothing(faint, hard, word):
    """8 hits of 1 N settle, 4 taps do not: they carry a part of the impulse like that of their force.

    Where they are not faint the sums hold all the same; of eight events in all, samples say nothing.
    """
    hits = [event(float(t)) for t in range(hard)]
    taps = [event(t + 0.5, force=faint, impulse=faint * hits[0].impulse) for t in range(4)]
    last = [replace(e, impulse=1.2 * e.impulse) for e in taps]
    same = dict.fromkeys(("base", "h2", "h4", "k2"), hits + taps)
    c = assess(outcomes(**same, k10=hits + last), "reduced", (0.0, 60.0), 0.01)
    assert [e.settled for e in c.events].count(False) == 4
    verdict = _of_convergence(c)
    assert verdict.word == word
    if (word, hard) == ("settled", 8):
        assert verdict.reasons[0].startswith(
            "4 of 12 events have not (none above 5 % of the largest force, 2.4 % of the impulse), the hardest"
        )


def test_a_tap_beside_what_presses_for_good_decides_nothing():
    """40 N press, 5 N of amplitude to and fro; a tap of 1 N beside it moves by 20 %, and the largest force by nothing."""
    tap, rest = event(1.0), (Rub(force=Pressing(40.0, 5.0 / np.sqrt(2.0))),)
    found = outcomes(base=[tap], h2=[tap], h4=[replace(tap, force_place=1.2)])
    for rubs, word in (((), "unsettled"), (rest, "settled")):
        beside = {name: replace(o, impulse=o.impulse + 40.0 * len(rubs), rubs=rubs) for name, o in found.items()}
        c = assess(beside, "reduced", (0.0, 60.0), 0.01)
        assert c.outcomes[BASE].force == (45.0 if rubs else 1.0)
        assert _of_convergence(c).word == word


@pytest.mark.parametrize(("unfinished", "word"), [(True, "settled"), (False, "unsettled")], ids=["goes on", "ended"])
def test_an_event_that_goes_on_when_the_run_ends_decides_nothing(unfinished, word):
    """Its duration, cut there, is 1.64 times as long again with another step; it has no bar of that."""
    hits = [event(float(t)) for t in range(4)]
    last = [replace(event(9.999, impulse=1e-6, duration=x), unfinished=unfinished) for x in (1e-4, 2.64e-4)]
    c = assess(outcomes(base=[*hits, last[0]], h2=[*hits, last[1]], h4=[*hits, last[0]]), "reduced", (0.0, 10.0), 0.01)
    verdict = _of_repeats(c)
    assert verdict.word == word
    assert len(c.judged) == (4 if unfinished else 5)
    bars = settled_to(c.events[-1])
    assert [key for key, bar in bars.items() if bar is None] == (["duration", "impulse"] if unfinished else [])
    said = "the event at 9.9990 s goes on when the run ends and is left out"
    assert any(said in reason for reason in verdict.reasons) == unfinished
    assert any("4 of 4 events are settled" in x and "1 more go on when" in x for x in findings(c)) == unfinished


def test_the_answer_tells_that_an_event_goes_on(tmp_path):
    """The mass presses for pi / omega = 31.3 ms: cut at 20 ms its impulse is F (1 - cos) / omega of F sin(omega t)."""
    result = solved(tmp_path, stop_study(1e-4, 0.02), STOP)
    (e,) = result.runs["reference"].events
    assert e.unfinished
    force = 1e6 / OMEGA
    assert e.impulse == pytest.approx(force * (1.0 - math.cos(0.02 * OMEGA)) / OMEGA, rel=1e-4)
    c = converge(result, silent)
    summary = summarised(result, c)
    (told,) = summary["runs"]["reference"]["events"]
    assert told["unfinished"] is True
    assert told["settled_to"]["duration"] is None
    assert told["settled_to"]["impulse"] is None
    assert told["settled_to"]["t_start"] is not None
    table = event_table(findings_of(result, c), UNITS["m-kg-s"])
    assert table.rows[0][table.head.index("duration, ms")] == "> 20"
    assert "goes on when the run ends" in table.note
    (row,) = csv.DictReader(event_csv(findings_of(result, c), UNITS["m-kg-s"]).splitlines())
    assert row["unfinished"] == "yes"


def test_a_stiffness_that_the_study_gives_unsettles_nothing():
    """What another one would change is told: half of the force, and one of the events."""
    hits = [event(float(t)) for t in range(8)]
    other = [replace(e, force_place=0.5 * e.force_place) for e in hits[1:]] + [event(7.5)]
    same = dict.fromkeys(("base", "h2", "h4", "k2"), hits)
    runs = outcomes(**same, k10=other)
    for word, judged in (("unsettled", True), ("settled", False)):
        for name in (TWICE, TENFOLD):
            runs[name] = replace(runs[name], repeat=replace(runs[name].repeat, judged=judged))
        c = assess(runs, "reduced", (0.0, 60.0), 0.01)
        assert _of_convergence(c).word == word
        assert len(c.new[TENFOLD]) == 1
        force = c.events[1].figures["force"]
        assert force.changes["stiffness"] == pytest.approx(-1.0)
        assert force.settled_to == pytest.approx((1.0 if judged else 0.0) + LEAST["force"])
        assert all(e.settled for e in c.events) is not judged


@pytest.mark.parametrize(("size", "word"), [(0.01, "settled"), (0.5, "unsettled")])
def test_faint_events_that_a_repeat_alone_has_unsettle_nothing(size, word):
    """Nodes at rest touch or do not touch as the contact stiffness has it: a hundredth of the hardest blow is counted
    and told, and decides nothing; half of it does."""
    hits = [event(0.3), event(0.6)]
    faint = replace(event(0.9), force_place=size * hits[0].force_place, impulse=size * hits[0].impulse)
    c = assess(outcomes(base=hits, h2=hits, h4=[*hits, faint]), "reduced", (0.0, 1.0), 0.01)
    assert _of_convergence(c).word == word
    assert len(c.new[QUARTER]) == 1
    assert any("h/4 1" in text for text in findings(c))


def test_dense_events_are_compared_by_their_distributions():
    """50 events in a second: single ones scatter by 30 %, the samples are the same in another order."""
    rng = np.random.default_rng(0)
    forces = 1.0 + 0.3 * rng.random(50)
    runs = [[event(0.02 * i + 0.001, force=f) for i, f in enumerate(rng.permutation(forces))] for _ in range(3)]
    c = assess(outcomes(base=runs[0], h2=runs[1], h4=runs[2]), "reduced", (0.0, 1.0), 0.01)
    assert c.chaotic
    assert c.settled_events("force") < 50
    assert c.statistics["step"].force.value == 0.0
    assert any("50 events per second" in text for text in findings(c))
    assert any("h/2 (50) and h/4 (50) are alike" in text for text in findings(c))
    assert settling_table(c, UNITS["mm-t-s"]).note.startswith("Single events of this run part")


@pytest.mark.parametrize(("impulse", "words"), [(1.03e-3, "hardest channel has not"), (1.2e-3, "stiffer contact")])
def test_a_force_that_follows_the_penalty_is_told_from_a_blow_that_does(impulse, words):
    runs = {key: [event(0.5)] for key in ("base", "h2", "h4", "k2")}
    c = assess(outcomes(**runs, k10=[event(0.5, force=1.5, impulse=impulse)]), "reduced", (0.0, 1.0), 0.01)
    assert sum(words in text for text in findings(c)) == 1


@pytest.mark.parametrize(("count", "parts", "chaotic"), [(60, False, False), (30, True, True), (9, True, False)])
def test_motion_is_chaotic_where_the_resolution_in_time_parts_events(count, parts, chaotic):
    """However many there are in a second; fewer than ten have no statistics."""
    base = [event((i + 0.5) / count) for i in range(count)]
    finer = [replace(e, impulse=e.impulse * (1.0 + 0.2 * (parts and i % 3 == 0))) for i, e in enumerate(base)]
    c = assess(outcomes(base=base, h2=base, h4=finer), "reduced", (0.0, 1.0), 0.001)
    assert c.chaotic == is_chaotic(c, count, 1.0, 100.0) == chaotic
    assert is_chaotic(None, count, 1.0, 100.0) == (count == 60)  # nothing repeated: by their rate
    assert ("statistics" in _of_convergence(c).word) == chaotic


def test_few_events_are_not_called_chaotic():
    c = assess(outcomes(base=[event(0.5)], h2=[event(0.5)], h4=[event(0.5)]), "reduced", (0.0, 1.0), 0.01)
    assert not c.chaotic
    assert not any("samples" in text for text in findings(c))


def test_change_of_figures_that_vanish():
    assert change("force", 1.0, 0.0) == np.inf
    assert change("closing_speed", 0.0, 0.0) == 0.0
    assert np.isnan(change("impulse", None, 1.0))
    assert change("start", 1.0, 1.5) == 0.5
    assert change("impulse", 3.0, 2.0) == -0.5


# --- what is written -------------------------------------------------------------------------------------------------


def test_csv_has_a_line_for_each_figure_of_each_event(repeated, tmp_path):
    with save_convergence(repeated, tmp_path, "a run").open(encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(FIGURES) * len(repeated.events)
    for line in lines:
        if line["figure"] == "impulse" and line[HALF] and line[QUARTER]:
            assert float(line["change_step"]) == pytest.approx(1.0 - float(line[HALF]) / float(line[QUARTER]), abs=1e-6)
    assert {line["verdict"].split(":")[0] for line in lines} <= {"settled", "not settled"}
    assert csv_rows(repeated)[0][:4] == ["contact", "channel", "t_start", "figure"]


def test_summary_holds_it_as_plain_json(strips, repeated):
    summary = summarised(strips, repeated)
    told = json.loads(json.dumps(summary, allow_nan=False))["convergence"]
    assert set(told["runs"]) == set(repeated.outcomes)
    assert told["findings"] == findings(repeated)
    assert len(told["events"]) == len(repeated.events)
    assert "convergence" not in summarised(strips)
