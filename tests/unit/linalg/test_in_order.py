"""Work handed to threads comes back in order, a bounded number of pieces ahead; works that go on at once end together."""

from __future__ import annotations

import time
from threading import Barrier, current_thread, main_thread

import pytest

from creak.linalg.threads import at_once, cores, in_order
from creak.progress import Shared


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


def test_works_go_on_at_once():
    both = Barrier(2, timeout=10.0)  # neither ends before the other has begun

    def work(k: int) -> int:
        both.wait()
        return k * k

    assert at_once(work, range(4), 2) == [0, 1, 4, 9]
    assert at_once(lambda _: current_thread() is main_thread(), [0, 1], 1) == [True, True]
    assert at_once(work, [], 2) == []


def test_what_goes_wrong_ends_the_others():
    told: list[str] = []
    shared, both, begun = Shared(lambda stage, done, total: told.append(stage)), Barrier(2, timeout=10.0), list[int]()

    def work(k: int) -> None:
        begun.append(k)
        if k < 2:
            both.wait()
        if k == 0:
            raise ValueError("the first")
        for _ in range(10_000):
            shared("another", 0, 1)
            time.sleep(0.001)

    with pytest.raises(ValueError, match="the first"):
        at_once(work, range(8), 2, shared.halt)
    assert len(begun) < 4  # the second, and perhaps one that took the place of the first
    assert len(told) < 10_000
