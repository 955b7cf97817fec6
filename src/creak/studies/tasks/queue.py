"""Jobs that wait for a worker, whatever they are (cases of a sweep, batches of draws), and worker processes on this
machine, each at the end of a pipe that nobody else can open."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar, cast

from creak.linalg.threads import cores

Ended = TypeVar("Ended")
Told = TypeVar("Told", covariant=True)

DEATHS = 4
"""Of workers, until their job has failed."""
DIED = "its worker process died every time (out of memory?)"


class Job(Protocol[Told]):
    """Plain data that goes to a worker, and what is done there."""

    @property
    def name(self) -> str:
        """Unlike that of all others."""

    @property
    def id(self) -> str:
        """Of what it is made from."""

    @property
    def reference(self) -> Path | None:
        """A file that one of the jobs that name it makes for all."""

    def run(self) -> Told:
        """Do it, in a worker; errors become part of what is told."""

    def lost(self, why: str, start: float) -> Told:
        """What is told of it where its worker told nothing; `start` as `time.perf_counter`."""


class Runner(Protocol):
    """Runs jobs somewhere."""

    def __call__(self, tasks: Sequence[Job[Ended]], /) -> Iterator[tuple[str, Ended]]:
        """Yield (name, what it told) of every one as it ends."""


@dataclass
class Queue(Generic[Ended]):
    """Jobs not yet started. Of those that need the same reference run one goes first, the others wait for it."""

    tasks: list[Job[Ended]]
    _making: set[Path] = field(default_factory=set)

    def ready(self, free: int) -> list[Job[Ended]]:
        """Jobs that may start now, no more than `free`; they leave the queue."""
        out: list[Job[Ended]] = []
        for task in list(self.tasks):
            if len(out) >= free:
                break
            path = task.reference
            if path is not None and not path.exists():
                if path in self._making:
                    continue
                self._making.add(path)
            self.tasks.remove(task)
            out.append(task)
        return out

    def ended(self, task: Job[Ended]) -> None:
        """A job ended, in whatever way; if it left no reference, the next one makes it."""
        if task.reference is not None:
            self._making.discard(task.reference)


def run_job(task: Job[Ended]) -> Ended:
    """Do it, in a worker."""
    return task.run()


THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "BLIS_NUM_THREADS", "NUMBA_NUM_THREADS")
TRIM = {"MALLOC_TRIM_THRESHOLD_": "65536"}
"""Memory that a case no longer needs goes back to the system."""


@dataclass(frozen=True)
class Worker:
    """A process and this end of its pipe."""

    process: BaseProcess
    connection: Connection

    def end(self) -> None:
        """Whatever it is doing."""
        self.process.kill()
        self.process.join()
        self.connection.close()


@contextmanager
def local_workers(count: int) -> Iterator[Runner]:
    """Up to `count` worker processes with their share of the cores each; one case at a time each.

    Threads of BLAS, MKL and numba are set in the environment that the workers start with; where it asks for fewer than
    their share already, that holds: threads that wait for others take time of the cores. A worker that dies is
    replaced and its case run again; it has failed after `DEATHS` of them. Workers end with this process, even when it
    is killed. Tasks and outcomes go through pipes between relatives: there is no port to connect to.
    """
    pool = _Pool(count)
    try:
        yield pool.outcomes
    finally:
        pool.end()


def threads_of(share: int) -> dict[str, str]:
    """Threads of a worker that has so many cores: no more than the environment asks for."""
    asked = {name: os.environ.get(name, "") for name in THREADS}
    return {name: str(min(share, int(text) or share) if text.isdecimal() else share) for name, text in asked.items()}


class _Pool:
    def __init__(self, count: int) -> None:
        self._count = count
        self._environ = {**TRIM, **threads_of(max(1, cores() // count))}
        self._idle: list[Worker] = []
        self._busy: dict[Connection, tuple[Worker, Job[Any]]] = {}

    def outcomes(self, tasks: Sequence[Job[Ended]]) -> Iterator[tuple[str, Ended]]:
        queue, deaths, start = Queue(list(tasks)), Counter[str](), time.perf_counter()
        while True:
            for task in queue.ready(self._count - len(self._busy)):
                self._give(task)
            if not self._busy:
                return
            for connection in wait(list(self._busy)):
                worker, task = self._busy.pop(cast(Connection, connection))
                try:
                    outcome: Ended = worker.connection.recv()
                    self._idle.append(worker)
                except (EOFError, OSError):
                    worker.end()
                    deaths[task.name] += 1
                    if deaths[task.name] < DEATHS:
                        self._give(task)
                        continue
                    outcome = task.lost(DIED, start)
                queue.ended(task)
                yield task.name, outcome

    def _give(self, task: Job[Any]) -> None:
        """To a worker that waits, or to a new one; workers that died while they waited are forgotten."""
        while True:
            worker = self._idle.pop() if self._idle else self._started()
            try:
                worker.connection.send(task)
            except OSError:
                worker.end()
                continue
            self._busy[worker.connection] = worker, task
            return

    def _started(self) -> Worker:
        context = multiprocessing.get_context("spawn")
        here, there = context.Pipe()
        process = context.Process(target=_work, args=(there,), daemon=True)
        before = dict(os.environ)
        try:
            os.environ.update(self._environ)
            process.start()
        finally:
            os.environ.clear()
            os.environ.update(before)
            there.close()
        return Worker(process, here)

    def end(self) -> None:
        for worker in [*self._idle, *(worker for worker, _ in self._busy.values())]:
            worker.end()
        self._idle, self._busy = [], {}


def _work(connection: Connection) -> None:
    """In a worker: case after case, until the pipe ends. Ctrl-C is for the process that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    while True:
        try:
            task: Job[Any] = connection.recv()
        except EOFError:
            return
        connection.send(run_job(task))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
