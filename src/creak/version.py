"""The version of the creak that runs."""

from __future__ import annotations

from functools import cache
from pathlib import Path


@cache
def version() -> str:
    """That of the installed package; `0+unknown` where it is run without one."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        return installed("creak")
    except PackageNotFoundError:
        return "0+unknown"


@cache
def edition() -> str:
    """The version; of a tree of sources also when one of them was last changed, as the version stays then."""
    here = Path(__file__).parent
    if not (here.parents[1] / "pyproject.toml").is_file():
        return version()
    return f"{version()} {max(path.stat().st_mtime_ns for path in here.rglob('*.py'))}"
