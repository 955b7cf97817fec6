"""Memory that does not suffice, and figures that are no numbers, in words."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy import sparse

from creak.cli import main as command
from creak.cli.output import Output
from creak.errors import NumericalError
from creak.formats import decks
from creak.linalg import factor as linalg
from helpers_decks import two_strips


def test_memory_is_told_with_what_was_to_be_held(creak, tmp_path, monkeypatch):
    def large(*_):
        raise MemoryError("Unable to allocate 3.24 GiB for an array with shape (20844, 20844) and data type float64")

    (tmp_path / "a.inp").write_text(two_strips())
    monkeypatch.setattr(decks, "read_model", large)
    said = creak("info", tmp_path / "a.inp")
    assert said.status == 1
    assert "out of memory (unable to allocate 3.24 GiB for an array with shape (20844, 20844)" in said.words
    assert "coarser mesh" not in said.words
    assert command._out_of_memory(MemoryError()).startswith("out of memory; ")


@pytest.mark.parametrize("code", [-2, -9])
def test_pardiso_says_memory(code, monkeypatch):
    class Library:
        def pardiso(self, *arguments):
            arguments[-1]._obj.value = code if arguments[4]._obj.value > 0 else 0

    monkeypatch.setattr(linalg, "mkl_library", Library)
    with pytest.raises(NumericalError, match=r"memory does not hold the factor of 3 equations"):
        linalg._PardisoFactor(sparse.csr_array(np.eye(3)), True)


def test_figures_that_are_no_numbers_are_null(capsys):
    Output(as_json=True).result({"mass": float("nan"), "parts": [{"mass": float("inf")}, 1.5]})
    assert json.loads(capsys.readouterr().out) == {"mass": None, "parts": [{"mass": None}, 1.5]}
