"""Threads of the linear algebra libraries."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache

from threadpoolctl import ThreadpoolController


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


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Run NumPy's BLAS on one thread; the sparse solver keeps its own.

    A time step alternates short vector operations with back-substitutions. Two thread pools that wait for
    each other on the same cores cost several times what the second thread saves.
    """
    with ThreadpoolController().select(internal_api=["openblas", "blis"]).limit(limits=1):
        yield
