"""Where MKL is found.

MKL that finds no room for itself ends the program with status 2, which says wrong input, unless it is asked first.
NumPy's BLAS on one thread inside, on as many as before outside, however often.
"""

from __future__ import annotations

import subprocess
import sys

import pytest
import scipy.linalg  # noqa: F401  (brings its own BLAS, whose threads are set below)
from threadpoolctl import threadpool_info, threadpool_limits

from creak.linalg import mkl
from creak.linalg.mkl import has_pardiso
from creak.linalg.threads import one_blas_thread

pytestmark = pytest.mark.skipif(not mkl.has_pardiso(), reason="no MKL")


def test_the_library_of_the_wheel_is_found_without_a_search(monkeypatch):
    """pypardiso looks through every folder of the environment: seconds, before anything is computed."""
    if mkl._at_its_place() is None:
        pytest.skip("MKL came another way")

    def searched():
        raise AssertionError("the environment was searched")

    monkeypatch.setattr(mkl, "_found_by_pypardiso", searched)
    mkl.mkl_library.cache_clear()
    try:
        assert mkl.mkl_library().pardiso
    finally:
        mkl.mkl_library.cache_clear()


def test_the_users_own_library_goes_before(monkeypatch):
    monkeypatch.setenv("PYPARDISO_MKL_RT", "/opt/mkl/libmkl_rt.so")
    assert mkl._at_its_place() is None


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


def threads() -> set[int]:
    return {int(p["num_threads"]) for p in threadpool_info() if p["internal_api"] in ("openblas", "blis")}


@pytest.mark.skipif(not threads(), reason="NumPy has no BLAS whose threads can be told")
def test_threads_are_given_back_each_time():
    with threadpool_limits(2, user_api="blas"):
        before = threads()
        for _ in range(2):
            with one_blas_thread():
                assert threads() == {1}
                with one_blas_thread():
                    assert threads() == {1}
                assert threads() == {1}
            assert threads() == before
    assert before == {2}
