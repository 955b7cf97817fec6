"""NumPy's BLAS on one thread inside, on as many as before outside, however often."""

from __future__ import annotations

import pytest
import scipy.linalg  # noqa: F401  (brings its own BLAS, whose threads are set below)
from threadpoolctl import threadpool_info, threadpool_limits

from creak.linalg.threads import one_blas_thread


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
