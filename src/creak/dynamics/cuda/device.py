"""Many runs of one reduced System on what is there: a GPU where it can, else all cores."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from importlib.util import find_spec
from itertools import islice
from typing import Any, Literal, TypeVar

from creak.dynamics.flow.batch import Variant, march_many
from creak.dynamics.flow.march import FlowRun
from creak.dynamics.history import History
from creak.dynamics.stopped import Stopped
from creak.errors import InputError, first_line
from creak.linalg.memory import free_bytes
from creak.linalg.threads import in_order, one_blas_thread

Found = TypeVar("Found")
Device = Literal["auto", "cpu", "gpu"]
MOST = 512
"""Runs of a launch: what is lost when it is killed."""
HOW = "pip install 'creak[gpu]' 'numba-cuda[cu12]', and a driver of CUDA 12.1 or newer."


@lru_cache(maxsize=1)
def no_gpu() -> str:
    """Why no GPU can be used; empty where one can."""
    if find_spec("numba_cuda") is None:
        return "numba-cuda is not installed"
    try:
        from numba import config, cuda

        if getattr(config, "ENABLE_CUDASIM", 0):
            return "numba simulates CUDA"
        if not cuda.is_available():
            return "no device or driver of CUDA was found"
        cuda.jit("void(float64[:])")(_nothing)
    except Exception as problem:  # whatever a broken installation of CUDA raises
        return f"CUDA cannot be used: {first_line(problem)}"
    return ""


def _nothing(x: Any) -> None:
    """A kernel that says whether kernels can be compiled."""


def check_device(device: Device) -> None:
    """Refuse a GPU that is not there.

    Raises
    ------
    InputError : `device` is "gpu" and none can be used.
    """
    reason = no_gpu() if device == "gpu" else ""
    if reason:
        raise InputError(f"device gpu: {reason}", expected="a GPU of NVIDIA with numba-cuda", fix=f"{HOW} Or: cpu.")


def march_anywhere(
    base: FlowRun,
    variants: Iterable[Variant],
    look: Callable[[Variant, History | Stopped], Found],
    threads: int | None = None,
    device: Device = "auto",
    notes: list[str] | None = None,
) -> Iterator[tuple[int, Found]]:
    """As `flow.batch.march_many`, on a GPU where there is one and a run is within its scope.

    Parameters
    ----------
    notes : what was marched where is told there, at the end; nothing where there was no GPU to choose.

    Raises
    ------
    InputError : `device` is "gpu" and none can be used.
    """
    check_device(device)
    told = notes if notes is not None else []
    if device == "cpu" or no_gpu():
        yield from march_many(base, variants, look, threads)
        return
    from creak.dynamics.cuda import march as flow_cuda

    size, rest, there = MOST, iter(variants), 0
    reasons: Counter[str] = Counter()
    while group := list(islice(rest, size)):
        launches, others = _sorted_out(base, group, reasons)
        for launch in launches:
            room = max(min(flow_cuda.at_once(launch[0][1]), int(0.5 * free_bytes() / flow_cuda.bytes_of(base))), 1)
            for begin in range(0, len(launch), room):
                part = launch[begin : begin + room]
                try:
                    with one_blas_thread():
                        histories = flow_cuda.march_together([run for _, run in part])
                except flow_cuda.FAILURES as problem:
                    reasons[f"the device failed ({first_line(problem)})"] += len(part)
                    others += [variant for variant, _ in part]
                    continue
                pairs = [(variant, history) for (variant, _), history in zip(part, histories, strict=True)]
                found = in_order(lambda pair: look(*pair), pairs)
                for (variant, _), seen in zip(pairs, found, strict=True):
                    there += 1
                    yield variant.number, seen
        yield from march_many(base, others, look, threads)
    if there:
        told.append(f"marched on the GPU ({flow_cuda.name()}): {there:,}")
    told += [f"marched on the cores, {reason}: {n:,}" for reason, n in reasons.items()]


def _sorted_out(
    base: FlowRun, group: list[Variant], reasons: Counter[str]
) -> tuple[list[list[tuple[Variant, FlowRun]]], list[Variant]]:
    """Launches of runs that are alike, and the runs for the cores; why they are is counted."""
    from creak.dynamics.cuda.march import alike, out_of_scope

    launches: list[list[tuple[Variant, FlowRun]]] = []
    others: list[Variant] = []
    for variant in group:
        run = base.again(variant.gaps, variant.loads, variant.system)
        scope = out_of_scope(run)
        reason = f"{scope} is not for the GPU" if scope else ""
        if not scope and run.form.model.rows is not base.form.model.rows:
            reason = "damping or preload of their own"
        if reason:
            reasons[reason] += 1
            others.append(variant)
            continue
        same = next((launch for launch in launches if alike(launch[0][1], run)), None)
        if same is None:
            launches.append([(variant, run)])
        else:
            same.append((variant, run))
    return launches, others
