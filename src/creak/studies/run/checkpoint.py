"""Checkpoints of unreduced runs: what a run that was stopped or killed is taken up from, beside its results.

A file belongs to one march: to the study with its decks and files, the version of creak, what is kept, and the
channels, which grow where one closes that the pre-check had dropped. The first of its two digests is of all but those.
"""

from __future__ import annotations

import json
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from types import FrameType
from typing import Any, TypeVar

from creak.arrays import IntArray
from creak.digest import digest
from creak.dynamics.instant import Saved
from creak.errors import CreakError
from creak.formats.stored.sealed import Damaged, bound_file, is_bound, opened_hdf5
from creak.formats.stored.tree import read_tree, write_tree
from creak.progress import Progress, Steps
from creak.studies.run.compared import Cost, Meter
from creak.studies.warned import Warned
from creak.version import version

EVERY = 300.0
"""s of wall time between two checkpoints."""
DEAR = 50.0
"""Longer where writing one took more than a share of one in so many."""
ENDING = ".checkpoint.h5"
ASKS = (signal.SIGINT, signal.SIGTERM)
"""Ctrl-C, and what batch systems send before they kill."""
T = TypeVar("T")
KIND, VERSION = "checkpoint", 2


@dataclass(frozen=True)
class Kept:
    """What a file holds."""

    saved: Saved
    cost: Cost
    """Of the run until then."""


class Checkpoints:
    """Those of the runs of a study, in the folder of its results."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.notes: list[str] = []
        """What the user should know of them."""
        self._studies: set[str] = set()

    def of(
        self,
        origin: Sequence[str],
        name: str,
        end: float,
        n: int,
        channels: Sequence[Sequence[str]],
        kept: Sequence[IntArray],
    ) -> Checkpoint:
        """That of one march.

        Parameters
        ----------
        origin : what it hangs on besides (`Setup.origin`). name : of the run. end : of it, s. n : its coordinates.
        channels : names of those that press, and of those that are looked at. kept : nodes' dofs and steps.
        """
        asked = [version(), name, *origin, f"{end!r} {n}", *map(digest, kept)]
        made_from = [blake2b(json.dumps(of).encode(), digest_size=8).hexdigest() for of in (asked, channels)]
        self._studies.add(made_from[0])
        others = [p for p in self.folder.glob(f"*{ENDING}") if f".{made_from[0]}." not in p.name]
        path = self.folder / f"{name}_run.{'.'.join(made_from)}{ENDING}"
        return Checkpoint(path, name, end, self.notes, others)

    def remove(self) -> None:
        """Those of this study; for when its results are complete."""
        for study in self._studies:
            for path in self.folder.glob(f"*_run.{study}.*{ENDING}"):
                path.unlink(missing_ok=True)


class Checkpoint:
    """`dynamics.instant.Keeper` of one march: a file every `EVERY` s, and one where the run is asked to end.

    Parameters
    ----------
    path : named after all that the march depends on. end : of the march, s. notes : takes what the user should know.
    others : checkpoints of other studies that lie there.
    """

    def __init__(self, path: Path, name: str, end: float, notes: list[str], others: list[Path]) -> None:
        self.path, self._name, self._end, self._notes, self._others = path, f"{name} run", end, notes, others
        self._meter, self._asked, self._failed, self._written = Meter(), False, False, False
        self._due, self._what = time.monotonic() + EVERY, self._name
        found = self._found()
        self.saved = None if found is None else found.saved
        """Until the march has taken it."""
        self._before = Cost(0.0, 0.0, 0.0) if found is None else found.cost
        self._done = 0 if found is None else found.saved.log.done
        self._at_end = found is not None and found.saved.log.time >= end

    def _found(self) -> Kept | None:
        """What lies in the file; notes say what becomes of it."""
        try:
            found = read_checkpoint(self.path, self.path.name, Kept)
        except Damaged as error:
            self._warn(f"starts anew, its checkpoint {self.path} is damaged ({error})")
            self._what = f"{self._name} anew (its checkpoint is damaged)"
            return None
        if found is not None:
            self._what = f"{self._name} goes on at {_time(found)} s of {self._end:g} s"
            self._notes.append(f"{self._what}, where an earlier one was stopped")
        elif self._others:
            names = ", ".join(path.name for path in self._others)
            self._warn(
                f"starts anew, {names} in {self.path.parent} belongs to another study, model or version of creak; "
                "delete it unless you want to go on with that"
            )
            self._what = f"{self._name} anew (a checkpoint there is of another study)"
        return found

    def told(self, progress: Progress) -> Steps:
        """What is told of the run while it goes on: of one that was taken up, from there."""
        if self._done:
            progress(self._what, int(self._at_end), 1)
        return lambda done, total: progress(self._what, done - self._done, total - self._done)

    @property
    def cost(self) -> Cost:
        """That of the whole run so far, what was taken up included."""
        before, now = self._before, self._meter.read()
        peak = max(before.peak_rss_gb, now.peak_rss_gb)
        return Cost(before.wall_s + now.wall_s, before.cpu_s + now.cpu_s, peak)

    def wanted(self, last: bool) -> bool:
        if last and (self._written or self._done):
            return True
        return self._asked or time.monotonic() >= self._due

    def keep(self, saved: Saved) -> None:
        started, held = time.monotonic(), Kept(saved, self.cost)
        try:
            self._write(held)
        except KeyboardInterrupt:  # it came in the middle of the file: once more, then the end
            self._asked = True
            self._write(held)
        now = time.monotonic()
        self._due = now + max(EVERY, DEAR * (now - started))
        if self._asked:
            if self._written:
                self._notes.append(f"{self._name}: the same command goes on at {_time(held)} s ({self.path})")
            raise KeyboardInterrupt

    @contextmanager
    def heeding(self) -> Iterator[None]:
        """Ctrl-C and SIGTERM wait for the next `keep`; the second one does not."""
        self.saved = None
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {ask: signal.getsignal(ask) for ask in ASKS}
        heeded = [ask for ask, now in before.items() if callable(now) or (ask, now) == (signal.SIGTERM, signal.SIG_DFL)]
        for ask in heeded:
            signal.signal(ask, self._remember)
        try:
            yield
        finally:
            for ask in heeded:
                signal.signal(ask, before[ask])
        if self._asked:
            raise KeyboardInterrupt

    def _remember(self, number: int, frame: FrameType | None) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = True

    def _write(self, held: Kept) -> None:
        """The file; one that cannot be written costs nothing but a warning."""
        try:
            write_checkpoint(self.path, self.path.name, held)
            self._written = True
        except (CreakError, OSError) as error:
            if not self._failed:
                self._warn(f"goes on without a checkpoint: {error}")
            self._failed = True

    def _warn(self, text: str) -> None:
        self._notes.append(Warned(f"{self._name} {text}"))


def _time(held: Kept) -> str:
    return f"{held.saved.log.time:.4g}"


def write_checkpoint(path: Path, made_from: str, held: Any) -> None:
    """Write the file, complete or absent: the one before stays until this one is whole.

    Raises
    ------
    InputError, WriteError : the folder cannot be written, or the disk is full.
    """
    with bound_file(path, KIND, VERSION, made_from) as file:
        write_tree(file.create_group("held"), held, packed=False)


def read_checkpoint(path: Path, made_from: str, kind: type[T]) -> T | None:
    """The dataclass; None where there is no such file, or it belongs to something else.

    Raises
    ------
    Damaged : the file is not as creak wrote it.
    """
    if not path.is_file():
        return None
    try:
        with opened_hdf5(path) as file:
            if not is_bound(file, KIND, VERSION, made_from):
                return None
            return read_tree(kind, file["held"])
    except Damaged:
        raise
    except (OSError, LookupError, TypeError, ValueError, ArithmeticError, RuntimeError, AttributeError) as error:
        raise Damaged(next(iter(str(error).splitlines()), "unreadable")) from error
