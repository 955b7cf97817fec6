"""The commands of the page on sweeps that start a dask cluster, run as they stand but for the host and a free port."""

from __future__ import annotations

import csv
import os
import re
import shlex
import socket
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from helpers_cli import caller
from helpers_decks import STUDY, write_strips
from helpers_docs import ROOT, text_of

PAGE = ROOT / "docs" / "sweeps.md"
LINE = re.compile(r"^    ((?:\w+=\S+ )*)dask (.+)$", re.MULTILINE)
STOP = 60.0
"""s that a process may take to end."""


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@contextmanager
def started(line: re.Match[str], port: int):
    """The process of a line of the page. A port of its own instead of 8786, and none for its web page."""
    settings = dict(word.split("=", 1) for word in shlex.split(line[1]))
    words = shlex.split(line[2].replace("HOST:8786", f"127.0.0.1:{port}"))
    if words[0] == "scheduler":
        words += ["--host", "127.0.0.1", "--port", str(port)]
    program = [str(Path(sys.executable).with_name("dask")), *words, "--no-dashboard"]
    process = subprocess.Popen(
        program, env={**os.environ, **settings}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(STOP)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait(STOP)


def test_a_sweep_on_a_cluster_started_as_the_page_says(tmp_path, monkeypatch, capsys):
    pytest.importorskip("distributed", reason="dask.distributed is not installed: pip install 'creak[cluster]'")
    lines = list(LINE.finditer(text_of(PAGE)))
    assert [line[2].split()[0] for line in lines] == ["scheduler", "worker"]
    option = re.search(r"`--scheduler (tcp://HOST:8786)`", text_of(PAGE))
    assert option
    write_strips(tmp_path, study=STUDY.replace("periods = 2", "periods = 1"))
    (tmp_path / "sweep.toml").write_text('base = "study.toml"\nseeds = [1, 2]\n', encoding="utf-8")
    port = free_port()
    with ExitStack() as cluster:
        for line in lines:
            cluster.enter_context(started(line, port))
        address = option[1].replace("HOST:8786", f"127.0.0.1:{port}")
        said = caller(monkeypatch, capsys)("sweep", tmp_path / "sweep.toml", "--scheduler", address)
    assert said.status == 0, said.words
    (table,) = tmp_path.rglob("sweep.csv")
    with table.open(newline="") as file:
        assert [row["status"] for row in csv.DictReader(file)] == ["done", "done"]
