"""Studies from Python: the same run as the command, and what happens without the packages of the report."""

from __future__ import annotations

import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import creak
from helpers_cli import say
from helpers_decks import STUDY, two_strips, write_strips
from helpers_refusal import refusal


@pytest.fixture(scope="module")
def result(tmp_path_factory) -> creak.Result:
    return creak.run(str(write_strips(tmp_path_factory.mktemp("strips"))))


def test_a_result_holds_what_the_summary_says(result):
    runs = result.summary["runs"]
    assert set(result.runs) == {"reduced", "reference"}
    assert result.main is result.runs["reduced"]
    assert len(result.events) == len(runs["reduced"]["events"]) > 0
    assert result.events[0].impulse == pytest.approx(runs["reduced"]["events"][0]["impulse"])
    assert result.history.time.size == runs["reduced"]["steps"] + 1
    assert len(result.agreement.pairs) == result.summary["verification"]["events"]["matched"]
    assert result.stopped is None


def test_the_command_finds_the_same(result, tmp_path):
    say("run", write_strips(tmp_path), "--quiet", "--out", tmp_path / "o").done()
    summary = json.loads((tmp_path / "o" / "summary.json").read_text())
    assert summary["runs"]["reduced"]["events"] == result.summary["runs"]["reduced"]["events"]


def test_save_and_report_write_files(result, tmp_path):
    written = result.save(tmp_path / "a" / "b")
    assert sorted(p.name for p in written) == ["results.h5", "summary.json"]
    assert all(p.exists() for p in written)
    page = result.report(tmp_path / "c" / "report.html", animation_mb=0.0)
    assert "<html" in page.read_text(encoding="utf-8")[:200]


def without_plotly(monkeypatch):
    for name in ("plotly", "plotly.offline"):
        monkeypatch.setitem(sys.modules, name, None)


def test_without_the_extra_the_report_says_how_to_get_it(result, tmp_path, monkeypatch):
    without_plotly(monkeypatch)
    with pytest.raises(creak.InputError, match=r"plotly.* pip install 'creak\[report\]'"):
        result.report(tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


def test_without_the_extra_the_command_writes_all_but_the_report(tmp_path, monkeypatch):
    without_plotly(monkeypatch)
    study = write_strips(tmp_path, study=STUDY.replace("periods = 2", "end = 0.02\n[reference]\nrun = false"))
    said = say("run", study, "--out", tmp_path / "o").done()
    assert sorted(p.name for p in (tmp_path / "o").iterdir()) == ["results.h5", "summary.json"]
    lines = [x for x in (said.out + said.err).splitlines() if "creak[report]" in x]
    assert len(lines) == 1
    assert "plotly" in lines[0]


@pytest.mark.parametrize("command", [["sweep", "sweep.toml"], ["thesis", "--out", "thesis"]])
def test_without_the_extra_long_work_is_not_begun(command, tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    without_plotly(monkeypatch)
    write_strips(tmp_path)
    (tmp_path / "sweep.toml").write_text('base = "study.toml"\n[grid]\n"reduction.f_max" = [2000, 3000]\n')
    monkeypatch.chdir(tmp_path)
    say(*command).refuses("pip install 'creak[report]'")
    assert not (tmp_path / "sweep_sweep").exists()
    assert not (tmp_path / "thesis").exists()


def test_a_study_from_tables_is_that_of_the_file(result, tmp_path):
    path = write_strips(tmp_path)
    tables = {
        "title": "Two strips",
        "model": {"deck": "strips.inp"},
        "contact": {"tip": {"secondary": "UNDER", "main": "OVER", "method": "surface-to-surface"}},
        "excitation": {
            "root": {
                "node_set": "ROOT_UPPER",
                "dof": "z",
                "kind": "displacement",
                "signal": {
                    "type": "multisine",
                    "f_min": 5,
                    "f_max": 60,
                    "amplitude": np.float64(0.05),
                    "period": 0.2,
                    "seed": np.int64(3),
                },
            }
        },
        "reduction": {"f_max": 3000},
        "time": {"step": 5e-4, "periods": 2},
        "verification": {"pairs": "PAIRS", "mac_f_max": 500},
    }
    assert creak.make_study(tables, tmp_path).config == creak.read_study(path).config


def test_a_changed_study_leaves_the_file_alone(tmp_path):
    path = write_strips(tmp_path)
    study = creak.read_study(path)
    other = creak.change_study(study, {"reduction.f_max": 700, "contact.tip.friction": 0.2})
    by_path = creak.change_study(study.path, {"reduction.f_max": 700, "contact.tip.friction": 0.2})
    assert by_path.config == other.config
    assert (other.config.reduction.f_max, other.config.contact["tip"].friction) == (700.0, 0.2)
    assert creak.read_study(path).config == study.config
    assert other.places.sibling("strips.inp") == study.places.sibling("strips.inp")


def test_rows_of_a_list_go_by_number_or_by_name(tmp_path):
    clip = (
        '[[clip]]\nname = "{}"\ntype = "stop"\nnodes = ["TIP_UPPER", "TIP_LOWER"]\naxis = [0, 0, 1]\nstiffness = 50\n'
    )
    path = write_strips(tmp_path, study=STUDY + clip.format("left") + clip.format("right"))
    named, numbered = (creak.change_study(path, {f"clip.{row}.stiffness": 70.0}) for row in ("right", 1))
    assert named.config == numbered.config
    assert [clip.stiffness for clip in named.config.clip] == [50.0, 70.0]
    both = {"clip.right.stiffness": 70.0, "clip.1.stiffness": 60.0}
    assert "change the same" in str(refusal(creak.change_study, path, both))
    assert "clip.0 to clip.1, clip.left, clip.right" in str(refusal(creak.change_study, path, {"clip.up.gap": 1.0}))


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda s, d: creak.change_study(s, {"reduction.f_maks": 7}), "unknown key 'reduction.f_maks'"),
        (lambda s, d: creak.change_study(s, {"contact.tipp.friction": 0.2}), "no .contact.tipp"),
        (lambda s, d: creak.make_study({"model": {"deck": object()}}), "make_study: object has no place"),
        (lambda s, d: creak.make_study({}), "model"),
        (lambda s, d: creak.run(d / "model.bdf"), "model.bdf"),
        (lambda s, d: creak.read_study(d / "none.toml"), "no such study file"),
        (lambda s, d: creak.read_deck(d / "none.inp"), "none.inp"),
    ],
)
def test_wrong_studies_get_one_clear_message(tmp_path, call, text):
    study = creak.read_study(write_strips(tmp_path))
    with pytest.raises(creak.InputError, match=text):
        call(study, tmp_path)


def test_a_study_that_stops_early_warns(monkeypatch):
    monkeypatch.setattr("creak.api.study.set_up", lambda *_, **__: None)
    monkeypatch.setattr(
        "creak.api.study.run_setup", lambda *_, **__: SimpleNamespace(stopped="reduced run: diverged", unreliable=[])
    )
    with pytest.warns(RuntimeWarning, match="ended early: reduced run: diverged"):
        creak.run("x.toml")


def test_decks_by_path_as_text(tmp_path):
    (tmp_path / "strips.inp").write_text(two_strips())
    model = creak.read_deck(f"{tmp_path}/strips.inp")
    assert model.nodes.count == 78
    modes = creak.deck_modes(f"{tmp_path}/strips.inp", count=3)
    assert len(modes.frequencies) == 3
    assert [p.name for p in creak.write_door(tmp_path / "door", 40.0)] == ["door.inp", "door.toml"]


def test_a_result_tells_what_it_is(result, tmp_path):
    result.save(tmp_path)
    for one in (result, creak.open_result(tmp_path)):
        said = repr(one)
        assert said.startswith(f"<{type(one).__name__} 'Two strips': runs: reduced, reference; events: ")
        assert f"{len(result.events)} contact events, the hardest at " in said
        assert f"verdict: {result.summary['runs']['reduced']['verdict']}" in said
        page = one._repr_html_()
        assert page.count("<tr>") > len(result.events[:10])
        assert "impulse, N s" in page


def test_events_are_a_list_and_a_table(result, monkeypatch):
    events = result.events
    assert events == result.main.events
    row = events.rows()[0]
    assert row["impulse"] == events[0].impulse
    assert row["node"] == result.found.setup.model.nodes.label(events[0].node_idx)
    assert set(events.units()) == set(row)
    assert events.units()["closing_speed"] == "mm/s"
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(creak.InputError, match=r"pip install 'creak\[pandas\]', or use events.rows\(\)"):
        events.to_frame()
    with pytest.raises(creak.InputError, match="no table 'gaps'; expected 'events', 'places' or 'elines'"):
        result.to_frame("gaps")


class Frame:
    """What creak asks of a DataFrame."""

    def __init__(self, rows, columns):
        self.rows, self.columns, self.attrs = rows, columns, {}


@pytest.mark.parametrize("kind", ["events", "places", "elines"])
def test_tables_go_to_pandas_with_their_units(result, tmp_path, monkeypatch, kind):
    """Every column is in every row, of the run and of what it left on disk."""
    result.save(tmp_path)
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=Frame))
    for one in (result, creak.open_result(tmp_path)):
        frame = one.to_frame(kind)
        assert frame.rows
        assert all(set(frame.columns) <= set(row) for row in frame.rows)
        assert list(frame.attrs["units"]) == frame.columns
    if kind == "elines":
        (line,) = result.summary["elines"]["lines"]
        assert [row["run"] for row in frame.rows] == ["linear", "contact"]
        assert [row["margin"] for row in frame.rows] == [line["linear"]["margin"], line["contact"]["margin"]]
        assert frame.attrs["units"]["margin"] == "mm"
    else:
        run = result.summary["runs"]["reduced"]
        total = run["impulse_total"] if kind == "events" else sum(place["impulse"] for place in run["places"])
        assert sum(row["impulse"] for row in frame.rows) == pytest.approx(total)
        assert frame.attrs["units"]["force"] == "N"


def test_tables_are_frames_where_there_is_pandas(result):
    pandas = pytest.importorskip("pandas", reason="pip install 'creak[pandas]'")
    for kind in ("events", "places", "elines"):
        frame = result.to_frame(kind)
        assert isinstance(frame, pandas.DataFrame)
        assert len(frame) > 0
    assert frame["margin"].min() == result.summary["elines"]["lines"][0]["linear"]["margin"]


def test_names_in_a_notebook_are_text(result):
    told = creak.Events(result.events[:1], ["<b>9</b>"], "mm-t-s")
    assert "<b>" not in told._repr_html_()
    assert repr(creak.Events([], [], "mm-t-s")) == "<no contact events>"


@pytest.mark.parametrize("kind", ["force", "gap", "energy"])
def test_a_result_draws_itself(result, kind):
    drawn = result.plot(kind)
    assert type(drawn).__module__.startswith("plotly.graph_objs")
    assert len(drawn.data) >= 2
    assert drawn.layout.xaxis.title.text == "time, s"


def test_a_figure_that_there_is_not(result):
    with pytest.raises(creak.InputError, match=r"no figure 'sound'.* expected 'force' or 'gap'"):
        result.plot("sound")


@pytest.mark.parametrize("name", ["plot", "events", "save", "report", "page", "notes", "main"])
def test_each_has_help(name):
    assert getattr(creak.Result, name).__doc__
