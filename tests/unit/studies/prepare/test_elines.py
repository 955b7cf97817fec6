"""E-lines of a study: points, frames, the limit without contact, what linear gets wrong, and wrong input."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from creak.errors import InputError
from creak.report.html import report_text
from creak.report.words.text import NONE
from creak.studies.file.eline_tables import LimitTable
from creak.studies.file.reader import read_study
from creak.studies.findings.elines import as_dict, line_rows, point_csv
from creak.studies.findings.limits import judged
from creak.studies.prepare.elines import Eline
from creak.studies.prepare.setup import set_up
from creak.studies.run.elines import LineFindings
from creak.studies.run.job import run_study
from creak.studies.run.screen import screen
from creak.verify.elines import PointMeasures
from helpers_decks import STUDY, two_strips, write_strips
from helpers_findings import summarised, to_draw

RECORDED = {"section": "verdicts"}

EXACT = STUDY.replace("step = 5e-4\nperiods = 2", 'accuracy = "quick"\nperiods = 1').replace(
    "[time]", "[reference]\nrun = false\n\n[time]"
)
LINES = """
[limit]
tolerance = "50 um"

[eline.tips]
main = "TIP_LOWER"
secondary = "TIP_UPPER"
clearance = 0.3

[eline.roots]
main = "OVER"
secondary = "ROOT_UPPER"
tolerance = "0.1 mm"
"""


def quiet(*_):
    """No progress."""


def made(folder, gap=0.3, more=LINES, study=EXACT):
    return set_up(read_study(write_strips(folder, two_strips(gap), study + more)))


@pytest.fixture(scope="module")
def rattling(tmp_path_factory):
    return run_study(made(tmp_path_factory.mktemp("rattling")), quiet)


@pytest.fixture(scope="module")
def silent(tmp_path_factory):
    """Contact that is kept and never closes."""
    study = EXACT.replace("[reduction]", "[precheck]\nenabled = false\n\n[reduction]")
    return run_study(made(tmp_path_factory.mktemp("silent"), 5.0, LINES.replace("clearance = 0.3\n", ""), study), quiet)


def test_contacts_are_lines_by_themselves(rattling):
    found = rattling.elines
    assert [(line.name, line.contact) for line in found.lines] == [("tip", True), ("tips", False), ("roots", False)]
    assert found.tolerance == pytest.approx(np.array([0.05, 0.05, 0.1])[found.line_of])
    assert np.bincount(found.line_of).tolist() == [39, 3, 3]
    assert found.gap0[found.line_of == 1] == pytest.approx(0.3)
    # A node set has no thickness of its own, the main surface has .75 on this side.
    assert found.gap0[found.line_of == 2] == pytest.approx(0.3 + 0.5)


def test_frames_are_right_handed_with_x_along_the_line(rattling):
    found = rattling.elines
    np.testing.assert_allclose(
        found.frames @ found.frames.transpose(0, 2, 1), np.tile(np.eye(3), (45, 1, 1)), atol=1e-12
    )
    assert np.linalg.det(found.frames) == pytest.approx(np.ones(45))
    np.testing.assert_allclose(found.frames[:, 2], np.tile([0.0, 0.0, 1.0], (45, 1)), atol=1e-12)
    np.testing.assert_allclose(found.frames[found.line_of == 0][:, 0], np.tile([1.0, 0.0, 0.0], (39, 1)), atol=1e-12)
    np.testing.assert_allclose(found.frames[found.line_of == 1][:, 0], np.tile([0.0, 1.0, 0.0], (3, 1)), atol=1e-12)


def test_without_contact_both_runs_measure_the_same(silent, measured):
    """Channels are there and never close: linear and nonlinear differ by round-off."""
    assert silent.gaps.m == 39
    assert not silent.runs["reduced"].history.force.any()
    found, worst = silent.elines, 0.0
    for name in found.linear.__dataclass_fields__:
        a, b = getattr(found.linear, name), getattr(found.contact, name)
        scale = max(float(found.linear.across.max()), 1e-300)
        worst = max(worst, float(np.abs(a - b).max()) / scale)
    assert found.linear.across.max() > 1.0
    rows = line_rows(found, silent.setup.study.config.limit, "mm-t-s")
    assert {r.outcome for r in rows} == {"neither"}
    measured(
        "E-lines without contact: linear against nonlinear", worst, 0.0, abs=1e-9, unit="-", source="same equations"
    )


def test_margin_is_gap_less_tolerance_less_closing(rattling):
    found = rattling.elines
    rows = {r.line.name: r for r in line_rows(found, rattling.setup.study.config.limit, "mm-t-s")}
    for row in rows.values():
        for figures in (row.linear, row.contact):
            assert figures.margin == pytest.approx(figures.gap - figures.tolerance - figures.closing, abs=1e-12)
    # The upper strip's root moves by the excitation alone: contact cannot change it.
    assert rows["roots"].linear.closing == pytest.approx(rows["roots"].contact.closing, rel=0.2)
    # Contact stops the tip where its gap is used up; without it the strips pass through each other.
    assert rows["tip"].linear.closing > 5.0 * rows["tip"].linear.gap
    assert 0.29 < rows["tip"].contact.closing < 0.35
    assert (rows["tip"].outcome, rows["roots"].outcome) == ("both", "neither")
    assert found.touched[found.line_of == 0].any()
    assert not found.touched[found.line_of > 0].any()


def test_a_line_that_contact_shields_is_a_false_alarm(tmp_path):
    """A stop with a clearance of .1 keeps the tips from a gap of .9 that the linear run closes."""
    more = LINES.replace("clearance = 0.3", "clearance = 0.9")
    result = run_study(made(tmp_path, 0.1, more), quiet)
    summary = summarised(result)["elines"]
    outcome = {line["name"]: line["outcome"] for line in summary["lines"]}
    assert outcome == {"tip": "both", "tips": "false alarm", "roots": "neither"}
    assert (summary["false_alarms"], summary["misses"]) == (1, 0)
    # All three tips, and what of the contact linear closes and contact does not.
    assert summary["points_false_alarms"] >= 3
    tips = next(line for line in summary["lines"] if line["name"] == "tips")
    assert tips["linear"]["risk"]
    assert tips["linear"]["points_at_risk"] == 3
    assert tips["contact"]["margin"] > 0.0
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary


def test_screening_needs_no_contact_and_agrees_with_the_linear_run(tmp_path, rattling):
    bare = EXACT[: EXACT.index("[contact.tip]")] + EXACT[EXACT.index("[excitation.root]") :]
    setup = made(tmp_path, study=bare)
    assert setup.contacts.m == 0
    found = screen(setup, quiet)
    assert found.contact is None
    full = rattling.elines
    for name in ("tips", "roots"):
        a, b = (
            next(r for r in line_rows(f, setup.study.config.limit, "mm-t-s") if r.line.name == name)
            for f in (found, full)
        )
        assert a.linear.closing == pytest.approx(b.linear.closing, rel=0.01)  # modes to three times the excitation
        assert a.outcome is None


def test_the_unreduced_model_alone_is_measured_too(tmp_path):
    study = EXACT.replace("[reduction]\nf_max = 3000", '[reduction]\nmethod = "none"').replace(
        "periods = 1", "end = 0.05"
    )
    result = run_study(made(tmp_path, study=study), quiet)
    found = result.elines
    assert found.without.startswith("modes up to")
    assert found.contact is not None
    assert found.linear is not None
    assert np.isfinite(found.contact.closing).all()


def test_points_by_coordinates_and_by_files(tmp_path):
    (tmp_path / "places.csv").write_text("x,y,z\n120,0,1\n120,0.1,1\n120,20,1\n")
    (tmp_path / "nodes.csv").write_text("main,secondary\n1013,13\n1039,39\n")
    more = """
[eline.listed]
main = "TIP_LOWER"
secondary = "UPPER"
points = [[0, 0, 1], [60, 10, 1]]
[eline.placed]
main = "OVER"
secondary = "UPPER"
points = "places.csv"
[eline.named]
points = "nodes.csv"
"""
    e = made(tmp_path, more=more).watch.lines
    nodes = {line.name: e.points.nodes_idx[e.line_of == k].tolist() for k, line in enumerate(e.lines)}
    ids = {13: 12, 39: 38, 1: 0, 20: 19}
    assert nodes["placed"] == [ids[13], ids[39]]  # two of the places have the same nearest node
    assert nodes["named"] == [ids[13], ids[39]]
    assert nodes["listed"] == [ids[1], ids[20]]
    z = e.frames[e.line_of == [line.name for line in e.lines].index("listed")][:, 2]
    assert z[0] @ [-1.0, 0.0, 0.0] > 0.99  # from the tips of the lower strip to the root of the upper one


def test_the_page_shows_them(rattling):
    page = report_text(*to_draw(rattling))
    assert 'id="elines"' in page
    assert re.search(
        r"raises no false alarms and misses no lines; of single points it raises \d+ and misses \d+\.", page
    )
    assert "linear_margin_mm" in page
    text = point_csv(rattling.elines, rattling.setup.model, "mm")
    assert len(text.splitlines()) == 46


WRONG = {
    "unknown set": ('[eline.a]\nmain = "OVER"\nsecondary = "UPPERR"\n', ["UPPERR", "UPPER"]),
    "unknown main": ('[eline.a]\nmain = "OVR"\nsecondary = "UPPER"\n', ["OVR", "OVER"]),
    "no points": ("[eline.tp]\n", ["[eline.tp]", "'tip'"]),
    "contact drawn": ('[eline.tip]\nmain = "OVER"\nsecondary = "UPPER"\n', ["eline.tip", "another name"]),
    "one side": ('[eline.a]\nmain = "OVER"\n', ["both main and secondary"]),
    "no unit": ("[limit]\ntolerance = 0.3\n", ["limit.tolerance", "0.3", "without its unit", '"0.3 mm"']),
    "no unit in text": ('[limit]\ntolerance = "0.3"\n', ["without its unit"]),
    "wrong unit": ('[limit]\nin_plane = "3 dB"\n', ["'dB'", "um, mm, cm, m"]),
    "negative": ('[limit]\ntolerance = "-0.3 mm"\n', ["negative"]),
    "unknown pair": ('[eline.tip]\nmaterial = "pvc"\n', ["unknown material pair 'pvc'"]),
    "no source": (
        "[material-pair.a]\nimpulse_rate_min = 1\nimpulse_rate_max = 2\n",
        ["material-pair.a.source", "missing"],
    ),
    "empty source": ('[material-pair.a]\nsource = " "\nimpulse_rate_min = 1\nimpulse_rate_max = 2\n', ["source"]),
    "rates": ('[material-pair.a]\nsource = "rig"\nimpulse_rate_min = 3\nimpulse_rate_max = 2\n', ["impulse_rate_min"]),
    "misspelt": ('[material-pair.a]\nsource = "rig"\nimpulse_rate = 3\n', ["impulse_rate_min"]),
    "misspelt table": ('[materialpair.a]\nsource = "rig"\n', ["material-pair"]),
    "turned normal": (
        '[eline.a]\nmain = "TIP_LOWER"\nsecondary = "TIP_UPPER"\nnormal = [0, 0, -1]\n',
        ["behind", "[eline.a.normal]", "exchange"],
    ),
    "far places": (
        '[eline.a]\nmain = "TIP_LOWER"\nsecondary = "UPPER"\npoints = [[60, 10, 1], [600, 10, 1]]\n',
        ["[eline.a] points", "(600, 10, 1)", "480", "deck's axes and units"],
    ),
    "places of one side alone": (
        '[eline.a]\nmain = "OVER"\nsecondary = "TIP_UPPER"\npoints = [[120, 10, 1], [60, 10, 1]]\n',
        ["[eline.a] points", "(60, 10, 1) does not lie between 'OVER' and 'TIP_UPPER'", " mm off"],
    ),
    "same place": ('[eline.a]\nmain = "TIP_UPPER"\nsecondary = "TIP_UPPER"\n', ["one place", "normal"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_one_message(case, tmp_path):
    more, words = WRONG[case]
    with pytest.raises(InputError, match=r"\w") as error:
        made(tmp_path, more="\n" + more)
    for word in words:
        assert word in str(error.value)
    assert "study.toml" in str(error.value)


FILES = {
    "columns": ("a,b\n1,2\n", ["a,b", "x,y,z or main,secondary"]),
    "no rows": ("x,y,z\n", ["no rows"]),
    "no number": ("x,y,z\n1,2,three\n", ["lines.csv:2", "1,2,three"]),
    "too few": ("x,y,z\n1,2\n", ["lines.csv:2"]),
    "no node": ("main,secondary\n13,99999\n", ["lines.csv:2", "99999"]),
    "both": ("main,secondary\n13,1013\n", ["Leave out main and secondary"]),
}


@pytest.mark.parametrize("case", FILES)
def test_a_wrong_file_of_points_is_one_message(case, tmp_path):
    text, words = FILES[case]
    (tmp_path / "lines.csv").write_text(text)
    with pytest.raises(InputError, match=r"\w") as error:
        made(tmp_path, more='\n[eline.a]\nmain = "OVER"\nsecondary = "UPPER"\npoints = "lines.csv"\n')
    for word in words:
        assert word in str(error.value)


def test_coordinates_without_sides_and_a_missing_file(tmp_path):
    (tmp_path / "lines.csv").write_text("x,y,z\n0,0,0\n")
    with pytest.raises(InputError, match="main and secondary"):
        made(tmp_path, more='\n[eline.a]\npoints = "lines.csv"\n')
    with pytest.raises(InputError, match="no such file of points"):
        made(tmp_path, more='\n[eline.a]\npoints = "liens.csv"\n')


def test_nothing_to_screen(tmp_path):
    bare = EXACT[: EXACT.index("[contact.tip]")] + EXACT[EXACT.index("[excitation.root]") :]
    with pytest.raises(InputError, match="nothing to screen"):
        screen(made(tmp_path, more="", study=bare), quiet)


def test_material_pairs_of_a_file(tmp_path):
    pair = '[material-pair.pvc]\nsource = "own rig, 2026"\nimpulse_rate_min = 0.5\nimpulse_rate_max = 2\n'
    (tmp_path / "pairs.toml").write_text(pair)
    study = 'material_pairs = "pairs.toml"\n' + EXACT
    setup = made(tmp_path, more='\n[eline.tip]\nmaterial = "pvc"\n', study=study)
    assert setup.watch.lines.lines[0].pair.impulse_rate_max == 2.0
    with pytest.raises(InputError, match=r"in the study and in pairs\.toml"):
        made(tmp_path, more="\n" + pair, study=study)
    (tmp_path / "pairs.toml").write_text(pair.replace("source", "sauce"))
    with pytest.raises(InputError, match=r"pairs.toml:.*'material-pair.pvc.sauce'"):
        made(tmp_path, more="", study=study)


def rubbing(folder, friction, gap=0.0, press=3.0):
    """The lower strip rests on the upper one and its root is drawn along it; the contact is soft, for long steps."""
    deck = two_strips(gap).replace("ROOT_UPPER, 1, 2", "ROOT_UPPER, 2, 2")
    study = f"""title = "Rub"
[model]
deck = "strips.inp"
[contact.tip]
secondary = "UNDER"
main = "OVER"
stiffness = 100.0
clearance = {gap}
friction = {friction}
[excitation.along]
node_set = "ROOT_UPPER"
dof = "x"
signal = {{ type = "sine", frequency = 50, amplitude = 0.2 }}
[excitation.press]
node_set = "TIP_UPPER"
dof = "z"
kind = "force"
signal = {{ type = "step", amplitude = {-press} }}
[damping]
modal = 0.02
[reference]
run = false
[time]
accuracy = "quick"
periods = 2
[eline.tip]
material = "pvc"
[material-pair.pvc]
source = "rig <1>, 2026"
impulse_rate_min = 2.0
impulse_rate_max = 4.0
normal_force = 10.0
temperature = 23.0
"""
    deck = deck.replace("*BOUNDARY\n", "*BOUNDARY\nROOT_UPPER, 3, 3\n")
    return run_study(set_up(read_study(write_strips(folder, deck, study))), quiet)


def test_linear_squeak_is_in_plane_motion_against_the_travel_of_an_impulse(tmp_path):
    """.4 mm of travel at 2 to 4 impulses per mm: longer than 1/4 mm, not longer than 1/2 mm. The sides that rub move by
    2 % less than the nodes, since the strips bend."""
    result = rubbing(tmp_path, "{ static = 0.5, kinetic = 0.3 }")
    (row,) = line_rows(result.elines, result.setup.study.config.limit, "mm-t-s")
    assert row.squeak_travel == pytest.approx((0.25, 0.5))
    assert row.linear.in_plane == pytest.approx(0.4, rel=0.025)
    assert row.linear.squeak == "possible"
    summary = summarised(result)
    (line,) = summary["elines"]["lines"]
    assert (line["material"], line["linear"]["squeak"]) == ("pvc", "possible")
    (squeak,) = summary["runs"]["reduced"]["squeak"]
    assert squeak["slips"] >= 1
    assert squeak["per_length"] == pytest.approx(squeak["slips"] / squeak["travel"])
    assert squeak["measured_per_length"] == pytest.approx([2.0, 4.0])
    expected = "below" if squeak["per_length"] < 2.0 else "within" if squeak["per_length"] <= 4.0 else "above"
    assert squeak["against_measured"] == expected
    page = report_text(*to_draw(result))
    assert "Squeak of each contact" in page
    assert "pvc: rig &lt;1&gt;, 2026" in page
    # Source and conditions beside the figures that they are of; what was not measured has a dash.
    told = summary["elines"]["material_pairs"]["pvc"]
    assert (told["source"], told["impulse_rate_max"], told["temperature"]) == ("rig <1>, 2026", 4.0, 23.0)
    table = page[page.index("Materials that rub") :]
    row = table[table.index("<td>pvc</td>") : table.index("</tbody>")]
    cells = re.findall("<td>(.*?)</td>", row)
    assert cells[1:4] == ["tip", "rig &lt;1&gt;, 2026", "2.00 to 4.00"]
    assert (cells[6], cells[7:]) == (NONE, ["10.0", NONE, "23.0", NONE])


def test_a_line_that_never_closes_cannot_squeak(tmp_path):
    """The same strips 5.5 mm apart: .4 mm of travel along, and the gap stays open in both runs."""
    result = rubbing(tmp_path, "{ static = 0.5, kinetic = 0.3 }", gap=5.5, press=0.3)
    setup = result.setup
    (row,) = line_rows(result.elines, setup.study.config.limit, "mm-t-s")
    for figures in (row.linear, row.contact):
        assert figures.in_plane == pytest.approx(0.4, rel=0.01)
        assert figures.margin > 2.0
        assert (figures.squeak, figures.risk, figures.in_plane_touching) == ("no", False, 0.0)
    # What scatter may take of the gap closes it: points that can touch can squeak.
    tolerant = replace(result.elines, tolerance=np.full(result.elines.gap0.size, 5.5))
    (row,) = line_rows(tolerant, setup.study.config.limit, "mm-t-s")
    assert row.linear.squeak == "possible"
    assert row.linear.in_plane_touching == pytest.approx(0.4, rel=0.01)
    # Nor does it break a limit of the motion in the plane, which is one of squeak.
    limit = LimitTable(in_plane="0.1 mm")
    bare = replace(result.elines, lines=(replace(result.elines.lines[0], pair=None, material=None),))
    summary = summarised(result) | {"elines": as_dict(bare, limit, "mm-t-s", setup.model)}
    assert [one["failed"] for one in judged(limit, summary)] == [[]]
    assert summary["elines"]["lines"][0]["linear"]["squeak"] == "no"


def test_only_points_that_can_touch_are_looked_at_for_squeak():
    """Two points: the one that closes does not move along, the other one does and stays open."""
    n = 2
    none, line = np.zeros(n), Eline("l", False, "", None, None)
    motion = PointMeasures(np.array([1.2, 0.1]), none, none, np.zeros((n, 2)), np.array([0.01, 5.0]), none)
    where = (np.zeros(n, dtype=np.int64), np.arange(n), np.zeros((n, 3)), np.zeros((n, 3, 3)))
    for gap, says in ((np.array([1.0, 1.0]), "no"), (np.array([1.0, 0.1]), "yes")):
        found = LineFindings((line,), *where, gap, none, 95.0, motion, None, None, "", "")
        (row,) = line_rows(found, LimitTable(in_plane="1 mm"), "mm-t-s")
        assert (row.linear.squeak, row.linear.in_plane) == (says, 5.0)
