"""Jobs that wait for a worker, whatever they are: cases of a sweep, batches of draws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, Protocol, TypeVar

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
