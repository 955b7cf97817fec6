"""Forms that decks have and that need not stop a reader."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.model.materials import PointMass
from helpers_nastran import motion, read, rigid_mass, unread

E, G = 2.0e5, 1.2e4
GRIDS = "GRID,1,,0.,0.,0.,,123456\nGRID,2,,10.,0.,0.\n"
BAR = "CBAR,1,1,1,2,0.,1.,0.\nPBAR,1,1,5.,4.,3.,2.\n"


def test_a_bar_needs_e_and_g_only(tmp_path):
    """E/(2 G) - 1 is no Poisson's ratio here; tension, bending and torsion follow E and G. Shells stop."""
    model = read(tmp_path, f"{GRIDS}{BAR}MAT1,1,{E},{G}\n")
    assert not any(unread(model).values())
    assert motion(model, {(2, 1): 1.0})[1, 0] == pytest.approx(10.0 / (E * 5.0))
    assert motion(model, {(2, 2): 1.0})[1, 1] == pytest.approx(1000.0 / (3 * E * 4.0))
    assert motion(model, {(2, 4): 1.0})[1, 3] == pytest.approx(10.0 / (G * 2.0))
    shell = "GRID,3,,0.,1.,0.\nCTRIA3,9,9,1,2,3\nPSHELL,9,1,1.,1,,1\n"
    with pytest.raises(InputError, match=r"MAT1 1 has E = 200000 and nu = 7\.33"):
        read(tmp_path, f"{GRIDS}{BAR}{shell}MAT1,1,{E},{G}\n")


@pytest.mark.parametrize(("card", "told"), [(f"{E}", True), (f",{G}", True), (f"{E},,.3", False), (f"{E},{G}", False)])
def test_one_modulus_without_nu_is_told(tmp_path, card, told):
    """Nastran takes NU and the other modulus for 0 then, so that such a bar does not twist."""
    model = read(tmp_path, f"{GRIDS}{BAR}MAT1,1,{card}\n")
    assert unread(model).get("MAT1 of one modulus alone") == (False if told else None)


def test_a_material_that_nothing_uses_may_be_anything(tmp_path):
    model = read(tmp_path, f"{GRIDS}{BAR}MAT1,1,{E},,.3\nMAT1,2,,,.3,1.\nMAT8,3,0.,0.,.3,0.\n")
    assert not any(unread(model).values())


def test_ends_of_a_beam_that_differ_by_rounding_are_no_taper(tmp_path):
    beam = "CBEAM,1,1,1,2,0.,1.,0.\nPBEAM,1,1,5.,4.,3.,,2.\n,0.,0.,0.,0.,0.,0.,0.,0.\n,YES,1.,5.0003,4.,3.,,2.\n"
    model = read(tmp_path, f"{GRIDS}{beam}MAT1,1,{E},,.3\n")
    assert not unread(model)
    assert model.blocks[0].section.area == 5.0


def test_a_mass_may_share_its_id_with_another_element(tmp_path):
    cards = "CVISC,1,7,1,2\nPVISC,7,2.\nCONM2,1,2,,.5\n"
    model = read(tmp_path, f"{GRIDS}{BAR}{cards}MAT1,1,{E},,.3\n")
    assert not any(unread(model).values())
    ids = [int(i) for b in model.blocks for i in b.ids]
    assert len(set(ids)) == 3
    assert [b.section.mass for b in model.blocks if isinstance(b.section, PointMass)] == [0.5]
    with pytest.raises(InputError, match=r"element 1 .CONM2. is defined twice"):
        read(tmp_path, f"{GRIDS}CONM2,1,2,,.5\nCONM2,1,1,,.7\n")


def test_sets_of_the_case_control_without_cards(tmp_path):
    model = read(tmp_path, f"{GRIDS}{BAR}MAT1,1,{E},,.3\n", "SPC = 3\nMPC = 4\n")
    assert unread(model) == {"SPC = 3": False, "MPC = 4": False}


def test_scalar_points_need_no_card_of_their_own(tmp_path):
    """CELAS3, CMASS4 and the like name them."""
    springs = "CELAS3,1,5,101,102\nPELAS,5,40.\nCELAS4,2,10.,101\nCMASS4,3,.5,102\n"
    model = read(tmp_path, GRIDS + springs)
    assert motion(model, {(102, 1): 1.0})[-1, 0] == pytest.approx(1 / 10.0 + 1 / 40.0)
    with pytest.raises(InputError, match="uses grid 103, which is not defined"):
        read(tmp_path, GRIDS + springs + "SPC1,1,1,103\n")


def test_fluid_is_left_out_and_told(tmp_path):
    """Fluid points (CD = -1) and their solids; the structure is read."""
    points = "".join(f"GRID,{i},,{i % 2}.,{i // 2 % 2}.,{i // 4 % 2}.,-1\n" for i in range(10, 18))
    fluid = "CHEXA,7,7,10,11,13,12,14,15\n,17,16\nPSOLID,7,8,,,,,PFLUID\nMAT10,8,,1.,3.\n"
    model = read(tmp_path, f"{GRIDS}{BAR}{points}{fluid}MAT1,1,{E},,.3\n")
    assert model.nodes.count == 2
    assert [name for name, changes in unread(model).items() if changes] == ["PSOLID, PFLUID", "MAT10"]


def test_a_deck_of_replicated_cards(tmp_path):
    """A beam of ten bars by replication has the tip motion of one bar."""
    text = "GRID,1,,0.,0.,0.,,123456\nGRID,2,,1.,0.,0.\n=,*1,=,*1.,==\n=8\n"
    bars = "CBAR,1,1,1,2,0.,1.,0.\n=,*1,=,*1,*1,==\n=(8)\nPBAR,1,1,5.,4.,3.,2.\n"
    model = read(tmp_path, f"{text}{bars}MAT1,1,{E},,.3,1.-3\n")
    assert model.nodes.ids.tolist() == list(range(1, 12))
    np.testing.assert_allclose(model.nodes.coords[:, 0], np.arange(11.0))
    assert motion(model, {(11, 2): 1.0})[10, 1] == pytest.approx(1000.0 / (3 * E * 4.0))
    assert rigid_mass(model)[0, 0] == pytest.approx(0.05)
