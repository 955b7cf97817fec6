"""Writers of a case that end the worker which calls them."""

from __future__ import annotations

import os
from pathlib import Path

from creak.studies.evaluate import Evaluation


def die(case: Evaluation, folder: Path) -> None:
    """As a process does that the system kills for its memory."""
    deaths = folder.parent / "deaths"
    deaths.write_text(deaths.read_text() + "x" if deaths.exists() else "x")
    os._exit(9)


def die_twice(case: Evaluation, folder: Path) -> None:
    """The third time it lives."""
    deaths = folder.parent / "deaths"
    if not deaths.exists() or len(deaths.read_text()) < 2:
        die(case, folder)
