"""Threads of the linear algebra libraries."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import ThreadpoolController


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Run NumPy's BLAS on one thread; the sparse solver keeps its own.

    A time step alternates short vector operations with back-substitutions. Two thread pools that wait for
    each other on the same cores cost several times what the second thread saves.
    """
    with ThreadpoolController().select(internal_api=["openblas", "blis"]).limit(limits=1):
        yield
