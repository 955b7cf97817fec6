"""Units as files of tests spell them."""

from __future__ import annotations

import pytest

from creak.formats.measured.unit_words import plain_unit


@pytest.mark.parametrize(
    ("unit", "plain"),
    [
        ("m.s^-2", "m/s^2"),
        ("m s-2", "m/s^2"),
        ("m·s⁻²/N", "m/s^2/n"),
        ("(m/sec**2)/N", "m/s^2/n"),
        ("mm*s**-1", "mm/s"),
        ("m/s/s", "m/s^2"),
        ("milliseconds", "ms"),
        ("NONE", ""),
    ],
)
def test_spellings(unit, plain):
    assert plain_unit(unit) == plain
