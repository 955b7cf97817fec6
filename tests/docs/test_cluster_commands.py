"""The commands of the page on sweeps that start a cluster with a certificate, run as they stand but for the host, a free port and one thread."""

from __future__ import annotations

import csv
import os
import re
import shlex
import shutil
import socket
import ssl
import stat
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import psutil
import pytest

from helpers_cli import caller
from helpers_decks import STUDY, write_strips
from helpers_docs import ROOT, text_of

pytestmark = pytest.mark.slow

PAGE = ROOT / "docs" / "sweeps.md"
DASK = re.compile(r"^    ((?:\w+=\S+ )*)(dask .+)$", re.MULTILINE)
OPENSSL = re.compile(r"^    ()(openssl req .+)$", re.MULTILINE)
SWEEP = re.compile(r"^    ()creak (sweep SWEEP.toml --scheduler .+)$", re.MULTILINE)
PATIENCE = 120.0
"""s that a process may take to come or to end."""


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@contextmanager
def started(line: re.Match[str], port: int, folder: Path):
    """The process of a line of the page, with a port of its own instead of 8786, and one thread."""
    settings = dict(word.split("=", 1) for word in shlex.split(line[1]))
    settings |= {name: "1" for name in settings if name.endswith("_THREADS")}  # more would take the cores by waiting
    words = shlex.split(line[2].replace("HOST:8786", f"127.0.0.1:{port}"))
    if words[1] == "scheduler":
        words += ["--host", "127.0.0.1", "--port", str(port)]
    program = [str(Path(sys.executable).with_name(words[0])), *words[1:]]
    process = subprocess.Popen(
        program, env={**os.environ, **settings}, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait(PATIENCE)


def listening(process: subprocess.Popen) -> list[int]:
    """Ports of a process and of those that it started."""
    all_of = [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]
    found = [c.laddr.port for p in all_of for c in p.net_connections(kind="inet") if c.status == psutil.CONN_LISTEN]
    return sorted(set(found))


def wait_for(condition) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.1)


def answers(port: int, context: ssl.SSLContext | None) -> bool:
    """Whether a caller without the certificate gets one byte of sense out of a port."""
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=3.0) as raw:
            if context is None:
                raw.settimeout(1.0)  # one that does not speak first is waited for in vain
                return raw.recv(1) != b""
            with context.wrap_socket(raw) as safe:
                return safe.recv(1) != b""
    except OSError:  # ssl.SSLError and timeouts are of them
        return False


def make_certificate(folder: Path) -> None:
    (line,) = OPENSSL.finditer(text_of(PAGE))
    subprocess.run(shlex.split(line[2]), cwd=folder, check=True, capture_output=True)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Folder with the certificate, port of a running scheduler, and the two processes as the page starts them."""
    pytest.importorskip("distributed", reason="dask.distributed is not installed: pip install 'creak[cluster]'")
    if shutil.which("openssl") is None:
        pytest.skip("there is no openssl")
    folder = tmp_path_factory.mktemp("cluster")
    make_certificate(folder)
    first, second = DASK.finditer(text_of(PAGE))
    port = free_port()
    with started(first, port, folder) as scheduler, started(second, port, folder) as worker:
        wait_for(lambda: len(listening(worker)) >= 1 and port in listening(scheduler))
        yield folder, port, scheduler, worker


def test_a_sweep_on_a_cluster_started_as_the_page_says(cluster, monkeypatch, capsys):
    folder, port, _, _ = cluster
    write_strips(folder, study=STUDY.replace("periods = 2", "end = 0.02") + "[reference]\nrun = false\n")
    (folder / "sweep.toml").write_text('base = "study.toml"\nseeds = [1, 2]\n', encoding="utf-8")
    (line,) = SWEEP.finditer(text_of(PAGE))
    words = shlex.split(line[2].replace("HOST:8786", f"127.0.0.1:{port}").replace("SWEEP.toml", "sweep.toml"))
    monkeypatch.chdir(folder)
    said = caller(monkeypatch, capsys)(*words)
    assert said.status == 0, said.words
    assert "is open" not in said.err
    (table,) = folder.rglob("sweep.csv")
    with table.open(newline="") as file:
        assert [row["status"] for row in csv.DictReader(file)] == ["done", "done"]
    said = caller(monkeypatch, capsys)("reduce", "study.toml", *words[2:])
    assert said.status == 0, said.words
    assert sorted(path.name for path in (folder / "superelements").glob("*.h5")) == ["LOWER.h5", "UPPER.h5"]


def test_who_does_not_hold_the_key_is_turned_away(cluster, monkeypatch, capsys, tmp_path):
    """At every port of both processes, without TLS, with TLS and no certificate, and with a certificate of one's own."""
    from distributed import Client
    from distributed.security import Security

    folder, port, scheduler, worker = cluster
    assert stat.S_IMODE((folder / "cluster.key").stat().st_mode) == 0o600
    key = (folder / "cluster.key").read_text().splitlines()[1]
    assert not any(key in word for p in (scheduler, worker) for word in psutil.Process(p.pid).cmdline())
    other = tmp_path / "other"
    other.mkdir()
    make_certificate(other)
    nobody = ssl.create_default_context(cafile=folder / "cluster.crt")
    nobody.check_hostname = False
    stranger = ssl.create_default_context(cafile=folder / "cluster.crt")
    stranger.check_hostname = False
    stranger.load_cert_chain(other / "cluster.crt", other / "cluster.key")
    owner = ssl.create_default_context(cafile=folder / "cluster.crt")
    owner.check_hostname = False
    owner.load_cert_chain(folder / "cluster.crt", folder / "cluster.key")
    assert answers(port, owner)
    for open_port in {*listening(scheduler), *listening(worker)}:
        assert not any(answers(open_port, context) for context in (None, nobody, stranger)), open_port
    ca, cert, private = (str(p) for p in (folder / "cluster.crt", other / "cluster.crt", other / "cluster.key"))
    wrong = Security(tls_ca_file=ca, tls_client_cert=cert, tls_client_key=private, require_encryption=True)
    for address, security in (("tcp", None), ("tls", wrong)):
        with pytest.raises((OSError, TypeError), match=r"[Cc]losed|reset|[Tt]imed out|TLS|ssl"):
            Client(f"{address}://127.0.0.1:{port}", security=security, timeout=1.0)
    write_strips(tmp_path)
    (tmp_path / "sweep.toml").write_text('base = "study.toml"\nseeds = [1]\n', encoding="utf-8")
    monkeypatch.setattr("creak.studies.tasks.cluster.WAIT", 1.0)
    for more in ([], ["--tls-ca-file", ca, "--tls-cert", cert, "--tls-key", private]):
        said = caller(monkeypatch, capsys)(
            "sweep", tmp_path / "sweep.toml", "--scheduler", f"tls://127.0.0.1:{port}", *more
        )
        assert said.status == 2, said.words
        assert "Traceback" not in said.err
