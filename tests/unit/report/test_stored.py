"""A report made from results.h5 is the one that was made from the result."""

import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from small_study import plates, study_text

from creak.api.extras import REPORT
from creak.api.result import Result
from creak.api.saved import open_result
from creak.errors import InputError
from creak.formats.stored.sealed import read_sealed
from creak.report.html import report_text
from creak.studies.converge.repeats import converge
from creak.studies.file.reader import read_study
from creak.studies.findings.gather import findings_of
from creak.studies.findings.stored import VERSION
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from helpers_decks import write_study
from helpers_findings import to_draw
from helpers_refusal import refusal
from helpers_stored import changed_hdf5, read_json, write_changed_json

CASES = (
    "both runs",
    "unreduced only",
    "no contact, no pairs",
    "contact and connector",
    "nothing moves",
    "mass on a spring",
)
ROOT = Path(__file__).parents[3]
WRITTEN = re.compile(r"<th>Report written</th><td>[^<]*</td>")


def page(findings, drawn):
    """The report without the time of writing."""
    text, count = WRITTEN.subn("", report_text(findings, drawn))
    assert count == 1
    return text


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run with recorded motion, and repeated for convergence."""
    folder = tmp_path_factory.mktemp("recorded")
    study_path = write_study(folder, study_text(reference=False), {"plates.inp": plates()})
    found = run_study(set_up(read_study(study_path)), lambda *_: None, record=True)
    repeated = converge(found, lambda *_: None)
    return Result(found, findings_of(found, repeated))


@pytest.fixture
def saved(recorded, tmp_path):
    recorded.save(tmp_path)
    return tmp_path


@pytest.mark.parametrize("case", CASES)
def test_the_page_is_the_same_for_every_kind_of_study(case, result_of, tmp_path):
    result = result_of(case)
    Result(result, findings_of(result)).save(tmp_path)
    again = open_result(tmp_path)
    assert page(again.findings, again.drawn) == page(*to_draw(result))
    assert again.summary == read_sealed(tmp_path / "summary.json")


def test_motion_and_convergence_come_back(recorded, saved):
    again = open_result(saved)
    assert repr(again.convergence) == repr(recorded.convergence)  # changes that are not known are nan
    assert again.events == recorded.events
    findings, drawn = to_draw(recorded.found, recorded.convergence)
    assert len(drawn.motions.shown) > 0
    text = page(again.findings, again.drawn)
    assert text == page(findings, drawn)
    assert "<h2>Convergence</h2>" in text


def test_the_forces_are_those_of_every_instant(recorded, saved):
    np.testing.assert_array_equal(open_result(saved).runs["reduced"].force, recorded.history.force)


@pytest.mark.slow
def test_what_stores_a_view_imports_nothing_that_draws():
    code = f"import sys, creak.studies.findings.stored; print(*[m for m in {REPORT} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_nothing_is_drawn_for_the_file(recorded, tmp_path, monkeypatch):
    """Results of a machine without the packages of the report are enough for one that has them."""
    monkeypatch.setitem(sys.modules, "plotly", None)
    recorded.save(tmp_path)
    with pytest.raises(InputError, match="not installed here"):
        open_result(tmp_path).report(tmp_path / "report.html")


def reason(folder) -> str:
    return str(refusal(open_result, folder))


def test_a_folder_that_lacks_a_file_says_which(saved):
    (saved / "summary.json").rename(saved / "other.json")
    assert "no such results" in reason(saved)
    assert "summary.json" in reason(saved)
    (saved / "other.json").rename(saved / "summary.json")
    (saved / "results.h5").unlink()
    assert "results.h5; expected" in reason(saved)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("name", ["results.h5", "summary.json"])
def test_a_file_cut_short_is_told(saved, share, name):
    whole = (saved / name).read_bytes()
    (saved / name).write_bytes(whole[: int(share * len(whole))])
    assert f"{name} is cut short or damaged" in reason(saved)


def test_other_versions_are_told(saved):
    with changed_hdf5(saved / "results.h5") as file:
        file["findings"].attrs["version"] = VERSION + 1
    assert f"version {VERSION + 1}" in reason(saved)
    with changed_hdf5(saved / "results.h5") as file:
        del file["findings"]
    assert "does not keep what a report needs" in reason(saved)


def test_a_damaged_view_is_told(saved):
    with changed_hdf5(saved / "results.h5") as file:
        del file["findings/window"]
        file["findings/window"] = np.zeros(3)
    assert "damaged" in reason(saved)


def test_files_of_two_runs_are_told(saved):
    path = saved / "summary.json"
    path.write_text(path.read_text().replace('"reduced": {', '"reference": {', 1))
    assert "checksum does not fit" in reason(saved)
    write_changed_json(path, read_json(path))
    assert "not of the same run" in reason(saved)


def test_every_field_of_the_view_is_documented(saved):
    names: set[str] = set()
    with h5py.File(saved / "results.h5") as file:
        for top in ("findings", "drawn", "model"):
            file[top].visititems(lambda name, item: names.add(name) if isinstance(item, h5py.Dataset) else None)
    page = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    generic = {re.sub(r"/\d+/", "/0/", name) for name in names if not name.startswith("setup/model/")}
    assert len(generic) > 60
    for name in generic:
        channels, _, field = name.rpartition("/")
        if channels in ("gaps", "setup/contacts", "setup/connectors"):
            assert f"`{channels}`" in page
            assert f"`{field}`" in page, name
        else:
            assert f"`{name}`" in page or f"`model/{name}`" in page, name
