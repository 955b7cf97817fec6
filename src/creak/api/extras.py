"""Packages that only some installations have."""

from __future__ import annotations

from importlib.util import find_spec

from creak.errors import InputError

REPORT = ("plotly", "matplotlib", "jinja2")
"""What report.html and the pages of sweeps and the thesis are made with: the extra `report`."""
HOW = "pip install 'creak[report]'"
HOW_PANDAS = "pip install 'creak[pandas]'"


def missing_for_report() -> tuple[str, ...]:
    """The packages of the extra `report` that are not installed."""
    return tuple(name for name in REPORT if find_spec(name) is None)


def no_report_text() -> str:
    """One line: why there is no report, and how to get it; empty where there is one."""
    missing = missing_for_report()
    return f"no report: {', '.join(missing)} not installed; for report.html: {HOW}" if missing else ""


def need_report(instead: str = "") -> None:
    """Check that reports can be written, before any work is done.

    Parameters
    ----------
    instead : what else can be done, for the message.

    Raises
    ------
    InputError : a package of the extra `report` is not installed.
    """
    missing = missing_for_report()
    if missing:
        fix = f"Install them: {HOW}{f', or use {instead}' if instead else ''}"
        raise InputError(f"reports need {', '.join(missing)}, not installed here", fix=fix)
