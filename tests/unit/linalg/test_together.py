"""Works that solve side by side: as one by one, in an order that no thread changes, and as errors end them."""

from __future__ import annotations

import threading
import time
from functools import partial

import numpy as np
import pytest

from creak.linalg.factor import factor
from creak.linalg.together import side_by_side

N = 40


class Counting:
    """A solver that keeps what it is asked for, and by which thread."""

    def __init__(self) -> None:
        A = np.random.default_rng(1).standard_normal((N, N))
        self.A = A @ A.T + N * np.eye(N)
        self._factor = factor(self.A)
        self.widths: list[int] = []
        self.threads: set[int] = set()

    def solve(self, b):
        self.widths.append(1 if b.ndim == 1 else b.shape[1])
        self.threads.add(threading.get_ident())
        return self._factor.solve(b)


def power(steps, b, solver, late=0.0):
    """A^-steps b."""
    for _ in range(steps):
        time.sleep(late)
        b = solver.solve(b)
    return b


@pytest.mark.parametrize("late", [(0.0, 0.0, 0.0), (0.0, 0.004, 0.001), (0.004, 0.0, 0.0)])
def test_each_work_finds_what_it_would_alone(late):
    one, several = Counting(), Counting()
    b = np.random.default_rng(2).standard_normal((3, N))
    steps = (2, 5, 3)
    works = [partial(power, n, x, late=wait) for n, x, wait in zip(steps, b, late, strict=True)]
    told: list[int] = []
    found = side_by_side(several, works, told.append)
    for n, x, y in zip(steps, b, found, strict=True):
        np.testing.assert_allclose(y, power(n, x, one), rtol=1e-11)
    assert several.widths == told == [3, 3, 2, 1, 1]  # whatever thread is late
    assert several.threads == {threading.get_ident()}


def test_blocks_and_vectors_are_solved_for_together():
    solver = Counting()
    b = np.random.default_rng(3).standard_normal((N, 3))
    vector, block = side_by_side(solver, [lambda s: s.solve(b[:, 0]), lambda s: s.solve(b[:, 1:])])
    assert (vector.shape, block.shape, solver.widths) == ((N,), (N, 2), [3])
    np.testing.assert_allclose(solver.A @ np.column_stack([vector, block]), b, atol=1e-11)


def test_a_work_without_a_solve_holds_nobody_up():
    solver = Counting()
    assert side_by_side(solver, [lambda _: 7, lambda s: s.solve(np.ones(N)).size]) == [7, N]
    assert side_by_side(solver, []) == []


def test_the_first_error_is_told_when_all_have_ended():
    solver, ended = Counting(), []

    def fails(s):
        s.solve(np.ones(N))
        raise ValueError("the second")

    def goes_on(s):
        power(4, np.ones(N), s)
        ended.append(True)

    with pytest.raises(ValueError, match="the second"):
        side_by_side(solver, [goes_on, fails])
    assert ended == [True]


def test_a_solver_that_fails_ends_them_all():
    class Fails:
        def solve(self, b):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        side_by_side(Fails(), [partial(power, 3, np.ones(N)), partial(power, 2, np.ones(N))])
    assert threading.active_count() < 20
