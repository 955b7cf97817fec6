"""Many runs of one reduced System side by side: other gaps, laws and loads of the same channels, on all cores.

The compiled march holds no lock, so threads of one process share the modal matrices, which stay in the cache of the
cores, and everything else that does not change. Each run is the same sequence of operations as a run by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.chunks import march_chunks
from creak.dynamics.flow.march import FlowRun
from creak.dynamics.history import History, Stopped
from creak.dynamics.loads import Loads
from creak.linalg.threads import cores, one_blas_thread

Found = TypeVar("Found")


@dataclass(frozen=True)
class Variant:
    """What is other in a run."""

    number: int
    gaps: GapOperator
    loads: Loads
    system: System | None = None
    """Where its damping is another; None: that of the others."""


def march_many(
    base: FlowRun,
    variants: Iterable[Variant],
    look: Callable[[Variant, History | Stopped], Found],
    threads: int | None = None,
) -> Iterator[tuple[int, Found]]:
    """Number of a variant and what `look` finds in its history, in the order in which they end.

    Histories are given back as soon as they were looked at: memory is that of as many runs as there are threads.

    Parameters
    ----------
    look : called in a thread of its own, of a run that ended early with the reason.
    threads : default: as many as cores that this process may use.
    """
    count = threads or cores()

    def one(variant: Variant) -> Found:
        try:
            found: History | Stopped = march_chunks(base.again(variant.gaps, variant.loads, variant.system), None)
        except Stopped as stopped:
            found = stopped
        return look(variant, found)

    under_way: dict[Future[Found], int] = {}
    rest = iter(variants)
    with one_blas_thread(), ThreadPoolExecutor(count) as pool:
        try:
            while True:
                for variant in islice(rest, 2 * count - len(under_way)):
                    under_way[pool.submit(one, variant)] = variant.number
                if not under_way:
                    return
                for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                    yield under_way.pop(future), future.result()
        finally:  # an interruption waits for what is marching, not for what is in the queue
            pool.shutdown(cancel_futures=True)
