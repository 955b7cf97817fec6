"""What a run came from: its files and the programs that made it."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from pathlib import Path

from creak.report.words.text import number
from creak.studies.file.identity import sha256
from creak.studies.run.job import StudyResult
from creak.version import version

PACKAGES = ("numpy", "scipy", "numba", "pypardiso", "h5py", "plotly")


def provenance(result: StudyResult) -> list[tuple[str, str]]:
    """Name and value, for a table: files with their digests, versions, machine."""
    study = result.setup.study
    source = Path(result.setup.model.source)
    deck = study.sibling(study.config.model.deck)
    rows = [("Run", result.identity.id), ("Study file", f"{study.path.name}, SHA-256 {result.identity.study_sha256}")]
    for path in dict.fromkeys((deck, source)):
        if path.is_file():
            rows.append(("Deck", f"{path.name}, {number(path.stat().st_size)} bytes, SHA-256 {sha256(path)}"))
            break
    rows.append(("creak", version()))
    rows.append(("Python and packages", f"Python {platform.python_version()}; {_versions()}"))
    return [*rows, ("Machine", f"{platform.system()}, {platform.machine()}")]


def _versions() -> str:
    words = []
    for name in PACKAGES:
        try:
            words.append(f"{name} {installed(name)}")
        except PackageNotFoundError:
            continue
    return ", ".join(words)
