"""Beams of Nastran and LS-DYNA decks written as Abaqus decks: a section for each direction, the same matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.writer import write_deck
from creak.formats.lsdyna.reader import read_lsdyna
from helpers_nastran import assembled, read

ROUND_OFF = 1e-12
LINE = "".join(f"GRID,{i},,{25.0 * i - 25.0},{3.0 * i - 3.0},0.\n" for i in range(1, 6)) + "GRID,99,,0.,50.,7.\n"
SECTION = "PBEAM,1,1,5.,10.,20.,,7.\nMAT1,1,210000.,,.3,7.85-9\nCONM2,50,99,,1.-6\n"
SAME, ACROSS, NODE = "0.,1.,0.", "0.,0.3,1.", "99"


def beams(*directions):
    return LINE + "".join(f"CBEAM,{i},1,{i},{i + 1},{v}\n" for i, v in enumerate(directions, start=1)) + SECTION


def matrices(model):
    """K and M over all dofs in the order of the nodes."""
    system = assembled(model)
    order = np.argsort(system.coordinates)
    return [to_dense(A)[np.ix_(order, order)] for A in (system.K, system.M)]


def assert_same(model, copy):
    for one, other in zip(matrices(model), matrices(copy), strict=True):
        assert one.shape == other.shape
        assert np.abs(one - other).max() <= ROUND_OFF * np.abs(one).max()


@pytest.mark.parametrize(
    ("directions", "sections"),
    [
        ((SAME,) * 4, 1),
        ((NODE,) * 4, 1),
        ((SAME, ACROSS, ACROSS, SAME), 2),
        ((SAME, "-7.35,62.118,0.", SAME, "0.,3.,0."), 1),
    ],
    ids=["one vector", "one node", "two vectors", "along the beams by unlike amounts"],
)
def test_a_section_for_each_direction(tmp_path, directions, sections):
    """Vectors in one plane with the beam are one direction; a node off a straight line, too."""
    model = replace(read(tmp_path, beams(*directions)), mass_form="consistent")
    write_deck(model, tmp_path / "copy.inp")
    assert (tmp_path / "copy.inp").read_text().count("*BEAM GENERAL SECTION") == sections
    assert_same(model, read_deck(tmp_path / "copy.inp"))


def test_sets_hold_the_same_elements(tmp_path):
    """Also where the elements of a set go to two blocks."""
    sets = "SET3,5,ELEM,2,3\nSET3,6,ELEM,1,2,3,4\n"
    model = replace(read(tmp_path, beams(SAME, ACROSS, ACROSS, SAME) + sets), mass_form="consistent")
    write_deck(model, tmp_path / "copy.inp")
    copy = read_deck(tmp_path / "copy.inp")
    assert {"SET_5", "SET_6"} <= set(model.element_sets)
    for name, rows in model.element_sets.items():
        labels = [sorted(int(m.blocks[b].ids[r]) for b, r in m.element_sets[name].tolist()) for m in (model, copy)]
        assert len(rows) == len(labels[0])
        assert labels[0] == labels[1]


@pytest.mark.parametrize(
    ("form", "size", "lost"),
    [
        (2, "10.,20.,30.,40.", ()),
        (1, "2.,2.,4.,4.", ("beam section PART_1: its surface, 1 from the axis, is not in the deck",)),
    ],
)
def test_poissons_ratio_passes_through_the_shear_modulus(tmp_path, form, size, lost):
    """E/(2 G) - 1 is 0.3 up to a rounding; the surface of an integrated beam is left out and told."""
    nodes = "".join(f"{i},{10.0 * i},{i}.,0.\n" for i in range(1, 4)) + "9,0.,0.,50.\n"
    text = f"*KEYWORD\n*NODE\n{nodes}*ELEMENT_BEAM\n1,1,1,2,9\n2,1,2,3,9\n*PART\nbar\n1,1,1\n*SECTION_BEAM\n1,{form}\n{size}\n"
    (tmp_path / "deck.k").write_text(f"{text}*MAT_ELASTIC\n1,7.85e-9,210000.,.3\n*END\n")
    model = read_lsdyna(tmp_path / "deck.k")
    assert write_deck(model, tmp_path / "copy.inp") == lost
    assert_same(model, read_deck(tmp_path / "copy.inp"))


@pytest.mark.parametrize("i12", [7.0, -7.0])
def test_second_moments_in_axes_that_are_not_principal(tmp_path, i12):
    """ISS, IST and ITT, or I2, I12 and I1, are I11, I12 and I22 of Abaqus, as they stand; the copy is as stiff.

    A cantilever along x yields in y and z by L^3/(3 E) times the inverse of the integrals of y^2, y z and z^2.
    """
    deck = (
        "*KEYWORD\n*NODE\n1,0.,0.,0.\n2,50.,0.,0.\n9,0.,50.,0.\n*ELEMENT_BEAM\n1,1,1,2,9\n*PART\nbar\n1,1,1\n"
        f"*SECTION_BEAM\n1,2\n10.,20.,30.,40.,0.,{i12}\n*MAT_ELASTIC\n1,7.85e-9,210000.,.3\n*END\n"
    )
    bulk = (
        "GRID,1,,0.,0.,0.\nGRID,2,,50.,0.,0.\nGRID,9,,0.,50.,0.\nCBEAM,1,1,1,2,9\nCONM2,5,9,,1.-6\n"
        f"PBEAM,1,1,10.,30.,20.,{i12},40.\n,\n,0.,0.\nMAT1,1,210000.,,.3,7.85-9\n"
    )
    (tmp_path / "deck.k").write_text(deck)
    expected = 50.0**3 / (3.0 * 210000.0) * np.linalg.inv([[30.0, i12], [i12, 20.0]])
    for model in (read_lsdyna(tmp_path / "deck.k"), replace(read(tmp_path, bulk), mass_form="consistent")):
        assert write_deck(model, tmp_path / "copy.inp") == ()
        assert f"10.0, 20.0, {i12}, 30.0, 40.0" in (tmp_path / "copy.inp").read_text()
        copy = read_deck(tmp_path / "copy.inp")
        assert_same(model, copy)
        tip = np.linalg.inv(matrices(copy)[0][6:12, 6:12])[1:3, 1:3]
        assert tip == pytest.approx(expected, rel=1e-9)


def test_bars_without_inertia_about_their_axis_are_refused(tmp_path):
    bulk = (
        beams(SAME, SAME, SAME, SAME).replace("CBEAM", "CBAR").replace("PBEAM,1,1,5.,10.,20.,,", "PBAR,1,1,5.,10.,20.,")
    )
    model = replace(read(tmp_path, bulk), mass_form="consistent")
    with pytest.raises(InputError, match=r"'PBAR 1' .* no inertia about its axis, as CBAR"):
        write_deck(model, tmp_path / "copy.inp")
