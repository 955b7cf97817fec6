"""What killed processes left goes; what somebody may still be writing, and what is not creak's, stays."""

import os
import socket
import subprocess
import sys
import time

import pytest

from creak.formats.complete_file import complete_file
from creak.formats.destination import OLD, partial_name, remove_dead

WRITER = """
import sys
from pathlib import Path
from creak.formats.complete_file import complete_file
with complete_file(Path(sys.argv[1])) as partial:
    partial.write_text("half")
    print(partial.name, flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def writer(tmp_path):
    """A process that is writing `file`; its partial file."""
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(tmp_path / "file")], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    name = process.stdout.readline().strip()
    yield process, tmp_path / name
    process.kill()
    process.communicate()


def test_of_a_live_process_nothing_goes_and_of_a_killed_one_all(writer, tmp_path):
    process, partial = writer
    remove_dead(tmp_path)
    assert partial.read_text() == "half"
    process.kill()
    process.wait()
    remove_dead(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_next_to_write_into_the_folder_cleans_it(writer, tmp_path):
    process, _ = writer
    process.kill()
    process.wait()
    with complete_file(tmp_path / "other") as mine:
        mine.write_text("whole")
    assert [p.name for p in tmp_path.iterdir()] == ["other"]


def test_a_process_number_given_anew_is_not_the_old_process(tmp_path):
    name = partial_name("file")
    start = name.split(".")[-2].split("-")[0]
    assert start
    (tmp_path / name).write_text("mine")
    (tmp_path / name.replace(f".{start}-", f".{int(start) - 1}-")).write_text("of one before me")
    remove_dead(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == [name]


def made(path, days):
    path.write_text("half")
    then = time.time() - days * 86_400.0
    os.utime(path, (then, then))
    return path


def test_other_machines_are_given_a_week(tmp_path):
    mine = partial_name("file")
    machine = mine.split("-")[-2]
    names = [
        mine.replace(f".{socket.gethostname()}.", ".elsewhere."),
        mine.replace(f"-{machine}-", "-00000000-"),
        f".file.{'a' * 32}.partial",
    ]
    young = [made(tmp_path / name, days=6) for name in names]
    remove_dead(tmp_path)
    assert set(tmp_path.iterdir()) == set(young)
    for path in young:
        made(path, days=OLD / 86_400.0 + 1)
    remove_dead(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_files_of_other_programs_stay(tmp_path):
    others = {
        made(tmp_path / name, days=400) for name in (".film.partial", ".a.b.partial", "file.partial", ".x.1.y.partial")
    }
    remove_dead(tmp_path)
    assert set(tmp_path.iterdir()) == others


def test_long_names_still_have_partial_ones(tmp_path):
    path = tmp_path / ("ä" * 120)
    with complete_file(path) as partial:
        partial.write_text("whole")
    assert path.read_text() == "whole"
