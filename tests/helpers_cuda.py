"""Runs for the GPU's march, and the same by the simulator of numba's CUDA: `python tests/helpers_cuda.py OUT.npz`.

The simulator needs a process of its own, without compiled code, whose block of few threads runs in Python.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from creak.dynamics.flow.march import SAMPLES, FlowRun
from creak.dynamics.flow.resolution import Resolution
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.reduction.diagonal import diagonalise
from helpers_core import chain, channels, system_of

N = 10
STEPS = 8
COARSE = Resolution(0.5, 0.16, 0.04)


def two_stops() -> list[FlowRun]:
    """Ten masses that are pushed against two stops: other gaps, stiffness and loads; two channels, no blocks."""
    M, K = chain(N, 0.01, 2e4)
    system = diagonalise(system_of(M, K, alpha=20.0))
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * STEPS + 1)
    G = np.zeros((2, N))
    G[0, 3], G[1, 7] = 1.0, -1.0

    def loads(size: float) -> Loads:
        push = size * np.sin(2.0 * np.pi * 90.0 * time)
        return Loads(time, np.zeros((3, time.size, 0)), push[:, None], (np.array([N // 2]),))

    def gaps(first: float, second: float, stiffness: float = 4e4) -> object:
        return channels(G, [first, second], stiffness)

    base = FlowRun(system, gaps(2e-4, 3e-4), loads(30.0), COARSE, np.arange(2), STEPS, None, None)
    others = [(gaps(4e-4, 1e-4), loads(30.0)), (gaps(1e-4, 2e-4, 3.9e4), loads(30.0)), (gaps(1.0, 2e-4), loads(45.0))]
    return [base, *(base.again(g, load) for g, load in others)]


def many_stops() -> list[FlowRun]:
    """Ten masses over ten stops: one presses at rest, two are hit, seven are out of reach: blocks, lasting contact."""
    M, K = chain(N, 0.01, 2e4)
    system = diagonalise(system_of(M, K, alpha=20.0))
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * STEPS + 1)
    push = -40.0 * np.sin(2.0 * np.pi * 160.0 * time)
    loads = Loads(time, np.zeros((3, time.size, 0)), push[:, None], (np.array([N // 2]),))
    stiffness = np.where(np.arange(N) == 0, 1e4, 2e6)
    near = np.isin(np.arange(N), (4, 5))
    preload = np.where(np.arange(N) == 0, 5.0, 0.0)

    gap0 = np.where(preload > 0.0, -preload / stiffness, np.where(near, 2e-4, 4e-3))
    gaps = replace(channels(np.eye(N), gap0, stiffness), preload=preload)
    return [FlowRun(system, gaps, loads, Resolution(0.5, 0.25, 0.04), np.arange(2), STEPS, None, None)]


MODELS = {"two": two_stops, "many": many_stops}
KEPT = ("time", "gap", "force", "output_index", "displacement")


def simulate(names: list[str]) -> dict[str, np.ndarray]:
    """What the simulated device gives, by name of the model, number of the run and array of the history."""
    from numba.cuda.simulator.kernel import BlockThread
    from numba.cuda.simulator.kernelapi import FakeCUDAModule

    from creak.dynamics.cuda import block as flow_cuda_block
    from creak.dynamics.cuda import kernel
    from creak.dynamics.cuda import march as flow_cuda

    threads = 4
    barrier = threading.Barrier(threads)

    class Device(FakeCUDAModule):
        def syncwarp(self) -> None:
            barrier.wait()

    BlockThread.syncthreads = lambda self: barrier.wait()
    flow_cuda_block.cuda = Device((1, 1, 1), (threads, 1, 1), 0)
    flow_cuda_block.LANES = 2
    found: dict[str, np.ndarray] = {}
    begun = {"blocks": 0, "held": 0}

    def counted(call: Callable[..., Any], key: str, did: Callable[[Any], bool]) -> Callable[..., Any]:
        def counting(team: Any, *others: Any) -> Any:
            answer = call(team, *others)
            begun[key] += team.lane == 0 and did(answer)
            return answer

        return counting

    kernel.open_block = counted(kernel.open_block, "blocks", lambda answer: answer[0] >= 0)
    kernel.hold = counted(kernel.hold, "held", bool)
    for name in names:
        for v, history in enumerate(flow_cuda.march_together(MODELS[name](), threads)):
            assert isinstance(history, History), history
            found |= {f"{name}/{v}/{key}": getattr(history, key) for key in KEPT}
    return found | {key: np.array(count) for key, count in begun.items()}


if __name__ == "__main__":
    np.savez(sys.argv[1], **simulate(sys.argv[2:]))
