"""Cost of the loudness over time beside the sound's own length and MoSQITo: `python -m benchmarks.loudness`.

One thread; MoSQITo is left out where it is not installed. Both hear the same five seconds of bursts of noise.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from rich.console import Console
from rich.table import Table

from creak.arrays import FloatArray
from creak.linalg.threads import one_blas_thread
from creak.sound.loudness import loudness

RATE = 48_000
SECONDS = 5.0
GOAL = 20.0
"""Seconds of sound per second of work."""
TIMES = 5


def bursts() -> FloatArray:
    """Noise bursts of 50 dB to 80 dB that die away in 30 ms, ten a second, Pa."""
    rng = np.random.default_rng(1)
    time_in_burst = np.arange(int(SECONDS * RATE)) % (RATE // 10) / RATE
    strength = np.repeat(10.0 ** rng.uniform(-2.2, -0.7, int(10 * SECONDS)), RATE // 10)
    return np.asarray(rng.standard_normal(strength.size) * strength * np.exp(-time_in_burst / 0.03))


def cpu_seconds(work: Callable[[], object], times: int) -> float:
    """CPU seconds, the best of some."""
    found = []
    for _ in range(times):
        started = time.process_time()
        work()
        found.append(time.process_time() - started)
    return min(found)


def main() -> None:
    """Measure and print."""
    argparse.ArgumentParser(prog="python -m benchmarks.loudness").parse_args()
    x = bursts()
    table = Table(
        "what", "CPU", "of real time", title=f"Loudness over time of {SECONDS:g} s of sound, ISO 532-1, one thread"
    )
    with one_blas_thread():
        loudness(x[: RATE // 10], RATE)  # compiles
        own = cpu_seconds(lambda: loudness(x, RATE), TIMES)
        table.add_row("creak", f"{own:.3f} s", f"{SECONDS / own:.0f} x faster, goal {GOAL:g}")
        try:
            from mosqito.sq_metrics import loudness_zwtv
        except ModuleNotFoundError as error:
            table.add_row("MoSQITo", "", f"not measured: {error}")
        else:
            other = cpu_seconds(lambda: loudness_zwtv(x, RATE), 1)
            table.add_row("MoSQITo", f"{other:.2f} s", f"{other / SECONDS:.2f} s per second of sound")
            table.add_row("creak over MoSQITo", f"{other / own:.0f} x", "")
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
