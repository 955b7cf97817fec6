"""Where commands write: plain files are replaced, streams written into, all else refused; full disks end in one line."""

import json
import os
import shutil
import socket
import stat
import subprocess
import sys
import threading

import pytest

from helpers_cli import say
from helpers_decks import STUDY, write_strips
from helpers_disk import FULL, NULL, device, limited_files, small_disk

pytestmark = pytest.mark.slow

SHORT = STUDY.replace("periods = 2", "end = 0.06\n[output]\nfield_interval = 0.01").replace(
    "0.05, period", "0.3, period"
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A deck and its study, and the results of a run."""
    folder = tmp_path_factory.mktemp("made")
    study = write_strips(folder, study=SHORT)
    assert say("run", study, "--quiet", "--out", folder / "out").status == 0
    return folder


def commands(made, target):
    """Every command with an output of its own name; its first input is not there: outputs are looked at before."""
    no, ending = made / "nowhere", target.suffix
    found = [
        ("schema", "--out", target),
        ("modes", no.with_suffix(".inp"), "--json", target),
        ("modes", no.with_suffix(".inp"), "--uff", target),
        ("modes", no.with_suffix(".inp"), "--pch", target),
        ("report", no, "--out", target),
        *([("modes", no.with_suffix(".inp"), "--vtk", target)] if ending == ".vtu" else []),
        *([("convert", no.with_suffix(".h5"), target)] if ending in (".unv", ".pch", ".csv", ".pvd") else []),
        *([("convert", no.with_suffix(".inp"), target)] if ending in (".inp", ".bdf") else []),
        *([("convert", no.with_suffix(".inp"), target, "--matrices", "npz")] if ending == ".npz" else []),
        *([("new", no.with_suffix(".inp"), "--out", target, "--overwrite")] if ending == ".toml" else []),
    ]
    return found


@pytest.mark.parametrize("ending", [".vtu", ".unv", ".pch", ".csv", ".pvd", ".inp", ".bdf", ".npz", ".toml", ".json"])
@pytest.mark.parametrize("kind", ["folder", "socket", "block device"])
def test_other_nodes_are_refused_before_anything_is_read(creak, made, tmp_path, monkeypatch, kind, ending):
    target = tmp_path / f"node{ending}"
    monkeypatch.chdir(tmp_path)
    server = socket.socket(socket.AF_UNIX)
    if kind == "folder":
        target.mkdir()
    elif kind == "socket":
        server.bind(target.name)
    else:
        device(target, os.makedev(250, 250), stat.S_IFBLK)
    before = target.lstat().st_mode
    for words in commands(made, target):
        said = creak(*words)
        assert said.status == 2, words
        assert f"cannot write to {target}: it is a {kind}" in said.words, words
    assert target.lstat().st_mode == before
    assert list(tmp_path.iterdir()) == [target]
    server.close()


def read_later(pipe):
    got = []
    thread = threading.Thread(target=lambda: got.append(pipe.read_text(encoding="utf-8")), daemon=True)
    thread.start()
    return got, thread


@pytest.mark.parametrize(
    ("ending", "words", "start"),
    [
        (".json", ("schema", "--out", "PIPE"), "{"),
        (".json", ("modes", "strips.inp", "--json", "PIPE", "--quiet"), '{\n  "frequencies"'),
        (".unv", ("modes", "strips.inp", "--uff", "PIPE", "--quiet"), "    -1\n   164"),
        (".csv", ("convert", "out/results.h5", "PIPE"), "time [s],"),
        (".unv", ("convert", "out/results.h5", "PIPE"), "    -1\n   164"),
        (".pch", ("convert", "out/results.h5", "PIPE"), "$TITLE   ="),
        (".inp", ("convert", "strips.inp", "PIPE"), "*"),
        (".html", ("report", "out", "--out", "PIPE"), "\n<!DOCTYPE html>"),
    ],
)
def test_streams_are_written_into(creak, made, tmp_path, monkeypatch, ending, words, start):
    monkeypatch.chdir(made)
    pipe, null = tmp_path / f"pipe{ending}", device(tmp_path / f"null{ending}", NULL)
    os.mkfifo(pipe)
    got, reader = read_later(pipe)
    creak(*(pipe if w == "PIPE" else w for w in words)).done()
    reader.join(30.0)
    assert got[0].lstrip("\n").startswith(start.lstrip("\n"))
    assert creak(*(null if w == "PIPE" else w for w in words)).status == 0
    assert stat.S_ISFIFO(pipe.lstat().st_mode)
    assert stat.S_ISCHR(null.lstat().st_mode)
    assert set(tmp_path.iterdir()) == {pipe, null}


@pytest.mark.parametrize(
    "words",
    [
        ("convert", "out/results.h5", "node.pvd"),
        ("convert", "strips.inp", "node.npz", "--matrices", "npz"),
        ("new", "strips.inp", "--out", "node.toml", "--overwrite"),
    ],
)
def test_what_is_no_stream_does_not_go_into_a_pipe(creak, made, tmp_path, monkeypatch, words):
    for name in ("strips.inp", "out"):
        (tmp_path / name).symlink_to(made / name)
    monkeypatch.chdir(tmp_path)
    name = next(w for w in words if w.startswith("node"))
    os.mkfifo(name)
    said = creak(*words)
    said.refuses(f"cannot write to {name}: it is a pipe; expected a file")


@pytest.mark.parametrize("name", ["results.h5", "summary.json", "report.html"])
def test_a_run_does_not_go_into_a_pipe(creak, tmp_path, name):
    os.mkfifo(tmp_path / name)
    said = creak("run", tmp_path / "nowhere.toml", "--out", tmp_path)
    said.refuses(f"{name}: it is a pipe; expected a file")


def test_a_device_that_is_full_ends_in_one_line(creak, made, tmp_path):
    full = device(tmp_path / "full", FULL)
    said = creak("modes", made / "strips.inp", "--json", full, "--quiet")
    assert (said.status, said.out) == (1, "")
    assert said.err.splitlines() == [f"creak: cannot write {full}: no space left on device"]


def command_line(*words, **options):
    line = [sys.executable, "-m", "creak.cli.main", *map(str, words)]
    return subprocess.run(line, capture_output="stdout" not in options, text=True, check=False, **options)


def test_stdout_by_its_other_name(made, tmp_path):
    done = command_line("modes", made / "strips.inp", "--json", "/dev/stdout")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["frequencies"]  # nothing else is there
    with (tmp_path / "file").open("w") as file:
        command_line("schema", "--out", "/proc/self/fd/1", stdout=file, stderr=subprocess.PIPE)
    assert (tmp_path / "file").read_text().startswith("{")


def test_stdout_on_a_full_disk_ends_in_one_line(made, tmp_path):
    with device(tmp_path / "full", FULL).open("w") as full:
        for words in (("modes", made / "strips.inp", "--json", "-", "--quiet"), ("schema",)):
            done = command_line(*words, stdout=full, stderr=subprocess.PIPE)
            assert (done.returncode, done.stderr) == (1, "creak: cannot write the output: no space left on device\n")


def test_a_link_stays(creak, made, tmp_path):
    (tmp_path / "far").mkdir()
    (tmp_path / "link.html").symlink_to("far/page.html")
    assert creak("report", made / "out", "--out", tmp_path / "link.html").status == 0
    assert (tmp_path / "link.html").is_symlink()
    assert (tmp_path / "far" / "page.html").stat().st_size > 1e6


def whole(folder):
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def test_a_run_on_a_full_disk_ends_in_one_line(creak, no_page, made, tmp_path):
    with small_disk(tmp_path / "disk", 1600) as disk:
        said = creak("run", made / "study.toml", "--out", disk / "out", "--quiet")
        assert said.status == 1
        last = [line for line in said.err.splitlines() if not line.startswith("warning: ")]
        assert len(last) == 1
        assert f"creak: cannot write {disk}/out/results.h5: no space left on device; at least " in last[0]
        assert f"are free in {disk}/out. Make room" in last[0]
        assert list((disk / "out").iterdir()) == []


def test_a_run_with_a_limit_of_file_size_leaves_the_earlier_one(creak, no_page, made, tmp_path):
    shutil.copytree(made / "out", tmp_path / "out")
    before = whole(tmp_path / "out")
    with limited_files(200_000):
        said = creak("run", made / "study.toml", "--out", tmp_path / "out", "--quiet")
    last = [line for line in said.err.splitlines() if not line.startswith("warning: ")]
    assert (said.status, said.out, len(last)) == (1, "", 1), said.err
    assert "results.h5: file too large; at least" in last[0]
    assert "may have 200 kB (ulimit -f)" in last[0]
    assert whole(tmp_path / "out") == before


@pytest.mark.parametrize(
    "words",
    [
        ("reduce", "study.toml", "--out", "TO"),
        ("convert", "out/results.h5", "TO/motion.pvd"),
        ("convert", "out/results.h5", "TO/h.unv"),
        ("convert", "out/results.h5", "TO/h.csv"),
        ("convert", "strips.inp", "TO/deck.bdf", "--mass", "lumped"),
        ("convert", "strips.inp", "TO/k.npz", "--matrices", "npz"),
        ("convert", "strips.inp", "TO/k.op4", "--matrices", "op4"),
        ("modes", "strips.inp", "--vtk", "TO/m.vtu"),
        ("modes", "strips.inp", "--uff", "TO/m.unv"),
        ("report", "out", "--out", "TO/page.html"),
        ("schema", "--out", "TO/schema.json"),
        ("example", "door", "--out", "TO"),
        ("new", "strips.inp", "--out", "TO/new.toml"),
    ],
)
def test_every_writer_ends_in_one_line(creak, made, tmp_path, monkeypatch, words):
    """Two blocks are too few for anything."""
    monkeypatch.chdir(made)
    to = tmp_path / "to"
    to.mkdir()
    quiet = [] if words[0] in ("schema", "example") else ["--quiet"]
    with limited_files(1024):
        said = creak(*(w.replace("TO", str(to)) for w in words), *quiet)
    last = [line for line in said.err.splitlines() if not line.startswith("warning: ")]
    assert said.status == 1, said.err
    assert len(last) == 1, said.err
    assert last[0].startswith(f"creak: cannot write {to}")
    assert "file too large" in last[0]
    assert list(to.iterdir()) == []


@pytest.mark.parametrize(("error", "status"), [(KeyboardInterrupt, 1), (ValueError, None)])
def test_a_page_that_cannot_be_drawn_does_not_cost_the_results(creak, made, tmp_path, monkeypatch, error, status):
    def fails(*_):
        raise error("drawn badly")

    shutil.copytree(made / "out", tmp_path / "out")
    before = json.loads((tmp_path / "out" / "summary.json").read_text())["run"]["id"]
    monkeypatch.setattr("creak.api.result.Result.page", fails)
    if status is None:
        with pytest.raises(error, match="drawn badly"):
            creak("run", made / "study.toml", "--out", tmp_path / "out", "--quiet")
    else:
        said = creak("run", made / "study.toml", "--out", tmp_path / "out", "--quiet")
        assert said.status == status
        assert f"written before: {tmp_path}/out/summary.json" in said.words
    assert sorted(whole(tmp_path / "out")) == ["results.h5", "summary.json"]  # the page of the earlier run is gone
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["run"]["id"] != before
    assert creak("report", tmp_path / "out").status == 0
