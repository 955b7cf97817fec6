"""Draws on other machines: batches of them as jobs. Each worker makes the model once, from superelements all share."""

from __future__ import annotations

import socket
import uuid
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator, join
from creak.errors import CreakError, InputError, NumericalError, unforeseen
from creak.progress import silent
from creak.studies.file.paths import digests_of
from creak.studies.file.reader import Study
from creak.studies.models.saved import Store
from creak.studies.prepare.setup import set_up
from creak.studies.robust.draws import Draw
from creak.studies.robust.shared_model import SharedModel, march_draws, shared_model
from creak.studies.tasks.queue import Runner
from creak.studies.warned import add_warnings
from creak.version import version

SIZE = 16
"""Draws of a batch: what is lost with a worker."""


@dataclass(frozen=True)
class Marched:
    """What became of a batch."""

    records: tuple[tuple[int, FloatArray], ...]
    """Number and record of each draw that ended."""
    error: str = ""
    notes: tuple[str, ...] = ()
    """Of the model."""


@dataclass(frozen=True)
class Batch:
    """Draws of one model, and what a worker needs to make it; all paths absolute."""

    name: str
    id: str
    """Of the model: batches with the same one share it in their worker."""
    study: Study
    raised: int
    """How often f_max is."""
    draws: tuple[Draw, ...]
    of: FloatArray | tuple[Draw, ...]
    """All draws of the model, in whatever batch they are, or `lowest_of` them."""
    store: Store
    """Of superelements."""
    files: tuple[str, str]
    """Digests of the decks and of the other files that the study names."""
    creak: str
    reference: Path | None = None

    def run(self) -> Marched:
        return run_batch(self)

    def lost(self, why: str, start: float) -> Marched:
        return Marched((), why)


def batches(
    study: Study, raised: int, draws: Sequence[Draw], of: FloatArray | Sequence[Draw], store: Store
) -> list[Batch]:
    """The draws of one model, `SIZE` to a batch; `raised` and `of` as there."""
    study = study.from_anywhere()
    files = digests_of(study)
    where = replace(store, folder=None if store.folder is None else store.folder.resolve())
    every = of if isinstance(of, np.ndarray) else tuple(of)
    model = uuid.uuid4().hex
    return [
        Batch(f"draws from {own[0].number}", model, study, raised, own, every, where, files, version())
        for own in (tuple(draws[k : k + SIZE]) for k in range(0, len(draws), SIZE))
    ]


_made: dict[str, tuple[SharedModel, GapOperator]] = {}
"""The last model of this worker, by `Batch.id`."""


def run_batch(batch: Batch) -> Marched:
    """March the draws of a batch, one after the other; errors become part of the outcome."""
    records: list[tuple[int, FloatArray]] = []
    try:
        model, channels = _model(batch)
        records += [(number, seen.record()) for number, seen in march_draws(model, channels, batch.draws, 1)]
    except CreakError as problem:
        return Marched(tuple(records), str(problem))
    except MemoryError:
        return Marched(tuple(records), f"out of memory on {socket.gethostname()}")
    except Exception as problem:
        return Marched(tuple(records), unforeseen(problem))
    return Marched(tuple(records), notes=model.notes)


def _model(batch: Batch) -> tuple[SharedModel, GapOperator]:
    if batch.id not in _made:
        _made.clear()
        host = socket.gethostname()
        if batch.creak != version():
            raise InputError(
                f"the worker on {host} has creak {version()}, the draws were made with {batch.creak}",
                fix="Install the same version everywhere.",
            )
        if digests_of(batch.study) != batch.files:
            raise InputError(
                f"the worker on {host} does not see the deck and the tables of {batch.study.path} as they were",
                expected="study, deck and tables under the same path on all machines",
                fix="Put them into a folder that all workers share.",
            )
        setup = replace(set_up(batch.study), raised=batch.raised)
        channels = join([setup.contacts, setup.connectors])
        _made[batch.id] = shared_model(setup, batch.of, silent, batch.store), channels
    return _made[batch.id]


def march_batches(runner: Runner, work: Sequence[Batch], notes: list[str]) -> Iterator[tuple[int, FloatArray]]:
    """Number and record of each draw as its batch ends; what the models warn of joins the notes.

    Raises
    ------
    NumericalError : at the end, where batches have failed.
    """
    failed: list[str] = []
    for _, marched in runner(work):
        add_warnings(notes, marched.notes)
        yield from marched.records
        if marched.error:
            failed.append(marched.error)
    if failed:
        raise NumericalError(
            f"{len(failed)} of {len(work)} batches of draws have failed: {failed[0]}. "
            "Draws that are finished are kept; the same command goes on from there"
        )
