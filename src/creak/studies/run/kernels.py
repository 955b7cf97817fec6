"""Kernels that the runs of a study need, compiled by processes beside this one while it reads and reduces the model."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Protocol

from creak.contact.step_problem import compile_kernels, solve_alone
from creak.dynamics.flow.ahead import compile_flow
from creak.dynamics.flow.kernel import march
from creak.jit import is_cached
from creak.progress import Progress
from creak.studies.prepare.marching import Marching

COMPILE = "compile kernels (first run: half a minute)"
"""A phase of its own: slow once, then kept on disk."""
AHEAD = "import os; getattr(os, 'nice', int)(10); "
"""First words of a process beside this one: it takes what this one leaves of the cores."""
LASTING = "from creak.dynamics.flow.ahead import compile_lasting; compile_lasting(); "
SHORT = "from creak.dynamics.flow.ahead import compile_short; compile_short(); "
START = "from creak.dynamics.flow.ahead import compile_start; compile_start(); "
STEPS = START + "from creak.contact.step_problem import compile_kernels; compile_kernels(); "
MARCH = "from creak.dynamics.flow.ahead import compile_flow; compile_flow(); "
SOLVING = "from creak.dynamics.flow.ahead import compile_flow; compile_flow(solver=True); "
SOUND = "import numpy; from creak.sound.loudness import loudness; loudness(numpy.zeros(4800), 48000.0)"
"""What a process compiles; each function is there for others to take as soon as it is compiled."""


class Compiled(Protocol):
    """Waits until kernels are compiled, the first time that it is called."""

    def __call__(self, progress: Progress, *, steps: bool = False) -> None:
        """Those of a march; with `steps` those of a state at rest and of the unreduced model too."""
        ...


@contextmanager
def compiling(marching: Marching, *, solves_steps: bool) -> Iterator[Compiled]:
    """Compile what the runs of a study need beside what is done within, which calls what it is handed before each run.

    Two processes write to numba's cache, where this one finds it; what they failed at it compiles itself, as where
    there is one core. Springs alone press without a solver: that of dampers, friction and steps is compiled only where
    the unreduced model or a state at rest takes it. Parts of the march that one process needs last the other one
    compiles meanwhile.

    Parameters
    ----------
    solves_steps : whether a state at rest, or steps of the unreduced model, are solved for.
    """
    exact, solver = marching.table.exact, marching.solver
    steps = solver or solves_steps or not exact
    if not exact:
        words = [STEPS, SOUND]
    elif solver:
        words = [LASTING + SHORT + SOLVING, STEPS + SOUND]
    else:
        words = [SHORT + MARCH, LASTING + (STEPS if steps else START) + SOUND]
    kernels = [*([march] if exact else []), *([solve_alone] if steps else [])]
    alone = os.cpu_count() == 1 or all(map(is_cached, kernels))
    others = [] if alone else [other for w in words if (other := _started(AHEAD + w))]
    wanted: dict[str, Callable[[], None]] = {"march": partial(compile_flow, solver=solver)} if exact else {}
    if steps:
        wanted["steps"] = compile_kernels

    def compiled(progress: Progress, *, steps: bool = False) -> None:
        every = steps or solver or not exact
        now = [name for name in wanted if name == "march" or every]
        if not now:
            return
        progress(COMPILE, 0, 1)
        for other in others if every else others[:1]:
            other.wait()
        for name in now:
            wanted.pop(name)()
        progress(COMPILE, 1, 1)

    try:
        yield compiled
    finally:
        for other in others:
            other.kill()
            other.wait()


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
