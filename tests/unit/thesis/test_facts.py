"""Figures of the thesis page from made-up outcomes: closed forms, and words that follow the numbers."""

from dataclasses import replace

import pytest

from creak_thesis.outcome import EventRow
from creak_thesis.plan import ETAS, FINE_ETAS
from creak_thesis.report import answers, summary
from creak_thesis.report.facts import Agreement, Facts, matched, thesis, thesis_cpu
from creak_thesis.report.sections.beyond import interface_words, step_words
from creak_thesis.report.sections.cost import saved, slower, timed
from creak_thesis.report.sections.participation import right_and_wrong
from creak_thesis.report.sections.ranges import enough
from creak_thesis.report.sections.spacing import captured_modes, slower_than_reference
from creak_thesis.report.tables import cost_table, grade_table, participation_table, spacing_table
from creak_thesis.report.words import CLOSE, listed, predicts
from helpers_thesis import STEPS, failed, fake_outcomes


@pytest.fixture
def facts():
    return Facts(20.0, fake_outcomes())


def event(start, force, impulse=1.0):
    return EventRow(start, start, force, force, impulse)


def test_mean_force_is_a_ratio_of_means():
    """(2 + 6) / (1 + 7) = 1, not the mean of 2 and 6/7 (thesis 3.7.3)."""
    a = Agreement(2, 2, [(event(4.0, 1.0), event(4.0, 2.0)), (event(4.1, 7.0), event(4.1, 6.0))])
    assert a.force_ratio == pytest.approx(1.0)
    assert a.largest_error == pytest.approx(1.0)
    assert a.graded == (0, 1, 1)


def test_forces_within_five_per_cent_are_perfect():
    pairs = [(event(4.0, 100.0), event(4.0, f)) for f in (95.5, 104.5, 94.0, 106.0, 107.0)]
    assert Agreement(5, 5, pairs).graded == (2, 1, 2)


def test_events_match_nearest_first_and_once():
    first = [event(4.100, 1.0), event(4.108, 2.0)]
    second = [event(4.107, 3.0), event(4.5, 4.0)]
    assert matched(first, second) == [(first[1], second[0])]


def test_plain_newton_is_scaled_to_the_steps_of_the_reference_load(facts):
    newton, run = facts.outcomes["D8"].newton, facts.outcomes["D8"].loads["A4"]
    expected = (STEPS - run.contact_steps) * newton["flight_s"] + run.contact_steps * newton["contact_s"]
    assert facts.usual_cpu("D8") == pytest.approx(expected)
    # a case without runs of its own takes the steps of the unreduced model
    assert facts.usual_cpu("C1") == pytest.approx(1.3 * facts.usual_cpu("Ref C"))
    assert facts.usual_cpu("F300") is None


def test_too_many_retained_dofs_are_seen_where_they_cost_more():
    assert slower_than_reference(Facts(20.0, fake_outcomes(full_cost=1.3))) == ["C1"]
    assert slower_than_reference(Facts(20.0, fake_outcomes(full_cost=0.7))) == []


def test_saving_and_slower_cases(facts):
    assert saved(facts, "D8", False) == pytest.approx(0.98)
    assert slower(facts, timed(facts), True) == []
    assert "C1" not in timed(facts)
    assert "Red NtS" not in timed(facts)


def test_events_and_participation(facts):
    assert predicts(facts, "D8")
    right, wrong = right_and_wrong(facts)
    assert wrong == ["P37"]
    assert "P35" in right
    assert captured_modes(facts, "C5") == 8


def test_enough_modes_is_where_the_fit_stays():
    outcomes = fake_outcomes()
    low = outcomes["F300"].loads["A4"]
    outcomes["F300"] = replace(outcomes["F300"], loads={"A4": replace(low, nrmse={"all": 0.5})})
    assert enough(Facts(20.0, outcomes))["A4"] == 500
    assert enough(Facts(20.0, outcomes))["A1"] == 500
    assert enough(Facts(20.0, {})) == {}


def test_force_is_same_explained_or_different_as_the_numbers_say():
    def mark(**how):
        outcomes = fake_outcomes(**{k: v for k, v in how.items() if k == "force"})
        if not how.get("steps", True):
            del outcomes["D8 h/4"]
        return next(f.mark for f in summary.findings(Facts(20.0, outcomes), None) if "forces are higher" in f.thesis)

    assert mark(force=1.2) == "same"
    assert mark(force=1.0) == "explained"
    assert mark(force=1.0, steps=False) == "differs"


def test_without_runs_nothing_is_claimed():
    facts = Facts(20.0, {})
    assert {f.mark for f in summary.findings(facts, None)} == {"not run"}
    every = [*answers.questions(facts), *answers.recommendations(facts), *answers.open_points(facts)]
    assert [len(answers.questions(facts)), len(answers.recommendations(facts)), len(answers.open_points(facts))] == [
        5,
        4,
        4,
    ]
    assert all("not" in a.creak for a in every)


def test_failed_case_counts_as_not_run():
    outcomes = fake_outcomes()
    outcomes["D8"] = failed(outcomes["D8"], "K is singular")
    facts = Facts(20.0, outcomes)
    assert facts.case("D8") is None
    assert facts.why_not("D8") == "K is singular"
    assert facts.missing(["D8", "D40", "nobody"]) == ["D8: K is singular", "nobody: not run"]


def test_words_about_the_step_follow_the_difference(facts):
    assert "does not shrink" in step_words(facts)
    assert "agree at either step" in step_words(Facts(20.0, fake_outcomes(force=1.01)))
    assert "not there" in step_words(Facts(20.0, {}))


def test_words_about_generalised_coordinates_follow_the_fit():
    outcomes = fake_outcomes()
    assert interface_words(Facts(20.0, outcomes)).startswith("X50 keeps")
    for name in ("X50", "X100"):
        loads = {k: replace(r, nrmse={"all": 0.93 - 2.0 * CLOSE}) for k, r in outcomes[name].loads.items()}
        outcomes[name] = replace(outcomes[name], loads=loads)
    assert interface_words(Facts(20.0, outcomes)).startswith("X200 keeps")


def test_tables_hold_both_columns(facts):
    head = thesis()
    table = grade_table(facts, "D8")
    assert [r[1] for r in table.rows[:3]] == [str(head["predictions"][k][0]) for k in ("perfect", "low", "high")]
    assert table.rows[3][3:5] == ["0", "1"]
    assert len(participation_table(facts).rows) == len(FINE_ETAS) + len(ETAS)
    spacing = spacing_table(facts)
    assert spacing.rows[1][5] == "1.25"
    assert spacing.rows[1][7] == "1.30"
    for t in (table, spacing, participation_table(facts), cost_table(facts, ["D8"], "Ref StS")):
        assert sum(n for _, n in t.groups) == len(t.head) == len(t.rows[0])


def test_condensed_column_appears_where_it_was_timed(facts):
    plain = cost_table(facts, ["D8"], "Ref StS")
    outcomes = dict(facts.outcomes)
    for name in ("D8", "Ref StS"):
        newton = outcomes[name].newton | {"condensed_flight_s": 0.01, "condensed_contact_s": 0.02}
        outcomes[name] = replace(outcomes[name], newton=newton)
    more = cost_table(Facts(20.0, outcomes), ["D8"], "Ref StS")
    assert len(more.head) == len(plain.head) + 2


def test_thesis_numbers_are_those_of_its_tables():
    assert thesis_cpu("Ref StS") == 463.45
    assert thesis_cpu("D8") == 9.87
    assert thesis_cpu("C1") == 49.17
    assert thesis_cpu("F300") == 8.44
    assert thesis_cpu("X100") is None
    # 97.9 %, 27.1 %, 32.5 %: what the text makes of its tables
    assert 1 - thesis_cpu("D8") / thesis_cpu("Ref StS") == pytest.approx(0.979, abs=5e-4)
    assert 1 - thesis_cpu("D8") / thesis_cpu("D90") == pytest.approx(0.271, abs=5e-4)
    assert 1 - thesis_cpu("M2") / thesis_cpu("D8") == pytest.approx(0.325, abs=5e-4)
    t = thesis()["participation"]
    for frame, panel, cut in zip(t["frame"], t["panel"], t["reduction"], strict=True):
        assert 100 * (1 - (frame + panel) / (1170 + 372)) == pytest.approx(cut, abs=0.05)


def test_listed():
    assert listed([]) == "none"
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"]) == "a, b and c"


def test_events_of_other_contacts_are_left_out():
    """The stops of hooks with play have events of their own: only those of the flange are counted."""

    outcomes = fake_outcomes()
    for name in ("D8", "Ref StS"):
        run = outcomes[name].loads["A2"]
        more = [*run.events, EventRow(4.5, 4.5, 90.0, 90.0, 1.0, group="HOOK1")]
        pairs = [*run.pairs, [5, 5]] if run.pairs else []
        outcomes[name] = replace(outcomes[name], loads={"A2": replace(run, events=more, pairs=pairs)})
    found = Facts(20.0, outcomes).agreement("D8", "A2")
    assert (found.reference, found.own, len(found.common)) == (5, 5, 5)
    assert found.exact
