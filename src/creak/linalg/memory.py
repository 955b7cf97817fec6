"""Memory that is free, and the refusal of what would not fit, before it starts."""

from __future__ import annotations

import ctypes
import functools
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from creak.errors import InputError, NumericalError
from creak.linalg.mkl import has_pardiso, mkl_library

GB = 1e9
ENTRY, PRODUCT = 12.0, 16.0
"""Bytes of a stored entry: in a sparse matrix, in MKL's copy of it for products."""
MADE = 30.0
"""Bytes of an entry of K while a factor is made: K - s M, where its upper triangle lies, and that triangle."""
SHARE = 0.6
"""Of what is free, that a block of columns may take which nothing but its answers outlives."""
LARGE, MUCH = 16e6, 0.1
"""Bytes that are worth being given back, and their share of what is free from which on they are."""
OVERRIDE = "CREAK_MEMORY_GB"
"""Environment variable: gigabytes to count on instead of what the system says is free."""
MEMINFO, GROUP, STATM = Path("/proc/meminfo"), Path("/sys/fs/cgroup"), Path("/proc/self/statm")


class OutOfMemory(NumericalError):
    """Something would not fit into memory."""


def free_bytes() -> float:
    """Memory that this process may still take, swap included; infinite where the system does not say.

    Raises
    ------
    InputError : the environment variable `OVERRIDE` is no positive number.
    """
    given = os.environ.get(OVERRIDE, "").strip()
    if given:
        return GB * _positive(given)
    return min(_of_machine(), _of_group())


def held_bytes() -> float:
    """Memory that this process has; 0 where the system does not say."""
    try:
        pages = STATM.read_text().split()[1]
    except OSError:  # not Linux
        return 0.0
    return float(pages) * os.sysconf("SC_PAGE_SIZE")


def left_beside(held: float) -> float:
    """What would be free if this process held so many bytes; what `OVERRIDE` says however many they are."""
    return free_bytes() if os.environ.get(OVERRIDE, "").strip() else free_bytes() + held_bytes() - held


def give_back(freed: float) -> None:
    """Return what the process no longer uses to the system, where `freed` bytes are much against what is free.

    MKL keeps half of a factor that is gone for its next calls, and the C library the holes of its heap. Takes 3 ms.
    """
    if freed < LARGE or freed < MUCH * free_bytes():
        return
    if has_pardiso():
        mkl_library().mkl_free_buffers()
    trim = _trim()
    if trim is not None:
        trim(0)


@functools.cache
def _trim() -> Any:
    """malloc_trim of the GNU C library; None elsewhere."""
    return getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None


def fits(needed: float) -> bool:
    """Whether so many bytes are free."""
    return needed <= free_bytes()


def blocks_that_fit(n: int, rows: int, copies: int, most: int, fewest: int) -> Iterator[slice]:
    """Slices of n columns of so many rows to work on at a time.

    Of `most`, or of fewer where `copies` of them would take more than `SHARE` of what is free; of `fewest` at least.
    """
    held = min(SHARE * free_bytes() / (copies * 8.0 * max(rows, 1)), most)
    step = max(int(held), fewest)
    for start in range(0, n, step):
        yield slice(start, min(start + step, n))


def require(needed: float, what: str, fix: str) -> None:
    """Refuse what needs more bytes than are free.

    Raises
    ------
    OutOfMemory : with both figures, what to do and how to go on all the same.
    """
    free = free_bytes()
    if needed > free:
        raise OutOfMemory(
            f"memory does not hold {what}: {needed / GB:.3g} GB are needed, {free / GB:.3g} GB are free. {fix} "
            f"To try all the same, set {OVERRIDE}={needed / GB * 1.01:.3g} in the environment."
        )


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not value > 0.0:
        raise InputError(f"{OVERRIDE}={text!r}", expected="a positive number of gigabytes", fix="Change or unset it.")
    return value


def _of_machine() -> float:
    try:
        lines = [line.split() for line in MEMINFO.read_text().splitlines()]
    except OSError:  # not Linux
        return float("inf")
    kilobytes = {words[0].rstrip(":"): float(words[1]) for words in lines if len(words) > 1}
    if "MemAvailable" not in kilobytes:
        return float("inf")
    return 1024.0 * (kilobytes["MemAvailable"] + kilobytes.get("SwapFree", 0.0))


def _of_group() -> float:
    """What a container's limit leaves; pages of files do not count, they are given back."""
    try:
        limit, used = ((GROUP / name).read_text().strip() for name in ("memory.max", "memory.current"))
        figures = dict(line.split() for line in (GROUP / "memory.stat").read_text().splitlines())
    except OSError:  # no container, or one that does not tell
        return float("inf")
    return float("inf") if limit == "max" else float(limit) - float(used) + float(figures.get("inactive_file", 0))
