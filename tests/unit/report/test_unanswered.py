"""Runs that say nothing of rattle, and runs that nothing checked: neither is told in green."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
import small_study as small

from creak.api.study import run_setup, set_up
from creak.progress import silent
from creak.report.html import report_text
from creak.report.tables.convergence import procedure
from creak.report.words.method import paragraph
from creak.studies.converge.repeats import converge
from creak.studies.file.reader import read_study
from creak.studies.findings.gather import findings_of
from creak.studies.run.job import run_study
from helpers_decks import write_study
from helpers_findings import summarised, to_draw

pytestmark = pytest.mark.once


def first_line(result, convergence=None):
    """Style and words of the page's first bar."""
    page = report_text(*to_draw(result, convergence, size=0))
    style, words = re.search(r'<p class="verdict (\w*)" id="verdict">(.*?)</p>', page, re.DOTALL).groups()
    return style, re.sub("<[^>]*>", "", words)


def exact(text):
    """The study without a forced step."""
    return text.replace("step = 5e-4\n", "")


def read(folder, text, deck=None):
    return set_up(read_study(write_study(folder, text, {"plates.inp": deck or small.plates()})))


def run(folder, text, deck=None, **more):
    return run_setup(read(folder, text, deck), **more)


@pytest.mark.parametrize("name", ["no contact, no pairs", "nothing moves"])
def test_a_run_that_could_not_rattle_is_told_in_red(result_of, name):
    result = result_of(name)
    summary = summarised(result)
    why = summary["unanswered"]
    assert "nothing can rattle" in why
    assert summary["warnings"][0] == why
    assert {(r["verdict"], *r["reasons"]) for r in summary["runs"].values()} == {("unsettled", why)}
    style, words = first_line(result)
    assert style == "bad"
    assert words.startswith("No answer. ")
    assert "ettled" not in words
    assert "No rattle" not in words


def test_what_drives_something_else_closes_no_gap(tmp_path):
    """A mass on a spring beside the plates is pushed."""
    mass = """*NODE
900, 500., 0., 0.
901, 500., 9., 0.
*NSET, NSET=LONELY
901
*ELEMENT, TYPE=SPRINGA, ELSET=SP
900, 900, 901
*SPRING, ELSET=SP

10.
*ELEMENT, TYPE=MASS, ELSET=MM
901, 901
*MASS, ELSET=MM
1e-3
*MATERIAL"""
    deck = small.plates().replace("*MATERIAL", mass, 1) + "ROOT_UPPER, 3\n901, 1\n901, 3, 6\n900, 1, 6\n"
    text = exact(small.study_text(pairs="", reference=False)).replace("ROOT_UPPER", "LONELY").replace('"z"', '"y"')
    for precheck in ("margin = 5.0", "margin = 0.01", "enabled = false"):
        result = run(tmp_path, text.replace("margin = 5.0", precheck), deck, converge=False)
        assert "no gap" in result.summary["unanswered"], precheck
        assert result.summary["runs"]["reduced"]["verdict"] == "unsettled"


def test_a_page_of_a_deck_in_other_units_says_so_first(tmp_path):
    """Steel in GPa and kg/mm^3, as decks in mm, kg and ms have it; the light and the headline go by no figure."""
    deck = small.plates().replace("210000., 0.3", "210., 0.3").replace("7.85e-9", "7.85e-6")
    found = run(tmp_path, exact(small.study_text(reference=False)), deck, converge=False)
    odd = "he deck looks to be in mm-kg-ms, not in mm-t-s as the study says"
    assert found.summary["other_units"] == f"t{odd}"
    assert re.search(rf'<p class="answer (amber|red)" id="answer">T{odd}, so no figure is in', found.page(0.0))


@pytest.mark.parametrize("margin", ["5.0", "0.01"])
def test_gaps_that_move_and_stay_open_are_an_answer(tmp_path, margin):
    text = exact(small.study_text(amplitude=0.001, reference=False)).replace("margin = 5.0", f"margin = {margin}")
    found = run(tmp_path, text)
    assert found.summary["unanswered"] is None
    assert found.summary["runs"]["reduced"]["verdict"] == "settled"


def test_contact_that_presses_is_an_answer_although_nothing_closes(result_of):
    result = result_of("both runs")
    assert result.unanswered is None
    far = replace(result.reference, linear_gaps=result.setup.contacts.gap0)
    assert replace(result, reference=far).unanswered is None


@pytest.fixture(scope="module")
def unchecked(tmp_path_factory):
    return run(tmp_path_factory.mktemp("unchecked"), exact(small.study_text(reference=False)), converge=False)


def test_what_nothing_checked_is_grey(unchecked):
    reduced = unchecked.summary["runs"]["reduced"]
    assert "verdict" not in reduced
    assert reduced["reasons"][0].startswith("not checked: ")
    page = unchecked.page(0.0)
    assert '<p class="verdict none" id="verdict"><strong>Not checked: ' in page
    assert "not checked" in repr(unchecked)


def test_what_was_compared_is_not_called_unchecked(tmp_path):
    found = run(tmp_path, exact(small.study_text()), converge=False)
    assert found.summary["runs"]["reduced"]["reasons"] == []
    assert "Not checked" not in found.page(0.0)


def test_convergence_is_told_of_the_runs_that_were_made(tmp_path):
    """By exact flow no step is shortened by hand, and no stiffness is ten times another."""
    text = small.study_text(reference=False)
    made = [converge(run_study(read(tmp_path, study), silent), silent) for study in (exact(text), text)]
    told = [procedure(c) for c in made]
    for c, words in zip(made, told, strict=True):
        for name in c.outcomes:
            assert (f"({name})" in words) == (name != "base"), name
    assert "contact resolved 2 times as finely in time (half the tolerance)" in told[0]
    assert "0.5 times the contact stiffness (half the stiffness)" in told[0]
    modes = [made[0].outcomes[name].modes for name in ("more modes", "base")]
    assert f"{modes[0]} modes for {modes[1]} (more modes)" in told[0].replace("\u2009", "")
    assert "steps of 0.125 ms for 0.5 ms and 10 times the contact stiffness (10 x stiffness)" in told[1]
    assert "h/4" not in told[0]
    only = replace(made[0], outcomes={n: made[0].outcomes[n] for n in ("base", "half the tolerance")})
    only = replace(only, families={"tolerance": ("base", "half the tolerance")})
    assert "stiffness" not in procedure(only)
    assert procedure(replace(made[0], outcomes={"base": made[0].outcomes["base"]}, families={})) == (
        "The run was not repeated."
    )


def test_the_method_says_no_stiffness_was_chosen_only_where_none_was(tmp_path, unchecked):
    stiff = small.study_text(contact=small.CONTACT + "stiffness = 50.0\n", reference=False)
    chosen = run(tmp_path, exact(stiff), converge=False)
    words = "No step, stiffness or scheme was chosen by hand"
    assert words in paragraph(findings_of(unchecked.found))
    assert words not in paragraph(findings_of(chosen.found))
