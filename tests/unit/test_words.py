"""Shares, times and lists in plain words."""

from __future__ import annotations

import pytest

from creak.words import duration, listed, percent


@pytest.mark.parametrize(
    ("share", "digits", "text"),
    [
        (0.0, 2, "0 %"),
        (3e-9, 2, "0 %"),
        (3.4e-5, 2, "0.0034 %"),
        (-0.0034, 2, "-0.34 %"),
        (0.0999, 2, "10 %"),
        (0.994, 2, "99 %"),
        (12.34, 2, "1234 %"),
        (0.12345, 3, "12.3 %"),
        (1.2345, 3, "123 %"),
    ],
)
def test_shares_have_so_many_digits_and_no_powers_of_ten(share, digits, text):
    assert percent(share, digits) == text


def test_lists_end_in_and():
    assert [listed(items) for items in (["a"], ["a", "b"], ["a", "b", "c"])] == ["a", "a and b", "a, b and c"]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(2.1e-5, "21 us"), (4.2e-3, "4.2 ms"), (38.0, "38 s"), (720.0, "12 min"), (18720.0, "5.2 h")],
)
def test_times_have_two_digits(seconds, text):
    assert duration(seconds) == text
