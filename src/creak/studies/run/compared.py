"""What a study found beside its models: of a result at hand, and as results.h5 keeps it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Generic, TypeVar

from creak.formats.stored.run_identity import RunIdentity
from creak.studies.run.agreement import ModeComparison, SpectraComparison
from creak.studies.run.elines import LineFindings
from creak.verify.events import Event
from creak.verify.matching import EventMatch, match_events
from creak.verify.slips import SlipEvent, Squeak
from creak.verify.statistics import EventStatistics, compare_statistics

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class RunBase:
    """One time integration, whatever is kept of it."""

    name: str
    integrator: str
    """In a few words."""
    stopped: str | None = None
    """Why it ended early; None: it did not."""
    retained: int = 0
    modes: int = 0
    cost: Cost
    offline_cpu_s: float = 0.0
    """Of the reduction."""
    offline_wall_s: float = 0.0
    events: list[Event]
    slips: tuple[SlipEvent, ...] = ()
    """Stick-slip events of the pairs that rub."""
    squeaks: tuple[Squeak, ...] = ()
    """Stick-slip of each pair that rubs, in the verification window."""


R = TypeVar("R", bound=RunBase)


@dataclass(frozen=True, kw_only=True)
class ResultBase(Generic[R]):
    """What a study found, whatever is kept of its models."""

    identity: RunIdentity
    runs: dict[str, R]
    modes: ModeComparison | None
    spectra: SpectraComparison | None
    events: EventMatch | None
    elines: LineFindings | None
    """E-lines in the main run and without contact; None: there are none."""
    window: tuple[float, float]
    """Of the verification, s."""
    closed_later: int
    """Contact channels that the pre-check dropped and that were kept after all, as one closed in the run."""
    stopped: str | None = None
    """Why the study ended early; None: it did not."""

    @property
    def main(self) -> R | None:
        """The run that the study speaks of: the reduced one where there is one."""
        return main_run(self.runs)

    @property
    def statistics(self) -> EventStatistics:
        """Of the events of both runs in the verification window."""
        return compare_statistics(self.runs["reference"].events, self.runs["reduced"].events, self.window)


def main_run(runs: Mapping[str, T]) -> T | None:
    """The run that a study speaks of: the reduced one where there is one."""
    return runs.get("reduced") or runs.get("reference")


def main_of(summary: Mapping[str, Any]) -> dict[str, Any]:
    """What a summary tells of its main run; empty: there is none."""
    return dict(main_run(summary["runs"]) or {})


def of_base(base: type, record: Any) -> dict[str, Any]:
    """The fields that a record has of its base, by name."""
    return {f.name: getattr(record, f.name) for f in fields(base)}


def compare_events(runs: Mapping[str, RunBase], tolerance: float, window: tuple[float, float]) -> EventMatch | None:
    """Events of the reduced run against those of the reference; None where one of them is missing."""
    if "reference" not in runs or "reduced" not in runs:
        return None
    return match_events(runs["reference"].events, runs["reduced"].events, tolerance, window)


@dataclass(frozen=True)
class Cost:
    """What a stretch of work cost."""

    wall_s: float
    cpu_s: float
    """All threads together."""
    peak_rss_gb: float
    """Largest resident memory of the process in that stretch (of its whole life where the system keeps no
    resettable peak)."""


class Meter:
    """Starts when made; `read` gives the cost so far."""

    def __init__(self) -> None:
        _reset_peak()
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def read(self) -> Cost:
        return Cost(time.perf_counter() - self._wall, time.process_time() - self._cpu, _peak_gb())


def _reset_peak() -> None:
    """Linux resets the peak when 5 is written here; elsewhere the peak stays that of the process."""
    clear = Path("/proc/self/clear_refs")
    if clear.exists():
        try:
            clear.write_text("5")
        except OSError:
            return


def _peak_gb() -> float:
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024.0**2
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2
