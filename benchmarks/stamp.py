"""Where a record comes from: version, commit, date, machine and command."""

from __future__ import annotations

import datetime
import os
import platform
import subprocess
import sys
from pathlib import Path

import creak

CPU_FILE, MEMORY_PAGES = Path("/proc/cpuinfo"), "SC_PHYS_PAGES"


def stamp() -> dict[str, str]:
    """Of a record that is written now by the command that runs."""
    return {
        "creak": creak.__version__,
        "commit": commit(),
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "machine": machine(),
        "command": command(),
    }


def commit() -> str:
    """Short name of the source's commit, with `+` where sources were changed since; `unknown` outside a repository.

    Records (JSON) are no sources: a benchmark writes them while it runs.
    """
    try:
        name, changed = _git("rev-parse", "--short", "HEAD"), _git("status", "--porcelain", "--", "src", "benchmarks")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return name + ("+" if any(not line.endswith(".json") for line in changed.splitlines()) else "")


def _git(*words: str) -> str:
    folder = Path(__file__).resolve().parents[1]  # paths are told from it
    return subprocess.run(["git", *words], cwd=folder, capture_output=True, text=True, check=True).stdout.strip()


def machine() -> str:
    """Processor, cores, memory, system, Python."""
    memory = os.sysconf(MEMORY_PAGES) * os.sysconf("SC_PAGE_SIZE") / 2**30 if MEMORY_PAGES in os.sysconf_names else 0.0
    threads = os.environ.get("OMP_NUM_THREADS", "all")
    return (
        f"{_processor()}, {os.cpu_count()} cores, {memory:.0f} GiB, {platform.system()}, "
        f"Python {platform.python_version()}, OMP_NUM_THREADS {threads}"
    )


def _processor() -> str:
    lines = CPU_FILE.read_text(encoding="utf-8").splitlines() if CPU_FILE.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def command() -> str:
    """As it was typed, without the interpreter's path."""
    spec = sys.modules["__main__"].__spec__
    name = Path(sys.argv[0]).name if spec is None else f"-m {spec.name}"
    return " ".join(["python", name, *sys.argv[1:]])
