"""`creak report`: the page of an earlier run, from its files alone; and the motion and histories of that run."""

import csv
import json
import re
import shutil
import xml.etree.ElementTree as ET

import h5py
import numpy as np
import pytest

from creak.signals.spectra import largest
from helpers_cli import say
from helpers_decks import STUDY, write_strips
from helpers_punch import punched
from helpers_uff import data_sets, fields
from helpers_vtu import arrays

WRITTEN = re.compile(r"<th>Report written</th><td>[^<]*</td>")
SHORT = STUDY.replace("periods = 2", "end = 0.1\n[output]\nfield_interval = 0.01").replace(
    "0.05, period", "0.3, period"
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The results of a run whose deck and study are gone, and the page that it wrote."""
    folder = tmp_path_factory.mktemp("made")
    study = write_strips(folder, study=SHORT)
    assert say("run", study, "--quiet", "--out", folder / "out").status == 0
    study.unlink()
    (folder / "strips.inp").unlink()
    return folder / "out"


@pytest.fixture
def folder(made, tmp_path):
    return shutil.copytree(made, tmp_path / "results")


def test_the_page_is_the_one_that_the_run_wrote(creak, folder):
    page = folder / "report.html"
    before = page.read_text(encoding="utf-8")
    page.unlink()
    said = creak("report", folder).done()
    assert f"wrote {page}" in said.out
    assert WRITTEN.sub("", page.read_text(encoding="utf-8")) == WRITTEN.sub("", before)
    assert sorted(p.name for p in folder.iterdir()) == ["report.html", "results.h5", "summary.json"]
    assert 'id="motion-event"' in before


def test_the_page_goes_where_it_is_asked_to_go(creak, folder, tmp_path):
    said = creak("report", folder, "--out", tmp_path / "new" / "page.html", "--quiet")
    assert (said.status, said.out, said.err) == (0, "", "")
    assert (tmp_path / "new" / "page.html").stat().st_size > 1e6
    assert creak("report", folder, "--out", tmp_path).status == 2


def test_what_cannot_be_read_ends_in_one_line_and_leaves_the_old_page(creak, folder):
    page = folder / "report.html"
    page.write_text("old")
    results = folder / "results.h5"
    results.write_bytes(results.read_bytes()[:20_000])
    said = creak("report", folder)
    assert said.status == 2
    assert said.err.count("creak: ") == 1
    assert "cut short or damaged" in said.err
    results.unlink()
    assert creak("report", folder).status == 2
    assert creak("report", folder / "nowhere").status == 2
    assert page.read_text() == "old"
    assert sorted(p.name for p in folder.iterdir()) == ["report.html", "summary.json"]


def test_a_file_in_place_of_its_folder_is_told_with_the_folder(creak, folder):
    for command in ("report", "listen"):
        said = creak(command, folder / "results.h5")
        said.refuses(f"no such results: {folder / 'results.h5'}", f"Give the folder, {folder}.")


def test_motion_becomes_a_series(creak, folder, tmp_path):
    said = creak("convert", folder / "results.h5", tmp_path / "motion.pvd", "--run", "reference").done()
    assert "11 instants of the reference run" in said.words
    sets = [s.attrib for s in ET.parse(tmp_path / "motion.pvd").iter("DataSet")]
    with h5py.File(folder / "results.h5") as file:
        field = file["runs/reference/field"]
        np.testing.assert_array_equal([float(s["timestep"]) for s in sets], field["time"])
        found = arrays(tmp_path / sets[-1]["file"])
        np.testing.assert_allclose(found["displacement"], field["displacement"][-1], rtol=6e-8, atol=1e-38)
        np.testing.assert_array_equal(found["Points"], field["coordinates"])
    assert found["types"].tolist() == [9] * 48


def functions(path):
    """Node, direction, kind, start, step and values of each data set 58: fields and lines as the format has them."""
    units, *sets = data_sets(path)
    assert units[0] == 164
    for number, lines in sets:
        assert number == 58
        names, shape, time, kind = lines[5:9]
        assert (int(names[:5]), int(time[:10])) == (1, 17)
        assert [int(shape[i : i + 10]) for i in (0, 20)] == [4, 1]
        values = [float(x) for line in lines[11:] for x in fields(line, 20)]
        assert len(values) == int(shape[10:20])
        yield int(names[41:51]), int(names[51:55]), int(kind[:10]), float(shape[30:43]), float(shape[43:56]), values


def moved(folder):
    """Times, nodes and relative motion of the points of E-lines that a run keeps."""
    with h5py.File(folder / "results.h5") as file:
        lines = file["runs/reduced/elines"]
        return lines["time"][()], lines["node_ids"][()], lines["motion"][()].astype(float)


def test_the_motion_of_a_contact_s_line_is_its_gap(folder):
    """z of each point against the gap of its channel; the measures of the line against the motion itself."""
    time, _, motion = moved(folder)
    with h5py.File(folder / "results.h5") as file:
        run, lines = file["runs/reduced"], file["findings/elines"]
        rows = np.searchsorted(run["time"][()], time - 1e-9)
        np.testing.assert_allclose(run["time"][()][rows], time, rtol=1e-12)
        column = [run["channels"].asstr()[()].tolist().index(name) for name in run["elines/points"].asstr()[()]]
        opened = run["gap"][()][rows][:, column] - lines["gap0"][()]
        np.testing.assert_allclose(motion[:, :, 2], opened, atol=1e-6 * np.abs(opened).max())
        touched = np.where(lines["touched"][()], lines["gap0"][()], -np.inf)
        closing = np.maximum(largest(-motion[:, :, 2]), touched)
        np.testing.assert_allclose(closing, lines["contact/closing"][()], rtol=1e-6)
        along = [largest(motion[:, :, k]) + largest(-motion[:, :, k]) for k in range(2)]
        np.testing.assert_allclose(np.stack(along, axis=1), lines["contact/along"][()], atol=1e-6)


def test_histories_become_a_punch_file(creak, folder, tmp_path):
    """Every number to the seven digits of the format; points by their nodes, named by the label."""
    said = creak("convert", folder / "results.h5", tmp_path / "histories.pch").done()
    assert "39 points of E-lines" in said.words
    found = punched(tmp_path / "histories.pch")
    line_time, line_nodes, motion = moved(folder)
    with h5py.File(folder / "results.h5") as file:
        run = file["runs/reduced"]
        time, nodes, channels = run["time"][()], run["node_ids"][()], run["channel_nodes"][()]
        displacement, force = run["displacement"][()], run["normal_force"][()]
        names = run["channels"].asstr()[()]
    expected = [("$DISPLACEMENTS", 1, n, time, displacement[:, k]) for k, n in enumerate(nodes)]
    expected += [
        ("$DISPLACEMENTS", 2, n, line_time, np.pad(motion[:, k], ((0, 0), (0, 3)))) for k, n in enumerate(line_nodes)
    ]
    expected += [("$MPCF", 3, n, time, np.outer(force[:, k], [0, 0, 1, 0, 0, 0])) for k, n in enumerate(channels)]
    assert len(found) == len(expected)
    for output, (kind, subcase, node, of, numbers) in zip(found, expected, strict=True):
        assert output.head[3:5] == [kind, "$REAL OUTPUT"]
        assert output.after("$SUBCASE ID =") == str(subcase)
        assert output.after("$POINT ID =") == f"{node}  IDENTIFIED BY TIME"
        np.testing.assert_allclose([*output.rows], of, rtol=5.1e-7)
        np.testing.assert_allclose([*output.rows.values()], numbers, rtol=5.1e-7, atol=1e-99)
    assert found[-1].after("$LABEL   =").endswith(names[-1])
    assert found[0].after("$SUBTITLE=") == "written by creak: mm, N, s"
    # A file of creak gives way to another one, a punch file of another program does not.
    assert creak("convert", folder / "results.h5", tmp_path / "histories.pch", "--run", "reference").status == 0
    other = (tmp_path / "histories.pch").read_text().replace("written by creak: mm, N, s", "a load case of the door   ")
    (tmp_path / "histories.pch").write_text(other)
    said = creak("convert", folder / "results.h5", tmp_path / "histories.pch")
    said.refuses("no file that creak wrote")
    assert (tmp_path / "histories.pch").read_text() == other


def test_histories_become_functions_of_a_universal_file(creak, folder, tmp_path):
    creak("convert", folder / "results.h5", tmp_path / "histories.unv").done()
    found = list(functions(tmp_path / "histories.unv"))
    with h5py.File(folder / "results.h5") as file:
        run = file["runs/reduced"]
        time, nodes, channels = run["time"][()], run["node_ids"][()], run["channel_nodes"][()]
        displacement, force = run["displacement"][()], run["normal_force"][()]
    assert force.any()
    expected = [(n, axis + 1, 8, displacement[:, k, axis]) for k, n in enumerate(nodes) for axis in range(3)]
    line_time, line_nodes, motion = moved(folder)
    relative = [(n, axis + 1, 8, motion[:, k, axis]) for k, n in enumerate(line_nodes) for axis in range(3)]
    expected += [*relative, *((n, 0, 9, force[:, k]) for k, n in enumerate(channels))]
    assert len(found) == len(expected)
    for (node, direction, kind, start, step, values), (*what, numbers) in zip(found, expected, strict=True):
        assert [node, direction, kind] == what
        of = line_time if numbers.base is motion else time
        np.testing.assert_allclose(start + step * np.arange(of.size), of, atol=1e-5 * time[-1])
        np.testing.assert_allclose(values, numbers, rtol=1e-12, atol=1e-99)


def test_lines_and_places_become_points(creak, folder, tmp_path):
    """Figures of the points against summary.json: of the worst point of the line, of the place, of all impulses."""
    said = creak("convert", folder / "results.h5", tmp_path / "found.vtu").done()
    found, summary = arrays(tmp_path / "found.vtu"), json.loads((folder / "summary.json").read_text())
    (line,), run = summary["elines"]["lines"], summary["runs"]["reduced"]
    assert found["types"].size == found["eline"].size == len(found["Points"])
    for key in ("linear", "contact"):
        assert found[f"{key}_margin"].min() == pytest.approx(line[key]["margin"], rel=1e-12)
    assert set(found["place"].astype(int)) - {0} == set(range(1, 1 + len(run["places"])))
    first = found["place"] == 1
    assert set(found["node"][first].astype(int)) == set(run["places"][0]["nodes"])
    assert set(found["place_impulse"][first]) == {run["places"][0]["impulse"]}
    assert found["impulse"].sum() == pytest.approx(run["impulse_total"], rel=1e-9)
    assert np.isnan(found["place_force"][~(found["place"] > 0)]).all()
    said = creak("convert", folder / "results.h5", tmp_path / "found.vtu", "--run", "reference")
    said.refuses("those of the main run")


def test_histories_become_a_table(creak, folder, tmp_path):
    creak("convert", folder / "results.h5", tmp_path / "histories.csv", "--run", "reference").done()
    with (tmp_path / "histories.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    with h5py.File(folder / "results.h5") as file:
        run = file["runs/reference"]
        parts = [
            run["time"][()][:, None],
            run["displacement"][()].reshape(len(rows), -1),
            run["gap"][()],
            run["normal_force"][()],
            run["peak_force"][()],
        ]
        names = [run[key].asstr()[()] for key in ("node_names", "channels")]
    np.testing.assert_array_equal(np.array(rows, dtype=float), np.concatenate(parts, axis=1))
    n, m = (len(some) for some in names)
    assert [head[0], head[6], *head[1 + 6 * n :: m]] == [
        "time [s]",
        f"{names[0][0]} RZ [rad]",
        f"{names[1][0]} gap [mm]",
        f"{names[1][0]} normal force [N]",
        f"{names[1][0]} peak force [N]",
    ]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("results.h5", "histories.csv", "--run", "other"), "no run 'other'"),
        (("deck.inp", "histories.unv"), "cannot write a deck that ends in '.unv'"),
        (("results.h5", "motion.vtk"), "cannot write results to motion.vtk"),
        (("deck.inp", "motion.pvd"), "expected results.h5"),
        (("results.h5", "motion.pvd", "--mass", "lumped"), "are for decks"),
        (("deck.inp", "deck.bdf", "--run", "reduced"), "--run reduced with a deck"),
        (("results.h5", "motion.pvd", "--run", "other"), "no run 'other'"),
    ],
)
def test_wrong_words_for_motion(creak, folder, monkeypatch, words, text):
    monkeypatch.chdir(folder)
    said = creak("convert", *words)
    said.refuses(text)
    assert sorted(p.name for p in folder.iterdir()) == ["report.html", "results.h5", "summary.json"]
