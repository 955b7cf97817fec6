"""A run replaces earlier results of its own study, and those of another study only when it is told to."""

import json

import pytest

from helpers_decks import write_strips

pytestmark = pytest.mark.usefixtures("no_page")

QUICK = """title = "Quick"
[model]
deck = "strips.inp"
[excitation.root]
node_set = "ROOT_UPPER"
dof = "z"
kind = "displacement"
signal = { type = "sine", frequency = 20, amplitude = 0.05 }
[reduction]
method = "none"
[time]
end = 2e-3
step = 1e-3
integrator = "hht"
"""


@pytest.fixture
def study(tmp_path):
    return write_strips(tmp_path, study=QUICK)


def results_of(folder):
    return json.loads((folder / "results" / "summary.json").read_text())["study"]


def test_the_same_study_runs_again_and_again(creak, study, tmp_path):
    assert creak("run", study, "--quiet").status == 0
    study.write_text(QUICK.replace("amplitude = 0.05", "amplitude = 0.06").replace("Quick", "Another title"))
    assert creak("run", study, "--quiet").status == 0
    assert results_of(tmp_path) == study.name


def test_another_study_asks_for_force_or_a_folder_of_its_own(creak, study, tmp_path):
    assert creak("run", study, "--quiet").status == 0
    other = tmp_path / "other.toml"
    other.write_text(QUICK)
    before = (tmp_path / "results" / "summary.json").read_bytes()
    said = creak("run", other, "--quiet")
    said.refuses(f"holds the results of {study.name}, which other.toml would replace", "--out FOLDER", "--force")
    assert (tmp_path / "results" / "summary.json").read_bytes() == before
    assert creak("run", other, "--quiet", "--out", tmp_path / "beside").status == 0
    assert creak("run", other, "--quiet", "--force").status == 0
    assert results_of(tmp_path) == "other.toml"


@pytest.mark.parametrize("text", ["", "[]", '{"study": 3}', "{", "[" * 100_000])
def test_what_cannot_be_read_is_replaced(creak, study, tmp_path, text):
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "summary.json").write_text(text)
    assert creak("run", study, "--quiet").status == 0
    assert results_of(tmp_path) == study.name


@pytest.mark.parametrize("name", ["summary.json", "results.h5", "report.html", "convergence.csv"])
def test_a_file_of_another_program_asks_for_force_too(creak, study, tmp_path, name):
    (tmp_path / "results").mkdir()
    path = tmp_path / "results" / name
    path.write_text('{"mine": 1}')
    said = creak("run", study, "--quiet")
    said.refuses("no file that creak wrote", "or add --force")
    assert path.read_text() == '{"mine": 1}'
    assert [p.name for p in path.parent.iterdir()] == [name]
    assert creak("run", study, "--quiet", "--force").status == 0
    assert results_of(tmp_path) == study.name
