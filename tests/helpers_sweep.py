"""A job that ends the worker which does it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Deadly:
    """It is done once it has ended so many workers, as a process does that the system kills for its memory."""

    name: str
    deaths: Path
    """A file with a letter for each."""
    most: int = 0
    id = ""
    reference = None

    def run(self) -> str:
        known = self.deaths.read_text() if self.deaths.exists() else ""
        if len(known) < self.most:
            self.deaths.write_text(known + "x")
            os._exit(9)
        return "done"

    def lost(self, why: str, start: float) -> str:
        return why
