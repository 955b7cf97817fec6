"""PCOMPP, STACK and PLY: the laminate of each element from the plies that lie on it."""

from __future__ import annotations

import numpy as np
import pytest

from creak.model.materials import GeneralShell
from helpers_nastran import read, unread
from helpers_refusal import refusal

MESH = (
    "GRID,1,,0.,0.\nGRID,2,,1.,0.\nGRID,3,,2.,0.\nGRID,4,,0.,1.\nGRID,5,,1.,1.\nGRID,6,,2.,1.\n"
    "CQUAD4,1,7,1,2,5,4,0.\nCQUAD4,2,7,2,3,6,5,0.\nMAT8,1,120.,8.,.3,4.,4.,3.,1.\n"
)
SETS = "SET,11,ELEM,LIST\n,1,2\nSET,12,ELEM,LIST\n,2\n"
PLIES = "PLY,1,1,.1,0.\n,11\nPLY,2,1,.2,90.\n,12\nPLY,3,1,.1,45.,YES,.05\n,11\n"
STACKED = MESH + SETS + PLIES + "PCOMPP,7,,.5\nSTACK,1,,1,2,3\n"


def section(model, element: int) -> GeneralShell:
    return next(b.section for b in model.blocks if element in b.ids.tolist())


@pytest.mark.parametrize(("lam", "z0"), [("", ""), ("SYM", ""), ("", "-.3"), ("SMEAR", "")])
def test_each_element_has_the_laminate_of_its_plies(tmp_path, lam, z0):
    """As PCOMP cards of the same plies say it."""
    stacked = read(tmp_path, STACKED.replace("STACK,1,", f"STACK,1,{lam}").replace("PCOMPP,7,", f"PCOMPP,7,{z0}"))
    assert unread(stacked) == {}
    rest = f"{z0},.5,,,,,{lam}\n"
    one = f"{MESH}PCOMP,7,{rest},1,.1,0.,,1,.1,45.\n"
    two = f"{one.replace('CQUAD4,2,7', 'CQUAD4,2,8')}PCOMP,8,{rest},1,.1,0.,,1,.2,90.\n,1,.1,45.\n"
    for element, text in ((1, one), (2, two)):
        wanted, found = section(read(tmp_path, text), element), section(stacked, element)
        for name in ("A", "B", "D", "S"):
            size = np.abs(getattr(wanted, name)).max(initial=1e-300)
            np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), atol=1e-12 * size)
        assert found.mass == pytest.approx(wanted.mass, rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "what", "card"),
    [
        ("STACK,1,,1,2,3", "STACK,1,,,,,,,,\n,SUB,1,top,1,2,3", "STACK 1 has substacks (SUB)", "STACK"),
        ("STACK,1,,1,2,3", "STACK,1,,1,4,3", "field 5 of STACK is '4'", "STACK"),
        ("YES,.05\n", "YES,.05,9\n", "PLY 3 is draped (DRAPE 9)", "PLY,3"),
        (",11\nPLY,2", ",13\nPLY,2", "field 12 of PLY is '13'", ",13"),
        ("STACK,1,,1,2,3", "STACK,1,,1,2\nSTACK,2,,3", "element 1 lies in two stacks, 1 and 2", "STACK,2"),
        ("SET,11,ELEM,LIST\n,1,2", "SET,11,ELEM,LIST\n,2", "no PLY of a STACK lies on CQUAD4 1", "CQUAD4,1"),
    ],
)
def test_stacks_that_are_not_simple_are_refused_for_their_reason(tmp_path, old, new, what, card):
    assert old in STACKED
    text = STACKED.replace(old, new)
    error = refusal(read, tmp_path, text)
    assert what in error.what
    line = next(i for i, words in enumerate(text.splitlines(), start=4) if words.startswith(card))
    assert error.where in (f"{tmp_path / 'deck.bdf'}:{line}", f"{tmp_path / 'deck.bdf'}:{line + 1}")
    assert error.expected
