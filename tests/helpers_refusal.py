"""What creak says to a wrong input, for tests that look at more of it than one match."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from creak.errors import InputError


def refusal(call: Callable[..., object], *words: object, **options: object) -> InputError:
    """The error with which `call` refuses its input; the test fails where it takes it."""
    try:
        call(*words, **options)
    except InputError as error:
        return error
    pytest.fail("the input was taken")
