"""CQUAD4, CTRIA3, PSHELL, PCOMP and sheet materials.

PCOMPP, STACK and PLY: the laminate of each element from the plies that lie on it.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from creak.contact.facets import facets_of
from creak.errors import InputError
from creak.formats.nastran.reader import read_nastran
from creak.model.elasticity import lamina, plane_stress
from creak.model.laminates import Ply, homogeneous_shell, laminate
from creak.model.materials import GeneralShell, Material, SheetMaterial, ShellSection
from helpers_nastran import motion, read, rigid_mass, row, unread
from helpers_refusal import refusal

E, T, L, B = 7.0e4, 2.0, 40.0, 10.0
MATERIAL = f"MAT1,1,{E},,0.,2.7-9\n"
"""No lateral contraction: a strip is a beam."""


def strip(tmp_path, prop=f"PSHELL,1,1,{T},1,,1", tail="", n=4, extra="", triangles=False):
    """A strip of n elements along x, clamped at x = 0; grids 1.. below, 101.. above."""
    lines = [f"GRID,{100 * k + i + 1},,{L * i / n},{B * k},0." for k in (0, 1) for i in range(n + 1)]
    for i in range(1, n + 1):
        if triangles:
            lines += [f"CTRIA3,{i},1,{i},{i + 1},{101 + i}{tail}", f"CTRIA3,{i + 50},1,{i},{101 + i},{100 + i}{tail}"]
        else:
            lines.append(f"CQUAD4,{i},1,{i},{i + 1},{101 + i},{100 + i}{tail}")
    return read(tmp_path, "\n".join([*lines, "SPC1,1,123456,1,101", prop, MATERIAL, extra]))


def tip(model, dof, force=1.0, n=4):
    u = motion(model, {(n + 1, dof): 0.5 * force, (n + 101, dof): 0.5 * force})
    return 0.5 * (u[row(model, n + 1)] + u[row(model, n + 101)])


def test_plain_section(tmp_path):
    """One MAT1 for all is creak's homogeneous shell; NSM adds to the mass, WTMASS multiplies it."""
    model = strip(tmp_path, f"PSHELL,1,1,{T},1,,1,,1.-9", extra="PARAM,WTMASS,3.")
    assert isinstance(model.blocks[0].section, ShellSection)
    assert rigid_mass(model)[0, 0] == pytest.approx(3.0 * (2.7e-9 * T + 1e-9) * L * B)
    assert not any(unread(model).values())


def test_bending_strip(tmp_path):
    """P L^3/(3 E I) + P L/(5/6 G A), exact with the residual bending flexibility that goes with lumped mass."""
    wanted = L**3 / (3 * E * B * T**3 / 12) + L / (5 / 6 * E / 2 * B * T)
    assert tip(strip(tmp_path), 3)[2] == pytest.approx(wanted, rel=1e-6)
    assert tip(strip(tmp_path, n=1), 3, n=1)[2] == pytest.approx(wanted, rel=1e-6)


def test_moment_of_inertia_and_shear_factor(tmp_path):
    """12I/T^3 = 2.5 and TS/T = 0.1."""
    model = strip(tmp_path, f"PSHELL,1,1,{T},1,2.5,1,.1")
    assert isinstance(model.blocks[0].section, GeneralShell)
    wanted = L**3 / (3 * E * 2.5 * B * T**3 / 12) + L / (0.1 * E / 2 * B * T)
    assert tip(model, 3)[2] == pytest.approx(wanted, rel=1e-6)
    assert tip(model, 1)[0] == pytest.approx(L / (E * B * T), rel=1e-6)


def test_four_materials(tmp_path):
    """MID1 for the membrane, MID2 for bending, MID3 in shear; without MID3 it is rigid there."""
    others = f"MAT1,2,{2 * E},,0.\nMAT1,3,{5 * E},,0."
    model = strip(tmp_path, f"PSHELL,1,1,{T},2,,3", extra=others)
    wanted = L**3 / (3 * 2 * E * B * T**3 / 12) + L / (5 / 6 * 5 * E / 2 * B * T)
    assert tip(model, 3)[2] == pytest.approx(wanted, rel=1e-6)
    assert tip(model, 1)[0] == pytest.approx(L / (E * B * T), rel=1e-6)
    rigid = strip(tmp_path, f"PSHELL,1,1,{T},1")
    also = strip(tmp_path, f"PSHELL,1,1,{T},1,,1,0.")
    np.testing.assert_array_equal(rigid.blocks[0].section.S, also.blocks[0].section.S)
    # A thousand times the shear modulus: the shear deflection is 3e-6 of the bending one.
    assert tip(rigid, 3)[2] == pytest.approx(L**3 / (3 * E * B * T**3 / 12), rel=1e-5)


def test_coupling_material(tmp_path):
    """MID4 of an offset h: Nastran's -T^2 G4 = B = h T Q, and D + h^2 T Q by 12I/T^3, is PCOMP with that Z0."""
    h = -0.3
    prop = f"PSHELL,1,1,{T},1,{1 + 12 * h * h / T**2},1\n,,,4"
    coupled = (
        strip(tmp_path, prop, extra=f"MAT2,4,{-h / T * E},0.,0.,{-h / T * E},0.,{-h / T * E / 2}").blocks[0].section
    )
    plies = strip(tmp_path, f"PCOMP,1,{-0.5 * T + h}\n,1,{T}").blocks[0].section
    for name in "ABD":
        ours, theirs = getattr(coupled, name), getattr(plies, name)
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12 * np.abs(theirs).max())


def test_membrane_only(tmp_path):
    """Without MID2 only a millionth of the bending stiffness is left, and the deck says so."""
    model = strip(tmp_path, f"PSHELL,1,1,{T}")
    assert tip(model, 1)[0] == pytest.approx(L / (E * B * T), rel=1e-6)
    assert tip(model, 3)[2] > 1e5 * L**3 / (3 * E * B * T**3 / 12)
    assert unread(model)["PSHELL without MID1 or MID2"] is False


@pytest.mark.parametrize(("mid2", "strained"), [("-1", True), ("-1,0.", True), ("", False)])
def test_a_membrane_in_plane_strain(tmp_path, mid2, strained):
    """MID2 = -1 holds the normal: exx = (1 - nu^2) s/E and eyy = -nu (1 + nu) s/E, where a membrane has s/E and -nu s/E;
    one degree presses with E alpha/(1 - 2 nu), where a membrane has E alpha/(1 - nu)."""
    nu, heat, width, stress = 0.3, 2e-5, 5.0, 7.0
    grids = f"GRID,1,,0.,0.\nGRID,2,,{L},0.\nGRID,3,,{L},{width}\nGRID,4,,0.,{width}\nCQUAD4,1,1,1,2,3,4\n"
    held = "SPC1,1,3456,1,2,3,4\nSPC1,1,12,1\nSPC1,1,1,4\nSPC1,1,2,2\n"
    model = read(tmp_path, f"{grids}{held}PSHELL,1,1,{T},{mid2}\nMAT1,1,{E},,{nu},2.7-9,{heat}")
    u = motion(model, {(2, 1): 0.5 * stress * T * width, (3, 1): 0.5 * stress * T * width})
    along, across = (1.0 - nu * nu, nu * (1.0 + nu)) if strained else (1.0, nu)
    assert u[2, 0] == pytest.approx(along * stress / E * L, rel=1e-9)
    assert u[2, 1] == pytest.approx(-across * stress / E * width, rel=1e-9)
    section = model.blocks[0].section
    pressed = T * E * heat / ((1.0 - 2.0 * nu) if strained else (1.0 - nu))
    np.testing.assert_allclose(section.expansion.force, [pressed, pressed, 0.0], rtol=1e-9)
    assert section.is_membrane


def test_plane_strain_keeps_a_shear_modulus_of_its_own(tmp_path):
    section = strip(tmp_path, f"PSHELL,1,2,{T},-1", extra=f"MAT1,2,{E},1.+4,.3").blocks[0].section
    assert section.A[2, 2] == pytest.approx(T * 1e4)


def test_composite(tmp_path):
    """Plies from the bottom, angles, symmetric lay-up, blank MID and T as before, NSM."""
    card = "PCOMP,1,,1.-8,,,,,SYM\n,8,.25,30.,YES,,,-45.\n,1,.5\n"
    mat8 = "MAT8,8,1.3+5,9.+3,.28,4.5+3,4.+3,3.+3,1.6-9\n"
    section = strip(tmp_path, card + mat8).blocks[0].section
    carbon = SheetMaterial("8", *lamina(1.3e5, 9e3, 0.28, 4.5e3, 4e3, 3e3), 1.6e-9)
    half = [
        Ply(carbon, 0.25, math.radians(30.0)),
        Ply(carbon, 0.25, math.radians(-45.0)),
        Ply(Material("1", E, 0.0, 2.7e-9), 0.5),
    ]
    wanted = laminate("w", [*half, *reversed(half)], added_mass=1e-8)
    for name in "ABDS":
        np.testing.assert_allclose(getattr(section, name), getattr(wanted, name), atol=1e-9 * np.abs(wanted.A).max())
    assert section.mass == pytest.approx(wanted.mass)


@pytest.mark.parametrize(("tail", "angle"), [("", 0.0), (",30.", 30.0), (",5", 60.0)])
def test_material_direction(tmp_path, tail, angle):
    """THETA from side G1-G2, or the x axis of MCID: the strip stretches with the turned modulus.

    1/Ex = c^4/E1 + s^4/E2 + (1/G12 - 2 nu12/E1) c^2 s^2 (Jones, eq. 2.97); end grids move together in x and are free
    otherwise, so 0.5 % is left for the clamp of a strip fifty times longer than wide.
    """
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    mat = "MAT8,8,1.3+5,9.+3,.28,4.5+3,4.+3,3.+3\n" + f"CORD2R,5,,0.,0.,0.,0.,0.,1.\n,.5,{math.sqrt(0.75)},0.\n"
    lines = [f"GRID,{100 * k + i + 1},,{25.0 * i},{10.0 * k},0." for k in (0, 1) for i in range(41)]
    lines += [f"CQUAD4,{i},1,{i},{i + 1},{101 + i},{100 + i}{tail}" for i in range(1, 41)]
    model = read(tmp_path, "\n".join([*lines, "SPC1,1,123456,1,101", "PSHELL,1,8,2.,8,,8", mat]))
    u = motion(model, {(41, 1): 0.5, (141, 1): 0.5})
    wanted = 1000.0 / 20.0 * (c**4 / 1.3e5 + s**4 / 9e3 + (1 / 4.5e3 - 0.56 / 1.3e5) * c * c * s * s)
    assert 0.5 * (u[row(model, 41), 0] + u[row(model, 141), 0]) == pytest.approx(wanted, rel=5e-3)


@pytest.mark.parametrize(
    ("lam", "pshell"), [("MEM", f"1,{T}"), ("BEND", f",{T},1"), ("SMEAR", f"1,{T},1"), ("SYSMEAR", f"1,{2 * T},1")]
)
def test_a_laminate_in_part_is_the_shell_of_these_materials(tmp_path, lam, pshell):
    """Plies of one material: LAM leaves out what a PSHELL without MID1, MID2 or MID3 does."""
    ply = f"1,{T / 2},0.,YES"
    part = strip(tmp_path, f"PCOMP,1,,,,,,,{lam}\n,{ply},{ply}").blocks[0].section
    whole = strip(tmp_path, f"PSHELL,1,{pshell}").blocks[0].section
    for one, other in ((part.A, whole.A), (part.D, whole.D)):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(other).max())
    assert not part.B.any()
    assert part.mass == pytest.approx(whole.mass)


def test_the_order_of_plies_counts_with_no_lam_and_not_with_smear(tmp_path):
    soft = "MAT1,2,7.+3,,0.,2.7-9"
    for lam, same in (("", False), ("SMEAR", True)):
        one, other = (
            strip(tmp_path, f"PCOMP,1,,,,,,,{lam}\n,{a},.5,0.,YES,{b},.5,0.,YES", extra=soft).blocks[0].section
            for a, b in ((1, 2), (2, 1))
        )
        assert np.allclose(one.A, other.A)
        assert np.allclose(one.B, other.B) == same


def test_offset(tmp_path):
    """ZOFFS lifts the shell from its grids: u = P L/(E A) + P h^2 L/(E I), end slope P h L/(E I)."""
    h = 0.7
    end = tip(strip(tmp_path, tail=f",,{h}"), 1)
    inertia = B * T**3 / 12
    assert end[0] == pytest.approx(L / (E * B * T) + h * h * L / (E * inertia), rel=1e-5)
    assert end[4] == pytest.approx(-h * L / (E * inertia), rel=1e-5)


def test_triangles(tmp_path):
    """CTRIA3 has its offset one field earlier; under pure stretch all corners are lifted alike."""
    block = strip(tmp_path, tail=",,.7", triangles=True).blocks[0]
    assert block.kind == "tri3"
    np.testing.assert_allclose(block.own.arms, np.broadcast_to([0.0, 0.0, 0.7], (8, 3, 3)))


def test_offset_in_contact(tmp_path):
    """The outer surface lies at ZOFFS +- T/2 from the grids; a surface of both sides would not say which."""
    model = strip(tmp_path, tail=",,.7")
    for name, distance in (("PID_1.SPOS", 0.5 * T + 0.7), ("PID_1.SNEG", 0.5 * T - 0.7)):
        np.testing.assert_allclose(facets_of(model, name, where="").thickness, 2.0 * distance)
    with pytest.raises(InputError, match="nodes lie off their middle"):
        facets_of(model, "PID_1", where="")


def test_corner_thickness(tmp_path):
    """T1 to T4, absolute or (TFLAG = 1) relative, instead of T, which may then be missing."""
    for tail, prop in (
        (f"\n,,,{2 * T},{2 * T},{2 * T},{2 * T}", f"PSHELL,1,1,{T},1,,1"),
        ("\n,,1,2.,2.,2.,2.", f"PSHELL,1,1,{T},1,,1"),
        (f"\n,,,{2 * T},{2 * T},{2 * T},{2 * T}", "PSHELL,1,1,,1,,1"),
    ):
        model = strip(tmp_path, prop, tail)
        assert tip(model, 1)[0] == pytest.approx(L / (E * B * 2 * T), rel=1e-6)
        assert tip(model, 3)[2] == pytest.approx(L**3 / (3 * E * B * (2 * T) ** 3 / 12), rel=0.05)
        assert rigid_mass(model)[0, 0] == pytest.approx(2.7e-9 * 2 * T * L * B)


def test_shear_modulus_of_its_own(tmp_path):
    """E, NU and G that do not agree: the shell keeps G, and the deck says so."""
    path = tmp_path / "g.bdf"
    path.write_text(
        f"GRID,1,,0.,0.\nGRID,2,,1.,0.\nGRID,3,,1.,1.\nGRID,4,,0.,1.\nCQUAD4,1,1,1,2,3,4\nPSHELL,1,1,{T},1,,1\nMAT1,1,{E},1.+4,.3\n"
    )
    model = read_nastran(path)
    section = model.blocks[0].section
    wanted = T * plane_stress(Material("m", E, 0.3, 0.0))
    wanted[2, 2] = T * 1e4
    np.testing.assert_allclose(section.A, wanted)
    assert unread(model)["MAT1, G"] is False


def test_sheet_offset_by_pcomp_is_the_laminate(tmp_path):
    section = strip(tmp_path, f"PCOMP,1,0.\n,1,{T}").blocks[0].section
    wanted = homogeneous_shell("w", Material("1", E, 0.0, 2.7e-9), T, 0.5 * T)
    np.testing.assert_allclose(section.B, wanted.B)
    assert section.first_moment == pytest.approx(wanted.first_moment)


@pytest.mark.parametrize(
    ("prop", "tail", "message"),
    [
        ("PSHELL,1,9,2.,1,,1", "", "PSHELL 1 uses material 9, which is not defined"),
        (
            "PSHELL,2,1,2.,1,,1",
            "",
            "CQUAD4 1 uses property 1, which is not defined; expected a PSHELL, PCOMP, PCOMPG, PCOMPP card",
        ),
        ("PSHELL,1,1,,1,,1", "", "PSHELL 1 has thickness 0"),
        ("PSHELL,1,1,0,1,,1", "\n,,,1.", "lacks thicknesses"),
        ("PSHELL,1,,2.", "", "neither MID1 nor MID2"),
        (
            "PSHELL,1,8,2.,-1\nMAT8,8,1.+5,1.+3,.3,1.+3",
            "",
            "in plane strain .MID2 = -1. and its MID1 is MAT8 8; expected a MAT1",
        ),
        ("PSHELL,1,,2.,-1", "", "neither MID1 nor MID2"),
        ("PSHELL,1,1,2.,-1,,1", "", "field 7 of PSHELL is '1'; expected a blank field beside MID2 = -1"),
        (
            "PSHELL,1,1,2.,-2",
            "",
            "field 5 of PSHELL is '-2'; expected the number of a material, or -1 for plane strain",
        ),
        ("PSHELL,1,-1,2.,1,,1", "", "field 3 of PSHELL is '-1'; expected the number of a material"),
        ("PCOMP,1", "", "PCOMP 1 has no plies"),
        ("PCOMP,1\n,1,0.", "", "a ply of PCOMP 1 has material 1 and thickness 0"),
        ("PSHELL,1,1,2.,1,,1\nPSHELL,1,1,3.,1,,1", "", "property 1 is defined twice, first at"),
        ("PSHELL,1,1,2.,1,,1", ",7", "CQUAD4 1 uses coordinate system 7, which is not defined"),
        ("PSHELL,1,1,2.,1,,1", ",abc", "field 8 of CQUAD4 is 'abc'; expected a real number"),
        ("PSHELL,1,1,2.,1,,1", "\n,,2,2.,2.,2.,2.", "field 13 of CQUAD4 is '2'; expected TFLAG: 0 or blank"),
        ("PCOMP,1\n,1,1.", "\n,,-1", "field 13 of CQUAD4 is '-1'; expected TFLAG: 0 or blank"),
        ("PCOMP,1\n,8,1.\nMAT8,8,1.+5,1.+3,.3,1.+3", ",7", "uses coordinate system 7, which is not defined"),
    ],
)
def test_mistakes(tmp_path, prop, tail, message):
    with pytest.raises(InputError, match=message):
        strip(tmp_path, prop, tail)


def test_plies_need_a_shear_modulus(tmp_path):
    with pytest.raises(InputError, match=r"a ply of PCOMP 1 has material 2, which has no shear modulus.*G of MAT1"):
        strip(tmp_path, "PCOMP,1\n,2,1.,0.", extra="MAT1,2,7.+4,1.-80,.3,2.7-9")


MESH = (
    "GRID,1,,0.,0.\nGRID,2,,1.,0.\nGRID,3,,2.,0.\nGRID,4,,0.,1.\nGRID,5,,1.,1.\nGRID,6,,2.,1.\n"
    "CQUAD4,1,7,1,2,5,4,0.\nCQUAD4,2,7,2,3,6,5,0.\nMAT8,1,120.,8.,.3,4.,4.,3.,1.\n"
)
SETS = "SET,11,ELEM,LIST\n,1,2\nSET,12,ELEM,LIST\n,2\n"
PLIES = "PLY,1,1,.1,0.\n,11\nPLY,2,1,.2,90.\n,12\nPLY,3,1,.1,45.,YES,.05\n,11\n"
STACKED = MESH + SETS + PLIES + "PCOMPP,7,,.5\nSTACK,1,,1,2,3\n"


def section(model, element: int) -> GeneralShell:
    return next(b.section for b in model.blocks if element in b.ids.tolist())


@pytest.mark.parametrize(("lam", "z0"), [("", ""), ("SYM", ""), ("", "-.3"), ("SMEAR", "")])
def test_each_element_has_the_laminate_of_its_plies(tmp_path, lam, z0):
    """As PCOMP cards of the same plies say it."""
    stacked = read(tmp_path, STACKED.replace("STACK,1,", f"STACK,1,{lam}").replace("PCOMPP,7,", f"PCOMPP,7,{z0}"))
    assert unread(stacked) == {}
    rest = f"{z0},.5,,,,,{lam}\n"
    one = f"{MESH}PCOMP,7,{rest},1,.1,0.,,1,.1,45.\n"
    two = f"{one.replace('CQUAD4,2,7', 'CQUAD4,2,8')}PCOMP,8,{rest},1,.1,0.,,1,.2,90.\n,1,.1,45.\n"
    for element, text in ((1, one), (2, two)):
        wanted, found = section(read(tmp_path, text), element), section(stacked, element)
        for name in ("A", "B", "D", "S"):
            size = np.abs(getattr(wanted, name)).max(initial=1e-300)
            np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), atol=1e-12 * size)
        assert found.mass == pytest.approx(wanted.mass, rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "what", "card"),
    [
        ("STACK,1,,1,2,3", "STACK,1,,,,,,,,\n,SUB,1,top,1,2,3", "STACK 1 has substacks (SUB)", "STACK"),
        ("STACK,1,,1,2,3", "STACK,1,,1,4,3", "field 5 of STACK is '4'", "STACK"),
        ("YES,.05\n", "YES,.05,9\n", "PLY 3 is draped (DRAPE 9)", "PLY,3"),
        (",11\nPLY,2", ",13\nPLY,2", "field 12 of PLY is '13'", ",13"),
        ("STACK,1,,1,2,3", "STACK,1,,1,2\nSTACK,2,,3", "element 1 lies in two stacks, 1 and 2", "STACK,2"),
        ("SET,11,ELEM,LIST\n,1,2", "SET,11,ELEM,LIST\n,2", "no PLY of a STACK lies on CQUAD4 1", "CQUAD4,1"),
    ],
)
def test_stacks_that_are_not_simple_are_refused_for_their_reason(tmp_path, old, new, what, card):
    assert old in STACKED
    text = STACKED.replace(old, new)
    error = refusal(read, tmp_path, text)
    assert what in error.what
    line = next(i for i, words in enumerate(text.splitlines(), start=4) if words.startswith(card))
    assert error.where in (f"{tmp_path / 'deck.bdf'}:{line}", f"{tmp_path / 'deck.bdf'}:{line + 1}")
    assert error.expected
