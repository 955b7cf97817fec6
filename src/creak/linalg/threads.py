"""Threads of the linear algebra libraries."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache, lru_cache
from typing import Any, TypeVar

from threadpoolctl import ThreadpoolController

Item = TypeVar("Item")
Result = TypeVar("Result")


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def pool() -> ThreadPoolExecutor:
    """Threads for compiled loops, as many as cores; they are kept, since starting them costs more than a small loop."""
    return _pool_of(os.getpid())


@lru_cache(maxsize=1)
def _pool_of(process: int) -> ThreadPoolExecutor:
    """A process that was forked has none of its parent's threads: each has its own."""
    return ThreadPoolExecutor(cores())


def in_order(work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """`work` of each item by the threads of `pool`, in the order of the items; one more than cores is held at most.

    Compiled loops and NumPy's let go of the interpreter; the result does not depend on the number of cores.
    """
    ahead: deque[Future[Result]] = deque()
    try:
        for item in items:
            if len(ahead) == cores() + 1:
                yield ahead.popleft().result()
            ahead.append(pool().submit(work, item))
        while ahead:
            yield ahead.popleft().result()
    finally:
        for waiting in ahead:
            waiting.cancel()


def at_once(
    work: Callable[[Item], Result], items: Sequence[Item], most: int, halt: Callable[[], object] = lambda: None
) -> list[Result]:
    """`work` of each item by threads of their own, which may use `pool` themselves; results in the order of the items.

    Parameters
    ----------
    most : threads; with one, all is done by the calling thread. halt : called where the calling thread is interrupted
        or a work raises, so that works under way end early; they are waited for, those that wait are given up.
    """
    if min(most, len(items)) < 2:
        return [work(item) for item in items]
    with ThreadPoolExecutor(min(most, len(items))) as own:
        under_way = [own.submit(work, item) for item in items]
        try:
            return [future.result() for future in under_way]
        except BaseException:
            halt()
            own.shutdown(wait=False, cancel_futures=True)
            raise


LARGE = 4000
"""Equations of a dense eigenproblem from which all cores are worth the risk that others run on them."""


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Run NumPy's BLAS on one thread; the sparse solver, and the products that it makes, keep their own.

    Time steps and Lanczos alternate short dense operations with back-substitutions. Two thread pools that wait for
    each other on the same cores cost several times what the second thread saves: a dense eigenproblem of 900 equations
    takes 20 times longer where something else runs on one of two cores.
    """
    with _numpys_blas().limit(limits=1):
        yield


@contextmanager
def dense_threads(n: int) -> Iterator[None]:
    """Run NumPy's BLAS on all cores where n equations are `LARGE`, on one thread else."""
    with _numpys_blas().limit(limits=cores() if n >= LARGE else 1):
        yield


@cache
def _numpys_blas() -> Any:
    """The libraries of NumPy and SciPy, looked for once: a search reads the whole map of the process's memory."""
    import scipy.linalg  # noqa: F401  (brings SciPy's own)

    return ThreadpoolController().select(internal_api=["openblas", "blis"])
