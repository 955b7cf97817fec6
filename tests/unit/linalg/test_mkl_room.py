"""MKL that finds no room for itself ends the program with status 2, which says wrong input, unless it is asked first."""

from __future__ import annotations

import subprocess
import sys

import pytest

from creak.linalg.mkl import has_pardiso

LOADED = """
import resource, numpy
from creak.linalg.mkl import mkl_library
held = 4096 * int(open("/proc/self/statm").read().split()[0])
resource.setrlimit(resource.RLIMIT_AS, (held + {free}, held + {free}))
try:
    mkl_library()
except MemoryError as error:
    print(error)
"""


@pytest.mark.skipif(not has_pardiso() or sys.platform != "linux", reason="MKL under a limit of Linux")
@pytest.mark.parametrize("megabytes", [20, 120, 220])
def test_no_room_for_the_libraries(megabytes):
    ran = subprocess.run(
        [sys.executable, "-c", LOADED.format(free=megabytes << 20)], capture_output=True, text=True, check=False
    )
    assert (ran.returncode, "libraries of MKL take" in ran.stdout) == (0, True), ran.stdout + ran.stderr
