"""A result is all of one run: written together, with one identity in every file, checked by every reader."""

import csv
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import pytest

import creak
from creak.errors import WriteError
from creak.formats.destination import partial_name
from creak.formats.measured.histories import read_histories
from creak.formats.measured.motion_series import motion_field
from creak.studies.file.paths import digests_of, files_sha256
from creak.studies.file.reader import read_study
from creak.studies.findings.save import save, save_convergence
from helpers_decks import STOP, STUDY, stop_study, two_strips, write_strips, write_study
from helpers_disk import small_disk
from helpers_refusal import refusal
from helpers_stored import changed_hdf5, write_changed_json

pytestmark = [pytest.mark.slow, pytest.mark.once]

SHORT = STUDY.replace("periods = 2", "end = 0.06\n[output]\nfield_interval = 0.01").replace(
    "0.05, period", "0.3, period"
)
SCRIPT = Path(__file__).parents[3] / "killed_writers.py"


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return creak.run(write_strips(tmp_path_factory.mktemp("one"), study=SHORT), converge=False)


@pytest.fixture(scope="module")
def other(result):
    """The same study run once more."""
    return creak.run(result.found.setup.study, converge=False)


@pytest.fixture
def folder(result, tmp_path):
    result.save(tmp_path / "out", page=page(result))
    return tmp_path / "out"


def page(result):
    return f'<meta name="creak-run" content="{result.found.identity.id}"><title>x – creak report</title>'


def names(folder):
    return sorted(p.name for p in folder.iterdir())


def test_the_identity_stands_in_every_file(result, tmp_path):
    run = result.found.identity
    result.save(tmp_path, page=result.page())
    summary = json.loads((tmp_path / "summary.json").read_text())["run"]
    with h5py.File(tmp_path / "results.h5") as file:
        in_results = {
            key: file.attrs[name]
            for key, name in (("id", "run_id"), ("study_sha256", "study_sha256"), ("deck_sha256", "deck_sha256"))
        } | {"files_sha256": file.attrs["files_sha256"]}
    study = result.found.setup.study.path
    expected = {
        "id": run.id,
        "study_sha256": hashlib.sha256(study.read_bytes()).hexdigest(),
        "deck_sha256": hashlib.sha256(study.with_name("strips.inp").read_bytes()).hexdigest(),
        "files_sha256": "",
    }
    assert summary == in_results == expected
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert re.findall('<meta name="creak-run" content="([^"]*)">', html) == [run.id]
    assert f"<th>Run</th><td>{run.id}</td>" in html
    assert all(value in html for value in expected.values())


def test_the_same_input_twice_is_two_runs_with_the_same_digests(result, other):
    one, two = (r.summary["run"] for r in (result, other))
    assert one["id"] != two["id"]
    assert {k: v for k, v in one.items() if k != "id"} == {k: v for k, v in two.items() if k != "id"}


def test_includes_count(tmp_path):
    study = write_strips(tmp_path, study=SHORT)
    plain = digests_of(read_study(study))[0]
    head, tail = two_strips().split("*MATERIAL", 1)
    (tmp_path / "strips.inp").write_text(head + "*INCLUDE, INPUT=rest.inp\n")
    (tmp_path / "rest.inp").write_text("*MATERIAL" + tail)
    split = digests_of(read_study(study))[0]
    digests = [hashlib.sha256((tmp_path / name).read_bytes()).hexdigest() for name in ("strips.inp", "rest.inp")]
    assert split == hashlib.sha256("".join(f"{d}\n" for d in digests).encode()).hexdigest() != plain
    (tmp_path / "rest.inp").write_text("*MATERIAL" + tail + "** a word\n")
    assert digests_of(read_study(study))[0] != split
    assert files_sha256([]) == ""


@pytest.mark.parametrize("name", ["summary.json", "results.h5"])
def test_files_of_two_runs_are_refused_by_every_reader(folder, other, tmp_path, name):
    other.save(tmp_path / "other")
    shutil.copy(tmp_path / "other" / name, folder / name)
    for read, at in (
        (creak.open_result, folder),
        (read_histories, folder / "results.h5"),
        (motion_field, folder / "results.h5"),
    ):
        assert f"summary.json and results.h5 in {folder} are not of the same run" in str(refusal(read, at))


def test_a_changed_digest_is_another_run(folder):
    text = folder / "summary.json"
    data = json.loads(text.read_text())
    data["run"]["deck_sha256"] = "0" * 64
    write_changed_json(text, data)
    assert "not of the same run" in str(refusal(creak.open_result, folder))


def test_results_of_an_earlier_version_are_named(folder):
    """They do not tell the digest of the other files, and keep their report in an earlier version."""
    text = folder / "summary.json"
    data = json.loads(text.read_text())
    del data["run"]["files_sha256"]
    write_changed_json(text, data)
    with changed_hdf5(folder / "results.h5") as file:
        del file.attrs["files_sha256"]
        file["findings"].attrs["version"] = 12
    assert "keeps its report in version 12" in str(refusal(creak.open_result, folder))
    assert read_histories(folder / "results.h5").run == "reduced"


def test_results_without_identity_are_refused(folder):
    text = folder / "summary.json"
    data = json.loads(text.read_text())
    del data["run"]
    write_changed_json(text, data)
    with changed_hdf5(folder / "results.h5") as file:
        del file.attrs["run_id"]
    assert "do not say of which run they are" in str(refusal(creak.open_result, folder))
    assert read_histories(folder / "results.h5").run == "reduced"  # one file is of one run


def test_histories_alone_are_read_and_a_report_of_them_refused(folder):
    (folder / "summary.json").unlink()
    assert "a run was stopped while it wrote them" in str(refusal(creak.open_result, folder))
    assert read_histories(folder / "results.h5").run == "reduced"


def test_motion_does_not_change_its_run_midway(folder, other):
    field = motion_field(folder / "results.h5")
    other.save(folder)
    assert "was replaced by another run meanwhile" in str(refusal(lambda: list(field.instants())))


def test_page_and_table_of_an_earlier_run_do_not_stay(result, other, folder):
    table = "contact,channel,t_start,figure,verdict,run\ntip,tip:1,0,force,settled,"
    (folder / "convergence.csv").write_text(f"{table}{result.found.identity.id}\n")
    result.save(folder)  # the same run once more: both are its own
    assert names(folder) == ["convergence.csv", "report.html", "results.h5", "summary.json"]
    other.save(folder)
    assert names(folder) == ["results.h5", "summary.json"]
    for name, text in (("report.html", "<title>my own page</title>"), ("convergence.csv", "my,own\n")):
        (folder / name).write_text(text)
    result.save(folder)
    assert names(folder) == ["convergence.csv", "report.html", "results.h5", "summary.json"]


def test_page_and_table_of_versions_without_identity_do_not_stay(result, folder):
    (folder / "report.html").write_text("<title>Strips – creak report</title>", encoding="utf-8")
    (folder / "convergence.csv").write_text("contact,channel,t_start,figure,verdict\n")
    result.save(folder)
    assert names(folder) == ["results.h5", "summary.json"]


def test_the_table_of_convergence_names_its_run(tmp_path, monkeypatch):
    rows = [["contact", "verdict"], ["tip", "settled"], ["tip", "not settled"]]
    monkeypatch.setattr("creak.studies.findings.save.csv_rows", lambda _: rows)
    with save_convergence(None, tmp_path, "abc").open(newline="") as file:
        assert list(csv.reader(file)) == [[*row, end] for row, end in zip(rows, ("run", "abc", "abc"), strict=True)]


def test_a_full_disk_leaves_the_earlier_run(result, other, tmp_path):
    with small_disk(tmp_path / "disk", 300) as disk:
        result.save(disk / "out")
        before = {p.name: p.read_bytes() for p in (disk / "out").iterdir()}
        (disk / "more").write_bytes(bytes(2_000_000 - 300_000 - sum(map(len, before.values())) - 200_000))
        with pytest.raises(WriteError, match=r"cannot write .*results\.h5: no space left on device; at least"):
            other.save(disk / "out")
        assert {p.name: p.read_bytes() for p in (disk / "out").iterdir()} == before
        (disk / "more").unlink()
        with pytest.raises(
            WriteError, match=r"cannot write .*report\.html: no space left on device; at least 3\.\d+ MB"
        ):
            other.save(disk / "out", page="x" * 3_000_000)
        assert {p.name: p.read_bytes() for p in (disk / "out").iterdir()} == before
        other.save(disk / "out")


def test_an_interruption_between_the_names_waits(result, other, folder, monkeypatch):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where tests run in the background
    replace, unlink = os.replace, Path.unlink

    def interrupted(call):
        def then(*words, **options):
            signal.raise_signal(signal.SIGINT)
            return call(*words, **options)

        return then

    monkeypatch.setattr("creak.formats.complete_file.os.replace", interrupted(replace))
    monkeypatch.setattr(Path, "unlink", interrupted(unlink))
    with pytest.raises(KeyboardInterrupt):
        other.save(folder)
    monkeypatch.undo()
    signal.signal(signal.SIGINT, before)
    assert creak.open_result(folder).summary["run"]["id"] == other.found.identity.id
    assert names(folder) == ["results.h5", "summary.json"]


def test_the_next_run_cleans_what_a_dead_one_left(result, folder):
    name = partial_name("results.h5")
    process = name.split(".")[-3]
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    (folder / name).write_text("of this process")
    (folder / name.replace(f".{process}.", f".{gone.pid}.")).write_text("of a dead one")
    result.save(folder)
    assert names(folder) == [name, "report.html", "results.h5", "summary.json"]


def test_names_that_are_taken_are_refused_before_anything_is_written(result, tmp_path):
    (tmp_path / "report.html").mkdir()
    assert "report.html: it is a folder" in str(refusal(save, result.found, result.summary, tmp_path))
    assert names(tmp_path) == ["report.html"]


def test_a_writer_killed_at_any_step_leaves_one_run_or_a_refusal(tmp_path):
    study = write_study(tmp_path, stop_study(1e-3, 0.1, "craig-bampton"), {"strips.inp": STOP})
    (tmp_path / "second.toml").write_text(study.read_text().replace("stiffness = 1e6", "stiffness = 2e6"))
    study.rename(tmp_path / "first.toml")
    done = subprocess.run([sys.executable, str(SCRIPT), str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *killed, ended = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(killed) > 12
    assert (ended["report"], ended["convert"], ended["left"]) == ("second", "second", "0")
    for found in killed:
        assert found["report"] in ("first", "second") or re.match("refused: no such results: ", found["report"])
        assert found["convert"] in ("first", "second") or re.match("refused: no such results: ", found["convert"])
        assert (found["next"], found["cleaned"]) == ("first", "True")
    told = {found["report"].split(":")[0] for found in killed}
    assert told == {"first", "second", "refused"}
    assert any(found["left"] != "0" for found in killed)
