"""Tolerances of gaps from tables as tolerance programs write them, point by point, and tables that cannot be used."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.report.html import report_text
from creak.studies.file.reader import read_study
from creak.studies.findings.elines import line_rows, point_csv
from creak.studies.findings.limits import judged, limit_words
from creak.studies.prepare.setup import set_up
from creak.studies.prepare.tolerances import points_of
from creak.studies.robust.draws import make_causes
from creak.studies.robust.job import deviations_of, fields_of
from creak.studies.run.job import run_study
from creak.studies.warned import warnings_of
from helpers_decks import STUDY, two_strips, write_strips
from helpers_findings import summarised, to_draw

GAP = 0.3
PAIRS = "id,main,secondary\nlock,1013,13\nhinge,1039,39\n"
LINE = '\n[eline.a]\npoints = "pairs.csv"\ntolerance = "gaps.csv"\n'
MAPPED = '\n[eline.a]\npoints = "pairs.csv"\ntolerance = { file = "gaps.csv", columns = { COLUMNS } }\n'
"""Nodes 13 and 39 of the upper strip lie at x = 120 and y = 0 and 20."""


def quiet(*_):
    """No progress."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tolerances")
    write_strips(folder, two_strips(GAP), STUDY)
    (folder / "pairs.csv").write_text(PAIRS)
    return folder


def made(folder, table, more=LINE, study=STUDY):
    (folder / "gaps.csv").write_bytes(table if isinstance(table, bytes) else table.encode())
    (folder / "study.toml").write_text(study + more)
    return set_up(read_study(folder / "study.toml"))


def of_line(setup, name="a"):
    e = setup.watch.lines
    return e.tolerance[e.line_of == [line.name for line in e.lines].index(name)].tolist()


def height(folder):
    nodes = made(folder, "point,minus\na,0\n").model.nodes
    return float(nodes.coords[nodes.ids.tolist().index(13), 2])


def spread_of(setup):
    """Key of a field whose tolerances a table has -> standard deviations."""
    c, points = setup.study.config, points_of(setup.watch.lines.points, setup.model)
    return deviations_of(points, c.scatter.vary, setup.study.places, c.model.units)


def test_a_row_holds_at_its_point_and_the_minus_side_counts(folder):
    for text, expected in (
        ("point,nominal,plus,minus,sigma\nlock,1.3,0.1,-0.2,\nhinge,1.3,0.2,,0.05\n", [0.2, 0.15]),
        ("sigma;minus;point\n;0,2;lock\n0,05;;hinge\n", [0.2, 0.15]),
        (
            "Report of 12 March\n\nFeature\tNom [mm]\tLSL [mm]\tUSL [mm]\nlock\t1.3\t1.1\t1.5\nhinge\t1.3\t1.15\t2\n",
            [0.2, 0.15],
        ),
        ("Name,Nominal,+Tol,-Tol\nlock,1.3,+0.1,\u22120.2\nhinge,1.3,0.3,-.15\n", [0.2, 0.15]),
        ("# um\nMeasure,Std Dev [um],Cpk\na:lock,66.6666666667,1\nA:HINGE,50,1.33\n", [0.2, 0.15]),
        ("units: m\nnode,\u00b1 Tol\n13,0.0002\n39,0.00015\n", [0.2, 0.15]),
        ("point,tol\na,0.4\nlock,0.1\n", [0.1, 0.4]),
        ("point,minus\nlock,0.1\n", [0.1, 0.1]),
    ):
        assert of_line(made(folder, text)) == pytest.approx(expected), text


def test_names_of_columns_and_which_of_two_ways_counts(folder):
    table = "Gap No;Low;Spread\nlock;-0.2;0.01\nhinge;-0.4;0.02\n"
    assert of_line(made(folder, table, MAPPED.replace("COLUMNS", 'point = "Gap No", minus = "Low"'))) == [0.2, 0.4]
    three = MAPPED.replace("COLUMNS", 'point = "gap no", sigma = "spread"')
    assert of_line(made(folder, table, three)) == pytest.approx([0.03, 0.06])
    both = "point,minus,sigma\nlock,0.2,0.01\nhinge,0.4,0.1\n"
    assert of_line(made(folder, both, MAPPED.replace("COLUMNS", 'sigma = "sigma"'))) == pytest.approx([0.03, 0.3])
    assert of_line(made(folder, both, MAPPED.replace("COLUMNS", 'minus = "minus"'))) == [0.2, 0.4]
    # Three sigma of .067 are .201: the same to what programs round.
    assert of_line(made(folder, "point,minus,sigma\na,0.2,0.067\n")) == [0.2, 0.2]


def test_places_find_the_nearest_point_and_the_others_follow(folder):
    z = height(folder)
    more = '\n[eline.a]\nmain = "OVER"\nsecondary = "UPPER"\ntolerance = "gaps.csv"\n'
    text = f"Feature,X [m],Y [m],Z [m],Minus [mm]\nF1,0.12,0,{z / 1e3},0.2\nF2,0,0.01,{z / 1e3},0.5\n"
    setup = made(folder, text, more)
    e = setup.watch.lines
    mine = e.line_of == [line.name for line in e.lines].index("a")
    near = np.linalg.norm(e.positions[mine] - [120.0, 0.0, z], axis=1)
    far = np.linalg.norm(e.positions[mine] - [0.0, 10.0, z], axis=1)
    assert e.tolerance[mine] == pytest.approx(np.where(near < far, 0.2, 0.5))
    assert set(e.tolerance[mine].tolist()) == {0.2, 0.5}
    # Of two places at one node the larger tolerance is the safe one.
    text = f"x,y,z,minus\n120,0,{z},0.2\n120,0.1,{z},0.3\n"
    assert set(of_line(made(folder, text, more))) == {0.3}


def test_the_table_of_the_limit_holds_for_every_line_but_those_with_their_own(folder):
    lines = '\n[limit]\ntolerance = "gaps.csv"\n[eline.a]\npoints = "pairs.csv"\n[eline.b]\npoints = "pairs.csv"\ntolerance = "1 um"\n'
    setup = made(folder, "point,minus\ntip,0.2\na:lock,0.1\nhinge,0.15\nb,9\n", lines)
    assert (of_line(setup), of_line(setup, "b")) == ([0.1, 0.15], [0.001, 0.001])
    assert set(of_line(setup, "tip")) == {0.2}
    assert [line.tolerance for line in setup.watch.lines.lines] == ["gaps.csv, minus", "gaps.csv, minus", ""]
    assert not setup.watch.lines.notes
    setup = made(folder, "point,sigma\na,0.1\n", lines)
    assert of_line(setup, "tip") == [0.0] * 39
    assert [line.tolerance for line in setup.watch.lines.lines] == ["", "gaps.csv, 3 sigma", ""]
    (said,) = setup.watch.lines.notes
    assert "no row for tip" in said


def test_a_nominal_gap_that_the_model_does_not_have_is_told(folder):
    gap = made(folder, "point,minus\na,0\n").watch.lines.points.gap0[-1]
    within = f"point,nominal,plus,minus\nlock,{gap - 0.05},0.1,0.2\nhinge,{gap + 0.15},0.1,0.2\n"
    assert not made(folder, within).watch.lines.notes
    setup = made(folder, f"point,nominal,plus,minus\nlock,{gap - 0.15},0.1,0.2\nhinge,{gap + 0.3},0.1,0.2\n")
    (said,) = setup.watch.lines.notes
    assert said in warnings_of(setup.notes)
    for word in ("'hinge'", "a:hinge", "gaps.csv:3", "-0.2 +0.1", "1 more"):
        assert word in said


@pytest.fixture(scope="module")
def ran(folder):
    study = STUDY.replace("step = 5e-4\nperiods = 2", 'accuracy = "quick"\nend = 0.1').replace(
        "[time]", "[reference]\nrun = false\n\n[time]"
    )
    lines = '\n[limit]\ntolerance = "gaps.csv"\n' + LINE
    return run_study(made(folder, "point,minus\nlock,0.1\nhinge,0.9\ntip,0.05\n", lines, study), quiet)


def test_margins_are_those_of_each_point(ran):
    rows = {r.line.name: r for r in line_rows(ran.elines, ran.setup.study.config.limit, "mm-t-s")}
    e, row = ran.elines, rows["a"]
    mine = np.flatnonzero(e.line_of == [line.name for line in e.lines].index("a"))
    margin = e.gap0[mine] - np.array([0.1, 0.9]) - e.linear.closing[mine]
    worst = int(margin.argmin())
    assert row.linear.margin == pytest.approx(margin[worst])
    assert (row.linear.tolerance, row.tolerance) == ([0.1, 0.9][worst], (0.1, 0.9))
    summary = summarised(ran)
    line = next(x for x in summary["elines"]["lines"] if x["name"] == "a")
    assert (line["tolerance"], line["tolerance_from"]) == (0.9, "gaps.csv, minus")
    text = point_csv(e, ran.setup.model, "mm")
    assert [row.split(",")[15] for row in text.splitlines() if row.startswith("a,")] == ["0.1", "0.9"]
    page = report_text(*to_draw(ran))
    assert f"{row.linear.tolerance:.3f} (gaps.csv, minus)" in page
    (limit,) = judged(ran.setup.study.config.limit, summary)
    assert (limit["table"], limit["allowed"]) == ("gaps.csv", 0.9)
    assert "gaps.csv (at most 0.9 mm)" in limit_words([limit])[0]


def test_a_field_of_gaps_scatters_by_the_table(folder):
    """`creak robust` draws each channel with its own sigma: a third of minus, correlated along the contact."""
    field = '[scatter.vary]\n"contact.tip.clearance" = { type = "field", tolerance = "gaps.csv", length = 50 }\n'
    setup = made(folder, "point,minus\ntip,0.24\ntip:13,0.12\n", field)
    spread = spread_of(setup)
    config = setup.study.config
    fields = fields_of(setup.contacts, setup.model.nodes)
    (cause,) = make_causes(config.scatter, {}, {}, fields, setup.study.places, spread)
    names, _, gaps, _ = fields["tip"]
    expected = np.where(np.array(names) == "tip:13", 0.04, 0.08)
    assert cause.shapes is not None
    np.testing.assert_allclose(np.linalg.norm(cause.shapes, axis=1), expected)
    np.testing.assert_array_equal(cause.mean, gaps)
    setup = made(folder, f"point,minus\ntip,{gaps.min():.17g}\n", field)  # as large as the gap: it may close
    make_causes(config.scatter, {}, {}, fields, setup.study.places, spread_of(setup))
    setup = made(folder, f"point,minus\ntip,{GAP + 0.1}\n", field)
    with pytest.raises(InputError, match="negative gaps"):
        make_causes(config.scatter, {}, {}, fields, setup.study.places, spread_of(setup))
    with pytest.raises(InputError, match=r"no point or line 'tap'.*'tip'"):
        spread_of(made(folder, "point,minus\ntap,0.3\n", field))
    with pytest.raises(InputError, match="for the gaps of a contact"):
        made(folder, "point,minus\ntip,0.3\n", field.replace('"field"', '"normal"').replace(", length = 50", ""))
    with pytest.raises(InputError, match="no number and no name of a table"):
        made(folder, "point,minus\ntip,0.3\n", field.replace('"gaps.csv"', '"0.3 mm"'))


WRONG = {
    "no side": ("point,nominal\nlock,1\n", ["gaps.csv:1", "point,nominal", "minus, sigma, or nominal,lower"]),
    "no point": ("minus,plus\n0.1,0.1\n", ["gaps.csv:1", "minus,plus", "point (or x,y,z)"]),
    "text": ("point,minus\nlock,much\n", ["gaps.csv:2", "'much'", "minus", "a finite number"]),
    "not finite": ("point,sigma\nlock,inf\n", ["gaps.csv:2", "'inf'"]),
    "blank": ("point,minus\nlock,\n", ["gaps.csv:2", "what the gap may lose", "Fill it in"]),
    "nameless": ("point,minus\n,0.2\n", ["gaps.csv:2", "without a point"]),
    "unknown": ("point,minus\nlock,0.2\nhing,0.2\n", ["gaps.csv:3", "'hing'", "Did you mean 'hinge'?"]),
    "twice": ("point,minus\nlock,0.2\nLock,0.3\n", ["gaps.csv:3", "second row", "gaps.csv:2"]),
    "two names": ("point,minus\nlock,0.2\na:lock,0.3\n", ["gaps.csv:3", "both the point a:lock", "gaps.csv:2"]),
    "contradiction": ("point,minus,sigma\nlock,0.2,0.2\n", ["gaps.csv:2", "minus is 0.2", "three sigma are 0.6"]),
    "limits": (
        "point,nominal,lower,minus\nlock,1,0.5,0.2\n",
        ["gaps.csv:2", "contradicts", "nominal less lower is 0.5"],
    ),
    "deviations": ("point,nominal,lsl,usl\nlock,1,-0.2,0.2\n", ["gaps.csv:2", "outside its limits", "minus = "]),
    "negative sigma": ("point,sigma\nlock,-0.1\n", ["gaps.csv:2", "sigma is -0.1"]),
    "negative plus": ("point,plus,minus\nlock,-0.1,-0.3\n", ["gaps.csv:2", "plus is -0.1", "lower and upper"]),
    "signs": ("point,minus\nlock,-0.1\nhinge,0.1\n", ["gaps.csv:2", "minus is -0.1", "line 3"]),
    "units": ("point,minus [kg]\nlock,0.2\n", ["gaps.csv:1", "'kg'", "um, mm, cm, m"]),
    "some units": (
        "x [m],y,z [m],minus [mm]\n120,0,90,0.2\n",
        ["gaps.csv:1", "the unit m stands for x, z and none for y", "Complete the head"],
    ),
    "no rows": ("point,minus\n", ["gaps.csv", "no rows", "point,minus"]),
    "empty": ("", ["gaps.csv", "nothing", "point (or x,y,z)"]),
    "two columns": ("point,minus,Low Tol\nlock,1,1\n", ["gaps.csv:1", "both minus", "columns = {"]),
    "far": (
        "x,y,z,minus\n120,0,90,0.2\n",
        ["gaps.csv:2", "no point within", " mm of (120, 0, 90)", " mm away", "tip:13", "columns = {"],
    ),
    "no place": ("x,y,z,minus\n120,,0,0.2\n", ["gaps.csv:2", "three finite numbers"]),
    "other line": ("point,minus\ntip,0.2\n", ["[eline.a.tolerance]", "no row", "'a'", "a:lock, a:hinge"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_table_that_cannot_be_used_is_one_message(case, folder):
    text, words = WRONG[case]
    with pytest.raises(InputError, match=r"\w") as error:
        made(folder, text)
    for word in words:
        assert word in str(error.value)


def test_wrong_keys_are_one_message(folder):
    table = "point,minus\nlock,0.2\n"
    for value, words in (
        ('"liens.csv"', ["no such table of tolerances", "liens.csv"]),
        ('"0.3"', ["eline.a.tolerance", "without its unit", "gaps.csv"]),
        ("0.3", ["eline.a.tolerance", "without its unit", '"0.3 mm"']),
        ('{ fiel = "gaps.csv" }', ["eline.a.tolerance.fiel", "Did you mean 'file'?"]),
        ('{ columns = { point = "point" } }', ["eline.a.tolerance.file", "missing"]),
        ('{ file = "gaps.csv", columns = { point = "Feature" } }', ["'Feature'", "names the columns", "tolerance"]),
        ('{ file = "gaps.csv", columns = { feature = "point" } }', ["eline.a.tolerance.columns.feature"]),
    ):
        with pytest.raises(InputError, match=r"\w") as error:
            made(folder, table, LINE.replace('"gaps.csv"', value))
        for word in words:
            assert word in str(error.value), value
