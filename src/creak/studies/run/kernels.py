"""Kernels compiled before a run: those that it needs, side by side where they do not hang on each other."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from creak.contact.step_problem import compile_kernels, solve_alone
from creak.dynamics.flow.ahead import compile_flow
from creak.studies.prepare.marching import Marching

START_AND_SOLVER = (
    "from creak.dynamics.flow.ahead import compile_start; from creak.contact.step_problem import compile_kernels; "
    "compile_start(); compile_kernels()"
)
MARCH = "from creak.dynamics.flow.ahead import compile_flow; compile_flow()"
"""What a process beside this one compiles; each function is there for others to take as soon as it is compiled."""


def compile_for(marching: Marching, *, solves_steps: bool) -> None:
    """Compile what the runs of a study need; what was compiled before is read from numba's cache.

    Springs alone press without a solver: that of dampers, friction and steps is compiled beside the march, by another
    process, and only where the unreduced model or a state at rest takes it, which read it from the cache once it is
    there; so does the march what comes before its first step, which that process compiles first. Where the march has
    the solver in it, the solver is compiled here and what else the march is made of beside it.

    Parameters
    ----------
    solves_steps : whether a state at rest, or steps of the unreduced model, are solved for.
    """
    if not marching.table.exact:
        compile_kernels()
    elif marching.solver:
        with _beside(MARCH):
            compile_kernels()
            compile_flow(solver=True)
    elif not solves_steps:
        compile_flow()
    else:
        with _beside(START_AND_SOLVER) as other:
            compile_flow()
            if other is not None:
                other.wait()  # one that failed is made up for here
            compile_kernels()


@contextmanager
def _beside(words: str) -> Iterator[subprocess.Popen[bytes] | None]:
    """Another process that compiles, ended at the end; None where nothing is left to do or there is but one core."""
    other = None if os.cpu_count() == 1 or _compiled() else _started(words)
    try:
        yield other
    finally:
        if other is not None:
            other.kill()
            other.wait()


def _compiled() -> bool:
    """Is the solver in numba's cache, compiled after its source was last changed?"""
    folder, source = solve_alone.stats.cache_path, Path(solve_alone.py_func.__code__.co_filename).stat().st_mtime
    found = [] if folder is None else Path(folder).glob("step_problem.solve_alone-*.nbi")
    return any(path.stat().st_mtime >= source for path in found)


def _started(words: str) -> subprocess.Popen[bytes] | None:
    """A process of these words; None where none can be started."""
    try:
        return subprocess.Popen(
            [sys.executable, "-c", words],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    except OSError:
        return None
