"""CFAST and CWELD: rigid motion free of force, the springs themselves between stiff patches, and each way to name a patch."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.linalg

from creak.arrays import to_dense
from creak.errors import InputError
from creak.model.constraints import Equation
from helpers_nastran import assembled, motion, read, rigid_mass, row, unread

H = 2.0
"""Between the sheets, mm."""
MATERIAL = "MAT1,1,2.+5,,.3,7.8-9\n"


def sheet(base: int, pid: int, z: float, n: int = 4, size: float = 40.0, held: str = "") -> str:
    grids = [
        f"GRID,{base + i * (n + 1) + j},,{size * i / n},{size * j / n},{z},,{held}"
        for i in range(n + 1)
        for j in range(n + 1)
    ]
    shells = []
    for i in range(n):
        for j in range(n):
            a = base + i * (n + 1) + j
            shells.append(f"CQUAD4,{base + n * i + j},{pid},{a},{a + n + 1},{a + n + 2},{a + 1}")
    return "\n".join([*grids, *shells, f"PSHELL,{pid},1,1.5,1,,1", ""])


def deck(fastener: str, held: str = "", top: str = "") -> str:
    return sheet(1001, 1, 0.0, held=held) + sheet(2001, 2, H, n=5, held=top) + MATERIAL + fastener + "\n"


GS = "GRID,9001,,17.,21.,1.,,123456\n"
FAST = "PFAST,7,6.,,,2000.,300.,300.,1.+4\n,2.+4,2.+4,.4\n"
WELD = "PWELD,7,1,6.\n"
WAYS = {
    "CFAST by property": FAST + GS + "CFAST,99,7,PROP,1,2,9001",
    "CFAST by element": FAST + GS + "CFAST,99,7,ELEM,1007,2013,9001",
    "CFAST by place": FAST + "CFAST,99,7,PROP,1,2\n,17.,21.,1.",
    "PARTPAT": WELD + GS + "CWELD,99,7,9001,PARTPAT\n,1,2",
    "ELPAT": WELD + GS + "CWELD,99,7,9001,ELPAT\n,1007,2013",
    "ELEMID": WELD + GS + "CWELD,99,7,9001,ELEMID\n,1007,2013",
    "GRIDID": WELD + GS + "CWELD,99,7,9001,GRIDID,,,QQ\n,1008,1013,1014,1009\n,2015,2021,2022,2016",
    "SPOT": "PWELD,7,1,6.,,,,,SPOT\n" + GS + "CWELD,99,7,9001,PARTPAT\n,1,2",
}


@pytest.mark.parametrize("way", WAYS)
def test_it_joins_the_sheets_and_resists_no_rigid_motion(tmp_path, way):
    """Both sheets and the fastener move as one body without force: six eigenvalues of K are zero, not twelve."""
    model = read(tmp_path, deck(WAYS[way]))
    assert not any(unread(model).values())
    equations = [c for c in model.constraints if isinstance(c, Equation)]
    assert len(equations) == 12
    x = model.nodes.coords
    for omega in np.eye(3):
        u = np.hstack([np.array([0.3, -0.1, 0.2]) + np.cross(omega, x), np.tile(omega, (len(x), 1))])
        for c in equations:
            assert c.coefficients @ u[c.nodes_idx, c.dofs - 1] == pytest.approx(0.0, abs=1e-10)
    K = assembled(model).K
    values = np.linalg.eigvalsh(np.asarray(K.todense() if hasattr(K, "todense") else K))
    assert (np.abs(values) < 1e-9 * values.max()).sum() == 6
    assert [p.name for p in model.parts] == ["PID_1", "PID_2"]


@pytest.mark.parametrize(("dof", "stiffness"), [(1, 300.0), (2, 300.0), (3, 2000.0)])
def test_cfast_between_a_held_and_a_rigid_sheet(tmp_path, dof, stiffness):
    """The sheets are held and rigid (RBE2), the grid moves along an axis alone: force over motion is KT1 along the axis
    and KT2, KT3 across."""
    others = [str(2001 + i) for i in range(36)]
    kept = "".join(str(d) for d in range(1, 7) if d != dof)
    rigid = f"GRID,9002,,17.,21.,1.,,{kept}\n" + _long("RBE2,5,9002,123456", others)
    model = read(tmp_path, deck(WAYS["CFAST by property"], held="123456") + rigid)
    assert motion(model, {(9002, dof): 1.0})[row(model, 9002), dof - 1] == pytest.approx(1.0 / stiffness, rel=1e-9)


@pytest.mark.parametrize(("dof", "stiffness"), [(1, 2000.0), (2, 300.0), (3, 400.0)])
def test_cfast_with_axes_of_its_own(tmp_path, dof, stiffness):
    """The same with MCID = 0 and MFLAG = 1: KT1, KT2, KT3 act along the basic x, y, z, though the fastener lies along z."""
    others = [str(2001 + i) for i in range(36)]
    kept = "".join(str(d) for d in range(1, 7) if d != dof)
    rigid = f"GRID,9002,,17.,21.,1.,,{kept}\n" + _long("RBE2,5,9002,123456", others)
    fast = FAST.replace("6.,,,2000.,300.,300.", "6.,0,1,2000.,300.,400.") + GS + "CFAST,99,7,PROP,1,2,9001\n"
    model = read(tmp_path, deck(fast, held="123456") + rigid)
    assert motion(model, {(9002, dof): 1.0})[row(model, 9002), dof - 1] == pytest.approx(1.0 / stiffness, rel=1e-9)


@pytest.mark.parametrize("axes", ["0,1", "3,1", "3,0"])
def test_springs_alike_in_all_directions_know_no_axes(tmp_path, axes):
    """KT1 = KT2 = KT3 and KR1 = KR2 = KR3: MCID and MFLAG change nothing, on the patches neither; D wider than a shell."""
    skew = "CORD2R,3,,0.,0.,0.,.3,-.5,.4\n,.2,.7,-.1\n"
    place = skew + GS + "CFAST,99,7,PROP,1,2,9001\n"
    alike = "PFAST,7,16.,%s,300.,300.,300.,2.+4\n,2.+4,2.+4\n"
    turned, plain = (assembled(read(tmp_path, deck(alike % a + place))).K for a in (axes, ","))
    turned, plain = (to_dense(K) for K in (turned, plain))
    np.testing.assert_allclose(turned, plain, rtol=0.0, atol=1e-12 * np.abs(plain).max())


def _long(head: str, ids: list[str]) -> str:
    fields = [*head.split(",")[1:], *ids]
    lines = [",".join(["RBE2" if k == 0 else "", *fields[k : k + 8]]) for k in range(0, len(fields), 8)]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("dof", [1, 3, 4, 6])
def test_cweld_is_a_round_shear_flexible_bar(tmp_path, dof):
    """The same against a CBEAM of PBEAML ROD between the piercing points, at the end of one held sheet."""
    others = [str(2001 + i) for i in range(36)]
    joint = "GRID,9002,,17.,21.,2.\n" + _long("RBE2,5,9002,123456", others)
    weld = read(tmp_path, deck(WAYS["PARTPAT"], held="123456") + joint)
    bar = "GRID,9003,,17.,21.,0.,,123456\nCBAR,9,9,9003,9002,1.,0.,0.\nPBARL,9,1,,ROD\n,3.\n"
    beam = read(tmp_path, deck(bar, held="123456") + joint)
    ours, theirs = (motion(m, {(9002, dof): 1.0})[row(m, 9002)] for m in (weld, beam))
    assert np.abs(theirs).max() > 0.0
    np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-9 * np.abs(theirs).max())


def _stiffness(folder, fastener: str) -> list[np.ndarray]:
    """The matrix of each fastener between the sheets."""
    return [b.section.stiffness for b in read(folder, deck(fastener)).blocks if b.kind == "bush2"]


def test_spot_has_half_of_both_thicknesses_as_length(tmp_path):
    """L = (1.5 + 1.5)/2, whatever the distance of the sheets."""
    (k,) = _stiffness(tmp_path, WAYS["SPOT"])
    assert k[0, 0] == pytest.approx(2e5 * math.pi * 9.0 / 1.5)


def test_spot_takes_the_thickness_of_the_shells_that_it_meets(tmp_path):
    """L = (tA + tB)/2 of plies beside the grids (tB = .8 from Z0 = 0 up), and of a shell with T1 to T4 of its own."""
    text = deck(WAYS["SPOT"]).replace("PSHELL,2,1,1.5,1,,1", "PCOMP,2,0.\n,1,.5,0.,,1,.3,90.")
    met = "CQUAD4,1007,1,1008,1013,1014,1009"
    for bulk, length in ((text, 1.15), (text.replace(met, met + "\n,,,1.,1.,2.4,2.4"), 1.25)):
        (k,) = [b.section.stiffness for b in read(tmp_path, bulk).blocks if b.kind == "bush2"]
        assert k[0, 0] == pytest.approx(2e5 * math.pi * 9.0 / length)


def test_spot_between_grids_is_as_long_as_it_is(tmp_path):
    """GRIDID names no shells whose thickness could be the length: EA/L of the distance of the patches, of 2 mm."""
    (k,) = _stiffness(tmp_path, WAYS["GRIDID"].replace(WELD, "PWELD,7,1,6.,,,,,SPOT\n"))
    assert k[0, 0] == pytest.approx(2e5 * math.pi * 9.0 / H)


@pytest.mark.parametrize("way", ["PARTPAT", "ELPAT", "ELEMID", "GRIDID", "SPOT of GRIDID"])
@pytest.mark.parametrize(
    ("d", "limits", "length"),
    [
        (16.0, "", 3.2),
        (0.2, "", 1.0),
        (16.0, ",.1", 2.0),
        (16.0, ",.3,.4", 4.8),
        (0.25, ",,4.", 1.0),
        (0.2, ",,12.", 2.0),
    ],
)
def test_a_weld_is_neither_stubbier_nor_more_slender_than_its_limits(tmp_path, way, d, limits, length):
    """EA/L and EI/L with L = 2 mm between the sheets, but at least LDMIN D and at most LDMAX D (.2 and 5)."""
    kind = "SPOT" if "SPOT" in way else ""
    pweld = f"PWELD,7,1,{d},,,,,{kind}\n{limits}\n"
    (k,) = _stiffness(tmp_path, WAYS[way.split()[-1]].replace(WELD, pweld))
    E, area, inertia = 2e5, math.pi * d**2 / 4.0, math.pi * d**4 / 64.0
    phi = 12.0 * E * inertia / (0.9 * E / 2.6 * area * length**2)
    across = 12.0 * E * inertia / (length**3 * (1.0 + phi))
    bend, turn = E * inertia / length, E / 2.6 * 2.0 * inertia / length
    np.testing.assert_allclose(np.diag(k), [E * area / length, across, across, turn, bend, bend], rtol=1e-12)


def test_mass_of_a_cfast(tmp_path):
    plain = rigid_mass(read(tmp_path, deck("")))[0, 0]
    assert rigid_mass(read(tmp_path, deck(WAYS["CFAST by property"])))[0, 0] == pytest.approx(plain + 0.4)


def test_a_grid_on_a_patch_and_two_grids(tmp_path):
    """ELEMID without the second shell joins GS itself; ALIGN joins two vertex grids."""
    point = "GRID,9001,,17.,21.,2.\nGRID,9002,,17.,21.,9.\nCBAR,8,8,9001,9002,1.,0.,0.\nPBARL,8,1,,ROD\n,3.\n"
    model = read(tmp_path, sheet(1001, 1, 0.0) + MATERIAL + point + WELD + "CWELD,99,7,9001,ELEMID\n,1007\n")
    assert len(model.constraints) == 6
    model = read(tmp_path, deck(WELD + "CWELD,99,7,,ALIGN,1013,2015"))
    assert not model.constraints
    assert sum(b.ids.size for b in model.blocks if b.kind == "bush2") == 1


ENDS = "GRID,9003,,17.,21.,0.,,{ps}\nGRID,9004,,17.,21.,2.,,{ps}\n"
GIVEN = {
    "CFAST": FAST + "CFAST,99,7,PROP,1,2,,9003,9004\n",
    "CWELD": WELD + "CWELD,99,7,,PARTPAT,9003,9004\n,1,2\n",
    "MSET = ON": "PWELD,7,1,6.,,,ON\nCWELD,99,7,,ELEMID,9003,9004\n,1007,2013\n",
}


@pytest.mark.parametrize("way", GIVEN)
def test_what_hangs_on_ga_and_gb_hangs_on_the_patches(tmp_path, way):
    """A force on GB moves the rigid upper sheet by 1/k along the fastener; GA stays with the lower sheet, which is held."""
    others = [str(2001 + i) for i in range(36)]
    rigid = ENDS.format(ps="") + "GRID,9002,,17.,21.,1.,,12456\n" + _long("RBE2,5,9002,123456", others)
    model = read(tmp_path, deck(GIVEN[way] + rigid, held="123456"))
    assert not any(unread(model).values())
    u = motion(model, {(9004, 3): 1.0, (9003, 3): 1.0})
    flexible = 1.0 / 2000.0 if way == "CFAST" else H / (2e5 * math.pi * 9.0)
    assert u[row(model, 9004), 2] == pytest.approx(flexible, rel=1e-9)
    assert u[row(model, 9002), 2] == pytest.approx(flexible, rel=1e-9)
    assert u[row(model, 9003), 2] == pytest.approx(0.0, abs=1e-12 * flexible)


def test_a_matrix_of_the_deck_hangs_on_gb(tmp_path):
    """K2GG that joins GA, GB and another grid: its springs of 500 from each to the next stand beside KT1 = 2000."""
    others = [str(2001 + i) for i in range(36)]
    rigid = ENDS.format(ps="") + "GRID,9002,,17.,21.,1.,,12456\n" + _long("RBE2,5,9002,123456", others)
    rigid += "GRID,9005,,0.,0.,0.,,12456\nDMIG,KX,0,6,1,0\n"
    for a, b, value in ((9003, 9003, 500.0), (9003, 9005, -500.0), (9005, 9005, 1000.0), (9004, 9005, -500.0)):
        rigid += f"DMIG,KX,{b},3,,{a},3,{value}\n"
    rigid += "DMIG,KX,9004,3,,9004,3,500.\n"
    model = read(tmp_path, deck(GIVEN["CFAST"] + rigid, held="123456"), case="K2GG = KX\n")
    assert motion(model, {(9004, 3): 1.0})[row(model, 9002), 2] == pytest.approx(1.0 / 2250.0, rel=1e-9)


def test_a_mass_on_gb_moves_as_the_mean_of_its_shell(tmp_path):
    """In the middle of a square shell that is the mean of its four corners: the same 1/omega^2 with an RBE3 for it,
    which leaves GB nothing to follow."""
    sheets = sheet(1, 1, 0.0, n=1, held="123456") + sheet(11, 2, H, n=1) + MATERIAL
    ends = "GRID,9003,,20.,20.,0.\nGRID,9004,,20.,20.,2.\nCONM2,50,9004,,1.-4\n"
    rbe3 = "RBE3,60,,9004,123456,1.,123,11,12\n,13,14\n"
    values = []
    for more in ("", rbe3):
        system = assembled(read(tmp_path, sheets + ends + GIVEN["CWELD"] + more))
        values.append(scipy.linalg.eigh(to_dense(system.M), to_dense(system.K), eigvals_only=True)[-12:])
    np.testing.assert_allclose(*values, rtol=1e-8)


@pytest.mark.parametrize(
    ("ends", "way", "stops"),
    [("held", "CFAST", False), ("held", "CWELD", False), ("held", "MSET = ON", True), ("corner", "CWELD", None)],
)
def test_a_grid_that_cannot_follow_gives_its_place_alone(tmp_path, ends, way, stops):
    """Held (PS), or a corner of the patch: K is that of the same fastener without GA and GB."""
    given = ENDS.format(ps="123456") + GIVEN[way]
    free = GIVEN[way].replace("9003", "").replace("9004", "")
    free = free.replace("PROP,1,2,,", "PROP,1,2,9001") if way == "CFAST" else free.replace("99,7,,", "99,7,9001,")
    place = GS
    if ends == "corner":
        given, place = given.replace("9003,9004", "1013,"), GS.replace("17.,21.,1.", "20.,20.,0.")
    ours, theirs = (read(tmp_path, deck(text)) for text in (given, place + free))
    K, plain = (to_dense(assembled(model).K) for model in (ours, theirs))
    np.testing.assert_allclose(K, plain, rtol=0.0, atol=1e-12 * np.abs(plain).max())
    assert [flag for what, flag in unread(ours).items() if "GA or GB" in what] == ([] if stops is None else [stops])


def test_fasteners_that_share_a_grid(tmp_path):
    """GB of one is GB of another: it follows the first, and binds the patches no further than six springs each."""
    second = "PFAST,8,9.,,,2000.,300.,300.,1.+4\n,2.+4,2.+4\nCFAST,98,8,PROP,1,2,,9003,9004\n"
    apart = second.replace("9003,9004", "").replace("PROP,1,2,,", "PROP,1,2,9001")
    ours, theirs = (read(tmp_path, deck(ENDS.format(ps="") + GIVEN["CFAST"] + GS + t)) for t in (second, apart))
    K, plain = (to_dense(assembled(model).K) for model in (ours, theirs))
    np.testing.assert_allclose(K, plain, rtol=0.0, atol=1e-12 * np.abs(plain).max())


@pytest.mark.parametrize(
    ("fastener", "message"),
    [
        (FAST + GS + "CFAST,99,7,PROP,1,5,9001", "joins property 5, which has no shells"),
        (FAST + "CFAST,99,7,PROP,1,2", "CFAST 99 has no place"),
        (FAST + GS + "CFAST,99,8,PROP,1,2,9001", "uses property 8, which is not defined; expected a PFAST"),
        (FAST + GS + "CFAST,99,7,PART,1,2,9001", "field 4 of CFAST is 'PART'; expected PROP or ELEM"),
        (WELD + GS + "CWELD,99,7,9001,ALIGN", "CWELD 99 has no GA and GB"),
        ("PWELD,7,1,0.\n" + GS + "CWELD,99,7,9001,PARTPAT\n,1,2", "has diameter 0"),
        (WELD + ",.6,.5\n" + GS + "CWELD,99,7,9001,PARTPAT\n,1,2", "PWELD 7 has LDMIN 0.6 and LDMAX 0.5"),
        ("PWELD,7,1,6.\n,DTAB,5\n" + GS + "CWELD,99,7,9001,PARTPAT\n,1,2", "PWELD is 'DTAB'; expected a real number"),
        (FAST + GS.replace("17.,21.", "99.,99.") + "CFAST,99,7,PROP,1,2,9001", "CFAST 99 lies .* beside a patch"),
    ],
)
def test_mistakes(tmp_path, fastener, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, deck(fastener))


@pytest.mark.parametrize(("way", "loss"), [("CFAST by property", 0.6), ("PARTPAT", 0.9)])
def test_damping(tmp_path, way, loss):
    """GE/W4 + G/W3 of PFAST, or of a weld's material; the mass of PFAST follows ALPHA1."""
    text = deck(WAYS[way]).replace(",.4\n", ",.4,.6\n").replace("7.8-9\n", "7.8-9,,,.9\n")
    model = read(tmp_path, text + "PARAM,W4,30.\nPARAM,G,.1\nPARAM,W3,50.\nPARAM,ALPHA1,2.\n")
    betas = [b.section.beta for b in model.blocks if b.kind == "bush2"]
    assert betas == [pytest.approx(loss / 30.0 + 0.1 / 50.0, rel=1e-14)]
    assert {b.section.alpha for b in model.blocks if b.kind == "mass"} == ({2.0} if loss == 0.6 else set())
