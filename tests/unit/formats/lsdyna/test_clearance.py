"""Discrete elements of LS-DYNA decks whose section has a clearance, or limits."""

from __future__ import annotations

import pytest

from creak.errors import InputError
from creak.formats.decks import read_model


def deck(section="3,0,0.,0.,0.5\n0.,0.", element="5,3,1,2,0", extra="", law="*MAT_SPRING_ELASTIC\n3,10."):
    return (
        "*KEYWORD\n*NODE\n1,0.,0.,0.,7,7\n2,0.,0.,10.,0,7\n*ELEMENT_DISCRETE\n"
        f"{element}\n*ELEMENT_MASS\n6,2,1.e-3\n*PART\nbump\n3,3,3\n*SECTION_DISCRETE\n{section}\n{law}\n{extra}*END\n"
    )


@pytest.fixture
def read(tmp_path):
    def one(text):
        (tmp_path / "a.k").write_text(text)
        return read_model(tmp_path / "a.k")

    return one


def changing(model):
    return {u.keyword: u.why for u in model.unread if u.changes_answer}


def test_a_clearance_makes_a_stop_in_compression(read):
    """u_2 - u_1 along the line stays above -CL; a set of such elements has nothing of the structure."""
    model = read(deck(extra="*SET_DISCRETE\n7\n5\n"))
    (stop,) = model.stops
    assert (stop.name, stop.first.tolist(), stop.second.tolist()) == ("GAP_3", [0], [1])
    assert (stop.dof, stop.lower, stop.upper, stop.stiffness) == (3, -0.5, None, 10.0)
    assert [block.kind for block in model.blocks] == ["mass"]
    assert 'dof = "z", lower = -0.5, stiffness = 10' in changing(model)["*SECTION_DISCRETE, CL"]
    assert "SET_DISCRETE_7" not in model.element_sets


def test_along_a_vector(read):
    model = read(deck(element="5,3,1,2,4,0.5", extra="*DEFINE_SD_ORIENTATION\n4,0,0.,3.,4.\n"))
    (stop,) = model.stops
    assert stop.direction == pytest.approx((0.0, 0.6, 0.8))
    assert stop.stiffness == 5.0


@pytest.mark.parametrize(
    "text", [deck(element="5,3,1,0,4", extra="*DEFINE_SD_ORIENTATION\n4,0,0.,0.,1.\n"), deck("3,1,0.,0.,0.5\n0.,0.")]
)
def test_to_ground_and_about_a_line_the_clearance_is_named(read, text):
    model = read(text)
    assert not model.stops
    assert "acts without it" in changing(model)["*SECTION_DISCRETE, CL"]


@pytest.mark.parametrize(
    ("section", "named"),
    [("3,0,1.5\n0.,0.", "KD"), ("3,0,0.,0.,0.,9.\n0.,0.", "FD"), ("3,0\n2.,0.", "CDL"), ("3,0\n0.,2.", "TDL")],
)
def test_limits_are_named(read, section, named):
    model = read(deck(section))
    assert [block.kind for block in model.blocks] == ["axial2", "mass"]
    assert named in changing(model)[f"*SECTION_DISCRETE, {named}"]


def test_a_plain_spring_says_nothing(read):
    assert not changing(read(deck("3,0\n0.,0.")))


def test_an_id_twice(read):
    with pytest.raises(InputError, match="discrete element 5 is defined twice"):
        read(deck(element="5,3,1,2,0\n5,3,1,2,0"))
