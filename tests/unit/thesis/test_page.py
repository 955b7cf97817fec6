"""The thesis page: self-contained, complete, and it says what is missing."""

import json
import re
from html.parser import HTMLParser

import pytest

from creak_thesis.record import study_record
from creak_thesis.report.page import Inputs, thesis_page, write_thesis_page
from helpers_thesis import failed, fake_outcomes

FIGURES = [*(f"Figure 3.{k}" for k in (1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12)), *(f"Figure 4.{k}" for k in range(1, 17))]
TABLES = [*(f"3.{k}" for k in range(1, 10)), *(f"4.{k}" for k in range(1, 8))]
VOID = {"meta", "img", "br", "link", "input", "hr"}


class Tags(HTMLParser):
    """Checks that elements are closed in order, and collects ids, links and sources."""

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.links, self.sources = [], [], [], []

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.ids += [found["id"]] if "id" in found else []
        self.links += [found["href"]] if "href" in found else []
        self.sources += [found["src"]] if "src" in found else []
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def parsed(text):
    tags = Tags()
    tags.feed(text)
    assert tags.open == []
    return tags


@pytest.fixture(scope="module")
def page():
    record = study_record(1, duration=8.0, rate=4800.0)
    outcomes = fake_outcomes()
    outcomes["M1"] = failed(outcomes["M1"], "<the mesh> & its reason")
    return thesis_page(Inputs(20.0, outcomes, record, None, {"A1": 1e-6, "A2": 0.005, "A3": 0.006, "A4": 0.007}))


def test_page_holds_every_figure_and_table(page):
    for figure in FIGURES:
        assert re.search(rf"<h3>{re.escape(figure)}[<: ]", page), figure
    for table in TABLES:
        assert re.search(rf"<h3>Tables? [^<]*{re.escape(table)}\b", page), table


def test_page_is_self_contained_and_well_formed(page):
    tags = parsed(page)
    assert len(tags.ids) == len(set(tags.ids))
    assert tags.links
    assert all(link.startswith("#") and link[1:] in tags.ids for link in tags.links)
    assert all(source.startswith("data:") for source in tags.sources)


def test_every_plot_has_its_place_and_all_bars_their_markers(page):
    tags = parsed(page)
    specs = json.loads(re.search(r'id="specs">(.*?)</script>', page, re.S).group(1))
    assert set(specs) <= set(tags.ids)
    assert len(specs) >= 22
    events = [s for s in specs.values() if any(t["type"] == "bar" and "width" in t for t in s["data"])]
    assert len(events) >= 9
    for spec in events:
        assert sum(t["type"] == "bar" for t in spec["data"]) == sum(t["type"] == "scatter" for t in spec["data"])
        assert all(0.0 <= x <= 1000.0 for t in spec["data"] for x in t["x"])


def test_reason_of_a_failed_case_is_on_the_page(page):
    assert "&lt;the mesh&gt; &amp; its reason" in page
    assert "<the mesh>" not in page


def test_page_of_nothing_says_so(tmp_path):
    write_thesis_page(Inputs(20.0, {}, None, None, {}, None), tmp_path / "thesis.html")
    text = (tmp_path / "thesis.html").read_text(encoding="utf-8")
    parsed(text)
    assert "confirms 0" in text
    assert "carries no measurement of the door of 1.17 million dofs" in text
    assert "hooks with play are no case of this run" in text
    assert json.loads(re.search(r'id="specs">(.*?)</script>', text, re.S).group(1)).keys() <= {"plot-1"}


def test_million_dofs_are_compared_where_they_were_measured():
    run = {
        "wall_s": 100.0,
        "cpu_s": 100.0,
        "offline_cpu_s": 0.0,
        "offline_wall_s": 0.0,
        "retained": 0,
        "modes": 0,
        "contact_steps": 40,
        "integrator": "exact flow",
        "events": [["flange", 4.2, 4.21, 10.0, 0.1]],
    }
    made = {"creak": "9.9", "commit": "abc1234", "date": "2030-01-02", "machine": "two cores", "command": "python -m x"}
    reduced = run | {"name": "D8", "cpu_s": 4.0, "offline_cpu_s": 6.0, "events": [["flange", 4.2, 4.21, 11.0, 0.1]]}
    data = {"made": made, "model": "door of 4.22 mm", "runs": [run | {"name": "unreduced"}, reduced]}
    text = thesis_page(Inputs(20.0, {}, None, None, {}, data))
    assert "D8 runs 25 times faster in CPU time than unreduced, 10 times with its reduction counted" in text
    assert "11.0 N (+10.0" in text
    assert "<td>4.2000</td>" in text
    assert "python -m x, creak 9.9, commit abc1234, 2030-01-02, two cores." in text
    assert "unreduced, exact flow" in text
