"""Lets every test import the helper modules that lie beside this file, and record what it verifies."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from helpers_measured import Measured, merge, test_of

RECORD = Measured()
RAN: dict[str, bool] = {}
"""Test -> whether it passed, with all its parameters."""


@pytest.fixture(scope="session")
def measured() -> Measured:
    """Records verified quantities: `measured(section, quantity, found, expected, rel=...)`, see helpers_measured."""
    return RECORD


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--measured", metavar="FILE", type=Path, help="run only tests that record verified quantities, into FILE"
    )


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--measured") and getattr(config.option, "numprocesses", None):
        raise pytest.UsageError("--measured records in one process: leave out -n")
    RECORD.writing = bool(config.getoption("--measured"))


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--measured"):
        others = [i for i in items if "measured" not in getattr(i, "fixturenames", ())]
        items[:] = [i for i in items if "measured" in getattr(i, "fixturenames", ())]
        config.hook.pytest_deselected(items=others)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.failed or (report.when == "call" and report.passed):
        test = test_of(report.nodeid)
        RAN[test] = RAN.get(test, True) and report.passed


def pytest_sessionfinish(session: pytest.Session) -> None:
    if file := session.config.getoption("--measured"):
        merge(file, RECORD, {test for test, passed in RAN.items() if passed})
