"""Damaged Nastran decks end in a Model or in an InputError that names a place, never in anything else."""

from __future__ import annotations

import random

import pytest

from creak.errors import InputError
from creak.formats.nastran.reader import read_nastran
from creak.model.mesh import Model

DECK = """\
SOL 103
CEND
SPC = 1
MPC = 1
IC = 3
SET 1 = 1, 3 THRU 6
BEGIN BULK
CORD2C,6,,0.,0.,0.,0.,0.,1.
,1.,0.,0.
CORD1R,7,1,2,3
GRDSET,,,,,,,
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.,6
GRID,3,6,1.,45.,0.
GRID,4,,0.,1.,0.,,4
GRID,5,,0.,0.,1.
GRID,6,,1.,0.,1.
GRID,7,,1.,1.,1.
GRID,8,,0.,1.,1.
SPOINT,20,21
MAT1,1,2.+5,,.3,1.-9,,,.01
MAT8,8,1.+5,1.+4,.3,5.+3,4.+3,3.+3,1.-9
MAT9,9,5.,1.,1.,0.,0.,0.,5.
,1.,0.,0.,0.,5.,0.,0.,0.
,2.,0.,0.,2.,0.,2.,1.-9
PSHELL,1,1,.1,1,,1
PCOMP,2,,,,,,,SYM
,8,.1,45.,,1,.2
CQUAD4,1,1,1,2,3,4,30.,.1
,,1,1.,1.,1.,1.
CTRIA3,2,2,5,6,7,6
PBAR,3,1,1.,1.,1.,1.,.1
,,,,,,,,
,.5,.5,.1
CBAR,3,3,1,5,1.,0.,0.
,,45,0.,.1
PBEAM,4,1,1.,1.,1.,,1.,
,1.,1.,1.,1.,1.,1.,1.,1.
,YESA,1.0
,.5,.5
CBEAM,4,4,2,6,1
PBARL,5,1,,BOX
,1.,2.,.1,.1
CBAR,5,5,3,7,5
CROD,6,6,4,8
PROD,6,1,1.,1.
CONROD,7,4,7,1,1.
PSOLID,8,9,6
CHEXA,8,8,1,2,3,4,5,6
,7,8
CTETRA,9,8,1,2,3,5
CELAS1,10,10,2,1,20
PELAS,10,5.,,,11,3.
CELAS2,11,5.,2,2,3,2
CDAMP2,12,5.,2,2
CMASS2,13,5.,2,2
CBUSH,14,14,1,2,0.,1.,0.
PBUSH,14,K,1.,2.,3.,4.,5.,6.
,B,1.
CONM2,15,2,6,1.,.1,.2,.3
,1.,.1,1.,.1,.1,1.
CONM1,16,3,6,1.,2.
RBE2,1,1,123,2,3
RBE3,2,,4,123456,1.,123,5,6
,7,1.,456,8
,UM,4,123456
RBAR,3,5,6
RROD,5,7,8
RBE1,4,1,123456
,UM,8,12
MPC,1,7,1,1.,20,,1.
,,3,2,.5
SPC1,1,12,1,THRU,3
SPC,1,5,3,.1,6,4
SPCADD,2,1
TIC,3,2,2,,1.
SET1,4,1,2,THRU,5
ASET1,123,1,2
SUPORT,1,123
PARAM,WTMASS,.5
PARAM,COUPMASS,1
EIGRL,1,,,10
ENDDATA
"""
VALUES = ("", "0", "1", "-1", "99", "1.5", "abc", "THRU", "nan", "1e400", "UM", "+", "*", "$", "BY", "-5.", "0.", "1_0", "\u0663")


def _damaged(rng: random.Random) -> str:
    lines = DECK.splitlines()
    for _ in range(rng.choice([1, 1, 2])):
        k = rng.randrange(len(lines))
        kind = rng.choice(["value", "value", "value", "delete", "truncate", "repeat"])
        if kind == "value":
            fields = lines[k].split(",")
            fields[rng.randrange(len(fields))] = rng.choice(VALUES)
            lines[k] = ",".join(fields)
        elif kind == "delete":
            del lines[k]
        elif kind == "truncate":
            lines[k] = lines[k][: rng.randrange(len(lines[k]) + 1)]
        else:
            lines.insert(rng.randrange(len(lines)), lines[k])
    return "\n".join(lines)


def test_the_deck_itself(tmp_path):
    """One of nearly every card; only the enforced displacement is not followed."""
    path = tmp_path / "deck.bdf"
    path.write_text(DECK)
    model = read_nastran(path)
    assert [u.keyword for u in model.unread if u.changes_answer] == ["SPC, D"]
    assert {b.kind for b in model.blocks} == {
        "quad4", "tri3", "beam2", "truss2", "hex8", "tet4", "spring1", "spring2", "nodal1", "bush2", "mass",
    }  # fmt: skip


@pytest.mark.parametrize("first", [0, 100])
def test_damaged_decks(tmp_path, first):
    path = tmp_path / "deck.bdf"
    places: list[str] = []
    for seed in range(first, first + 100):
        path.write_text(_damaged(random.Random(seed)), encoding="utf-8")
        try:
            assert isinstance(read_nastran(path), Model)
        except InputError as error:
            places.append(str(error))
    assert places
    assert all("deck.bdf" in place for place in places)
