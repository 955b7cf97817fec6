"""DMIG matrices that the case control adds to the structure: K2GG, M2GG, B2GG."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.assembly.coupling import Driven
from creak.assembly.rigid import unheld_parts
from creak.errors import InputError
from creak.formats.nastran.reader import read_nastran
from helpers_nastran import assembled, motion, read, unread

GRIDS = "GRID,1\nGRID,2,,10.,.1,.3\nGRID,3,,17.,3.\nGRID,4,,,5.\n"
BARS = GRIDS + "CBAR,1,3,1,2,0.,1.,.2\nCBAR,2,3,3,4,0.,1.,.2\nPBAR,3,1,8.,10.,3.,7.\nMAT1,1,210000.,,.3,7.85-9\n"
TURNED = "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,.6,.8,0.\n"


def spring(name: str, a: int, b: int, dof: int, k: float) -> str:
    """k between one dof of two grids, in the lower triangle."""
    return (
        f"DMIG,{name},0,6,2,0\nDMIG,{name},{a},{dof},,{a},{dof},{k}\n,{b},{dof},{-k}\n"
        f"DMIG,{name},{b},{dof},,{b},{dof},{k}\n"
    )


def parts_of(model):
    system = assembled(model)
    C = system.damping.extra
    order = np.argsort(system.coordinates)
    return [None if A is None else to_dense(A)[np.ix_(order, order)] for A in (system.K, system.M, C)]


@pytest.mark.parametrize("grid", ["GRID,4,,,5.", "GRID,4,,,5.,,5"], ids=["basic", "turned"])
def test_a_spring_by_matrix_is_a_spring(tmp_path, grid):
    """Between two parts, and in a displacement frame."""
    bulk = TURNED + BARS.replace("GRID,4,,,5.", grid)
    K, M, _ = parts_of(read(tmp_path, bulk + "CELAS2,9,7.,2,2,4,2\n"))
    with_matrix = read(tmp_path, bulk + spring("SPRING", 2, 4, 2, 7.0), case="K2GG = SPRING\n")
    found, mass, _ = parts_of(with_matrix)
    np.testing.assert_allclose(found, K, rtol=1e-14, atol=1e-14 * K.max())
    np.testing.assert_array_equal(mass, M)
    assert not [word for word, changes in unread(with_matrix).items() if changes]


def test_mass_and_damping(tmp_path):
    """WTMASS scales CONM2 and not M2GG; PARAM,CM2 and factors of the case control do."""
    bulk = "GRID,1\nPARAM,WTMASS,10.\nPARAM,CM2,2.\nCONM2,9,1,,1.\n"
    matrices = (
        "DMIG,M1,0,1,1,0\nDMIG,M1,1,1,,1,1,3.\n,1,2,.5\nDMIG,M1,1,2,,1,1,.5\nDMIG,B1,0,6,1,0\nDMIG,B1,1,3,,1,3,4.\n"
    )
    _, M, C = parts_of(read(tmp_path, bulk + matrices, case="M2GG = M1\nB2GG = 1.5*B1, 1.5*B1\n"))
    wanted = np.diag([10.0 + 6.0, 10.0, 10.0])
    wanted[0, 1] = wanted[1, 0] = 1.0
    np.testing.assert_allclose(M, wanted)
    np.testing.assert_allclose(C, np.diag([0.0, 0.0, 12.0]))


def test_scalar_points(tmp_path):
    """A spring of 4 to a scalar point that another of 12 holds: 1/(1/4 + 1/12) = 3."""
    bulk = (
        "GRID,1,,,,,,23456\nCONM2,9,1,,1.\nSPOINT,7\nCELAS4,2,12.,7\nDMIG,K1,0,6,2,0\nDMIG,K1,1,1,,1,1,4.\n,7,0,-4.\n"
    )
    model = read(tmp_path, bulk + "DMIG,K1,7,0,,7,0,4.\n", case="K2GG=K1\n")
    assert motion(model, {(1, 1): 6.0})[0, 0] == pytest.approx(2.0)


def test_a_matrix_between_two_bodies_holds_neither(tmp_path):
    """A matrix is one element, so the motion of both bodies together stays free."""
    model = read(tmp_path, BARS + spring("SPRING", 2, 4, 2, 7.0), case="K2GG = SPRING\n")
    assert len(unheld_parts(model, Driven({}))) == 2


def test_pieces_that_do_not_touch_are_elements_of_their_own(tmp_path):
    two = spring("SPRING", 1, 2, 1, 7.0) + spring("SPRING", 3, 4, 2, 5.0).split("\n", 1)[1]
    model = read(tmp_path, BARS + two, case="K2GG = SPRING\n")
    blocks = [b for b in model.blocks if b.kind == "nodal2"]
    assert [model.nodes.ids[b.nodes_idx].tolist() for b in blocks] == [[[1, 2]], [[3, 4]]]
    assert len({int(i) for b in model.blocks for i in b.ids}) == model.n_elements


def test_matrices_that_are_not_selected(tmp_path):
    bulk = BARS + spring("SPRING", 2, 4, 2, 7.0)
    assert unread(read(tmp_path, bulk)) == {"DMIG": False}
    (tmp_path / "alone.bdf").write_text(bulk, encoding="utf-8")
    found = {u.keyword: u for u in read_nastran(tmp_path / "alone.bdf").unread}
    assert found["DMIG"].changes_answer
    assert "K2GG" in found["DMIG"].why
    assert unread(read(tmp_path, bulk, case="K2PP = SPRING\n"))["K2PP"]


WRONG = {
    "no such matrix": ("K2GG = SPRUNG\n", spring("SPRING", 2, 4, 2, 7.0), "SPRING"),
    "no name": ("K2GG = 3 4\n", "", "name of a DMIG"),
    "complex": ("K2GG = Z\n", "DMIG,Z,0,6,4,0\nDMIG,Z,1,1,,1,1,1.,2.\n", "real"),
    "rectangular": ("K2GG = Z\n", "DMIG,Z,0,9,2,0,,,3\nDMIG,Z,1,1,,1,1,1.\n", "symmetric, square"),
    "not symmetric": ("B2GG = Z\n", "DMIG,Z,0,1,2,0\nDMIG,Z,1,1,,1,2,1.\nDMIG,Z,1,2,,1,1,-1.\n", "not symmetric"),
    "no such grid": ("K2GG = Z\n", "DMIG,Z,0,6,2,0\nDMIG,Z,77,1,,77,1,1.\n", "77"),
    "no such dof": ("K2GG = Z\n", "DMIG,Z,0,6,2,0\nDMIG,Z,1,7,,1,7,1.\n", "component 7"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_matrices_are_named(tmp_path, name):
    case, cards, word = WRONG[name]
    with pytest.raises(InputError, match=word):
        read(tmp_path, BARS + cards, case=case)
