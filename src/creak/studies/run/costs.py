"""Wall time, CPU time and memory of a stretch of work."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path


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
