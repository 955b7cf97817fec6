"""[material.NAME] and [section.NAME] thickness on shells that are stored by their matrices: every number by own sums."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from creak.assembly.part import Rayleigh, part_system
from creak.errors import InputError
from creak.formats.decks import read_model
from creak.model.laminates import of_other_materials, remade, shell_of
from creak.model.materials import Bushing, GeneralShell, Layup, Material, Ply
from creak.studies.design.properties import properties_of, with_properties
from creak.studies.file.model_tables import MaterialTable, SectionTable
from creak.studies.file.places import Places
from creak.studies.file.reader import read_study
from creak.studies.models.trials import Joined, UpdateCase, joined
from creak.studies.prepare.structure import modes_up_to
from helpers_decks import STEEL, strip
from helpers_nastran import read

FOAM = "*MATERIAL, NAME=FOAM\n*ELASTIC\n700., 0.2\n*DENSITY\n3e-10,\n*EXPANSION\n5e-5,\n"
CLAMPED = "*BOUNDARY\nROOT_S, 1, 6\n"
E, NU, RHO, ALPHA, BETA = 210000.0, 0.3, 7.85e-9, 5.0, 2e-6
"""Of STEEL."""
GRIDS = "GRID,1,,0.,0.\nGRID,2,,10.,0.\nGRID,3,,10.,10.\nGRID,4,,0.,10.\nCQUAD4,1,1,1,2,3,4\n"


def sheet(modulus, nu, factor=1.0):
    """Plane stress; `factor` is that of a shear modulus of its own."""
    Q = modulus / (1.0 - nu * nu) * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
    Q[2, 2] *= factor
    return Q


def abaqus(folder, section, more=""):
    (folder / "strip.inp").write_text(f"*HEADING\nstrip\n{strip(1, 1, 'S', 0.0)}{STEEL}{FOAM}{section}{CLAMPED}{more}")
    return read_model(folder / "strip.inp")


def changed(model, folder, materials=None, sections=None):
    materials = {name: MaterialTable(**table) for name, table in (materials or {}).items()}
    sections = {name: SectionTable(**table) for name, table in (sections or {}).items()}
    return with_properties(model, materials, sections, Places(folder / "study.toml", ""))[0]


def shell(model) -> GeneralShell:
    found = model.blocks[0].section
    assert isinstance(found, GeneralShell)
    return found


def same(found, wanted):
    np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-12 * np.abs(wanted).max())


def holds(section, layers, z):
    """A, B, D, masses and damping of (Q, rho, alpha, beta) between the heights z; by Gauss points, exact here."""
    at, weight = np.polynomial.legendre.leggauss(3)
    sums = [0.0, 0.0, 0.0]
    masses, damping = np.zeros(3), np.zeros(2)
    for (Q, rho, alpha, beta), low, high in zip(layers, z[:-1], z[1:], strict=True):
        for height, w in zip(0.5 * (low + high) + 0.5 * (high - low) * at, 0.5 * (high - low) * weight, strict=True):
            sums = [s + w * height**n * Q for n, s in enumerate(sums)]
            masses += w * rho * height ** np.arange(3)
            damping += w * rho * np.array([alpha, beta])
    for name, wanted in zip("ABD", sums, strict=True):
        same(getattr(section, name), wanted)
    same([section.mass, section.first_moment, section.rotary_inertia], masses)
    same([section.alpha, section.beta], damping / masses[0])


def test_plies_of_a_laminate_beside_the_nodes(tmp_path):
    """E and density of STEEL, twice and three times as much; FOAM stays, damping is weighted by mass."""
    plies = "*SHELL SECTION, ELSET=S, COMPOSITE, OFFSET=0.25\n0.4, 3, STEEL\n0.6, 3, FOAM\n0.3, 3, STEEL\n"
    model = abaqus(tmp_path, plies)
    assert properties_of(model)["material", "STEEL", "youngs_modulus"] == E
    found = shell(changed(model, tmp_path, {"steel": {"youngs_modulus": 2 * E, "density": 3 * RHO}}))
    steel, foam = (sheet(2 * E, NU), 3 * RHO, ALPHA, BETA), (sheet(700.0, 0.2), 3e-10, 0.0, 0.0)
    z = np.array([0.0, 0.4, 1.0, 1.3]) - 0.65 - 0.25 * 1.3
    holds(found, (steel, foam, steel), z)
    same(found.expansion.force, 0.6 * 5e-5 * sheet(700.0, 0.2) @ [1.0, 1.0, 0.0])
    stiff = shell(changed(model, tmp_path, {"FOAM": {"youngs_modulus": 1400.0}}))
    same(stiff.expansion.force, 0.6 * 5e-5 * sheet(1400.0, 0.2) @ [1.0, 1.0, 0.0])


@pytest.mark.parametrize("offset", ["SPOS", "0.25"])
def test_a_homogeneous_shell_beside_the_nodes(tmp_path, offset):
    """OFFSET is a share of the thickness, and follows it; S = 5/6 G t."""
    model = abaqus(tmp_path, f"*SHELL SECTION, ELSET=S, MATERIAL=STEEL, OFFSET={offset}\n1.0,\n")
    assert properties_of(model)["section", "S", "thickness"] == 1.0
    tables = {"STEEL": {"youngs_modulus": 2 * E, "density": 3 * RHO}}, {"S": {"thickness": 1.6}}
    found = shell(changed(model, tmp_path, *tables))
    share = 0.5 if offset == "SPOS" else 0.25
    holds(found, [(sheet(2 * E, NU), 3 * RHO, ALPHA, BETA)], np.array([-0.8, 0.8]) - 1.6 * share)
    same(found.S, 5.0 / 6.0 * 2 * E / (2.0 * (1.0 + NU)) * 1.6 * np.eye(2))
    assert (found.thickness, found.offset) == pytest.approx((1.6, -1.6 * share))


def test_what_the_deck_gives_beside_the_material_stays(tmp_path):
    """The transverse shear stiffness, and nonstructural mass by area and by volume."""
    given = "*SHELL SECTION, ELSET=S, MATERIAL=STEEL, OFFSET=0.5\n1.0,\n*TRANSVERSE SHEAR STIFFNESS\n6e4, 5e4, 1e3\n"
    mass = "*NONSTRUCTURAL MASS, ELSET=S, UNITS=MASS PER {}\n1e-9\n"
    for units in ("VOLUME", "AREA"):
        model = abaqus(tmp_path, given, mass.format(units))
        found = shell(changed(model, tmp_path, {"STEEL": {"youngs_modulus": 2 * E, "density": 3 * RHO}}))
        same(found.mass + found.area_mass, 3 * RHO + 1e-9)
        same(found.S, np.array([[6e4, 1e3], [1e3, 5e4]]))
        same(found.A, sheet(2 * E, NU))


def test_a_membrane_follows_its_material(tmp_path):
    nodes, element = (
        "*NODE\n1, 0., 0.\n2, 10., 0.\n3, 10., 10.\n4, 0., 10.\n",
        "*ELEMENT, TYPE=M3D4, ELSET=S\n1, 1, 2, 3, 4\n",
    )
    (tmp_path / "m.inp").write_text(f"{nodes}{element}{STEEL}*MEMBRANE SECTION, ELSET=S, MATERIAL=STEEL\n0.5,\n")
    model = read_model(tmp_path / "m.inp")
    found = shell(changed(model, tmp_path, {"STEEL": {"youngs_modulus": 2 * E, "density": 3 * RHO}}))
    same(found.A, 0.5 * sheet(2 * E, NU))
    same(found.mass, 1.5 * RHO)
    assert found.rotary_inertia == 0.0
    assert found.is_membrane


def test_moduli_of_pshell(tmp_path):
    """12I/T^3 = 2, TS/T = 0.5, a material for each; of one with G of its own, G follows E."""
    cards = "PSHELL,1,1,2.,2,2.,3,.5,1.-9\n,,,4\nMAT1,1,1000.,,.3,1.-9\nMAT1,2,2000.,1000.,.2\nMAT1,3,3000.,,.1\nMAT1,4,40.,,.3\n"
    model = read(tmp_path, GRIDS + cards)
    doubled = {f"MAT1 {i}": {"youngs_modulus": 2.0 * e} for i, e in ((1, 1e3), (2, 2e3), (3, 3e3), (4, 40.0))}
    doubled["MAT1 1"]["density"] = 3e-9
    found = shell(changed(model, tmp_path, doubled, {"PSHELL 1": {"thickness": 3.0}}))
    same(found.A, 3.0 * sheet(2e3, 0.3))
    same(found.D, 2.0 * 27.0 / 12.0 * sheet(4e3, 0.2, 1000.0 * 2.4 / 2000.0))
    same(found.B, -9.0 * sheet(80.0, 0.3))
    same(found.S, 0.5 * 3.0 * 6e3 / 2.2 * np.eye(2))
    same([found.mass, found.area_mass, found.rotary_inertia], [9e-9, 1e-9, 3e-9 * 27.0 / 12.0])


@pytest.mark.parametrize("lam", ["", "SYM", "MEM", "BEND", "SMEAR"])
def test_plies_of_pcomp(tmp_path, lam):
    """What LAM leaves is left of the changed plies too, at Z0; MAT8 has a density alone."""
    cards = f"PCOMP,1,-.2,,,,20.,,{lam}\n,1,.5,,,8,.25,90.\nMAT1,1,1000.,,.3,1.-9,1.-5,50.\nMAT8,8,900.,300.,.25,200.,200.,200.,2.-9\n"
    model = read(tmp_path, GRIDS + cards)
    assert {w for _, name, w in properties_of(model) if name == "MAT8 8"} == {"density"}
    tables = {"MAT1 1": {"youngs_modulus": 2e3, "density": 3e-9}, "MAT8 8": {"density": 5e-9}}
    found = shell(changed(model, tmp_path, tables))
    iso = sheet(2e3, 0.3)
    nu21 = 0.25 * 300.0 / 900.0
    share = 1.0 - 0.25 * nu21
    across = np.array([[300.0, 0.25 * 300.0, 0.0], [0.25 * 300.0, 900.0, 0.0], [0.0, 0.0, 200.0 * share]]) / share
    t, layers = [0.5, 0.25], [iso, across]
    if lam == "SYM":
        t, layers = [*t, *t[::-1]], [*layers, *layers[::-1]]
    z = -0.2 + np.concatenate([[0.0], np.cumsum(t)])
    A, D = (sum((b**n - a**n) / n * Q for Q, a, b in zip(layers, z[:-1], z[1:], strict=True)) for n in (1, 3))
    same(found.A, (1e-6 if lam == "BEND" else 1.0) * A)
    even = A * sum(t) ** 2 / 12.0
    if lam in ("MEM", "SMEAR"):
        same(found.D, (1e-6 if lam == "MEM" else 1.0) * even)
    else:
        same(found.D, D)
    assert found.B.any() == (lam in ("", "SYM"))
    same(found.mass, (0.5 * 3e-9 + 0.25 * 5e-9) * (2.0 if lam == "SYM" else 1.0))
    assert found.expansion.reference == 20.0


def test_a_pcomp_of_one_ply_gets_thicker_where_it_lies(tmp_path):
    model = read(tmp_path, f"{GRIDS}PCOMP,1,-.2\n,1,.5\nMAT1,1,1000.,,.3,1.-9\n")
    found = shell(changed(model, tmp_path, sections={"PCOMP 1": {"thickness": 0.8}}))
    holds(found, [(sheet(1e3, 0.3), 1e-9, 0.0, 0.0)], np.array([-0.2, 0.6]))


def test_a_weld_is_as_stiff_as_its_material(tmp_path):
    """E A / L along it; its mass is none, so its material has no density."""
    grids = "GRID,9,,5.,5.\n" + "".join(
        f"GRID,{10 + i},,{x},{y},2.\n" for i, (x, y) in enumerate(((0, 0), (10, 0), (10, 10), (0, 10)))
    )
    cards = "CQUAD4,2,1,10,11,12,13\nPSHELL,1,1,1.,1,,1\nMAT1,1,1000.,,.3,1.-9\nMAT1,2,2000.,,.3,1.-9\n"
    model = read(
        tmp_path, GRIDS.replace("0.,10.\n", "0.,10.,0.\n") + grids + cards + "PWELD,7,2,6.\nCWELD,99,7,9,ELEMID\n,1,2\n"
    )
    assert ("material", "MAT1 2", "density") not in properties_of(model)
    stiffer = changed(model, tmp_path, {"MAT1 2": {"youngs_modulus": 6e3}})
    old, new = (next(b.section for b in m.blocks if isinstance(b.section, Bushing)) for m in (model, stiffer))
    assert new.stiffness[0, 0] == pytest.approx(6e3 * math.pi * 9.0 / 2.0, rel=1e-9)
    same(new.stiffness, 3.0 * old.stiffness)


def test_a_laminate_has_no_one_thickness(tmp_path):
    model = abaqus(tmp_path, "*SHELL SECTION, ELSET=S, COMPOSITE\n0.4, 3, STEEL\n0.6, 3, FOAM\n")
    with pytest.raises(InputError, match=r"no single thickness; expected stiffness_factor.*differ between.*plies"):
        changed(model, tmp_path, sections={"S": {"thickness": 2.0}})


def test_a_shell_by_its_stiffness_names_no_material(tmp_path):
    terms = "*SHELL GENERAL SECTION, ELSET=S, DENSITY=1e-9\n2., .6, 2., 0., 0., .7, 0., 0.\n0., 1., 0., 0., 0., .3, 1., 0.\n0., 0., 0., 0., .35\n"
    model = abaqus(tmp_path, terms + "*TRANSVERSE SHEAR STIFFNESS\n1., 1., 0.\n")
    assert set(properties_of(model)) == {("section", "S", "stiffness_factor")}


def test_an_update_sees_the_laminate_change(tmp_path):
    """f ~ sqrt(E / rho) of a strip whose plies are of one material, also where parts are kept from another trial."""
    plies = "*SHELL SECTION, ELSET=S, COMPOSITE\n0.4, 3, STEEL\n0.6, 3, STEEL\n"
    model = abaqus(tmp_path, plies)
    (tmp_path / "study.toml").write_text('[model]\ndeck = "strip.inp"\n[material.STEEL]\ndensity = 7.85e-9\n')
    case = UpdateCase(read_study(tmp_path / "study.toml"), model, None, None, {}, (), ())
    base = joined(case, {})
    assert isinstance(base, Joined)
    first = modes_up_to(base.system, 200.0).frequencies[0]
    stiff = joined(case, {"material.STEEL.youngs_modulus": 4 * E}, base)
    heavy = joined(case, {"material.STEEL.density": 4 * RHO}, base)
    assert modes_up_to(stiff.system, 400.0).frequencies[0] == pytest.approx(2.0 * first, rel=1e-9)
    assert modes_up_to(heavy.system, 200.0).frequencies[0] == pytest.approx(0.5 * first, rel=1e-9)
    same(part_system(heavy.structure.model, 0, Rayleigh(0.0, 0.0)).stats.mass, 4 * RHO * 120 * 20)


def test_damping_given_for_the_whole_layup_stays():
    """As GE of a PCOMP: the plies' own is another."""
    steel = Material("S", 2e5, 0.3, 7.8e-9, beta=3e-5)
    made_of = Layup((Ply(steel, 1.0), Ply(steel, 2.0)), beta=1e-4)
    stiffer = of_other_materials(made_of, lambda m: replace(m, youngs_modulus=4e5))
    again = remade(shell_of("L", made_of), stiffer)
    assert (shell_of("L", made_of).beta, again.beta) == (1e-4, 1e-4)
    np.testing.assert_allclose(again.A, 2.0 * shell_of("L", made_of).A)
