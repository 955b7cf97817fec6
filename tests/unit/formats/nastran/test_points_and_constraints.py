"""Springs, bushings, masses, rigid elements, MPC and supports, in the basic and in displacement frames."""

from __future__ import annotations

import math

import numpy as np
import pytest

from creak.errors import InputError
from creak.model.constraints import DistributingCoupling, KinematicCoupling, RigidLink
from helpers_nastran import assembled, matrix, motion, read, rigid_mass, row, unread

TURNED = "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,.6,.8,0.\n"
"""x axis (.6, .8, 0)."""
BLOCK = "CONM2,900,1,,1.\n"
"""So that grid 1 is a part."""


def bar(a=1, b=2, name=800):
    """A stiff bar, to make a part of two grids."""
    return f"CBAR,{name},80,{a},{b},.123,.456,.789\nPBAR,80,80,1.,1.,1.,1.\nMAT1,80,1.+5,,.3\n"


@pytest.mark.parametrize(
    ("cards", "stiffness"),
    [
        ("CELAS2,1,7.,1,2", {(1, 1): 7.0}),
        ("CELAS1,1,4,1,6\nPELAS,4,3.,,,9,8.", {(5, 5): 3.0}),
        ("CELAS1,1,9,,,1,3\nPELAS,4,3.,,,9,8.", {(2, 2): 8.0}),
        ("CBUSH,1,1,1,,,,,0\nPBUSH,1,K,1.,2.,3.,4.,5.,6.", {(i, i): i + 1.0 for i in range(6)}),
    ],
)
def test_springs_to_ground(tmp_path, cards, stiffness):
    K = matrix(read(tmp_path, f"GRID,1,,1.,2.,3.\n{BLOCK}{cards}"), "K", 1)
    wanted = np.zeros((6, 6))
    for at, value in stiffness.items():
        wanted[at] = value
    np.testing.assert_allclose(K, wanted)


def test_springs_in_a_displacement_frame(tmp_path):
    """Component 1 of grid 1 is along (.6, .8, 0): K = k n n'; the same for a dashpot and a mass."""
    grid = TURNED + f"GRID,1,,1.,2.,3.,5\n{BLOCK}"
    n = np.array([0.6, 0.8, 0.0])
    for cards, name, size in (
        ("CELAS2,1,7.,1,1", "K", 7.0),
        ("CDAMP2,1,5.,1,1", "C", 5.0),
        ("CMASS2,1,3.,1,1", "M", 3.0),
    ):
        wanted = size * np.outer(n, n) + (np.eye(3) if name == "M" else 0.0)
        np.testing.assert_allclose(matrix(read(tmp_path, grid + cards), name, 1)[:3, :3], wanted, atol=1e-14)


def test_spring_between_frames(tmp_path):
    """g = n1 . u1 - e_x . u2: a force f along x at grid 2 stretches it by f/k whatever n1 is."""
    bulk = TURNED + "GRID,1,,,,,5,123456\nGRID,2,,,,,,23456\nCELAS2,1,4.,1,2,2,1\nCONM2,9,2,,1.\n"
    assert motion(read(tmp_path, bulk), {(2, 1): 8.0})[1, 0] == pytest.approx(2.0)


def test_scalar_points(tmp_path):
    """Two springs in series through an SPOINT: k = 1/(1/4 + 1/12) = 3."""
    bulk = f"GRID,1,,,,,,23456\n{BLOCK}SPOINT,7\nCELAS2,1,4.,1,1,7\nCELAS4,2,12.,7\n"
    assert motion(read(tmp_path, bulk), {(1, 1): 6.0})[0, 0] == pytest.approx(2.0)


def test_dampers(tmp_path):
    bulk = f"GRID,1\nGRID,2,,3.\n{BLOCK}CONM2,901,2,,1.\n"
    C = matrix(read(tmp_path, bulk + "CDAMP1,1,3,1,2,2,2\nPDAMP,3,.5"), "C", 1)
    assert C[1, 1] == 0.5
    C = matrix(read(tmp_path, bulk + "CVISC,1,3,1,2\nPVISC,2,9.,,,3,.25"), "C", 1)
    assert C[0, 0] == 0.25
    assert np.count_nonzero(C) == 1


@pytest.mark.parametrize("orientation", [",0.,0.,1.", ",3", ",,,,5"])
def test_bushing_axes(tmp_path, orientation):
    """Axis 1 along the grids and axis 2 towards the vector or grid; or the axes of CID. K1 = 3 acts along axis 1."""
    frame = "CORD2R,5,,0.,0.,0.,1.,0.,0.\n,0.,1.,0.\n" if orientation == ",,,,5" else ""
    bulk = f"{frame}GRID,1,,,,,,123456\nGRID,2,,0.,2.\nGRID,3,,0.,0.,5.,,123456\nCONM2,9,2,,1.\n"
    model = read(tmp_path, f"{bulk}CBUSH,1,1,1,2{orientation}\nPBUSH,1,K,3.,4.,5.,100.,100.,100.\n,B,,,.5")
    assert unread(model) == {}
    u = motion(model, {(2, 2): 1.0})
    assert u[1, 1] == pytest.approx(1.0 / 3.0)
    # Across it at the middle of 2 length units: the force turns the rotational springs on its arm too.
    u = motion(model, {(2, 3): 1.0})
    assert u[1, 2] == pytest.approx(1.0 / 4.0 + 1.0 / 100.0)


def test_lines_of_a_bushing(tmp_path):
    """Flags stand in field 3; in field 2 they are understood, and others are refused."""
    bulk = f"GRID,1\n{BLOCK}CBUSH,1,1,1,,,,,0\nPBUSH,1,K,1.,2.,3.,4.,5.,6.\n"
    for line in (",,B,.5", ",B,.5"):
        assert matrix(read(tmp_path, bulk + line), "C", 1)[0, 0] == 0.5
    assert unread(read(tmp_path, bulk + ",,M,.5"))["PBUSH, M"]
    with pytest.raises(InputError, match="a line of PBUSH 1 begins with 'RVC'"):
        read(tmp_path, bulk + ",,RVC,.5")


def test_bushing_without_orientation(tmp_path):
    bulk = "GRID,1\nGRID,2\nCBUSH,1,1,1,2\nPBUSH,1,K,3.,4.\nCONM2,9,2,,1.\n"
    with pytest.raises(InputError, match=r"CBUSH 1 has coincident grids \(or one\) and no CID"):
        read(tmp_path, bulk)


def test_concentrated_mass(tmp_path):
    """Offset and inertia in the axes of CID; products of inertia come with a minus; WTMASS multiplies all."""
    mass = "CONM2,1,1,5,4.,1.,0.,2.\n,10.,.5,11.,.25,.75,12.\nPARAM,WTMASS,2.\n"
    M = matrix(read(tmp_path, TURNED + "GRID,1,,7.,8.,9.\n" + mass), "M", 1)
    R = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    x, y, z = R @ [1.0, 0.0, 2.0]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    J = R @ np.array([[10.0, -0.5, -0.25], [-0.5, 11.0, -0.75], [-0.25, -0.75, 12.0]]) @ R.T
    wanted = 2.0 * np.block([[4.0 * np.eye(3), -4.0 * cross], [4.0 * cross, J - 4.0 * cross @ cross]])
    np.testing.assert_allclose(M, wanted, atol=1e-12)


def test_mass_at_a_place(tmp_path):
    """CID = -1: X is where the mass is."""
    model = read(tmp_path, "GRID,1,,7.,8.,9.\nCONM2,1,1,-1,4.,1.,2.,3.\n")
    np.testing.assert_allclose(rigid_mass(model)[3:, :3].diagonal(), 0.0)
    assert rigid_mass(model)[5, 0] == pytest.approx(-4.0 * 2.0)


def test_mass_matrix(tmp_path):
    """CONM1: lower triangle by rows."""
    lower = [float(i) for i in range(1, 22)]
    fields = (
        ",".join(map(str, lower[:5])) + "\n," + ",".join(map(str, lower[5:13])) + "\n," + ",".join(map(str, lower[13:]))
    )
    M = matrix(read(tmp_path, f"GRID,1\nCONM1,1,1,,{fields}"), "M", 1)
    wanted = np.zeros((6, 6))
    wanted[np.tril_indices(6)] = lower
    np.testing.assert_allclose(M, wanted + np.tril(wanted, -1).T)


def test_rbe2(tmp_path):
    """All dofs follow as a rigid body, whatever the frames; THRU and ALPHA are understood."""
    bulk = TURNED + "GRID,1\nGRID,2,,3.,4.,5.,5\nGRID,3,,1.\nCONM2,9,2,,1.\nRBE2,1,1,123456,2,THRU,3,1.-5\n"
    coupling = read(tmp_path, bulk).constraints[0]
    assert isinstance(coupling, KinematicCoupling)
    assert coupling.nodes_idx.tolist() == [1, 2]


def test_rbe2_in_a_displacement_frame(tmp_path):
    """Only n = (.6, .8, 0) of grid 2 follows: pulled along it, grid 2 goes with grid 1; across it its spring holds it."""
    bulk = (
        TURNED + "GRID,1,,,,,,3456\nGRID,2,,,,,5,3456\nCELAS2,1,100.,1,1\nCELAS2,2,100.,1,2\nCELAS2,3,25.,2,2\n"
        "CONM2,9,2,,1.\nCONM2,8,1,,1.\nRBE2,1,1,1,2\n"
    )
    u = motion(read(tmp_path, bulk), {(2, 1): 0.6, (2, 2): 0.8})
    np.testing.assert_allclose(u[1, :2], [0.006, 0.008], atol=1e-12)
    u = motion(read(tmp_path, bulk), {(2, 1): -0.8, (2, 2): 0.6})
    np.testing.assert_allclose(u[1, :2], np.array([-0.8, 0.6]) / 25.0, atol=1e-12)


def test_rbar(tmp_path):
    """Blank fields: B follows A. Three independent dofs at each end: a simply supported rigid bar of length 2."""
    model = read(tmp_path, f"GRID,1\nGRID,2,,2.\nGRID,3,,2.,1.\n{bar(2, 3)}RBAR,1,1,2\n")
    assert isinstance(model.constraints[0], RigidLink)
    bulk = "GRID,1\nGRID,2,,2.\nRBAR,1,1,2,1234,23,56,1456\nCELAS2,1,4.,1,2\nCELAS2,2,8.,2,2\nSPC1,1,134,1\nSPC1,1,3,2\nCONM2,9,1,,1.\nCONM2,8,2,,1."
    u = motion(read(tmp_path, bulk), {(1, 2): 1.0})
    np.testing.assert_allclose(u[:, 1], [0.25, 0.0], atol=1e-12)
    np.testing.assert_allclose(u[:, 5], -0.125, atol=1e-12)


def test_rbe1_is_rbar(tmp_path):
    bulk = (
        "GRID,1\nGRID,2,,2.\nRBE1,1,1,1234,2,23\n,UM,1,56,2,1456\nCELAS2,1,4.,1,2\nCELAS2,2,8.,2,2\nSPC1,1,134,1\n"
        "SPC1,1,3,2\nCONM2,9,1,,1.\nCONM2,8,2,,1."
    )
    u = motion(read(tmp_path, bulk), {(1, 2): 1.0})
    np.testing.assert_allclose(u[:, 5], -0.125, atol=1e-12)


def test_rrod(tmp_path):
    """Only the distance stays: along (3, 4) grid 2 is held, across it its spring of 5."""
    bulk = "GRID,1,,,,,,123456\nGRID,2,,3.,4.,,,3456\nRROD,1,1,2,,1\nCELAS2,1,5.,2,1\nCELAS2,2,5.,2,2\nCONM2,9,2,,1.\n"
    u = motion(read(tmp_path, bulk), {(2, 1): 4.0, (2, 2): -3.0})
    np.testing.assert_allclose(u[1, :2], [0.8, -0.6])
    assert np.abs(motion(read(tmp_path, bulk), {(2, 1): 3.0, (2, 2): 4.0})).max() < 1e-12


def test_rbe3(tmp_path):
    """Translations of three grids with one weight each: creak's distributing coupling. With rotations: equations."""
    grids = "GRID,1,,1.,1.\nGRID,2\nGRID,3,,3.\nGRID,4,,0.,3.\n" + "".join(f"CONM2,{i},{i},,1.\n" for i in (2, 3, 4))
    plain = read(tmp_path, grids + "RBE3,1,,1,123456,1.,123,2,3\n,2.,123,4").constraints
    assert isinstance(plain[0], DistributingCoupling)
    assert plain[0].weights.tolist() == [1.0, 1.0, 2.0]
    assert len(read(tmp_path, grids + "RBE3,1,,1,123456,1.,123456,2,3,4").constraints) == 6
    with pytest.raises(InputError, match="grids of RBE3 1 do not define a rigid motion"):
        read(tmp_path, grids + "RBE3,1,,1,123456,1.,12,2,3,4")


@pytest.mark.parametrize(
    ("cards", "u2"),
    [
        ("MPC,1,2,1,1.,1,1,-3.", 3.0),
        ("MPCADD,1,7,8\nMPC,7,2,1,1.,1,1,-3.", 3.0),
        ("MPC,1,2,1,2.,1,1,-3.\n,,1,1,1.", 1.0),
    ],
)
def test_mpc(tmp_path, cards, u2):
    """The first term follows the others; two terms a line; MPCADD."""
    bulk = f"GRID,1,,,,,,23456\nGRID,2,,5.,,,,23456\nCELAS2,1,1.,1,1\nCONM2,8,1,,1.\nCONM2,9,2,,1.\n{cards}\n"
    u = motion(read(tmp_path, bulk, "MPC = 1\n"), {(1, 1): 1.0})
    np.testing.assert_allclose(u[:, 0], [1.0, u2])


def test_mpc_in_a_displacement_frame(tmp_path):
    """u2 along (.6, .8, 0) is twice u1 along x."""
    bulk = (
        TURNED
        + "GRID,1,,,,,,23456\nGRID,2,,5.,,,5,23456\nCELAS2,1,1.,1,1\nCONM2,8,1,,1.\nCONM2,9,2,,1.\nMPC,1,2,1,1.,1,1,-2.\n"
    )
    u = motion(read(tmp_path, bulk), {(1, 1): 1.0})
    np.testing.assert_allclose(u[1, :2], [1.2, 1.6], atol=1e-12)


@pytest.mark.parametrize(
    ("cards", "case"),
    [
        ("SPC,1,1,1,,2,1", None),
        ("SPC1,1,1,1,2", None),
        ("SPC1,1,1,1,THRU,5", None),
        ("SPCADD,4,1,3\nSPC1,3,1,1\nSPC1,1,1,2", "SPC=4\n"),
        ("SPC1,1,1,1,2\nSPC1,2,123456,1", "SUBCASE 1\nSPC=1\nSUBCASE 2\nSPC = 2\n"),
    ],
)
def test_supports(tmp_path, cards, case):
    """Set 1 holds x of both grids, and the first subcase is the one that counts."""
    model = read(tmp_path, f"GRID,1\nGRID,2,,1.\n{bar()}{cards}\n", case)
    held = {(int(n), d) for fixed in model.fixed for n in fixed.nodes_idx for d in fixed.dofs}
    assert held == {(0, 1), (1, 1)}


def test_supports_in_a_cylindrical_frame(tmp_path):
    """A grid at 60 degrees that may move radially only: n = (cos, sin); PS and SPC alike."""
    n = np.array([math.cos(math.pi / 3), math.sin(math.pi / 3)])
    frame = "CORD2C,6,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
    springs = "CELAS2,1,2.,1,1\nCELAS2,2,3.,1,2\nCONM2,9,1,,1.\n"
    for cards in ("GRID,1,6,4.,60.,0.,6,23456\n", "GRID,1,6,4.,60.,0.,6\nSPC1,1,23456,1\n"):
        model = read(tmp_path, frame + cards + springs)
        np.testing.assert_allclose(model.nodes.coords[0], [4 * n[0], 4 * n[1], 0.0], atol=1e-12)
        u = motion(model, {(1, 1): 1.0})[0]
        # The springs are in the cylindrical frame as well: only the radial one of 2 acts.
        np.testing.assert_allclose(u[:2], n * n[0] / 2.0, atol=1e-12)
        assert np.abs(u[2:]).max() == 0.0


def test_no_case_control(tmp_path):
    """Bulk data alone: the only set acts, and that is said; of two none does, and the run should stop."""
    from creak.formats.nastran.reader import read_nastran

    path = tmp_path / "bulk.bdf"
    path.write_text(f"GRID,1\nGRID,2,,1.\n{bar()}SPC1,7,123456,1\n")
    model = read_nastran(path)
    assert len(model.fixed) == 1
    assert unread(model)["SPC1"] is False
    path.write_text(path.read_text() + "SPC1,8,123456,2\n")
    model = read_nastran(path)
    assert not model.fixed
    assert unread(model)["SPC1"] is True


def test_initial_velocity(tmp_path):
    """TIC of the set that IC takes, turned from the displacement frame."""
    model = read(tmp_path, TURNED + f"GRID,1,,,,,5\n{BLOCK}TIC,4,1,1,,10.\n", "IC = 4\n")
    assert model.initial_velocity == ((0, 1, pytest.approx(6.0)), (0, 2, pytest.approx(8.0)))
    assert read(tmp_path, f"GRID,1\n{BLOCK}TIC,4,1,1,,10.\n").initial_velocity == ()


def test_parts_hold_their_reference_grids(tmp_path):
    """Grids tied to one part join it; those between parts do not; a loose mass is a part of its own."""
    grids = "".join(f"GRID,{i},,{float(i)},{float(i * i)}\n" for i in range(1, 10))
    model = read(
        tmp_path, grids + bar(1, 2) + bar(3, 4, 801) + "RBE2,1,5,123,1,2\nRBE2,2,6,123,2,3\nRBAR,3,5,7\nCONM2,9,8,,1.\n"
    )
    owner = {int(model.nodes.ids[i]): p.name for p in model.parts for i in p.nodes_idx}
    assert owner == {1: "PART-1", 2: "PART-1", 5: "PART-1", 7: "PART-1", 3: "PART-2", 4: "PART-2", 8: "PART-3"}
    assert assembled(model).n > 0
    assert row(model, 9) == 8


@pytest.mark.parametrize(
    ("cards", "message"),
    [
        ("CELAS2,1,7.,1,7", "acts on component 7 of grid 1"),
        ("CELAS2,1,7.", "CELAS2 1 has no grid"),
        ("CELAS1,1,3,1,1", "CELAS1 1 uses property 3, which is not defined; expected a PELAS"),
        ("CONM2,1,1,9,1.", "CONM2 1 uses coordinate system 9"),
        ("RBE2,1,1,123,1", "RBE2 1 makes grid 1 follow itself"),
        ("RBE2,1,1,127,2", "field 4 of RBE2 is '127'; expected dofs"),
        ("RBE2,1,1,123", "RBE2 1 has no grids"),
        ("RBE2,1,1,1,2\nRBE2,1,1,2,2", "rigid element 1 .RBE2. is defined twice"),
        ("RBAR,1,1,2,1,2", "independent dofs of RBAR 1 do not define a rigid motion"),
        ("RBE3,1,,1,123,1.,123,2\n,UM,2,3", "UM of RBE3 1 names 1 dofs; expected 3|do not define a rigid motion"),
        ("MPC,1,1,1,0.,2,1,1.", "MPC of set 1 has no first coefficient"),
        ("MPC,1,1,8,1.,2,1,1.", "field 4 of MPC is '8'; expected a dof"),
        ("SPC1,1,1,7", "uses grid 7, which is not defined"),
    ],
)
def test_mistakes(tmp_path, cards, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, f"GRID,1\nGRID,2,,1.\n{BLOCK}{cards}\n")


def test_unknown_set_in_the_case_control(tmp_path):
    with pytest.raises(
        InputError, match=r"SPC = 5 in the case control, but no card has this set; expected one of \[1\]"
    ):
        read(tmp_path, f"GRID,1\n{BLOCK}SPC1,1,1,1\n", "SPC = 5\n")


@pytest.mark.parametrize("cid", ["", "5"])
def test_one_dimensional_bushings(tmp_path, cid):
    """K and C along the line of the grids, or along axis 1 of CID; M at both; tables act in nonlinear solutions."""
    frame = "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,.6,.8,0.\n"
    cards = f"{frame}CBUSH1D,3,4,1,2,{cid}\nPBUSH1D,4,50.,2.,.6\n,SPRING,TABLE,7\n"
    model = read(tmp_path, f"GRID,1\nGRID,2,,3.,4.\n{cards}")
    assert unread(model) == {"PBUSH1D, tables": False}
    t = np.array([0.6, 0.8, 0.0])
    np.testing.assert_allclose(matrix(model, "K", 1)[:3, :3], 50.0 * np.outer(t, t), atol=1e-12)
    np.testing.assert_allclose(matrix(model, "C", 2)[:3, :3], 2.0 * np.outer(t, t), atol=1e-12)
    np.testing.assert_allclose(matrix(model, "M", 1)[:3, :3], 0.3 * np.eye(3), atol=1e-12)
    with pytest.raises(InputError, match="CBUSH1D 3 has coincident grids and no CID"):
        read(tmp_path, "GRID,1\nGRID,2\nCBUSH1D,3,4,1,2\nPBUSH1D,4,50.\n")


@pytest.mark.parametrize("dofs", ["", "123"])
def test_rbar1_is_rbe2_of_one_grid(tmp_path, dofs):
    """In turned displacement frames too."""
    grids = TURNED + f"GRID,1,,,,,,123456\nGRID,2,,3.,4.,5.,5\nGRID,3,,3.,9.,5.,5\n{BLOCK}"
    held = "CELAS2,61,50.,3,1\nCELAS2,62,60.,3,2\nCELAS2,63,70.,3,3\nCELAS2,64,80.,2,4\nCELAS2,65,90.,2,5\nCELAS2,66,99.,2,6\n"
    held += "CELAS2,67,80.,3,4\nCELAS2,68,90.,3,5\nCELAS2,69,99.,3,6\n" if dofs else ""
    ours = motion(read(tmp_path, f"{grids}{held}RBAR1,9,2,3,{dofs}\n"), {(3, 1): 1.0, (2, 3): 2.0})
    theirs = motion(read(tmp_path, f"{grids}{held}RBE2,9,2,{dofs or 123456},3\n"), {(3, 1): 1.0, (2, 3): 2.0})
    np.testing.assert_allclose(ours, theirs, atol=1e-12)
