"""Functions that compiled code alone calls, and the bundles that they pass by reference."""

from __future__ import annotations

import gc
from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray
from creak.linalg.by_reference import by_reference, by_value
from creak.linalg.compiled import few_collections, inner, outer, with_arrays
from creak.linalg.loops import largest


class Weights(NamedTuple):
    each: FloatArray
    on: bool


class Sums(NamedTuple):
    weights: Weights
    offset: float
    out: FloatArray


@inner
def weighted(sums, x, j):
    return sums.offset + sums.weights.each[j] * x[j] if sums.weights.on else sums.offset


@with_arrays
def doubled(x):
    return 2.0 * x.copy().sum()


@inner
def total(sums):
    found = 0.0
    for j in range(sums.out.size):
        found += sums.out[j]
    return found


@outer
def summed(sums, other, x):
    """Into `out` of the first, then of the second; what their sums are, and twice the sum of x."""
    values, sums, other = sums, by_reference(sums), by_reference(other)
    for _ in range(2):
        for j in range(x.size):
            sums.out[j] = weighted(sums, x, j)
        sums, other = other, sums
    return total(sums), total(by_value(other)), total(values), doubled(x)


def test_bundles_are_read_and_exchanged_by_reference():
    x, each = np.array([1.0, 2.0, 4.0]), np.array([3.0, 5.0, 7.0])
    one, two = (Sums(Weights(each, on), offset, np.zeros(3)) for on, offset in ((True, 0.5), (False, 2.0)))
    assert summed(one, two, x) == (42.5, 6.0, 42.5, 14.0)
    np.testing.assert_array_equal(one.out, 0.5 + each * x)
    np.testing.assert_array_equal(two.out, 2.0)


@outer
def largest_of(values):
    return largest(values)


def test_the_largest_of_numbers_is_none_where_one_is_none():
    assert largest_of(np.array([1.0, -3.0, 2.0])) == 3.0
    assert largest_of(np.zeros(0)) == 0.0
    assert np.isnan(largest_of(np.array([1.0, np.nan, 2.0])))


def test_collections_are_as_often_as_before_afterwards():
    before = gc.get_threshold()
    with few_collections():
        assert gc.get_threshold()[0] == 100 * before[0]
    assert gc.get_threshold() == before
