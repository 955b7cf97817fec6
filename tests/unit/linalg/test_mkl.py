"""Where MKL is found."""

from __future__ import annotations

import pytest

from creak.linalg import mkl

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
