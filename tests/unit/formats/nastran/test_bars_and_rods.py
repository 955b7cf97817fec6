"""CBAR, CBEAM, CROD, CTUBE: each field against the closed form of a loaded bar."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.errors import InputError
from helpers_nastran import assembled, matrix, motion, read, rigid_mass, unread

RECORDED = {"section": "beams and solids"}

E, G, L = 2.0e5, 8.0e4, 100.0
A, I1, I2, J = 50.0, 400.0, 150.0, 320.0
MATERIAL = f"MAT1,1,{E},{G},,7.8-9\n"
PBAR = f"PBAR,1,1,{A},{I1},{I2},{J}\n"
GRIDS = f"GRID,1,,0.,0.,0.\nGRID,2,,{L},0.,0.\nSPC1,1,123456,1\n"
EXACT = 1e-9


def cantilever(tmp_path, element="CBAR,1,1,1,2,0.,1.,0.", bar=PBAR, grids=GRIDS):
    return read(tmp_path, grids + element + "\n" + bar + MATERIAL)


@pytest.mark.parametrize(
    ("dof", "stiffness"), [(1, E * A / L), (2, 3 * E * I1 / L**3), (3, 3 * E * I2 / L**3), (4, G * J / L)]
)
def test_cantilever(tmp_path, dof, stiffness):
    """Plane 1 holds the orientation vector: I1 resists the load along it. Bars are exact under end loads."""
    u = motion(cantilever(tmp_path), {(2, dof): 7.0})
    assert u[1, dof - 1] == pytest.approx(7.0 / stiffness, rel=EXACT)


@pytest.mark.parametrize("element", ["CBAR,1,1,1,2,9", "CBAR,1,1,1,2,0.,0.,-3.", "CBAR,1,,1,2,\nBAROR,,1,,,0.,0.,1."])
def test_orientation(tmp_path, element):
    """A grid, a vector or the default of BAROR turn plane 1 to z."""
    u = motion(cantilever(tmp_path, element, grids=GRIDS + "GRID,9,,5.,0.,8.,,123456\n"), {(2, 3): 7.0})
    assert u[1, 2] == pytest.approx(7.0 * L**3 / (3 * E * I1), rel=EXACT)


def test_orientation_in_the_displacement_frame(tmp_path):
    """X1, X2, X3 are in the frame of GA: its y is the basic z; OFFT = BGG takes the basic frame."""
    frame = "CORD2R,5,,0.,0.,0.,0.,-1.,0.\n,1.,0.,0.\n"
    grids = frame + GRIDS.replace("GRID,1,,0.,0.,0.", "GRID,1,,0.,0.,0.,5")
    u = motion(cantilever(tmp_path, grids=grids), {(2, 3): 7.0})
    assert u[1, 2] == pytest.approx(7.0 * L**3 / (3 * E * I1), rel=EXACT)
    u = motion(cantilever(tmp_path, "CBAR,1,1,1,2,0.,1.,0.,BGG", grids=grids), {(2, 3): 7.0})
    assert u[1, 2] == pytest.approx(7.0 * L**3 / (3 * E * I2), rel=EXACT)


def test_shear(tmp_path):
    """P L^3/(3 E I) + P L/(K A G); PBEAM has K1 = K2 = 1 unless it says otherwise."""
    bar = PBAR.strip() + ",\n,\n,.5,.25\n"
    model = cantilever(tmp_path, bar=bar)
    for dof, i, k in ((2, I1, 0.5), (3, I2, 0.25)):
        assert motion(model, {(2, dof): 1.0})[1, dof - 1] == pytest.approx(
            L**3 / (3 * E * i) + L / (k * A * G), rel=EXACT
        )
    model = cantilever(tmp_path, "CBEAM,1,1,1,2,0.,1.,0.", f"PBEAM,1,1,{A},{I1},{I2},,{J}\n")
    assert motion(model, {(2, 2): 1.0})[1, 1] == pytest.approx(L**3 / (3 * E * I1) + L / (A * G), rel=EXACT)


EXACT_SHEAR = {
    "I": ("100.,60.,60.,4.,6.,6.", 0.343, 0.568),
    "BOX": ("60.,100.,3.,2.", 0.491, 0.321),
    "T": ("14.,20.,2.,3.", 0.600, 0.361),
    "H": ("10.,4.,20.,3.", 0.655, 0.280),
    "CROSS": ("12.,3.,20.,2.5", 0.597, None),
    "CHAN": ("40.,100.,3.,4.", 0.436, None),
}
"""Dimensions and shear areas over area along y and z, by finite elements over the section (sectionproperties 3.10)."""


@pytest.mark.parametrize("kind", EXACT_SHEAR)
@pytest.mark.parametrize("form", ["PBARL", "PBEAML"])
def test_shear_of_shapes(tmp_path, kind, form):
    """Nastran computes shear factors from the shape: P L/(K A G) on top of bending, within a third of the exact one."""
    dims, *exact = EXACT_SHEAR[kind]
    model = cantilever(tmp_path, f"C{form[1:-1]},1,1,1,2,0.,1.,0.", f"{form},1,1,,{kind}\n,{dims}\n")
    section = model.blocks[0].section
    for dof, factor, inertia in zip((2, 3), exact, (section.i22, section.i11), strict=True):
        shear = motion(model, {(2, dof): 1.0})[1, dof - 1] - L**3 / (3 * E * inertia)
        assert factor is None or shear == pytest.approx(L / (factor * section.area * G), rel=1 / 3)


def test_product_of_inertia(tmp_path):
    """Unsymmetric bending: (u_y, u_z) = P L^3/(3 E) [I1 I12; I12 I2]^-1 e_y, I12 = integral of y z."""
    i12 = 120.0
    u = motion(cantilever(tmp_path, bar=PBAR.strip() + f",\n,\n,,,{i12}\n"), {(2, 2): 1.0})
    wanted = L**3 / (3 * E) * np.linalg.solve([[I1, i12], [i12, I2]], [1.0, 0.0])
    np.testing.assert_allclose(u[1, 1:3], wanted, rtol=EXACT)


def test_a_beam_with_a_product_of_inertia_keeps_its_shear(tmp_path):
    """K1, K2 of a PBAR are left out beside I12, those of a PBEAM (default 1) are not: P L/(K A G) on top of bending."""
    beam = f"PBEAM,1,1,{A},{I1},{I2},120.,{J}\n"
    u = motion(cantilever(tmp_path, "CBEAM,1,1,1,2,0.,1.,0.", beam), {(2, 2): 1.0})
    wanted = L**3 / (3 * E) * np.linalg.solve([[I1, 120.0], [120.0, I2]], [1.0, 0.0]) + [L / (A * G), 0.0]
    np.testing.assert_allclose(u[1, 1:3], wanted, rtol=EXACT)


def test_offsets(tmp_path):
    """A bar at height e above its grids: the axial force at the grid bends it, u = P L/(E A) + P e^2 L/(E I)."""
    e = 4.0
    u = motion(cantilever(tmp_path, f"CBAR,1,1,1,2,0.,1.,0.\n,,,0.,{e},0.,0.,{e},0."), {(2, 1): 6.0})
    assert u[1, 0] == pytest.approx(6.0 * L / (E * A) + 6.0 * e**2 * L / (E * I1), rel=EXACT)
    assert u[1, 5] == pytest.approx(6.0 * e * L / (E * I1), rel=EXACT)


def test_offsets_of_both_ends(tmp_path):
    """Offsets along the bar shorten it; in the element's own axes (OFFT = GOO) as in the basic ones."""
    for offt in ("GGG", "GOO"):
        element = f"CBAR,1,1,1,2,0.,1.,0.,{offt}\n,,,10.,0.,0.,-30.,0.,0."
        u = motion(cantilever(tmp_path, element), {(2, 4): 1.0})
        assert u[1, 3] == pytest.approx((L - 40.0) / (G * J), rel=EXACT)


@pytest.mark.parametrize("offt", ["GOO", "GEE", "goe", "GGG"])
def test_offsets_in_the_axes_of_the_bar(tmp_path, offt):
    """Plane 1 is the basic x, z one: an offset along y of the bar (O, or E by its older name) lifts it in z, and I1
    resists; along the y of the grids (G) it lies beside, and I2 does: u = P L/(E A) + P e^2 L/(E I)."""
    e, inertia = 4.0, I2 if offt == "GGG" else I1
    element = f"CBAR,1,1,1,2,0.,0.,1.,{offt}\n,,,0.,{e},0.,0.,{e},0."
    u = motion(cantilever(tmp_path, element), {(2, 1): 6.0})
    assert u[1, 0] == pytest.approx(6.0 * L / (E * A) + 6.0 * e**2 * L / (E * inertia), rel=EXACT)


@pytest.mark.parametrize("offt", ["XYZ", "EGG", "OOO", "GGB", "GG", "GGGG", "2", ".5"])
def test_an_unknown_offt_is_refused(tmp_path, offt):
    wanted = rf"field 9 of CBAR is '{re.escape(offt)}'; expected OFFT: G or B, then G or O .*\. Give the orientation"
    with pytest.raises(InputError, match=r"deck\.bdf:8: " + wanted):
        cantilever(tmp_path, f"CBAR,1,1,1,2,0.,1.,0.,{offt}")
    with pytest.raises(InputError, match=r"deck\.bdf:9: " + wanted.replace("CBAR", "BAROR")):
        cantilever(tmp_path, f"CBAR,1,1,1,2,0.,1.,0.\nBAROR,,,,,,,,{offt}")


def test_pins(tmp_path):
    """A released bending at end B leaves 3 E I/L^3 where the rotations of the grid are held, a released axis nothing."""
    held = GRIDS + "SPC1,1,3456,2\n"
    u = motion(cantilever(tmp_path, "CBAR,1,1,1,2,0.,1.,0.\n,,6", grids=held), {(2, 2): 7.0})
    assert u[1, 1] == pytest.approx(7.0 * L**3 / (3 * E * I1), rel=EXACT)
    u = motion(cantilever(tmp_path, "CBAR,1,1,1,2,0.,1.,0.", grids=held), {(2, 2): 7.0})
    assert u[1, 1] == pytest.approx(7.0 * L**3 / (12 * E * I1), rel=EXACT)


def test_pins_of_a_slanted_bar(tmp_path):
    """The released direction is the bar's own: 45 degrees in the plane."""
    s = L / math.sqrt(2.0)
    grids = f"GRID,1,,0.,0.,0.\nGRID,2,,{s},{s},0.\nSPC1,1,123456,1\nSPC1,1,3456,2\n"
    u = motion(cantilever(tmp_path, "CBAR,1,1,1,2,0.,0.,1.\n,,5", grids=grids), {(2, 1): -1.0, (2, 2): 1.0})
    assert u[1, 1] == pytest.approx(L**3 / (3 * E * I2), rel=EXACT)
    assert u[1, 0] == pytest.approx(-u[1, 1], rel=EXACT)


def test_rods(tmp_path):
    """CROD and CONROD carry force, and torque where J > 0; CTUBE by its diameter and wall."""
    held = GRIDS + "SPC1,1,2356,2\n"
    for element in (f"CROD,1,1,1,2\nPROD,1,1,{A},{J}", f"CONROD,1,1,2,1,{A},{J}"):
        model = read(tmp_path, held + element + "\n" + MATERIAL)
        assert motion(model, {(2, 1): 1.0})[1, 0] == pytest.approx(L / (E * A), rel=EXACT)
        assert motion(model, {(2, 4): 1.0})[1, 3] == pytest.approx(L / (G * J), rel=EXACT)
    model = read(tmp_path, held + "CTUBE,1,1,1,2\nPTUBE,1,1,10.,1.\n" + MATERIAL)
    assert motion(model, {(2, 1): 1.0})[1, 0] == pytest.approx(L / (E * math.pi * 9.0), rel=EXACT)
    assert motion(model, {(2, 4): 1.0})[1, 3] == pytest.approx(L / (G * math.pi / 32.0 * (1e4 - 8.0**4)), rel=EXACT)


@pytest.mark.parametrize(
    ("shape", "area", "i1", "i2"),
    [
        ("ROD\n,3.", 9 * math.pi, 81 * math.pi / 4, 81 * math.pi / 4),
        ("TUBE\n,3.,2.", 5 * math.pi, 65 * math.pi / 4, 65 * math.pi / 4),
        ("BAR\n,2.,6.", 12.0, 36.0, 4.0),
        ("BOX\n,10.,20.,1.,2.", 92.0, (10 * 8000 - 6 * 18**3) / 12, (20 * 1000 - 18 * 216) / 12),
        ("I\n,20.,10.,10.,1.,2.,2.", 56.0, (10 * 8000 - 9 * 4096) / 12, (4 * 1000 + 16) / 12),
        ("T\n,10.,12.,2.,1.", 30.0, 10 * 8 / 12 + 20 * 4 + 1000 / 12 + 10 * 16, 2000 / 12 + 10 / 12),
        ("T2\n,10.,12.,2.,1.", 30.0, 10 * 8 / 12 + 20 * 4 + 1000 / 12 + 10 * 16, 2000 / 12 + 10 / 12),
        ("T1\n,10.,10.,2.,1.", 30.0, 2000 / 12 + 10 / 12, 10 * 8 / 12 + 20 * 4 + 1000 / 12 + 10 * 16),
        ("TUBE2\n,3.,1.", 5 * math.pi, 65 * math.pi / 4, 65 * math.pi / 4),
        ("BOX1\n,10.,20.,1.,1.,2.,2.", 92.0, (10 * 8000 - 6 * 18**3) / 12, (20 * 1000 - 18 * 216) / 12),
        ("H\n,6.,4.,20.,1.", 86.0, (4 * 8000 + 6) / 12, (20 * 1000 - 19 * 216) / 12),
        ("CHAN1\n,8.,2.,16.,20.", 72.0, (10 * 8000 - 8 * 4096) / 12, 4000 / 12 + 128 / 12 + 40 * 32 / 72 * 16),
        ("CHAN2\n,2.,2.,10.,20.", 72.0, 4000 / 12 + 128 / 12 + 40 * 32 / 72 * 16, (10 * 8000 - 8 * 4096) / 12),
        ("CROSS\n,8.,2.,20.,4.", 72.0, (2 * 8000 + 8 * 64) / 12, (4 * 1000 + 16 * 8) / 12),
        ("HAT\n,10.,1.,8.,5.", 36.0, 483.0, 708.0),
    ],
)
def test_shapes(tmp_path, shape, area, i1, i2):
    """Area and moments of PBARL (width along z, height along y), from rectangles and circles."""
    section = cantilever(tmp_path, bar=f"PBARL,1,1,,{shape}\n").blocks[0].section
    assert (section.area, section.i22, section.i11) == pytest.approx((area, i1, i2), rel=1e-12)


def test_principal_axes_of_a_z(tmp_path):
    """Two flanges of 10 x 2 beside a web of 2 x 20: the product of inertia turns the axes."""
    section = cantilever(tmp_path, bar="PBARL,1,1,,Z\n,10.,2.,16.,20.\n").blocks[0].section
    i1, i2, i12 = (
        2 * 8000 / 12 + 2 * (10 * 8 / 12 + 20 * 81),
        20 * 8 / 12 + 2 * (2 * 1000 / 12 + 20 * 36),
        -2 * 20 * 9 * 6,
    )
    larger, smaller = (0.5 * (i1 + i2) + sign * math.hypot(0.5 * (i1 - i2), i12) for sign in (1, -1))
    assert (section.area, section.i22, section.i11) == pytest.approx((80.0, larger, smaller), rel=1e-12)
    assert math.tan(2.0 * section.angle) == pytest.approx(2.0 * i12 / (i1 - i2))


def test_torsion_of_shapes(tmp_path):
    """A square has J = 0.1406 a^4 (Timoshenko), a thin box 2 t a^3-like by Bredt; the series is good to 0.3 %."""
    square = cantilever(tmp_path, bar="PBARL,1,1,,BAR\n,2.,2.\n").blocks[0].section
    assert square.torsion == pytest.approx(0.1406 * 16.0, rel=3e-3)
    box = cantilever(tmp_path, bar="PBARL,1,1,,BOX\n,10.,10.,.1,.1\n").blocks[0].section
    assert box.torsion == pytest.approx(0.1 * 9.9**3, rel=1e-9)


def test_beam_stations(tmp_path):
    """YESA without stress points, then K1, K2."""
    bar = f"PBEAM,1,1,{A},{I1},{I2},,{J},\n,1.,1.,1.,1.,1.,1.,1.,1.\n,YESA,1.0\n,.5,.25\n"
    section = cantilever(tmp_path, "CBEAM,1,1,1,2,0.,1.,0.", bar).blocks[0].section
    assert (section.shear_area1, section.shear_area2) == pytest.approx((0.5 * A, 0.25 * A))


E_STEEL, RHO = 7e4, 2.7e-9


@pytest.mark.parametrize(
    "card",
    [
        "PBEAM,1,1,100.,{0},{0},,{1}\n,,,,,,,,\n,YES,1.,50.,{2},{2},,{3}\n,,,,,,,,\n,1.E9,1.E9\n",
        "PBEAM,1,1,100.,{0},{0},,{1}\n,,,,,,,,\n,NO,.5,75.,{4},{4},,{5}\n,NO,1.,50.,{2},{2},,{3}\n,1.E9,1.E9\n",
    ],
)
def test_a_tapered_beam_bends_as_its_sections_say(tmp_path, card, measured):
    """Tip deflection of a cantilever whose I falls linearly to an eighth: the integral of P (L - x)^2 / E I(x), and its
    stretch ln(A0/A1) P L / (E (A0 - A1)); the mass that of the mean area."""
    I0, I1, length = 800.0, 100.0, 500.0
    text = card.format(I0, 1600.0, I1, 200.0, 0.5 * (I0 + I1), 900.0)
    grids = "GRID,1,,0.,0.,0.\nGRID,2,,500.,0.,0.\nSPC1,1,123456,1\nMAT1,1,7.E4,,.3,2.7E-9\n"
    model = read(tmp_path, grids + "CBEAM,7,1,1,2,0.,1.,0.\n" + text)
    assert not any(u.changes_answer for u in model.unread)
    tip = [motion(model, {(2, 1 + d): 1.0})[1, d] for d in (0, 1)]
    x, w = np.polynomial.legendre.leggauss(40)
    x, w = 0.5 * length * (x + 1.0), 0.5 * length * w
    bent = float(w @ ((length - x) ** 2 / (E_STEEL * (I0 + (I1 - I0) * x / length))))
    stretched = np.log(2.0) * length / (E_STEEL * 50.0)
    for k, (name, exact, rel) in enumerate((("stretch", stretched, 1e-9), ("deflection", bent, 5e-3))):
        what, source = f"tapered CBEAM: {name} of the tip", "integral over the sections"
        measured(what, tip[k], exact, rel=rel, unit="mm/N", source=source)
    assert rigid_mass(model)[0, 0] == pytest.approx(RHO * 75.0 * length, rel=1e-9)
    ids = sorted(int(i) for b in model.blocks for i in b.ids)
    assert ids[0] == 7
    assert sum(b.ids.size for b in model.blocks) == len(set(ids)) == model.element_sets["PID_1"].shape[0]


def test_a_taper_by_dimensions(tmp_path):
    """BAR 10 x 20 to 5 x 10: areas 200 and 50, and the pieces' own in between."""
    bar = "PBEAML,1,1,,BAR\n,10.,20.,,YES,1.,5.,10.\n"
    model = cantilever(tmp_path, "CBEAM,1,1,1,2,0.,1.,0.", bar)
    areas = [b.section.area for b in model.blocks]
    assert areas == sorted(areas, reverse=True)
    assert 180.0 < areas[0] < 200.0
    assert 50.0 < areas[-1] < 65.0
    assert {u: c for u, c in unread(model).items() if "taper" in u} == {"PBEAML 1, taper": False}


@pytest.mark.parametrize("x", ["1.5", "-.5"])
def test_stations_beyond_the_ends_are_told(tmp_path, x):
    bar = f"PBEAM,1,1,{A},{I1},{I2},,{J}\n,,,,,,,,\n,NO,{x},70.\n"
    with pytest.raises(InputError, match="X/XB between 0 and 1"):
        cantilever(tmp_path, "CBEAM,1,1,1,2,0.,1.,0.", bar)


def test_mass(tmp_path):
    """rho A L + NSM L, times WTMASS; half at each end unless COUPMASS, then (5, 1; 1, 5)/12 along the axis."""
    bar = PBAR.strip() + ",.002\n"
    total = (7.8e-9 * A + 0.002) * L
    model = cantilever(tmp_path, bar=bar + "PARAM,WTMASS,2.\n")
    M = to_dense(assembled(model).M)
    assert rigid_mass(model)[0, 0] == pytest.approx(2.0 * total)
    assert M.diagonal().max() == pytest.approx(total)
    axial = assembled(cantilever(tmp_path, bar=bar + "PARAM,COUPMASS,1\n"))
    x = axial.coordinates.tolist().index(6)
    assert to_dense(axial.M)[x, x] == pytest.approx(total * 5.0 / 12.0)


@pytest.mark.parametrize(
    ("element", "message"),
    [
        ("CBAR,1,1,1,1,0.,1.,0.", "uses a grid twice"),
        ("CBAR,1,1,1,2,1.,0.,0.", "orientation vector of CBAR 1 lies along it"),
        ("CBAR,1,1,1,2", "no orientation vector"),
        ("CBAR,1,7,1,2,0.,1.,0.", "uses property 7, which is not defined; expected a PBAR or PBARL"),
        ("CBAR,1,1,1,3,0.,1.,0.", "uses grid 3, which is not defined"),
        ("CBAR,1,1,1,2,0.,1.,0.\n,,,,,,-100.", "has zero length"),
        ("CBAR,1,1,1,2,0.,1x,0.", "field 7 of CBAR is '1x'; expected a real number"),
        ("CBAR,1,1,1,2,0.,1.,0.\nCBAR,1,1,1,2,0.,1.,0.", "element 1 .CBAR. is defined twice, first at .*deck.bdf:"),
    ],
)
def test_mistakes(tmp_path, element, message):
    with pytest.raises(InputError, match=message):
        cantilever(tmp_path, element)


def test_no_material(tmp_path):
    with pytest.raises(InputError, match=r"deck\.bdf:9: PBAR 1 uses material 3, which is not defined"):
        cantilever(tmp_path, bar=PBAR.replace("PBAR,1,1", "PBAR,1,3"))


@pytest.mark.parametrize("rod", [f"CONROD,1,2,3,1,{A}", f"CROD,1,5,2,3\nPROD,5,1,{A},{J},,.01"])
def test_rods_couple_their_mass_along_the_axis_only(tmp_path, rod):
    """PARAM,COUPMASS: 5/12 and 1/12 of the mass along the rod, a half at each end across it, nothing on rotations."""
    line = f"GRID,2,,0.,0.,0.\nGRID,3,,{0.6 * L},{0.8 * L},0.\n"
    model = read(tmp_path, f"{line}{rod}\nPARAM,COUPMASS,1\n{MATERIAL}")
    m = L * (7.8e-9 * A + (0.01 if "PROD" in rod else 0.0))
    M = matrix(model, "M", 2)
    along, across = np.array([0.6, 0.8, 0.0]), np.array([0.8, -0.6, 0.0])
    np.testing.assert_allclose(M[:3, :3] @ along, 5.0 / 12.0 * m * along, atol=EXACT * m)
    np.testing.assert_allclose(M[:3, :3] @ across, 0.5 * m * across, atol=EXACT * m)
    assert M[2, 2] == pytest.approx(0.5 * m)
    assert not M[3:].any()
    np.testing.assert_allclose(rigid_mass(model)[:3, :3], m * np.eye(3), rtol=EXACT, atol=EXACT * m)


@pytest.mark.parametrize(
    ("card", "mean"),
    [
        ("PBEAM,1,1,10.,9.,9.,,9.,.6\n,,,,,,,,\n,YES,1.,,,,,,0.\n", 10.0 + 0.3),
        ("PBEAM,1,1,10.,9.,9.,,9.,.6\n,NO,1.\n", 10.0 + 0.6),
        ("PBEAM,1,1,10.,9.,9.,,9.,.6\n,NO,.5,,,,,,0.\n,NO,1.,,,,,,.2\n", 10.0 + 0.5 * 0.3 + 0.5 * 0.1),
        ("PBEAM,1,1,10.,9.,9.,,9.,.6\n,NO,.5\n,NO,1.,,,,,,0.\n", 10.0 + 0.3),
        ("PBEAM,1,1,10.,9.,9.,,9.,.6\n,NO,1.,6.\n", 8.0 + 0.6),
        ("PBEAML,1,1,,BAR\n,10.,5.,,YES,1.,,2.5\n", 37.5),
        ("PBEAML,1,1,,BAR\n,10.,5.,,YES,1.,6.\n", 40.0),
        ("PBEAML,1,1,,BAR\n,10.,5.,.6,YES,1.,,2.5\n", 37.5 + 0.6),
        ("PBEAML,1,1,,BAR\n,10.,5.,.6,YES,1.,,2.5,0.\n", 37.5 + 0.3),
        ("PBEAML,1,1,,BAR\n,10.,5.,.6,YES,.5,,,\n,NO,1.,,2.5,0.\n", 37.5 + 0.3),
        ("PBEAML,1,1,,BAR\n,10.,5.,.6,YES,.25,,3.,.2\n,NO,1.,,2.5\n", 0.25 * 40.4 + 0.75 * 27.9),
        ("PBEAML,1,1,,BAR\n,10.,5.,.6,YES,1.\n", 50.6),
    ],
)
def test_blank_fields_of_stations_and_zeros(tmp_path, card, mean):
    """Blank is what end A has (between the ends: linear), 0. is zero; the mass is that of the mean of A + NSM."""
    grids = "GRID,1,,0.,0.,0.\nGRID,2,,100.,0.,0.\nMAT1,1,7.E4,,.3,1.\n"
    model = read(tmp_path, f"{grids}CBEAM,7,1,1,2,0.,1.,0.\n{card}")
    assert rigid_mass(model)[0, 0] == pytest.approx(mean * 100.0, rel=1e-9)


def test_a_blank_dimension_of_end_b_is_that_of_end_a(tmp_path):
    """Tip deflection of a BAR 10 x 5 whose height falls to 2.5: the integral of P x^2 / E I between linear I1."""
    bar = "PBEAML,1,1,,BAR\n,10.,5.,,YES,1.,,2.5\n"
    grids = "GRID,1,,0.,0.,0.\nGRID,2,,500.,0.,0.\nSPC1,1,123456,1\nMAT1,1,7.E4,,.3\n"
    model = read(tmp_path, f"{grids}CBEAM,7,1,1,2,0.,1.,0.\n{bar}")
    I0, I1, length = 10.0 * 5.0**3 / 12.0, 10.0 * 2.5**3 / 12.0, 500.0
    x, w = np.polynomial.legendre.leggauss(40)
    x, w = 0.5 * length * (x + 1.0), 0.5 * length * w
    bent = float(w @ ((length - x) ** 2 / (E_STEEL * (I0 + (I1 - I0) * x / length))))
    assert motion(model, {(2, 2): 1.0})[1, 1] == pytest.approx(bent, rel=5e-3)


@pytest.mark.parametrize(
    ("card", "noted"),
    [
        ("PBEAML,1,1,,I\n,20.,10.,10.,2.,1.,1.\n", False),
        ("PBEAML,1,1,,I\n,20.,30.,2.,1.,1.,1.\n", True),
        ("PBEAML,1,1,,I\n,20.,10.,10.,2.,1.,2.\n", True),
        ("PBEAML,1,1,,I\n,20.,10.,10.,2.,1.,1.,,NO\n,1.,,,8.\n", True),
        ("PBEAML,1,1,,I\n,20.,10.,10.,2.,1.,1.,,NO\n,1.,,8.,8.\n", False),
        ("PBEAML,1,1,,T\n,30.,20.,1.,1.\n", True),
    ],
)
def test_a_shear_centre_beside_the_centroid_is_told(tmp_path, card, noted):
    """That of an I lies towards the stiffer flange: e = h I_top/(I_top + I_bottom) is the centroid's only where the
    flanges are alike."""
    model = cantilever(tmp_path, "CBEAM,1,1,1,2,0.,1.,0.", card)
    assert [name for name, changes in unread(model).items() if changes] == ([f"PBEAML, {card[12]}"] if noted else [])
