"""Lets every test import the helper modules that lie beside this file, and record what it verifies; long files go first."""

from __future__ import annotations

import gc
import os
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import pytest
import typer.main

sys.path.insert(0, str(Path(__file__).parent))

from helpers_measured import Measured, merge, test_of

pytest_plugins = ["pytester"]
RECORD = Measured()
RAN: dict[str, bool] = {}
"""Test -> whether it passed, with all its parameters."""
SPENT: Counter[str] = Counter()
"""Test -> CPU time of it, its fixtures and its processes, s."""


@pytest.fixture(scope="session", autouse=True)
def _commands_made_once():
    """Typer makes all commands of a program anew for each call, which takes as long as a short one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", cache(typer.main.get_command))
        yield


@pytest.fixture(scope="module")
def measured(request: pytest.FixtureRequest) -> Measured:
    """Records verified quantities: `measured(quantity, found, expected, rel=...)`, see helpers_measured; `RECORDED` of a
    module has the section and the source of its quantities that are given none."""
    return RECORD.of(**getattr(request.module, "RECORDED", {}))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--measured", metavar="FILE", type=Path, help="run only tests that record verified quantities, into FILE"
    )
    parser.addoption(
        "--quick", metavar="S", type=float, help="run only tests not marked slow; name those that take more CPU time"
    )


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--measured") and getattr(config.option, "numprocesses", None):
        raise pytest.UsageError("--measured records in one process: leave out -n")
    RECORD.writing = bool(config.getoption("--measured"))
    if hasattr(config.option, "loadscopereorder"):  # xdist: files in the order below, not by their number of tests
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Files with slow tests first, so that no process is left with one of them at the end."""
    kept = items
    if config.getoption("--measured"):
        kept = [i for i in kept if "measured" in getattr(i, "fixturenames", ())]
    if config.getoption("--quick"):
        kept = [i for i in kept if not slow(i)]
    chosen = set(kept)
    if len(chosen) < len(items):
        config.hook.pytest_deselected(items=[i for i in items if i not in chosen])
    long = {i.path for i in kept if slow(i)}
    items[:] = sorted(kept, key=lambda i: i.path not in long)


def pytest_collection_finish() -> None:
    """What collection has made lives to the end: the garbage collector need not look at it again and again."""
    gc.collect()
    gc.freeze()


def slow(item: pytest.Item) -> bool:
    return item.get_closest_marker("slow") is not None


def cpu_time() -> float:
    """Of this process and of those that it has waited for, s."""
    return sum(os.times()[:4])


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    item.user_properties.append(("begin", cpu_time()))


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item) -> None:
    item.user_properties.append(("end", cpu_time()))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    for test, seconds in SPENT.most_common():
        if seconds > (config.getoption("--quick") or float("inf")):
            terminalreporter.line(f"{test} took {seconds:.1f} s: make it quicker, or mark it slow")


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.failed or (report.when == "call" and report.passed):
        test = test_of(report.nodeid)
        RAN[test] = RAN.get(test, True) and report.passed
    if report.when == "teardown":
        times = dict(report.user_properties)
        SPENT[report.nodeid] = times["end"] - times["begin"]


def pytest_sessionfinish(session: pytest.Session) -> None:
    if file := session.config.getoption("--measured"):
        merge(file, RECORD, {test for test, passed in RAN.items() if passed})
