"""Decks of many things that creak does not read: what reading them costs grows with their number alone.

Counted are calls of Python functions, which no other load of the machine changes. n of something four times over cost
four times as much, less what a deck costs at all; a search among all others for each of them would cost 16 times.
"""

from __future__ import annotations

import sys

import pytest

from creak.formats.deck.surfaces import surfaces
from creak.formats.decks import read_model

ABAQUS = (
    "*NODE\n1,0.,0.,0.\n2,1.,0.,0.\n*ELEMENT,TYPE=T3D2,ELSET=E\n1,1,2\n*SOLID SECTION,ELSET=E,MATERIAL=M\n1.,\n"
    "*MATERIAL,NAME=M\n*ELASTIC\n2e5,.3\n*DENSITY\n1e-9\n"
)
NASTRAN = "BEGIN BULK\nGRID,1\nGRID,2,,1.\nCROD,1,1,1,2\nPROD,1,1,1.\nMAT1,1,2.+5,,.3,1.-9\n"
N = 150
LINEAR = 4.5
"""Of 4, for tables grow in jumps."""
KINDS = {
    "harmless keywords": (ABAQUS, "*AMPLITUDE, NAME=A{0}\n0., 1.\n"),
    "unknown parameters": (ABAQUS, "*NSET, NSET=S{0}, FOO=3\n1\n"),
    "steps": (ABAQUS, "*STEP\n*FREQUENCY\n2\n*END STEP\n"),
    "material laws": (ABAQUS, "*MATERIAL, NAME=M{0}\n*ELASTIC\n2e5,.3\n*PLASTIC\n2., 0.\n"),
    "unknown cards": (NASTRAN, "ZQ{2},1\n"),
    "shared ids": (NASTRAN, "CONM2,{1},1,,1.\nCROD,{1},1,1,2\n"),
}


def calls(path, text):
    path.write_text(text + "ENDDATA\n" * (path.suffix == ".bdf"), encoding="utf-8")
    count = 0

    def counted(_frame, event, _arg):
        nonlocal count
        count += event == "call"

    sys.setprofile(counted)
    try:
        read_model(path)
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.parametrize("kind", KINDS)
def test_the_cost_grows_with_their_number(tmp_path, kind):
    head, each = KINDS[kind]
    path = tmp_path / ("deck.inp" if head is ABAQUS else "deck.bdf")
    texts = [head + "".join(each.format(i, i + 2, i + 1000) for i in range(n)) for n in (0, 0, N, 4 * N)]
    _, none, few, many = (calls(path, text) for text in texts)
    assert many - none < LINEAR * (few - none)


def test_names_that_are_like_none_are_not_looked_up_twice(tmp_path):
    """10,000 unknown keywords of one name take one look among those that creak knows."""
    path = tmp_path / "deck.inp"
    one, two = (calls(path, ABAQUS + f"*QUITE UNKNOWN {n}\n" * n) for n in (1, 2))
    assert two - one < 0.1 * one


def test_free_faces_are_found_once_for_all_properties(tmp_path, monkeypatch):
    """Of 40 properties with a tetrahedron each."""
    deck = "BEGIN BULK\nGRID,1\nGRID,2,,1.\nGRID,3,,0.,1.\nMAT1,1,2.+5,,.3,1.-9\n"
    deck += (
        "".join(f"GRID,{k},,0.,0.,{k}.\nCTETRA,{k},{k},1,2,3,{k}\nPSOLID,{k},1\n" for k in range(4, 44)) + "ENDDATA\n"
    )
    path, found = tmp_path / "deck.bdf", []
    path.write_text(deck, encoding="utf-8")
    original = surfaces.__globals__["free_faces"]
    monkeypatch.setitem(surfaces.__globals__, "free_faces", lambda *a: found.append(1) or original(*a))
    model = read_model(path)
    assert len(found) == 1
    assert {len(model.surfaces[f"PID_{k}"].facets) for k in range(4, 44)} == {3}
