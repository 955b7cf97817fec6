"""The version of the creak that runs."""

from __future__ import annotations

from functools import cache


@cache
def version() -> str:
    """That of the installed package; `0+unknown` where it is run without one."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        return installed("creak")
    except PackageNotFoundError:
        return "0+unknown"
