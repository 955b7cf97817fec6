"""The march by exact flow compiled ahead of a run, by one of a mass at rest."""

from __future__ import annotations

from typing import Any, cast

import numba
import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.damping import Damping
from creak.assembly.system import System, no_supports
from creak.contact.gap_operator import join
from creak.dynamics.flow.block import open_block
from creak.dynamics.flow.books import book_flow, complete
from creak.dynamics.flow.kernel import advance
from creak.dynamics.flow.kicks import press
from creak.dynamics.flow.lasting import hold_on
from creak.dynamics.flow.march import SAMPLES, FlowRun
from creak.dynamics.flow.motion import load_step
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
    """The part of it that takes long steps, a third."""
    run = _at_rest(False)
    x = run.empty()
    _compile((hold_on, (run.model, run.scheme, run.desk, 0, x, x, run.block)))


def compile_short() -> None:
    """The part of it that takes short steps without the solver, and keeps books, a quarter."""
    run = _at_rest(False)
    model, scheme, desk, x, block = run.model, run.scheme, run.desk, run.empty(), run.block
    W, h = scheme.W, scheme.H
    opened = model, scheme.slope, scheme.band, desk.D, desk.energy, desk.course
    _compile(
        (load_step, (model, 0, h, desk.course, desk.drive, desk.D)),
        (open_block, (block, *opened, h, h, 0, 0, x, True)),
        (advance, (model, scheme, True, desk, 0, 0, True, x, x, block)),
        (press, (model, scheme, None, h, desk, x, x, block.is_near)),
        (book_flow, (model, desk.drive, h, x, x, False, desk.together.mean)),
        (complete, (model, scheme.laws, W, h, desk.steady.force, x)),
    )


def _compile(*calls: tuple[Any, tuple[Any, ...]]) -> None:
    """Functions for what `kernel.march` calls them with; bundles go by reference."""
    typeof = cast(Any, numba.typeof)
    with few_collections():
        for function, given in calls:
            kinds = [typeof(one) for one in given]
            function.compile(tuple(Reference(k) if isinstance(k, numba.types.BaseNamedTuple) else k for k in kinds))


def _at_rest(solver: bool) -> FlowRun:
    one, label = Diagonal(np.ones(1)), np.zeros(1, dtype=np.int64)

    def rows(labels: IntArray) -> tuple[FloatArray, FloatArray]:
        return np.ones((labels.size, 1)), np.zeros((labels.size, 0))

    mass = System("at rest", one, one, Damping(), rows, no_supports(1), label, np.zeros(1), labels=label)
    time = np.linspace(0.0, 1e-3, SAMPLES + 1)
    return FlowRun(mass, join([]), at_rest(time), OutputRequest(label), SETTLED, solver)
