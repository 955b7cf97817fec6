"""Kernels that are compiled before a run: those that it needs."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import creak
from creak.contact.gap_operator import GapOperator
from creak.dynamics.flow.march import SAMPLES, FlowRun, simulate_flow
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.loads import Loads
from creak.reduction.diagonal import diagonalise
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run import kernels
from helpers_core import chain, channels, system_of
from helpers_decks import STUDY, write_strips

EXACT = STUDY.replace("step = 5e-4\n", "")


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return read_study(write_strips(tmp_path_factory.mktemp("strips"), study=EXACT))


@pytest.fixture
def calls(monkeypatch):
    """What is compiled, in this order, without compiling it; none of it was compiled before."""
    found: list[str] = []
    monkeypatch.setattr(kernels, "compile_kernels", lambda: found.append("solver"))
    monkeypatch.setattr(kernels, "compile_flow", lambda solver=False: found.append(f"march {solver}"))
    monkeypatch.setattr(kernels, "_compiled", lambda: False)
    monkeypatch.setattr(kernels.os, "cpu_count", lambda: 2)
    return found


@pytest.mark.parametrize(
    ("changes", "aside", "expected"),
    [
        ({}, True, ["march False", "solver"]),
        ({"reference.run": False}, False, ["march False"]),
        ({"reference.run": False, "reduction.method": "none"}, True, ["march False", "solver"]),
        ({"contact.tip.friction": 0.3}, True, ["solver", "march True"]),
        ({"contact.tip.damping": 1e-4}, True, ["solver", "march True"]),
        ({"time.step": 5e-4}, False, ["solver"]),
    ],
)
def test_what_a_study_needs_is_compiled(study, changes, aside, expected, calls, monkeypatch):
    started = []

    def start(words: str) -> subprocess.Popen[bytes]:
        started.append(words)
        return subprocess.Popen([sys.executable, "-c", "raise SystemExit(1)"])  # one that fails is made up for

    monkeypatch.setattr(kernels, "_started", start)
    setup = set_up(creak.change_study(study, changes))
    kernels.compile_for(setup.marching, solves_steps=setup.solves_steps)
    assert calls == expected
    assert bool(started) == aside


def test_the_process_beside_compiles_what_is_looked_for(monkeypatch, tmp_path):
    """Its words run, and the cache then holds what tells that nothing is left to do."""
    assert isinstance(kernels._compiled(), bool)
    idle = "import creak.contact.step_problem as s, creak.dynamics.flow.ahead as a; s.solve_channels = lambda *_: None"
    words = f"{idle}; a.FlowRun.start = lambda _: None; {kernels.START_AND_SOLVER}"
    assert subprocess.run([sys.executable, "-c", words], capture_output=True, timeout=600).returncode == 0
    name = f"step_problem.{kernels.solve_alone.py_func.__qualname__}-7.py311.nbi"
    monkeypatch.setattr(type(kernels.solve_alone), "stats", property(lambda _: type("S", (), {"cache_path": tmp_path})))
    assert not kernels._compiled()
    (tmp_path / name).write_bytes(b"")
    assert kernels._compiled()


def test_springs_move_the_same_with_the_solver_and_without():
    """Both kernels march one model of springs alone; the solver's stands on 1e-5 of its rates (`flow.kicks.RATE`)."""
    M, K = chain(4, 0.01, 2e4)
    system = diagonalise(system_of(M, K, alpha=20.0))
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * 60 + 1)
    push = (30.0 * np.sin(2.0 * np.pi * 31.0 * time))[:, None]
    loads = Loads(time, np.zeros((3, time.size, 0)), push, (np.array([2]),))
    gaps: GapOperator = channels(np.eye(4), 1e-3 * np.ones(4), np.full(4, 1e5))
    plain, solved = (simulate_flow(system, gaps, loads, observed=np.arange(4), solver=s) for s in (False, True))
    assert plain.force.max() > 1.0
    at = plain.output_index
    np.testing.assert_allclose(plain.gap[at], solved.gap[solved.output_index], atol=1e-7 * np.abs(plain.gap).max())


def test_a_run_without_force_takes_the_kernel_of_the_run_beside_it():
    M, K = chain(2, 0.01, 2e4)
    system = diagonalise(system_of(M, K))
    time = 1e-3 / SAMPLES * np.arange(SAMPLES + 1)
    loads = Loads(time, np.zeros((3, time.size, 0)), np.zeros((time.size, 0)), ())
    gaps = channels(np.eye(2), np.ones(2), np.full(2, 1e5)).without_force()
    kept = (np.arange(2), 1, None, None)
    assert [FlowRun(system, gaps, loads, SETTLED, *kept, s).solver for s in (False, True)] == [False, True]
