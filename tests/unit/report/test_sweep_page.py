"""The table and the page at the end of a sweep."""

from __future__ import annotations

import pytest

from creak.report.sweep_page import idle_keys, sentence, sweep_rows, write_sweep_page
from creak.report.words.text import NONE
from creak.studies.sweep.case import Outcome
from creak.studies.sweep.cases import Case
from creak.studies.sweep.job import Row


def row(name: str, gap: float, impulse: float | None, status: str = "done", error: str = "") -> Row:
    changes = {"contact.tip.clearance": gap, "contact.edge.clearance": 1.0, "reduction.f_max": 500}
    case = Case(name, name, changes, None, "", "", "", None)
    record = {
        "reduced.events": 3,
        "reduced.force": 2.5,
        "reduced.n5": 0.75,
        "reduced.impulse_total": impulse,
        "units": "mm-t-s",
    }
    record |= {"nrmse_all": 0.9987, "case_wall_s": 2.0}
    return Row(case, Outcome(status, error, record if impulse is not None else {}))


ROWS = [row("gap<.1>", 0.1, 0.5), row("b", 0.25, 2.0), row("c", 0.3, None, "failed", "it broke")]


def test_rows_say_what_each_case_changes_and_how_it_ended():
    head, *cells = sweep_rows(ROWS)
    changed = ["contact.tip.clearance", "contact.edge.clearance", "f_max"]
    assert head == [
        "case",
        *changed,
        "status",
        "events",
        "force of the hardest place, N",
        "impulse, N s",
        "N5 of the loudest, sone",
        "fit",
    ]
    assert cells[0] == ["gap<.1>", "0.1", "1", "500", "done", "3", "2.500", "0.5000", "0.7500", "0.9987"]
    assert cells[2][4] == "failed"
    assert len(set(cells[2][5:])) == 1, "nothing is known of it"
    assert sentence(ROWS) == "3 cases; impulse from 0.5000 N s (gap<.1>) to 2.000 N s (b)."


def test_a_key_that_changes_nothing_is_told():
    rows = [row(f"{gap}", gap, 2.0) for gap in (0.1, 0.25)]
    assert idle_keys(rows) == ["contact.tip.clearance"]
    assert sentence(rows).endswith("; contact.tip.clearance changes nothing.")
    assert idle_keys(ROWS) == []
    assert idle_keys([row("a", 0.1, 0.0), row("b", 0.2, 0.0)]) == [], "nothing touches"


def test_friction_is_told_where_anything_rubs():
    """A block that sticks and one that slides: nothing else tells the two apart."""
    rubs = {"friction": "sliding", "slips": 28, "slip_rate": 113.5, "slip_path": 3.7, "friction_energy_total": 5.69}
    slides = {f"reduced.{key}": value for key, value in rubs.items()}
    sticks = slides | {"reduced.friction": "stick", "reduced.slip_rate": None, "reduced.friction_energy_total": 0.0}
    rows = [
        Row(r.case, Outcome("done", "", r.outcome.record | more))
        for r, more in zip(ROWS[:2], (slides, sticks), strict=True)
    ]
    head, *cells = sweep_rows([*rows, ROWS[2]])
    assert head[9:14] == ["hardest rub", "its slips", "its slip rate, 1/s", "its slip path, mm", "friction energy, mJ"]
    assert cells[0][9:14] == ["sliding", "28", "113.5", "3.700", "5.690"]
    assert cells[1][9:12] == ["stick", "28", NONE]
    assert cells[2][9] == NONE
    assert sentence(rows).endswith("; friction energy from 0 mJ (b) to 5.690 mJ (gap<.1>).")


def test_the_page_leads_to_the_cases_and_quotes_their_names(tmp_path):
    write_sweep_page("A <b>sweep</b>", ROWS, tmp_path / "sweep.html")
    text = (tmp_path / "sweep.html").read_text()
    assert '<a href="gap%3C.1%3E/report.html">gap&lt;.1&gt;</a>' in text
    assert "A &lt;b&gt;sweep&lt;/b&gt;" in text
    assert "c: it broke" in text
    assert 'href="c/report.html"' not in text, "it has no report"


@pytest.mark.parametrize("seeds", [(1, 1, 1), (1, 2, 3)])
def test_seeds_are_shown_where_they_differ(seeds):
    rows = [Row(Case(r.case.name, "x", {}, s, "", "", "", None), r.outcome) for r, s in zip(ROWS, seeds, strict=True)]
    assert ("seed" in sweep_rows(rows)[0]) == (len(set(seeds)) > 1)
