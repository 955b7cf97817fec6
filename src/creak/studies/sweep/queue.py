"""Tasks of a sweep that wait for a worker, and how one ended whose worker was lost."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from creak.studies.sweep.case import FAILED, Outcome, Task, ended, finished_record, provenance

DEATHS = 4
"""Of workers, until their case has failed."""
DIED = "its worker process died every time (out of memory?)"

Runner = Callable[[Sequence[Task]], Iterator[tuple[str, Outcome]]]
"""Runs tasks somewhere; yields (name, outcome) of every one as it ends."""


@dataclass
class Queue:
    """Tasks not yet started. Of those that need the same reference run one goes first, the others wait for it."""

    tasks: list[Task]
    _making: set[Path] = field(default_factory=set)

    def ready(self, free: int) -> list[Task]:
        """Tasks that may start now, no more than `free`; they leave the queue."""
        out: list[Task] = []
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

    def ended(self, task: Task) -> None:
        """A task ended, in whatever way; if it left no reference, the next one makes it."""
        if task.reference is not None:
            self._making.discard(task.reference)


def lost(task: Task, why: str, start: float) -> Outcome:
    """Of a task whose worker told nothing: its result where that is there, else `why`."""
    record = finished_record(task.folder, task.id)
    return ended(record) if record is not None else Outcome(FAILED, why, provenance(task, start))
