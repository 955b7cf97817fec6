"""Workers of this machine: replaced when they die, gone with the sweep, told what threads to use."""

from __future__ import annotations

import multiprocessing
import os
from dataclasses import replace

import pytest

from creak.studies.sweep.cases import resolve
from creak.studies.sweep.file import read_sweep
from creak.studies.sweep.job import tasks_of
from creak.studies.tasks.queue import THREADS, local_workers, threads_of
from helpers_decks import STUDY, write_strips
from helpers_sweep import die, die_twice

pytestmark = [pytest.mark.slow, pytest.mark.once]

QUICK = STUDY.replace("periods = 2", "end = 0.01") + "[reference]\nrun = false\n"


@pytest.fixture
def tasks(tmp_path):
    """Two cases, by name."""
    write_strips(tmp_path, study=QUICK)
    (tmp_path / "sweep.toml").write_text('base = "study.toml"\nseeds = [1, 2]\n', encoding="utf-8")
    out = tmp_path / "out"
    out.mkdir()
    return tasks_of(resolve(read_sweep(tmp_path / "sweep.toml"), out), out)


def test_a_case_that_kills_its_worker_is_run_again(tasks, tmp_path):
    bad = replace(tasks["seed=1"], write=die_twice)
    with local_workers(2) as outcomes:
        found = dict(outcomes([bad, tasks["seed=2"]]))
    assert {name: o.status for name, o in found.items()} == {"seed=1": "done", "seed=2": "done"}
    assert (tmp_path / "out" / "deaths").read_text() == "xx"


def test_a_case_that_always_kills_its_worker_has_failed_and_the_others_go_on(tasks, tmp_path, monkeypatch):
    """A worker that died while it waited is replaced, none is left, and the environment stays."""
    monkeypatch.setattr("creak.studies.tasks.queue.DEATHS", 1)
    bad, before = replace(tasks["seed=1"], write=die), dict(os.environ)
    with local_workers(1) as outcomes:
        ran = outcomes([bad, tasks["seed=2"], tasks["seed=1"]])
        name, failed = next(ran)
        assert (name, failed.status) == ("seed=1", "failed")
        assert "its worker process died every time" in failed.error
        assert (tmp_path / "out" / "deaths").read_text() == "x"
        name, other = next(ran)
        assert (name, other.status) == ("seed=2", "done")
        (first,) = multiprocessing.active_children()
        assert dict(os.environ) == before
        first.kill()
        first.join()
        assert next(ran)[1].status == "done"
        (second,) = multiprocessing.active_children()
        assert second.pid != first.pid
    assert not second.is_alive()


def test_fewer_threads_that_the_environment_asks_for_hold(monkeypatch):
    for name in THREADS:
        monkeypatch.delenv(name, raising=False)
    assert set(threads_of(4).values()) == {"4"}
    for asked, given in (("1", "1"), ("9", "4"), ("0", "4"), ("2,1", "4"), ("", "4")):
        monkeypatch.setenv("OMP_NUM_THREADS", asked)
        assert threads_of(4) == {**dict.fromkeys(THREADS, "4"), "OMP_NUM_THREADS": given}
