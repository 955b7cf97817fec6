"""The report is one file, says what was found, and works for every kind of study."""

import hashlib
import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from plotly import graph_objects

from creak.contact.laws.parameters import Friction
from creak.dynamics.history import ENERGIES
from creak.model.mesh import Unread
from creak.report.html import report_text, write_page
from creak.report.templates import coded, page_templates
from creak.studies.warned import Warned
from creak.verify.slips import SlipEvent
from helpers_findings import to_draw

CASES = (
    *("both runs", "reduced only", "unreduced only", "no pairs", "no contact, no pairs", "no events"),
    *("connector only", "contact and connector", "no modes", "nothing moves", "mass on a spring"),
)


def own_text(html: str) -> str:
    """The report without plotly's library and without its own programs."""
    return re.sub(r'<script( type="text/plain" [^>]*)?>.*?</script>', "", html, flags=re.DOTALL)


def report_of(result) -> str:
    return own_text(report_text(*to_draw(result)))


@pytest.fixture(scope="module")
def page_of(result_of):
    """The page of a case by its name."""
    return cache(lambda case: report_of(result_of(case)))


@pytest.fixture(scope="module")
def full(page_of):
    return page_of("both runs")


@pytest.mark.parametrize("case", CASES)
def test_report_is_complete_and_figures_valid_for_every_kind_of_study(case, page_of):
    html = page_of(case)
    for section in (
        *("places", "checks", "motion", "model", "force", "events", "modes", "spectra", "energy", "precheck"),
        *("size", "method", "provenance"),
    ):
        assert f'<section id="{section}"' in html
    assert "nan" not in re.sub(r"base64,[^\"]*", "", html).lower().split()
    specs = re.search(r'<script type="application/json" id="specs">(.*?)</script>', html, flags=re.DOTALL)
    assert specs is not None
    for name, spec in json.loads(specs[1]).items():
        graph_objects.Figure(spec)
        assert f'id="plot-{name}"' in html


def test_file_loads_nothing_from_elsewhere_and_leaves_no_part_behind(result_of, tmp_path):
    result = result_of("both runs")
    path = tmp_path / "report.html"
    write_page(*to_draw(result), path)
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]
    assert path.stat().st_size < 8e6
    html = path.read_text(encoding="utf-8")
    assert 'id="plotly-source"' in html
    assert html.count("<script") == 8
    sources = re.findall(r"""(?:src|href)\s*=\s*["']([^"']*)""", own_text(html))
    assert sources
    assert all(s.startswith(("data:image/png;base64,", "#")) for s in sources)
    assert "url(" not in own_text(html)


def test_an_old_report_survives_a_failure(result_of, tmp_path):
    path = tmp_path / "report.html"
    path.write_text("old")
    findings, drawn = to_draw(result_of("both runs"))
    with pytest.raises(AttributeError, match="history"):
        write_page(replace(findings, runs={"reduced": None}), drawn, path)
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


def test_causes_stand_below_the_list_as_its_clauses(result_of):
    """The card of the place has the first of them, and the first change that would help."""
    result = result_of("reduced only")
    cause = {"words": "closed by <b>; most through 9 Hz", "changes_words": ["more gap: N5 2 -> 1 sone"]}
    html = own_text(report_text(*to_draw(result, causes={1: cause})))
    card = html[html.index('<ol class="cards">') : html.index('<div class="causes">')]
    assert "<p>Closed by &lt;b&gt;.</p>" in card
    assert "<p>Would help: more gap: N5 2 -&gt; 1 sone.</p>" in card
    assert "9 Hz" not in card
    below = html[html.index('<div class="causes">') : html.index('<section id="checks">')]
    clauses = ("Closed by &lt;b&gt;", "Most through 9 Hz", "more gap: N5 2 -&gt; 1 sone")
    assert [f"<li>{c}</li>" in below for c in clauses] == [True] * 3
    assert below.count("<details") == 1


def test_a_single_run_is_said_to_be_unchecked(page_of):
    html = page_of("reduced only")
    assert "Nothing was held against the unreduced model" in html
    assert "not checked" in html
    assert "not compared: there is only one run" in html


def test_absent_figures_are_explained_in_words(page_of):
    html = page_of("no contact, no pairs")
    assert "No spectra: the study names no verification pairs." in html
    assert "No contact forces: the study has no channel that can close." in html
    assert "The study has neither contacts nor connectors." in html


def test_unread_keywords_and_what_they_mean_are_listed(result_of):
    result = result_of("reduced only")
    unread = Unread("*PREPRINT", "plates.inp:7", True, "a made-up reason")
    model = replace(result.setup.model, unread=(unread,))
    structure = replace(result.setup.structure, model=model)
    html = report_of(replace(result, setup=replace(result.setup, structure=structure)))
    assert "*PREPRINT" in html
    assert "changes the answer" in html
    assert "a made-up reason" in html
    assert "plates.inp:7" in html


def test_units_follow_the_study(full):
    assert "force, N" in full
    assert "peak, raw" not in full
    assert "closing speed, mm/s" in full
    assert "mm-t-s" in full


def test_report_does_not_depend_on_the_working_folder(result_of, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = result_of("both runs")
    write_page(*to_draw(result), Path("report.html"))
    assert (tmp_path / "report.html").exists()


@pytest.fixture(scope="module")
def rubbed(result_of):
    """The two plates with friction and two made-up stick-slip events."""
    result = result_of("both runs")
    m = result.gaps.m
    gaps = replace(result.gaps, friction=Friction(np.full(m, 0.3), np.full(m, 0.3), np.zeros(m)))
    slips = (
        SlipEvent("tip", "tip:110", 1, 0.005, 0.02, 0.125, 40.0, 0.75, ((0.005, 0.006), (0.0175, 0.02))),
        SlipEvent("tip", "tip:110", 1, 0.03, 0.031, 0.02, 7.0, 0.1, ((0.03, 0.031),)),
    )
    runs = {}
    for name, run in result.runs.items():
        energy = run.history.energy.copy()
        energy[:, ENERGIES.index("friction")] = np.linspace(0.0, 0.03, energy.shape[0])
        runs[name] = replace(run, gaps=gaps, history=replace(run.history, energy=energy, residual=2e-11), slips=slips)
    return replace(result, gaps=gaps, runs=runs)


def test_stick_slip_events_are_listed_where_something_rubs(rubbed, full):
    html = report_of(replace(rubbed, window=(0.0, 0.04)))
    assert "<h3>Stick-slip events</h3>" in html
    # Two slips 12.5 ms apart: 80 per second, .125 mm.
    assert "<td>2</td><td>80.0</td><td>15.0</td><td>0.125</td><td>40.0</td><td>0.750</td>" in html
    assert "Slips per second in the window: reduced tip 75.0; unreduced tip 75.0." in html
    assert "Stick-slip events" not in full
    assert "No slip between two sticks" in report_of(replace(rubbed, window=(0.035, 0.04)))


def test_energy_balance_tells_friction_and_the_algorithmic_part(rubbed, full):
    html = report_of(rubbed)
    for words in (
        "<td>friction</td><td>0.0300</td>",
        "time integration (algorithmic)",
        "energy created at the worst",
        "equations of motion held to",
    ):
        assert words in html
    names = [t["name"] for t in json.loads(specs_of(html))["energy"]["data"]]
    assert "friction" in names
    assert "friction" not in [t["name"] for t in json.loads(specs_of(full))["energy"]["data"]]


def specs_of(html: str) -> str:
    found = re.search(r'<script type="application/json" id="specs">(.*?)</script>', html, flags=re.DOTALL)
    assert found is not None
    return found[1]


def test_agreement_and_penetration_are_in_tables(full, result_of):
    result = result_of("both runs")
    assert result.events is not None
    if result.events.pairs:
        assert "mean error of each" in full
        assert "(recall)" in full
    assert "penetration, mm" in full
    assert "Kolmogorov-Smirnov distance" in full


def test_notes_are_shown(result_of):
    result = result_of("reduced only")
    assert "A made-up note" in report_of(replace(result, notes=["a made-up note"]))


def test_warnings_come_first_and_a_run_without_contact_names_the_closest_approach(result_of, page_of):
    html = page_of("no events")
    h = result_of("no events").runs["reduced"].history
    assert 'id="alarms"' in html
    assert "the closest approach is" in html
    assert f"{h.gap.min():.3g} mm" in html
    assert html.index('id="alarms"') < html.index('id="places"')
    assert "Nowhere: no contact event in the run." in html


def test_created_energy_raises_an_alarm(result_of, full):
    result = result_of("both runs")
    run = result.runs["reduced"]
    energy = run.history.energy.copy()
    energy[-1, ENERGIES.index("scheme")] = -0.5 * run.history.energy_scale
    history = replace(run.history, energy=energy)
    html = report_of(replace(result, runs=result.runs | {"reduced": replace(run, history=history)}))
    assert "<b>Energy was created:</b> the reduced run created 50" in html
    assert "Energy was created" not in full


def test_study_file_and_digest_of_the_deck_are_told(full, result_of):
    study = result_of("both runs").setup.study
    digest = hashlib.sha256((study.path.parent / "plates.inp").read_bytes()).hexdigest()
    assert digest in full
    assert "amplitude = 0.8 }" in full[full.index('id="study-text"') :]
    assert "numpy " in full


def test_precheck_map_marks_the_channels_that_are_kept(full, result_of):
    result = result_of("both runs")
    dots = json.loads(specs_of(full))["precheck"]["data"][-1]
    assert len(dots["x"]) == result.setup.contacts.m
    rings = sum(w > 0.0 for w in dots["marker"]["line"]["width"])
    assert rings == result.gaps.m
    assert min(dots["marker"]["color"]) == pytest.approx(result.reference.linear_gaps.min(), rel=1e-5)


def test_gap_plot_reaches_the_deepest_penetration(full, result_of):
    result = result_of("both runs")
    traces = json.loads(specs_of(full))["gap"]["data"]
    h = result.runs["reduced"].history
    inside = (h.time >= result.window[0] - 1e-12) & (h.time <= result.window[1] + 1e-12)
    assert min(min(t["y"]) for t in traces if t["name"] == "reduced model") == pytest.approx(
        h.gap[inside].min(), rel=1e-5
    )


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("set [time] substeps, or `creak run --converge`", "set [time] substeps, or <code>creak run --converge</code>"),
        ("`a<b`, x > y & `c`", "<code>a&lt;b</code>, x &gt; y &amp; <code>c</code>"),
        ("`</li><script>alert(1)</script>`", "<code>&lt;/li&gt;&lt;script&gt;alert(1)&lt;/script&gt;</code>"),
        ("a lone ` stays", "a lone ` stays"),
        ("`` stays too", "`` stays too"),
    ],
)
def test_what_stands_between_back_ticks_is_code_and_escaped(text, shown):
    assert coded(text) == shown
    page = page_templates("creak.report").from_string("{{ text | coded }}")  # whatever page was made before
    assert page.render(text=text) == str(shown)


def test_messages_on_the_page_show_no_back_tick(result_of):
    result = result_of("reduced only")
    note = "`creak run --converge` looks closer, where <a> is `b`"
    unread = Unread("*PREPRINT", "plates.inp:7", True, "see `creak info`")
    of = result.setup.structure
    setup = replace(result.setup, structure=replace(of, model=replace(of.model, unread=(unread,))))
    html = report_of(replace(result, setup=setup, notes=[note, Warned(note)]))
    assert html.count("<li><code>creak run --converge</code> looks closer, where &lt;a&gt; is <code>b</code></li>") == 2
    assert "see <code>creak info</code>" in html


def test_superelements_show_their_verdict_first_and_units(full):
    start = full.index("<summary>LOWER: no warnings</summary>")
    table = full[start : full.index("</table>", start)]
    assert table.index("<td>verdict</td>") < table.index("<td>mass, t</td>") < table.index("centre of gravity, mm")
    assert "t mm\N{SUPERSCRIPT TWO}" in table
    assert "<td>part</td>" not in table


def test_events_are_told_once_and_short_ones_have_a_duration(page_of):
    """The force is that of the place: the page does not call it that of one channel as well, and .03 ms are not 0.0."""
    html = page_of("reduced only")
    events = html[html.index('<section id="events"') :].split("</section>")[0]
    assert events.count("low-passed") == 1 + events.count("median force, low")
    assert "hardest pressed channel" not in events
    durations = re.findall(r"<tr><td>.*?</td>(?:<td>.*?</td>){3}<td>(.*?)</td>", events)
    assert durations
    assert "0.0" not in durations
    assert "The reduced model is right where" not in html
    assert "The reduced model is right where" in page_of("both runs")


def test_reasons_of_a_verdict_are_not_cried_out(result_of, monkeypatch):
    monkeypatch.setattr("creak.report.html.verdict.trust", lambda _: "Settled as statistics. Single events differ.")
    html = report_of(result_of("reduced only"))
    assert "<strong>Settled as statistics.</strong> " in html
    assert '<ul class="why"><li>Single events differ.</li></ul>' in html
