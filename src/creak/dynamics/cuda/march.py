"""Many runs of one reduced System side by side on a GPU: `flow.batch` where there is a device.

Runs whose contact is resolved in equal steps share all arrays but gaps, stiffness and loads; each is a block of
threads. Between launches each run's table and motion go to its `Recorder`, so that what comes out is a `History` as
that of a core, but for the energies: nothing asks for them here, they are not a number.
"""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import cuda
from numba.cuda.cudadrv import error

from creak.arrays import FloatArray
from creak.dynamics.compiled import DONE
from creak.dynamics.cuda.block import THREADS
from creak.dynamics.cuda.kernel import compiled
from creak.dynamics.cuda.model import Shared, Sizes, Work, Written
from creak.dynamics.flow.kernel import FULL
from creak.dynamics.flow.march import FlowRun
from creak.dynamics.flow.model import FlowState
from creak.dynamics.history import History
from creak.dynamics.stopped import Diverged, Stopped

FAILURES = (getattr(error, "CudaDriverError", MemoryError), error.CudaSupportError, MemoryError)
"""What a device that is lost, or whose memory others took, raises; a simulated one never does."""
SHARE = 0.8
"""Of the free memory of the device that a launch takes."""


def out_of_scope(run: FlowRun) -> str:
    """Why a run is marched by the cores; empty where a GPU can."""
    if run.form.basis is not None:
        return "damping that couples modes"
    if run.gaps.rubbing:
        return "friction"
    if run.model.damped:
        return "dampers of contacts"
    if (run.steps.laws.curve >= 0).any():
        return "curves of force over closure"
    if run.light:
        return "coordinates without mass"
    if not run.model.presses:
        return "channels that cannot press"
    return "motion that is kept whole" if run.keeps_whole else ""


def name() -> str:
    """Of the device."""
    own = cuda.get_current_device().name
    return own.decode() if isinstance(own, bytes) else str(own)


def alike(run: FlowRun, other: FlowRun) -> bool:
    """Can they be in one launch?"""
    same = run.form.model.rows is other.form.model.rows and run.steps.levels == other.steps.levels
    return same and run.lasting == other.lasting and run.log.chunk == other.log.chunk


def bytes_of(run: FlowRun, threads: int = THREADS) -> int:
    """Memory of the device that a run takes in a launch, beside what all share."""
    arrays = [*_work([run], np.zeros(1, dtype=np.int64), threads), *_written([run])]
    loads = run.model.support.nbytes + run.model.force.nbytes
    return loads + sum(array.nbytes for array in arrays)


def at_once(run: FlowRun) -> int:
    """Runs like this one that the device has memory for."""
    free = cuda.current_context().get_memory_info().free
    if free == float("inf"):  # a simulated device
        return 64
    return int(SHARE * free / bytes_of(run))


def march_together(runs: Sequence[FlowRun], threads: int = THREADS) -> list[History | Stopped]:
    """Histories of runs that are all `alike`, in their order; of one that ended early the reason."""
    shared, sizes, work, out = launch_of(runs, threads)
    for v, run in enumerate(runs):
        _begin(run, run.start(), work, v)
        out.state[v, 5] = run.n_step
    on_device = cuda_arrays(shared), sizes, cuda_arrays(work)
    written = Written(*(cuda.device_array_like(array) for array in out[:4]), *(cuda.to_device(a) for a in out[4:]))
    ended: dict[int, Stopped] = {}
    for run in runs:
        run.log.setup_s = clock.perf_counter() - run.started
    while True:
        compiled()[len(runs), threads](*on_device, written)
        state, time = written.state.copy_to_host(), written.time.copy_to_host()
        for v, run in enumerate(runs):
            code, _, used, kept, _, _ = state[v].tolist()
            if v in ended:
                continue
            if used:
                _take(run, written, v, used, kept)
            if code not in (DONE, FULL):
                ended[v] = Diverged(float(time[v]), run.log.history())
        under_way = (state[:, 1] < state[:, 5]) & np.isin(state[:, 0], (DONE, FULL))
        if not under_way.any():
            return [ended[v] if v in ended else run.log.history() for v, run in enumerate(runs)]


def launch_of(runs: Sequence[FlowRun], threads: int) -> tuple[Shared, Sizes, Work, Written]:
    """What the kernel is given for some runs, before they begin."""
    which, support, force = _loads(runs)
    first = runs[0]
    sizes = Sizes(first.H, first.steps.levels, first.lasting, first.block.length, first.log.chunk)
    return _shared(first, support, force), sizes, _work(runs, which, threads), _written(runs)


def cuda_arrays(group: Any) -> Any:
    """The arrays of a NamedTuple on the device."""
    return type(group)(*(cuda.to_device(array) for array in group))


def _loads(runs: Sequence[FlowRun]) -> tuple[Any, FloatArray, FloatArray]:
    """Row of each run in the loads that are different, and these."""
    rows: dict[tuple[int, int], int] = {}
    which = np.array([rows.setdefault((id(r.loads.support), id(r.loads.force)), len(rows)) for r in runs])
    first = [int(np.flatnonzero(which == k)[0]) for k in range(len(rows))]
    support, force = (np.stack([getattr(runs[k].model, key) for k in first]) for key in ("support", "force"))
    return which, support, force


def _shared(run: FlowRun, support: FloatArray, force: FloatArray) -> Shared:
    model, m = run.model, run.gaps.m
    return Shared(
        model.rows,
        model.rates,
        model.push,
        model.rows_s,
        model.preload,
        model.load,
        model.order,
        model.column,
        model.m,
        model.k,
        model.still,
        run.P,
        run.W,
        run.B,
        run.gain,
        run.steps.band,
        run.steps.reach,
        run.block.off,
        run.block.width,
        support,
        force,
        np.arange(m, dtype=np.int64),
        np.zeros(m),
        np.full(m, -1, dtype=np.int64),
        np.zeros(0),
        np.zeros(0, dtype=np.int64),
        np.zeros(0, dtype=np.bool_),
    )


def _work(runs: Sequence[FlowRun], which: Any, threads: int) -> Work:
    """Nothing in it yet but gaps, laws and shares."""
    model, V = runs[0].model, len(runs)
    n, m, n_s, bands = model.m.size, runs[0].gaps.m, model.support.shape[2], runs[0].steps.reach.shape[1]
    lasts = m if runs[0].lasting <= runs[0].steps.levels else 0

    def channels(dtype: Any = float) -> Any:
        return np.zeros((V, m), dtype=dtype)

    def instants() -> FloatArray:
        return np.zeros((V, 2, m))

    return Work(
        np.stack([run.model.gap0 for run in runs]),
        np.stack([run.steps.laws.stiffness for run in runs]),
        which.astype(np.int64),
        np.zeros((V, 2, 2, n)),
        np.zeros((V, 2, n)),
        instants(),
        instants(),
        instants(),
        instants(),
        np.zeros((V, 2, 3, n_s)),
        np.zeros((V, 4, n)),
        np.zeros((V, 3, n_s, 4)),
        np.zeros((V, model.order.size, 4)),
        np.zeros((V, threads, bands)),
        np.ones((V, m)),
        channels(),
        channels(bool),
        channels(np.int64),
        np.ones((V, m), dtype=np.bool_),
        channels(np.int64),
        channels(),
        channels(),
        np.zeros((V, threads, 7, 2 * (-(-m // threads)))),
        channels(np.int64),
        channels(),
        channels(),
        channels(),
        np.zeros((V, lasts * lasts)),
    )


def _written(runs: Sequence[FlowRun]) -> Written:
    """Shapes for the device, but for state and time."""
    run, V = runs[0], len(runs)
    chunk = min(run.log.chunk, run.n_step)
    n, m, n_s = run.model.m.size, run.gaps.m, run.model.support.shape[2]
    state = np.zeros((V, 6), dtype=np.int64)
    return Written(
        np.empty((V, run.rows(chunk), 1 + 2 * m)),
        np.empty((V, chunk), dtype=np.int64),
        np.empty((V, chunk, n)),
        np.empty((V, chunk, n_s)),
        state,
        np.zeros(V),
    )


def _begin(run: FlowRun, x: FlowState, work: Work, v: int) -> None:
    """The first instant of a run."""
    work.x[v, 0], work.F[v, 0], work.force[v, 0], work.gap[v, 0] = x.x, x.F, x.force, x.gap
    work.rate[v, 0], work.drift[v, 0], work.s[v, 0] = x.rate, x.drift, x.support
    x.energy[:] = np.nan
    run.log.first(run.loads.time[0], x, run.kept(x))


def _take(run: FlowRun, written: Written, v: int, used: int, kept: int) -> None:
    """What a launch left of a run goes to its log."""
    m, out, before = run.gaps.m, run.log.room(used), run.log.used
    rows = out.table[before : before + used]
    rows[:, : 1 + 2 * m] = written.table[v][:used].copy_to_host()
    rows[:, 1 + 2 * m :] = np.nan
    if kept:
        out.at[:kept] = before + written.at[v][:kept].copy_to_host()
        out.u[:kept] = written.u[v][:kept].copy_to_host()
        out.s[:kept] = written.s[v][:kept].copy_to_host()
    run.log.take(before + used, kept, out)
