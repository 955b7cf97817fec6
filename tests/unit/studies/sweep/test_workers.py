"""Workers of this machine: replaced when they die, gone with the sweep, told what threads to use."""

from __future__ import annotations

import multiprocessing
import os

import pytest

from creak.studies.tasks.queue import DIED, THREADS, local_workers, threads_of
from helpers_sweep import Deadly

pytestmark = [pytest.mark.slow, pytest.mark.once]


def test_a_case_that_kills_its_worker_is_run_again(tmp_path):
    bad, other = Deadly("bad", tmp_path / "deaths", 2), Deadly("other", tmp_path / "none")
    with local_workers(2) as outcomes:
        assert dict(outcomes([bad, other])) == {"bad": "done", "other": "done"}
    assert bad.deaths.read_text() == "xx"


def test_a_case_that_always_kills_its_worker_has_failed_and_the_others_go_on(tmp_path, monkeypatch):
    """A worker that died while it waited is replaced, none is left, and the environment stays."""
    monkeypatch.setattr("creak.studies.tasks.queue.DEATHS", 1)
    bad, before = Deadly("bad", tmp_path / "deaths", 9), dict(os.environ)
    with local_workers(1) as outcomes:
        ran = outcomes([bad, Deadly("one", tmp_path / "none"), Deadly("two", tmp_path / "none")])
        assert next(ran) == ("bad", DIED)
        assert bad.deaths.read_text() == "x"
        assert next(ran) == ("one", "done")
        (first,) = multiprocessing.active_children()
        assert dict(os.environ) == before
        first.kill()
        first.join()
        assert next(ran) == ("two", "done")
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
