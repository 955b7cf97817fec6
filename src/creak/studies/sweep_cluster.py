"""Where a sweep runs: worker processes on this machine, or a cluster that is there already."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from creak.errors import InputError

if TYPE_CHECKING:
    from distributed import Client

THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "BLIS_NUM_THREADS", "NUMBA_NUM_THREADS")
WAIT = 30.0
"""s to wait for a scheduler."""


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def need_distributed() -> None:
    """Raises InputError, with what to install, where dask.distributed is not there."""
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise InputError("sweeps need dask.distributed, which is not installed",
                         fix="pip install 'creak[cluster]' or: pip install distributed") from error  # fmt: skip


@contextmanager
def local_workers(count: int) -> Iterator[Client]:
    """Worker processes on this machine, each with its share of the cores; one case at a time each.

    Threads of BLAS, MKL and numba are set in the environment that the workers start with. A worker that dies is
    replaced. Workers have no limit of memory, and none to the time that they may be busy without a sign.
    """
    import dask
    from distributed import Client, LocalCluster

    share = {name: str(max(1, cores() // count)) for name in THREADS}
    settings = {
        "distributed.nanny.pre-spawn-environ": {"MALLOC_TRIM_THRESHOLD_": "65536", **share},
        "distributed.scheduler.worker-ttl": None,
    }
    before = dict(os.environ)
    try:
        with dask.config.set(settings), LocalCluster(
            n_workers=count, threads_per_worker=1, processes=True, memory_limit=0, dashboard_address=None,
            silence_logs=logging.CRITICAL,
        ) as cluster, Client(cluster) as client:  # fmt: skip
            yield client
    finally:
        os.environ.clear()
        os.environ.update(before)


@contextmanager
def running_cluster(address: str) -> Iterator[Client]:
    """A cluster by the address of its scheduler; its workers keep the threads they were started with.

    Raises
    ------
    InputError : nothing answers there, or workers take several cases at once.
    """
    from distributed import Client

    try:
        client = Client(address, timeout=WAIT)
    except (OSError, ValueError) as error:
        raise InputError(f"no dask scheduler at {address}: {error}", expected="an address such as tcp://host:8786",
                         fix="Start it with: dask scheduler") from error  # fmt: skip
    with client:
        workers = client.scheduler_info(n_workers=-1)["workers"]
        several = next((w for w in workers.values() if w["nthreads"] > 1), None)
        if several is not None:
            raise InputError(
                f"worker {several['name']} would run {several['nthreads']} cases at once", expected="one at a time",
                fix="Start the workers with: dask worker ADDRESS --nthreads 1",
            )  # fmt: skip
        yield client
