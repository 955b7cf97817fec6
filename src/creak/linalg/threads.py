"""Threads of the linear algebra libraries."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import ThreadpoolController


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Run NumPy's BLAS on one thread; the sparse solver keeps its own.

    A time step alternates short vector operations with back-substitutions. Two thread pools that wait for
    each other on the same cores cost several times what the second thread saves.
    """
    with ThreadpoolController().select(internal_api=["openblas", "blis"]).limit(limits=1):
        yield
