"""OptiStruct's decks, bulk data alone and decks of unknown endings: read as Nastran's, with their own cards."""

from __future__ import annotations

import numpy as np
import pytest

from creak.assembly.elimination import linear_equations
from creak.errors import InputError
from creak.formats.decks import read_model

CASE = "$$ OptiStruct\nSUBCASE 1\n  ANALYSIS MODES\n  METHOD(STRUCTURE) = 1\n  SPC = 7\nBEGIN BULK\n"
PLATES = """GRID,1,,0.,0.,0.
GRID,2,,100.,0.,0.
GRID,3,,100.,100.,0.
GRID,4,,0.,100.,0.
GRID,11,,10.,10.,2.
GRID,12,,90.,10.,2.
GRID,13,,90.,90.,2.
GRID,14,,10.,90.,2.
CQUAD4,1,1,1,2,3,4
CQUAD4,2,1,11,12,13,14
PSHELL,1,1,2.,1,,1
MAT1,1,7.E4,,.3,2.7E-9
SPC1,7,123456,1
"""
SURFACES = "SURF,101,ELFACE\n,1\nSURF,102,ELEM\n,2\n"
BRICK = (
    "".join(
        f"GRID,{20 + i},,{x}.,{y}.,{z}.\n"
        for i, (x, y, z) in enumerate((a, b, c) for c in (1, 21) for a, b in ((10, 10), (90, 10), (90, 90), (10, 90)))
    )
    + "CHEXA,9,9,20,21,22,23,24,25\n,26,27\nPSOLID,9,1\n"
)


def read(folder, text, ending="fem"):
    path = folder / f"deck.{ending}"
    path.write_text(text)
    return read_model(path)


def equations(model):
    return [e for c in model.constraints for e in linear_equations(c, model.nodes.coords)]


def keywords(model, changes):
    return [u.keyword for u in model.unread if u.changes_answer is changes]


@pytest.mark.parametrize("ending", ["fem", "bulk", "blk", "txt", "deck"])
def test_any_ending(tmp_path, ending):
    model = read(tmp_path, CASE + PLATES + "ENDDATA\n", ending)
    assert model.n_elements == 2
    assert [f.nodes_idx.size for f in model.fixed] == [1], "SPC of a case control without CEND is taken"
    assert keywords(model, True) == []


def test_bulk_data_alone(tmp_path):
    assert read(tmp_path, "$TITLE   = punched\n" + PLATES, "pch").n_elements == 2


def test_an_abaqus_deck_of_an_unknown_ending(tmp_path):
    text = "** GRID 1\n*NODE\n1,0.\n2,1.\n*ELEMENT, TYPE=SPRING2, ELSET=S\n1,1,2\n*SPRING, ELSET=S\n1,1\n5.\n"
    assert read(tmp_path, text, "txt").n_elements == 1


def test_parameters_may_be_words(tmp_path):
    assert read(tmp_path, PLATES + "PARAM,COUPMASS,YES\n").mass_form == "linear"
    assert read(tmp_path, PLATES + "PARAM,COUPMASS,NO\n").mass_form == "lumped"


@pytest.mark.parametrize("card", ["TIE,5,,102,101,,5.", "CONTACT,5,FREEZE,102,101,,5."])
def test_ties(tmp_path, card):
    """The grids of the secondary side follow the face of the main one: a rotation of it moves them as a body."""
    model = read(tmp_path, PLATES + SURFACES + card + "\n")
    found = equations(model)
    assert len(found) == 12, "x, y and z of four grids"
    coords, u = model.nodes.coords, np.zeros(6 * model.nodes.count)
    turn = np.array([0.3, -0.2, 0.5])
    u.reshape(-1, 6)[:, :3], u.reshape(-1, 6)[:, 3:] = np.cross(turn, coords), turn
    assert max(abs(u[list(e.labels)] @ e.coefficients) for e in found) < 1e-12
    followers = {int(n) for c in model.constraints for n in c.dependents}
    assert followers == {4, 5, 6, 7}
    assert keywords(model, True) == []


def test_moments_where_the_card_ties_them(tmp_path):
    assert len(equations(read(tmp_path, PLATES + SURFACES + "TIE,5,,102,101,123456,5.\n"))) == 24


def test_a_face_of_a_solid(tmp_path):
    """Two grids name the lower face of a brick that stands on the plate."""
    text = PLATES + BRICK + "SURF,101,ELFACE\n,1\nSURF,103,ELFACE\n,9,20,22\nTIE,5,,103,101,,5.\n"
    model = read(tmp_path, text)
    assert {int(n) for c in model.constraints for n in c.dependents} == {8, 9, 10, 11}
    assert {"SURF_101", "SURF_103"} <= model.surfaces.keys()


def test_sliding_contact_is_that_of_the_study(tmp_path):
    text = PLATES + SURFACES + "CONTACT,5,SLIDE,101,102\nSET,3,GRID,LIST\n,1,THRU,4\n"
    model = read(tmp_path, text + "SURF,8,FACE\n,1,2,3,4\n")
    assert keywords(model, True) == []
    assert {"CONTACT 5", "SURF"} <= set(keywords(model, False))
    assert {"SURF_101", "SURF_102.SNEG"} <= model.surfaces.keys()
    assert model.node_sets["SET_3"].tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("cards", "text"),
    [("TIE,5,,101,9\n", "there is no surface 9"), ("SURF,9,FACE\n,1,2,3\nTIE,5,,101,9\n", "SURF 9 is of type FACE")],
)
def test_ties_to_nothing_are_told(tmp_path, cards, text):
    with pytest.raises(InputError, match=text):
        read(tmp_path, PLATES + SURFACES + cards)


@pytest.mark.parametrize("card", ["CGAPG,9,9,1,2", "PRETENS,1,2", "RBODY,3,1"])
def test_what_is_not_read_stops(tmp_path, card):
    assert keywords(read(tmp_path, PLATES + card + "\n"), True) == [card.split(",")[0]]


@pytest.mark.parametrize("name", ["CPYRAM", "CPYRA"])
def test_pyramids(tmp_path, name):
    top = "GRID,5,,50.,50.,60.\nPSOLID,2,1\n"
    model = read(tmp_path, PLATES + top + f"{name},5,2,1,2,3,4,5\n")
    assert [b.kind for b in model.blocks] == ["quad4", "quad4", "pyramid5"]
    with pytest.raises(InputError, match=r"has 6 grids; expected 5 grids. Export the mesh in first order\."):
        read(tmp_path, PLATES + top + f"{name},5,2,1,2,3,4,5,11\n")
