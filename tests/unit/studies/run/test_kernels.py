"""Kernels that are compiled before a run: those that it needs."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import creak
from creak.contact.gap_operator import GapOperator
from creak.dynamics.flow.ahead import compile_flow, compile_lasting, compile_short
from creak.dynamics.flow.block import open_block
from creak.dynamics.flow.books import book_flow, complete
from creak.dynamics.flow.kernel import advance
from creak.dynamics.flow.kicks import press
from creak.dynamics.flow.lasting import hold_on
from creak.dynamics.flow.march import SAMPLES, FlowRun, simulate_flow
from creak.dynamics.flow.motion import load_step
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
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
    """What is compiled here, in this order, without compiling it, and the processes beside; nothing was compiled yet.

    Each of them fails, so that what it should have done is left to this one.
    """
    here: list[str] = []
    beside: list[str] = []

    def start(words: str) -> subprocess.Popen[bytes]:
        beside.append(words.removeprefix(kernels.AHEAD))
        return subprocess.Popen([sys.executable, "-c", "raise SystemExit(1)"])

    monkeypatch.setattr(kernels, "compile_kernels", lambda: here.append("solver"))
    monkeypatch.setattr(kernels, "compile_flow", lambda solver=False: here.append(f"march {solver}"))
    monkeypatch.setattr(kernels, "is_cached", lambda _: False)
    monkeypatch.setattr(kernels, "_started", start)
    monkeypatch.setattr(kernels.os, "cpu_count", lambda: 2)
    return here, beside


BOTH = [kernels.SHORT + kernels.MARCH, kernels.LASTING + kernels.STEPS + kernels.SOUND]


@pytest.mark.parametrize(
    ("changes", "beside", "here"),
    [
        ({}, BOTH, ["march False", "solver"]),
        ({"reference.run": False}, [BOTH[0], kernels.LASTING + kernels.START + kernels.SOUND], ["march False"]),
        ({"reference.run": False, "reduction.method": "none"}, BOTH, ["march False", "solver"]),
        (
            {"contact.tip.friction": 0.3},
            [kernels.LASTING + kernels.SHORT + kernels.SOLVING, kernels.STEPS + kernels.SOUND],
            ["march True", "solver"],
        ),
        (
            {"contact.tip.damping": 1e-4},
            [kernels.LASTING + kernels.SHORT + kernels.SOLVING, kernels.STEPS + kernels.SOUND],
            ["march True", "solver"],
        ),
        ({"time.step": 5e-4}, [kernels.STEPS, kernels.SOUND], ["solver"]),
    ],
)
def test_what_a_study_needs_is_compiled_beside_it(study, changes, beside, here, calls):
    setup = set_up(creak.change_study(study, changes))
    with kernels.compiling(setup.marching, solves_steps=setup.solves_steps) as compiled:
        compiled(lambda *_: None)
        assert calls == (
            here if len(here) == 1 or setup.marching.solver else [name for name in here if name != "solver"],
            beside,
        )
        for _ in range(2):  # the second time nothing is left to do
            compiled(lambda *_: None, steps=True)
            assert calls == (here, beside)


def test_one_core_compiles_when_it_is_asked(study, calls, monkeypatch):
    monkeypatch.setattr(kernels.os, "cpu_count", lambda: 1)
    setup = set_up(study)
    with kernels.compiling(setup.marching, solves_steps=setup.solves_steps) as compiled:
        compiled(lambda *_: None, steps=True)
    assert calls == (["march False", "solver"], [])


def test_processes_end_with_what_they_were_started_for(study, monkeypatch):
    started = []

    def start(words: str) -> subprocess.Popen[bytes]:
        started.append(subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"]))
        return started[-1]

    monkeypatch.setattr(kernels, "is_cached", lambda _: False)
    monkeypatch.setattr(kernels, "_started", start)
    monkeypatch.setattr(kernels.os, "cpu_count", lambda: 2)
    setup = set_up(study)
    with (
        pytest.raises(KeyboardInterrupt),
        kernels.compiling(setup.marching, solves_steps=setup.solves_steps),
    ):
        raise KeyboardInterrupt
    assert [process.returncode is not None for process in started] == [True, True]


@pytest.mark.parametrize("words", [kernels.STEPS + kernels.SOLVING, kernels.MARCH + kernels.SOUND, kernels.START])
def test_the_words_of_a_process_run(words):
    """Without compiling: what they call is there, takes these arguments, and no more is needed."""
    idle = (
        "import creak.contact.step_problem as s, creak.dynamics.flow.ahead as a, creak.sound.loudness as n; "
        "s.solve_channels = n.loudness = lambda *_: None; a.FlowRun.start = lambda _: None; "
        "a.FlowRun.chunk = lambda *_: None; "
    )
    done = subprocess.run([sys.executable, "-c", idle + kernels.AHEAD + words], capture_output=True, timeout=600)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize(
    ("compile_part", "functions"),
    [(compile_lasting, [hold_on]), (compile_short, [load_step, open_block, advance, press, book_flow, complete])],
)
def test_the_parts_that_are_compiled_by_themselves_are_what_the_march_calls(compile_part, functions):
    """What was compiled amid the march is found, and nothing is compiled."""
    compile_flow()
    known = [set(f._cache._cache_file._load_index()) if f.stats.cache_path else set() for f in functions]
    assert all(known)
    misses = [dict(f.stats.cache_misses) for f in functions]  # none but where the cache was empty before
    compile_part()
    assert [set(f._cache._cache_file._load_index()) for f in functions] == known
    assert [dict(f.stats.cache_misses) for f in functions] == misses


def test_springs_move_the_same_with_the_solver_and_without():
    """Both kernels march one model of springs alone; the solver's stands on 1e-5 of its rates (`flow.kicks.RATE`)."""
    M, K = chain(4, 0.01, 2e4)
    system = diagonalise(system_of(M, K, alpha=20.0))
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * 60 + 1)
    push = (30.0 * np.sin(2.0 * np.pi * 31.0 * time))[:, None]
    loads = Loads(time, np.zeros((3, time.size, 0)), push, (np.array([2]),))
    gaps: GapOperator = channels(np.eye(4), 1e-3 * np.ones(4), np.full(4, 1e5))
    plain, solved = (simulate_flow(system, gaps, loads, OutputRequest(np.arange(4)), solver=s) for s in (False, True))
    assert plain.force.max() > 1.0
    at = plain.output_index
    np.testing.assert_allclose(plain.gap[at], solved.gap[solved.output_index], atol=1e-7 * np.abs(plain.gap).max())


def test_a_run_without_force_takes_the_kernel_of_the_run_beside_it():
    M, K = chain(2, 0.01, 2e4)
    system = diagonalise(system_of(M, K))
    time = 1e-3 / SAMPLES * np.arange(SAMPLES + 1)
    loads = Loads(time, np.zeros((3, time.size, 0)), np.zeros((time.size, 0)), ())
    gaps = channels(np.eye(2), np.ones(2), np.full(2, 1e5)).without_force()
    kept = OutputRequest(np.arange(2))
    assert [FlowRun(system, gaps, loads, kept, SETTLED, s).solver for s in (False, True)] == [False, True]
