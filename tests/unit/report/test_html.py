"""The report is one file, says what was found, and works for every kind of study."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from plotly import graph_objects

from creak.model.mesh import Unread
from creak.report.html import report_text, write_report
from creak.studies.summary import summarise

CASES = (
    "both runs", "reduced only", "unreduced only", "no pairs", "no contact, no pairs", "no events", "connector only",
    "contact and connector", "no modes", "nothing moves", "mass on a spring",
)  # fmt: skip


def own_text(html: str) -> str:
    """The report without plotly's library."""
    return re.sub(r"<script>.{1000000,}?</script>", "", html, flags=re.DOTALL)


def report_of(result) -> str:
    return own_text(report_text(result, summarise(result)))


@pytest.fixture(scope="module")
def full(result_of):
    return report_of(result_of("both runs"))


@pytest.mark.parametrize("case", CASES)
def test_report_is_complete_and_figures_valid_for_every_kind_of_study(case, result_of):
    html = report_of(result_of(case))
    for section in ("checks", "model", "force", "events", "modes", "spectra", "energy", "size", "method"):
        assert f'<section id="{section}">' in html
    assert "nan" not in re.sub(r"base64,[^\"]*", "", html).lower().split()
    specs = re.search(r'<script type="application/json" id="specs">(.*?)</script>', html, flags=re.DOTALL)
    assert specs is not None
    for name, spec in json.loads(specs[1]).items():
        graph_objects.Figure(spec)
        assert f'id="plot-{name}"' in html


def test_file_loads_nothing_from_elsewhere_and_leaves_no_part_behind(result_of, tmp_path):
    result = result_of("both runs")
    path = tmp_path / "report.html"
    write_report(result, summarise(result), path)
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]
    assert path.stat().st_size < 8e6
    html = path.read_text(encoding="utf-8")
    assert "Plotly.newPlot" in html
    assert html.count("<script") == 3
    sources = re.findall(r"""(?:src|href)\s*=\s*["']([^"']*)""", own_text(html))
    assert sources
    assert all(s.startswith("data:image/png;base64,") for s in sources)
    assert "url(" not in own_text(html)


def test_an_old_report_survives_a_failure(result_of, tmp_path):
    path = tmp_path / "report.html"
    path.write_text("old")
    with pytest.raises(KeyError):
        write_report(result_of("both runs"), {}, path)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


def test_event_table_and_verdict_hold_the_numbers_of_the_match(full, result_of):
    result = result_of("both runs")
    match = result.events
    count = len(match.pairs) + len(match.missed)
    assert count > 0
    assert f"{count} rattle event" in full
    assert f"{len(match.pairs)} of {count} matched, {len(match.missed)} missed, {len(match.extra)} extra" in full
    assert full.count('<tr class="missed">') == len(match.missed)
    assert full.count('<tr class="extra">') == len(match.extra)
    for reference, _ in match.pairs:
        assert f"<td>{reference.t_start:.4f}</td>" in full
        assert f"node {result.setup.model.nodes.label(reference.node_idx)}" in full


def test_title_is_escaped(full):
    assert "<h1>Two plates &lt;test&gt;</h1>" in full


def test_a_single_run_is_said_to_be_unchecked(result_of):
    html = report_of(result_of("reduced only"))
    assert "The unreduced model was not run" in html
    assert "not checked" in html
    assert "not compared: there is only one run" in html


def test_absent_figures_are_explained_in_words(result_of):
    html = report_of(result_of("no contact, no pairs"))
    assert "No spectra: the study names no verification pairs." in html
    assert "No contact forces: the study has no channel that can close." in html
    assert "The study has neither contacts nor connectors." in html


def test_unread_keywords_and_what_they_mean_are_listed(result_of):
    result = result_of("reduced only")
    unread = Unread("*PREPRINT", "plates.inp:7", True, "a made-up reason")
    model = replace(result.setup.model, unread=(unread,))
    html = report_of(replace(result, setup=replace(result.setup, model=model)))
    assert "*PREPRINT" in html
    assert "changes the answer" in html
    assert "a made-up reason" in html
    assert "plates.inp:7" in html


def test_units_follow_the_study(full):
    assert "peak, raw, N" in full
    assert "closing speed, mm/s" in full
    assert "mm-t-s" in full


def test_report_does_not_depend_on_the_working_folder(result_of, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = result_of("both runs")
    write_report(result, summarise(result), Path("report.html"))
    assert (tmp_path / "report.html").exists()
