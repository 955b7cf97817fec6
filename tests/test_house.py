"""The tools of the house: what `make check` leaves out, what `measured` asserts, and the map of the tree."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from helpers_measured import Measured

ROOT = Path(__file__).parents[1]
TESTS = ROOT / "tests"


# --- make check -----------------------------------------------------------------------------------------------------


@pytest.fixture
def suite(pytester, monkeypatch):
    """Three tests under this suite's conftest.py: one that is slow and says so, one that does not, a quick one."""
    monkeypatch.syspath_prepend(TESTS)
    pytester.makeconftest((TESTS / "conftest.py").read_text(encoding="utf-8"))
    pytester.makeini("[pytest]\nmarkers = slow\naddopts = -p no:cacheprovider -p no:xdist\n")
    body = "import os\n\ndef test_unmarked():\n    end = sum(os.times()[:4]) + 0.3\n"
    pytester.makepyfile(
        test_a="def test_quick(): pass\n",
        test_b=body + "    while sum(os.times()[:4]) < end: pass\n",
        test_c="import pytest\n@pytest.mark.slow\ndef test_marked(): pass\n",
    )
    return pytester


def test_quick_leaves_out_what_is_marked_and_names_what_should_be(suite):
    result = suite.runpytest_inprocess("--quick=0.1")
    result.assert_outcomes(passed=2, deselected=1)
    named = [line for line in result.outlines if "mark it slow" in line]
    assert len(named) == 1
    assert named[0].startswith("test_b.py::test_unmarked took 0.")


def test_files_with_slow_tests_go_first(suite):
    result = suite.runpytest_inprocess("-v")
    result.assert_outcomes(passed=3)
    order = re.findall(r"(test_\w)\.py::\w+ PASSED", result.stdout.str())
    assert order == ["test_c", "test_a", "test_b"]


def marked_slow(path: Path) -> bool:
    """Whether a whole file is."""
    return bool(re.search(r"^pytestmark = .*mark\.slow", path.read_text(encoding="utf-8"), re.MULTILINE))


@pytest.mark.parametrize("folder", sorted(p.name for p in (TESTS / "unit").iterdir() if any(p.glob("test_*.py"))))
def test_check_keeps_most_of_every_folder(folder):
    files = list((TESTS / "unit" / folder).rglob("test_*.py"))
    assert sum(map(marked_slow, files)) <= len(files) / 3


def test_newest_and_lowest_leave_out_little():
    files = list((TESTS / "unit").rglob("test_*.py"))
    once = [p for p in files if re.search(r"mark\.once", p.read_text(encoding="utf-8"))]
    assert 0 < len(once) <= len(files) / 10


# --- files ----------------------------------------------------------------------------------------------------------

LONGEST = 400
"""Lines of a file: beyond, it holds more than one idea."""


def test_no_file_of_the_program_is_long():
    files = [*(ROOT / "src").rglob("*.py"), *(ROOT / "tools").rglob("*.py")]
    lines = {str(p.relative_to(ROOT)): len(p.read_text(encoding="utf-8").splitlines()) for p in files}
    assert {name: n for name, n in lines.items() if n > LONGEST} == {}


# --- measured -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("found", "limits"),
    [
        (1.02, {"expected": 1.0, "rel": 0.01}),
        ([1.0, 0.97], {"expected": [1.0, 1.0], "abs": 0.02}),
        (3, {"expected": 2}),
        (-0.2, {"at_most": 0.1}),
        (9, {"at_least": 10}),
        (1.1, {"between": (0.9, 1.0)}),
        (float("nan"), {"expected": 1.0, "rel": 0.01}),
        ([], {"expected": 1.0, "rel": 0.01}),
    ],
)
def test_measured_fails_outside_its_tolerance(found, limits):
    record = Measured()
    with pytest.raises(AssertionError, match=r"^figure: (found .*, expected|no value)"):
        record("figure", found, **limits)


def test_measured_wants_something_to_hold_to():
    with pytest.raises(TypeError, match="neither an expected value nor a limit"):
        Measured()("figure", 1.0)


def test_measured_keeps_what_lies_inside():
    record = Measured()
    record("figure {}", [1.0, 1.01], 1.0, rel=0.02)
    assert [(q, r["low"], r["value"], r["high"]) for (_, q), r in record.quantities.items()] == [
        ("figure 1", 0.98, 1.0, 1.02),
        ("figure 2", 0.98, 1.01, 1.02),
    ]
