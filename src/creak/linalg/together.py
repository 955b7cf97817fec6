"""Works that solve with one factor, side by side: their right sides become columns of one block.

A back-substitution reads the whole factor. For several columns it is read once, so that eight together cost four times
one alone instead of eight times.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Condition
from typing import Protocol, TypeVar

import numpy as np

from creak.arrays import FloatArray

Result = TypeVar("Result")


class Solver(Protocol):
    """What has the inverse of a matrix."""

    def solve(self, b: FloatArray) -> FloatArray:
        """x with A x = b; b is (n,) or (n, k)."""
        ...


class _Broken(Exception):
    """The others were given up."""


class _Desk:
    """Right sides that wait, and solutions that wait to be fetched, by the number of their work."""

    def __init__(self, count: int) -> None:
        self.changed = Condition()
        self.under_way = set(range(count))
        self.asked: dict[int, FloatArray] = {}
        self.solved: dict[int, FloatArray] = {}
        self.broken = False

    def solve(self, number: int, b: FloatArray) -> FloatArray:
        """The solution for work `number`, once all others have asked or ended."""
        with self.changed:
            self.asked[number] = b
            self.changed.notify_all()
            self.changed.wait_for(lambda: self.broken or number in self.solved)
            if self.broken:
                raise _Broken
            return self.solved.pop(number)

    def end(self, number: int) -> None:
        with self.changed:
            self.under_way.discard(number)
            self.changed.notify_all()

    def serve(self, solver: Solver, counted: Callable[[int], object]) -> None:
        """Solve for all whenever all have asked, until none is under way."""
        while True:
            with self.changed:
                self.changed.wait_for(lambda: self.asked.keys() >= self.under_way)
                if not self.under_way:
                    return
                asked, self.asked = dict(sorted(self.asked.items())), {}
            columns = [b.reshape(len(b), -1) for b in asked.values()]
            B = np.empty((len(columns[0]), sum(c.shape[1] for c in columns)), order="F")
            ends = np.cumsum([c.shape[1] for c in columns]).tolist()
            for c, end in zip(columns, ends, strict=True):
                B[:, end - c.shape[1] : end] = c
            X = solver.solve(B)
            parts = [X[:, end - c.shape[1] : end] for c, end in zip(columns, ends, strict=True)]
            solved = {
                k: np.ascontiguousarray(x.reshape(b.shape)) for (k, b), x in zip(asked.items(), parts, strict=True)
            }
            counted(len(solved))
            with self.changed:
                self.solved.update(solved)
                self.changed.notify_all()

    def give_up(self) -> None:
        with self.changed:
            self.broken = True
            self.changed.notify_all()


class _Member:
    """The solver that one of the works is handed."""

    def __init__(self, desk: _Desk, number: int) -> None:
        self._desk, self._number = desk, number

    def solve(self, b: FloatArray) -> FloatArray:
        return self._desk.solve(self._number, b)


class _Alone:
    """The solver of a work beside which there is no other."""

    def __init__(self, solver: Solver, counted: Callable[[int], object]) -> None:
        self._solver, self._counted = solver, counted

    def solve(self, b: FloatArray) -> FloatArray:
        self._counted(1)
        return self._solver.solve(b)


def side_by_side(
    solver: Solver, works: Sequence[Callable[[Solver], Result]], counted: Callable[[int], object] = int
) -> list[Result]:
    """Results of works, each in a thread of its own where there are several, which all solve by what they are handed.

    Right sides wait until every work that still goes on has one; columns stand in the order of the works. So results
    do not depend on which thread is faster. The solver itself is used by the calling thread alone.

    Parameters
    ----------
    counted : is told how many solutions there are more.

    Raises
    ------
    What a work raises, the first of them in order, once all have ended.
    """
    if len(works) == 1:
        return [works[0](_Alone(solver, counted))]
    desk = _Desk(len(works))

    def run(number: int) -> Result:
        try:
            return works[number](_Member(desk, number))
        finally:
            desk.end(number)

    with ThreadPoolExecutor(max(1, len(works))) as pool:
        under_way = [pool.submit(run, number) for number in range(len(works))]
        try:
            desk.serve(solver, counted)
        except BaseException:
            desk.give_up()
            raise
        return [future.result() for future in under_way]
