"""The march by exact flow compiled ahead of a run, by one of a mass at rest."""

from __future__ import annotations

from typing import Any, cast

import numba
import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.damping import Damping
from creak.assembly.system import System, no_supports
from creak.contact.gap_operator import join
from creak.dynamics.flow.lasting import hold_on
from creak.dynamics.flow.march import SAMPLES, FlowRun
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.loads import at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.linalg.by_reference import Reference
from creak.linalg.compiled import few_collections
from creak.linalg.diagonal import Diagonal


def compile_flow(*, solver: bool = False) -> None:
    """Compile now what a run would compile, by one step of a mass at rest; what `compile_start` compiles comes last.

    solver: with that of channels that rub or have dampers.
    """
    run = _at_rest(solver)
    with few_collections():
        run.chunk(run.empty(), run.empty(), run.log.room(run.rows(1)), 0, 1)
        run.start()


def compile_start() -> None:
    """The part of it that a run takes before its first step, a fifth."""
    run = _at_rest(False)
    with few_collections():
        run.start()


def compile_lasting() -> None:
    """The part of it that takes long steps, a quarter: the signature is that of the call in `kernel.march`."""
    run, typeof = _at_rest(False), cast(Any, numba.typeof)
    bundles = run.model, run.scheme, run.desk, run.empty(), run.block
    model, scheme, desk, x, block = (Reference(typeof(bundle)) for bundle in bundles)
    with few_collections():
        hold_on.compile((model, scheme, desk, numba.int64, x, x, block))


def _at_rest(solver: bool) -> FlowRun:
    one, label = Diagonal(np.ones(1)), np.zeros(1, dtype=np.int64)

    def rows(labels: IntArray) -> tuple[FloatArray, FloatArray]:
        return np.ones((labels.size, 1)), np.zeros((labels.size, 0))

    mass = System("at rest", one, one, Damping(), rows, no_supports(1), label, np.zeros(1), labels=label)
    time = np.linspace(0.0, 1e-3, SAMPLES + 1)
    return FlowRun(mass, join([]), at_rest(time), OutputRequest(label), SETTLED, solver)
