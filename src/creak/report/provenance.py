"""What a run came from: its files and the programs that made it."""

from __future__ import annotations

import hashlib
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import creak
from creak.report.text import number
from creak.studies.run import StudyResult

PACKAGES = ("numpy", "scipy", "numba", "pypardiso", "h5py", "plotly")
BLOCK = 1 << 20


def provenance(result: StudyResult) -> list[tuple[str, str]]:
    """Name and value, for a table: files with their digests, versions, machine."""
    study = result.setup.study
    source = Path(result.setup.model.source)
    deck = study.sibling(study.config.model.deck)
    rows = [("Study file", study.path.name)]
    for path in dict.fromkeys((deck, source)):
        if path.is_file():
            rows.append(("Deck", f"{path.name}, {number(path.stat().st_size)} bytes, SHA-256 {digest(path)}"))
            break
    rows.append(("creak", creak.__version__))
    rows.append(("Python and packages", f"Python {platform.python_version()}; {_versions()}"))
    return [*rows, ("Machine", f"{platform.system()}, {platform.machine()}")]


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    found = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(BLOCK):
            found.update(block)
    return found.hexdigest()


def _versions() -> str:
    words = []
    for name in PACKAGES:
        try:
            words.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            continue
    return ", ".join(words)
