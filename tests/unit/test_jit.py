"""Compiled code is taken from the cache only where all that it was made from is what it was."""

from __future__ import annotations

import subprocess
import sys

import pytest

FILES = {
    "__init__.py": "",
    "numbers.py": "FACTOR = 2.0\n",
    "parts.py": """from creak.jit import njit
from own.numbers import FACTOR

@njit()
def part(x):
    return FACTOR * x + 1.0
""",
    "whole.py": """from creak.jit import njit
from own.parts import part

@njit()
def whole(x):
    return part(x) + 10.0
""",
}
RUN = """import creak.jit
creak.jit.OWN = "own"
from own.whole import whole
known = creak.jit.is_cached(whole)
print(known, whole(3.0), whole.stats.cache_hits and not whole.stats.cache_misses)
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "own").mkdir()
    for name, text in FILES.items():
        (tmp_path / "own" / name).write_text(text)
    return tmp_path


def told(folder):
    done = subprocess.run([sys.executable, "-B", "-c", RUN], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    known, value, taken = done.stdout.split()
    return known == "True", float(value), taken == "True"


def test_code_is_taken_where_nothing_has_changed_and_what_a_function_calls_and_takes_counts(folder):
    """Numba by itself looks at the file of the function alone, and would go on with 17."""
    assert told(folder) == (False, 17.0, False)
    (folder / "own" / "whole.py").write_text(FILES["whole.py"])  # as by a checkout: another date, the same text
    assert told(folder) == (True, 17.0, True)
    for name, old, new, value in (
        ("parts.py", "+ 1.0", "+ 2.0", 18.0),
        ("numbers.py", "2.0", "3.0", 21.0),
        ("whole.py", "10.0", "20.0", 31.0),
    ):
        path = folder / "own" / name
        path.write_text(path.read_text().replace(old, new))
        assert told(folder) == (False, value, False), name
    assert told(folder) == (True, 31.0, True)


OWN_TYPE = "from typing import NamedTuple\n\nclass Pair(NamedTuple):\n    a: float\n"


def test_code_for_types_that_a_program_does_not_have_stops_nothing(folder):
    """As what tests compile for a class of theirs: the next program cannot import it."""
    (folder / "own" / "parts.py").write_text(FILES["parts.py"].replace("FACTOR * x", "FACTOR * x.a"))
    run = RUN.replace("whole(3.0)", "whole(Pair(3.0))")
    theirs, mine = "from others import Pair\n" + run, OWN_TYPE + run
    (folder / "others.py").write_text(OWN_TYPE)
    for code, known in ((theirs, "False"), (theirs, "True"), (mine, "False")):
        if code is mine:
            (folder / "others.py").unlink()
        command = [sys.executable, "-B", "-c", code]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert done.stdout.split()[:2] == [known, "17.0"]
