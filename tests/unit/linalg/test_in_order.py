"""Work handed to threads comes back in order, a bounded number of pieces ahead."""

from __future__ import annotations

import time

import pytest

from creak.linalg.threads import cores, in_order


def test_results_come_in_the_order_of_the_items():
    def work(k: int) -> int:
        time.sleep(0.002 * (k % 3 == 0))
        return k * k

    assert list(in_order(work, range(20))) == [k * k for k in range(20)]
    assert list(in_order(work, [])) == []


def test_no_more_than_a_few_results_wait():
    started: list[int] = []
    results = in_order(started.append, range(100))
    next(results)
    time.sleep(0.02)
    assert len(started) <= cores() + 2
    results.close()
    time.sleep(0.02)
    assert len(started) <= cores() + 2


def test_what_goes_wrong_comes_where_its_result_would():
    def work(k: int) -> int:
        if k == 3:
            raise ValueError("the fourth")
        return k

    results = in_order(work, range(10))
    assert [next(results) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(ValueError, match="the fourth"):
        next(results)
