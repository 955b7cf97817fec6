"""The run of a module's study, saved beside it."""

from __future__ import annotations

import pytest

import creak


@pytest.fixture(scope="module")
def result(folder):
    """Of the study that the module has written to its `folder`."""
    result = creak.run(creak.read_study(folder / "study.toml"), converge=False)
    result.save(folder / "out")
    return result
