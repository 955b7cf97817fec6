"""`creak sweep` through the command line; one test with a real cluster whose processes are killed.

`creak sweep --scheduler`: certificates that cannot be used are told, and so is a scheduler that is open to others.
"""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from creak.linalg.threads import cores
from creak.studies.sweep.case import run_case
from creak.studies.sweep.cases import resolve
from creak.studies.sweep.file import read_sweep
from creak.studies.sweep.job import tasks_of
from creak.studies.tasks.cluster import open_to_others
from creak.studies.tasks.queue import THREADS, threads_of
from helpers_cli import say
from helpers_decks import STUDY, write_strips

pytestmark = pytest.mark.slow

PATIENCE = 240.0
"""s that a step of the test with processes may take on a busy machine."""


def sweep_in(folder: Path, text: str, periods: int = 1) -> Path:
    write_strips(folder, study=STUDY.replace("periods = 2", f"periods = {periods}"))
    path = folder / "sweep.toml"
    path.write_text(f'base = "study.toml"\n{text}', encoding="utf-8")
    return path


def rows_of(folder: Path) -> dict[str, dict[str, str]]:
    with (folder / "sweep.csv").open(newline="") as file:
        return {row["case"]: row for row in csv.DictReader(file)}


def test_dry_run_lists_the_cases_and_writes_nothing(creak, tmp_path):
    path = sweep_in(tmp_path, 'seeds = [1, 2]\n[grid]\n"reduction.f_max" = [2000, 3000]')
    before = set(tmp_path.iterdir())
    text = creak("sweep", path, "--dry-run").done().out
    assert "4 cases, 0 of them finished" in text
    assert "f_max=3000,seed=2" in text
    assert set(tmp_path.iterdir()) == before
    path.write_text('base = "study.toml"\n[grid]\n"time.periods" = [1000000000]', encoding="utf-8")
    creak("sweep", path, "--dry-run").refuses("case periods=1000000000: a run of 2e+08 s")
    path.write_text('base = "study.toml"\nseeds = [1]', encoding="utf-8")
    assert "1 case, 0 of them finished" in creak("sweep", path, "--dry-run").done().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["--workers", "2", "--scheduler", "tcp://x:1"], "exclude each other"), (["--workers", "0"], "--workers")],
)
def test_wrong_options(creak, tmp_path, arguments, words):
    creak("sweep", sweep_in(tmp_path, "seeds = [1]"), *arguments).refuses(words)


def test_wrong_sweep_file(creak, tmp_path):
    creak("sweep", sweep_in(tmp_path, '[grid]\n"reduction.f_mx" = [1]')).refuses("Did you mean 'f_max'?")
    assert not (tmp_path / "sweep_sweep").exists()


def test_a_cluster_without_dask_says_what_to_install(creak, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    path = sweep_in(tmp_path, "seeds = [1]")
    creak("sweep", path, "--scheduler", "tcp://127.0.0.1:1").refuses("pip install distributed")


def test_workers_of_this_machine_need_no_dask(creak, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    path = sweep_in(tmp_path, "seeds = [1]")
    assert creak("sweep", path, "--no-reports", "--quiet").status == 0
    assert rows_of(tmp_path / "sweep_sweep")["seed=1"]["status"] == "done"


def test_a_finished_sweep_needs_no_workers(creak, tmp_path, monkeypatch):
    path, out = sweep_in(tmp_path, "seeds = [5]"), tmp_path / "results"
    out.mkdir()
    cases = resolve(read_sweep(path), out)
    run_case(tasks_of(cases, out)["seed=5"])
    monkeypatch.setattr("creak.studies.tasks.queue.local_workers", None)
    assert "1 of 1 cases have results, 1 from before" in creak("sweep", path, "--out", out).done().out
    told = creak("sweep", path, "--out", out, "--dry-run", "--no-converge").done().out
    assert "1 case, 0 of them finished" in told
    assert "finished with neither --converge nor --no-converge: 1" in told
    assert rows_of(out)["seed=5"]["status"] == "done"
    assert (out / "sweep.h5").exists()
    assert (out / "sweep.html").exists()


def test_the_command_line_starts_without_dask():
    code = "import sys, creak.cli.main; sys.exit('dask' in sys.modules or 'distributed' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def wait_for(condition, process: subprocess.Popen) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert process.poll() is None, "the sweep ended before it could be killed"
        assert time.monotonic() < end
        time.sleep(0.02)


def workers_of(process: subprocess.Popen) -> list[psutil.Process]:
    """Those that live: one that was killed has no command any more, and may be gone before it is asked for it."""
    living = []
    for child in psutil.Process(process.pid).children(recursive=True):
        with suppress(psutil.NoSuchProcess):  # a zombie too
            if "spawn_main" in " ".join(child.cmdline()):
                living.append(child)
    return living


def test_killed_worker_and_killed_sweep_lose_nothing(tmp_path):
    """No process of a sweep listens on a port. kill -9 of a worker, then of the first process, which leaves none of the
    others; the next start does the rest, and only the rest."""
    path = sweep_in(tmp_path, 'seeds = [1, 2, 3, 4]\n[[case]]\nname = "good"\n', periods=2)
    text = path.read_text()
    path.write_text(f'{text}[[case]]\nname = "bad"\nchanges = {{ "excitation.root.node_set" = "NOWHERE" }}\n')
    out = tmp_path / "sweep_sweep"
    words = ("sweep", str(path), "--no-reports", "--workers")
    command = [sys.executable, "-m", "creak.cli.main", *words, "2"]

    def done() -> list[Path]:
        return sorted(p for p in out.glob("good*/case.json") if not p.parent.name.startswith("."))

    first = subprocess.Popen(command, start_new_session=True, stderr=subprocess.DEVNULL)
    try:
        wait_for(lambda: len(done()) >= 1, first)
        workers = workers_of(first)
        assert {name: workers[0].environ()[name] for name in THREADS} == threads_of(max(1, cores() // 2))
        for one in (psutil.Process(first.pid), *workers):
            assert [c for c in one.net_connections(kind="inet") if c.status == psutil.CONN_LISTEN] == []
        workers[0].kill()
        before = len(done())
        wait_for(lambda: len(done()) > before, first)
        workers = workers_of(first)
        first.kill()
        first.wait()
        assert psutil.wait_procs(workers, timeout=PATIENCE)[1] == []
    finally:
        with suppress(ProcessLookupError):
            os.killpg(first.pid, signal.SIGKILL)
        first.wait()
    kept = {p: p.stat().st_mtime_ns for p in done()}
    assert len(kept) >= 2

    second = say(*words, "1")
    assert second.status == 1
    assert "4 of 8 cases failed" in second.err
    assert "bad,seed=3: " in second.err
    assert len(done()) == 4
    assert {p: p.stat().st_mtime_ns for p in kept} == kept
    assert [p.name for p in out.iterdir() if p.name.startswith(".")] == []
    assert {name: row["status"] for name, row in rows_of(out).items()} == {
        f"{kind},seed={k}": status for kind, status in (("good", "done"), ("bad", "failed")) for k in range(1, 5)
    }


TLS = "tls://127.0.0.1:1"


@pytest.fixture
def sweep(creak, tmp_path, monkeypatch):
    """Runs a small sweep with the words given; no scheduler ever answers."""
    pytest.importorskip("distributed")
    monkeypatch.setattr("creak.studies.tasks.cluster.WAIT", 0.5)
    write_strips(tmp_path)
    (tmp_path / "sweep.toml").write_text('base = "study.toml"\nseeds = [1]\n', encoding="utf-8")
    return lambda *words: creak("sweep", tmp_path / "sweep.toml", "--out", tmp_path / "out", *words)


@pytest.mark.parametrize(
    ("address", "others"),
    [
        ("tcp://127.0.0.1:8786", False),
        ("127.0.0.1:8786", False),
        ("tcp://localhost:8786", False),
        ("tcp://[::1]:1", False),
        ("tls://10.0.0.7:8786", False),
        ("tcp://10.0.0.7:8786", True),
        ("10.0.0.7:8786", True),
        ("tcp://node7:8786", True),
        ("ws://node7:8786", True),
        ("tcp://0.0.0.0:8786", True),
    ],
)
def test_a_scheduler_without_certificates_is_open_to_others(address, others):
    assert open_to_others(address) is others


def test_an_open_scheduler_is_warned_of(sweep):
    said = sweep("--scheduler", "tcp://192.0.2.1:9")
    assert "warning: the scheduler tcp://192.0.2.1:9 is open: whoever reaches it" in said.err
    said.refuses("no dask scheduler at tcp://192.0.2.1:9")
    assert "is open" not in sweep("--scheduler", "tcp://127.0.0.1:1").err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--tls-cert", "a.crt"], "--tls-cert without --scheduler"),
        (["--scheduler", "tcp://127.0.0.1:1", "--tls-cert", "a.crt"], "expected an address tls://HOST:PORT"),
        (["--scheduler", TLS, "--tls-ca-file", "none.crt"], "--tls-ca-file: no such file: none.crt"),
        (["--scheduler", TLS], "asks for certificates, none are named"),
    ],
)
def test_certificates_that_do_not_fit(sweep, words, told):
    said = sweep(*words)
    said.refuses(told)


def test_a_certificate_that_is_none(sweep, tmp_path):
    wrong = tmp_path / "wrong.crt"
    wrong.write_text("no certificate", encoding="utf-8")
    said = sweep("--scheduler", TLS, "--tls-ca-file", wrong, "--tls-cert", wrong, "--tls-key", wrong)
    said.refuses("the certificates cannot be used")
