"""Decks written from models: reading them gives the same model, and what cannot be said is refused by name."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.write.sections import inverted
from creak.formats.abaqus.writer import write_deck
from creak.model.comparison import difference
from creak.model.materials import Material, ShellSection
from creak_thesis.door.writer import write_door
from fuzz_samples import INSTANCES, SOLIDS, STRIPS
from helpers_dynamic_decks import STEP, bar_deck, cantilever_deck, stop_deck
from helpers_nastran import read as nastran
from helpers_same_model import abaqus_deck, mesh
from helpers_ties import cut_plate

STEEL = "*MATERIAL, NAME=Steel\n*ELASTIC\n 210000., 0.3\n*DENSITY\n 7.85e-9\n"
CARBON = (
    "*MATERIAL, NAME=CARBON\n*ELASTIC, TYPE=LAMINA\n 140000., 9000., 0.31, 5000., 4900., 3500.\n*DENSITY\n 1.6e-9\n"
    "*DAMPING, ALPHA=1.1, BETA=3.3e-6\n"
)
PLATE = (
    "*NODE\n 5, 0.1\n 2, 10.3\n 9, 10., 8.\n 11, 0., 8.\n 3, 20., 4.7, 1e-17\n*ELEMENT, TYPE=S4R, ELSET=P\n 70, 5, 2, 9, 11\n"
    "*ELEMENT, TYPE=S3R, ELSET=P\n 7, 2, 3, 9\n"
)
ROD = "*NODE\n 1, 0.\n 2, 10.\n 3, 17., 3.\n 4, 0., 5.\n"
BEAMS = "*ELEMENT, TYPE=B31, ELSET=B\n 1, 1, 2\n*ELEMENT, TYPE=B33, ELSET=B\n 9, 2, 3\n"
SECTION = "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION="
GENERAL = "*BEAM GENERAL SECTION, ELSET=B, DENSITY=7.85e-9"
AXES = "*ORIENTATION, NAME=O\n 1., .3, 0., 0., 1., .1\n 3, 33.\n"
MASSES = "*ELEMENT, TYPE=MASS, ELSET=M\n 1, 1\n 2, 3\n*MASS, ELSET=M{}\n"
TURNED = (
    f"{AXES}*ELEMENT, TYPE=SPRING2, ELSET=S\n 31, 1, 3\n*SPRING, ELSET=S, ORIENTATION=O\n 1, 2\n 5.\n"
    "*ELEMENT, TYPE=SPRING1, ELSET=T\n 32, 1\n*SPRING, ELSET=T, ORIENTATION=O\n 5\n 70.\n"
    "*ELEMENT, TYPE=DASHPOT2, ELSET=D\n 33, 1, 3\n 34, 3, 4\n*DASHPOT, ELSET=D, ORIENTATION=O\n 3, 3\n .2\n"
)
QUOTED = f"""*Part, name="Plate, 1"
{PLATE}*Nset, nset="Left  side"
 5, 11
*Elset, elset="a=b.c"
 7
*Shell Section, elset=P, material="Cold Steel"
 1.2
*Surface, type=ELEMENT, name="Top, 1"
 P, SPOS
*End Part
*Assembly, name="Assy 1"
*Instance, name="Plate 1.1", part="plate, 1"
*End Instance
*Instance, name="Plate 1.2", part="PLATE, 1"
 0., 0., 5.
*End Instance
*Nset, nset="Both sides"
 "Plate 1.1"."Left side", Plate 1.2."LEFT SIDE", "Assy 1"."Plate 1.1".3
*Nset, nset="of one", elset="a=b.c", instance="Plate 1.2"
*Coupling, constraint name="C, 1", ref node="Plate 1.1".3, surface="Plate 1.2"."Top, 1"
*Kinematic
*End Assembly
{STEEL.replace("Steel", '"Cold Steel"')}*Boundary
 "Plate 1.1"."Left side", ENCASTRE
 "PLATE 1.1".2, 3
"""
"""Names as Abaqus/CAE writes them, with blanks, commas, dots and equals signs."""

SAMPLES = {
    "quoted names": QUOTED,
    "instances": INSTANCES.replace(" PANEL_NODES, 2, -1000.\n", " 903, 2, -1000.\n")
    .replace("elset=CLIP, orientation=R", "elset=CLIP")
    .replace("*Nonstructural Mass, elset=Frame-1.SKIN, units=TOTAL MASS\n 1e-6\n", "")
    .replace("CYLINDRICAL\n 0., 0., 0., 0., 0., 1.", "RECTANGULAR\n 0., 1., 0., 1., 0., 1."),
    "solids": SOLIDS.replace("*TIE, NAME=GLUE, POSITION TOLERANCE=20., ADJUST=NO\n UNDER, TOP\n", ""),
    "same model": abaqus_deck(mesh()),
    "strips": STRIPS,
    "mass on a stop": stop_deck(),
    "bar": bar_deck("", 1e-6, 1e-3, n=5),
    "cantilever": cantilever_deck(STEP),
    "offset": f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=STEEL, OFFSET=0.137\n 1.23\n{STEEL}",
    "plies": f"{PLATE}{AXES}*SHELL SECTION, ELSET=P, COMPOSITE, OFFSET=SNEG, ORIENTATION=O\n .2, 3, CARBON, 17.3\n"
    f" .31, 3, STEEL\n .2, 3, CARBON, -45.\n{STEEL}{CARBON}",
    "shear of plies": f"{PLATE}*SHELL SECTION, ELSET=P, COMPOSITE, SYMMETRIC\n .21, 3, CARBON, 1.\n"
    f"*TRANSVERSE SHEAR STIFFNESS\n 11., 12., 3.\n{CARBON}",
    "nodal thickness": f"{PLATE}*NODAL THICKNESS\n 5, .7\n 2, .9\n 9, 1.1\n 11, 1.3\n 3, .3\n"
    f"*SHELL SECTION, ELSET=P, MATERIAL=STEEL, NODAL THICKNESS\n .77\n{STEEL}",
    "rectangle": f"{ROD}{BEAMS}{SECTION}RECT\n 3.1, 2.3\n 0., .2, 1.\n{STEEL}",
    "pipe": f"{ROD}{BEAMS}{SECTION}PIPE\n 3.1, .7\n{STEEL}",
    "box": f"{ROD}{BEAMS}{SECTION}BOX\n 6.1, 4., .5, .6, .5, .6\n 0., 1., 0.\n{STEEL}",
    "I": f"{ROD}{BEAMS}{SECTION}I\n 1., 6., 4., 5., .3, .4, .5\n 0., 1., 0.\n*TRANSVERSE SHEAR STIFFNESS\n 1e5, 2e5\n{STEEL}",
    "general": f"{ROD}{BEAMS}{GENERAL}\n 2., 3., .5, 4., 5.\n 0., 0., 1.\n 1000., 411.\n*CENTROID\n .1, .2\n",
    "shape with moduli": f"{ROD}{BEAMS}{GENERAL}, SECTION=CIRC\n 1.7\n\n 1000., 411.\n*SHEAR CENTER\n .1, .2\n",
    "third node": f"{ROD}*ELEMENT, TYPE=B31, ELSET=B\n 1, 1, 2, 4\n 2, 2, 3\n{SECTION}CIRC\n 1.5\n{STEEL}",
    "one mass per direction": f"{ROD}{BEAMS}{SECTION}CIRC\n 1.5\n{STEEL}"
    + MASSES.replace(" 1, 1\n 2, 3", " 11, 1\n 12, 3").format(", TYPE=ANISOTROPIC")
    + " 1., 2., 3.\n",
    "springs": f"{ROD}{MASSES.format(', ALPHA=.3')} .1\n*ELEMENT, TYPE=SPRINGA, ELSET=S\n 31, 1, 3\n"
    "*SPRING, ELSET=S\n\n 45.6\n*ELEMENT, TYPE=DASHPOTA, ELSET=D\n 32, 1, 2\n*DASHPOT, ELSET=D\n\n .1\n"
    "*ELEMENT, TYPE=DASHPOT2, ELSET=E\n 33, 1, 2\n*DASHPOT, ELSET=E\n 1, 3\n .2\n",
    "springs along turned axes": f"{ROD}{MASSES.format('')} .1\n{TURNED}",
    "bushing": f"{ROD}{MASSES.format('')} .1\n{AXES}*ELEMENT, TYPE=CONN3D2, ELSET=C\n 5, 1, 3\n"
    "*CONNECTOR SECTION, ELSET=C, BEHAVIOR=R\n Bushing,\n O,\n*CONNECTOR BEHAVIOR, NAME=R\n"
    "*CONNECTOR ELASTICITY, COMPONENT=2\n 3.3\n*CONNECTOR DAMPING, COMPONENT=5\n 7.7\n",
    "two densities": f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.\n*ELSET, ELSET=Q\n 7\n"
    f"*NONSTRUCTURAL MASS, ELSET=Q, UNITS=MASS PER VOLUME\n 1e-9\n{STEEL}",
    "two masses per area": f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.\n*ELSET, ELSET=Q\n 7\n"
    f"*NONSTRUCTURAL MASS, ELSET=Q, UNITS=TOTAL MASS\n 1e-6\n"
    f"*NONSTRUCTURAL MASS, ELSET=P, UNITS=MASS PER AREA\n .3e-9\n{STEEL}",
    "mass per area of plies": f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=CARBON, OFFSET=SNEG\n 1.\n{CARBON}"
    "*NONSTRUCTURAL MASS, ELSET=P, UNITS=MASS PER AREA\n 1e-9\n",
}


def written(read, text, tmp_path):
    """The model of a deck, and the one read from the deck that is written of it."""
    model = read(text)
    write_deck(model, tmp_path / "copy.inp")
    return model, read_deck(tmp_path / "copy.inp")


@pytest.mark.parametrize("name", SAMPLES)
def test_written_decks_read_back_the_same(read, tmp_path, name):
    model, copy = written(read, SAMPLES[name], tmp_path)
    assert difference(model, copy, names=not name.startswith("two ")) == ""
    write_deck(copy, tmp_path / "again.inp")
    assert difference(copy, read_deck(tmp_path / "again.inp"), names=not name.startswith("two ")) == ""


def test_a_written_spring_pulls_along_the_turned_axes(read, tmp_path):
    """Axis 1 along (1, .3, 0) turned by 33 degrees about axis 3; dof 1 of node 1 against dof 2 of node 3."""
    _, copy = written(read, SAMPLES["springs along turned axes"], tmp_path)
    a = np.array([1.0, 0.3, 0.0]) / np.hypot(1.0, 0.3)
    c = np.cross(a, [0.0, 1.0, 0.1])
    b = np.cross(c / np.linalg.norm(c), a)
    angle = np.radians(33.0)
    g = np.zeros(12)
    g[:3], g[6:9] = -(np.cos(angle) * a + np.sin(angle) * b), np.cos(angle) * b - np.sin(angle) * a
    spring = next(x for x in copy.blocks if x.ids[0] == 31)
    np.testing.assert_allclose(spring.section.stiffness, 5.0 * np.outer(g, g), rtol=0, atol=1e-13)
    assert not spring.section.mass.any()
    assert not spring.section.damping.any()


@pytest.mark.parametrize("name", ["flat", "parts"])
def test_flat_decks_and_instances(read, tmp_path, request, name):
    model, copy = written(read, request.getfixturevalue(name), tmp_path)
    assert difference(model, copy) == ""


def test_the_door(tmp_path):
    deck = next(p for p in write_door(40.0, tmp_path) if p.suffix == ".inp")
    model = read_deck(deck)
    write_deck(model, tmp_path / "copy.inp")
    assert difference(model, read_deck(tmp_path / "copy.inp")) == ""


def test_names_in_quotes_are_understood_and_written_in_quotes(read, tmp_path):
    model, copy = written(read, QUOTED, tmp_path)
    for m in (model, copy):
        assert m.nodes.ids[m.node_sets["BOTH SIDES"]].tolist() == [5, 11, 5, 11, 3]
        assert m.nodes.ids[m.node_sets["OF ONE"]].tolist() == [2, 3, 9]
        assert [m.nodes.ids[f.nodes_idx].tolist() for f in m.fixed] == [[5, 11], [2]]
        assert {name for name in m.element_sets if "A=B" in name} == {"PLATE 1.1.A=B.C", "PLATE 1.2.A=B.C"}
        assert m.constraints[0].nodes_idx.size == 5
    lines = (tmp_path / "copy.inp").read_text().splitlines()
    assert '"PLATE 1.1"."LEFT SIDE", 1, 6' in lines
    assert '*INSTANCE, NAME="PLATE 1.2", PART="PLATE 1.2"' in lines


def test_a_set_of_the_only_instance_is_known_by_its_own_name(read):
    """Though the names of both hold dots."""
    whole, second = QUOTED.split('*Instance, name="Plate 1.2"')
    text = whole + "*End Assembly\n" + second[second.index("*Material".upper()) :]
    assert set(read(text).element_sets) == {"PLATE 1.1.P", "P", "PLATE 1.1.A=B.C", "A=B.C"}


def test_a_coupling_without_a_surface_gets_one(read, tmp_path):
    """*RIGID BODY names nodes; written as *COUPLING it needs a surface, which is the only addition."""
    text = f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.\n{STEEL}*NSET, NSET=T\n 2, 3, 9\n*RIGID BODY, REF NODE=5, PIN NSET=T\n"
    model, copy = written(read, text, tmp_path)
    assert difference(model, copy) == ""
    assert set(copy.surfaces) - set(model.surfaces) == {"_COUPLING-1"}


REFUSED = {
    "tie": (cut_plate((2, 2), (2, 2)), "tie 'SEAM'"),
    "mass along turned axes": (
        f"{ROD}{AXES}{MASSES.format(', TYPE=ANISOTROPIC, ORIENTATION=O')} 1., 2., 3.\n",
        "a mass along turned axes",
    ),
    "axes that vary": (
        f"{PLATE}*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n 0., 0., 0., 0., 0., 1.\n 3\n"
        f"*SHELL SECTION, ELSET=P, MATERIAL=CARBON, ORIENTATION=O\n 1.\n{CARBON}",
        "section 'P'",
    ),
    "not read": (
        f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.\n{STEEL}*EMBEDDED ELEMENT\n P\n",
        "EMBEDDED ELEMENT",
    ),
    "denser plies": (
        f"{PLATE}*SHELL SECTION, ELSET=P, MATERIAL=CARBON\n 1.\n{CARBON}"
        "*NONSTRUCTURAL MASS, ELSET=P, UNITS=MASS PER VOLUME\n 1e-9\n",
        "section, mass",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_deck_cannot_say_is_refused_and_nothing_is_written(read, tmp_path, name):
    text, word = REFUSED[name]
    with pytest.raises(InputError, match=re.escape(word)):
        write_deck(read(text), tmp_path / "copy.inp")
    assert [p.name for p in tmp_path.iterdir()] == ["deck.inp"]


def test_an_ignored_keyword_may_get_lost(read, tmp_path):
    model = read(REFUSED["not read"][0])
    write_deck(model, tmp_path / "copy.inp", ignore=["EMBEDDED ELEMENT"])
    assert difference(model, read_deck(tmp_path / "copy.inp")) == ""


def test_lumped_mass_is_refused(read, tmp_path):
    model = replace(read(STRIPS), mass_form="lumped")
    with pytest.raises(InputError, match="--mass consistent"):
        write_deck(model, tmp_path / "copy.inp")


CHANGES = {
    "coordinate": lambda m: replace(m, nodes=replace(m.nodes, coords=np.nextafter(m.nodes.coords, np.inf))),
    "label": lambda m: replace(m, nodes=replace(m.nodes, ids=m.nodes.ids + 1)),
    "thickness": lambda m: replace(m, blocks=tuple(_thicker(b) for b in m.blocks)),
    "set": lambda m: replace(m, node_sets={k: v[::-1] for k, v in m.node_sets.items()}),
    "missing set": lambda m: replace(m, node_sets={}),
    "side": lambda m: replace(m, surfaces={k: replace(s, side=-s.side) for k, s in m.surfaces.items()}),
    "support": lambda m: replace(m, fixed=m.fixed[1:]),
    "mass": lambda m: replace(m, mass_form="linear"),
    "part": lambda m: replace(m, parts=tuple(replace(p, name=p.name + "X") for p in m.parts)),
    "blocks": lambda m: replace(m, blocks=m.blocks[:-1]),
}


def _thicker(block):
    assert isinstance(block.section, ShellSection)
    return replace(block, section=replace(block.section, thickness=np.nextafter(block.section.thickness, 9.0)))


@pytest.mark.parametrize("change", CHANGES)
def test_every_difference_is_seen(read, change):
    model = read(STRIPS)
    assert difference(model, read(STRIPS)) == ""
    assert difference(model, CHANGES[change](model)) != ""


def test_inverted_finds_the_number_of_the_deck():
    nu = 1000.0 / (2.0 * 411.0) - 1.0
    guess = Material("A", 1000.0, nu, 1.0).shear_modulus
    assert inverted(lambda g: 1000.0 / (2.0 * g) - 1.0, nu, guess) == 411.0


@pytest.mark.parametrize(
    ("cards", "told"),
    [
        ("PSHELL,1,1,.1,1,,1\nMAT1,1,1.+4,,.3,1.-9,1.-5,35.\n", ["MAT1 1: its TREF, 35, is not in the deck"]),
        ("PCOMP,1,,,,,35.\n,1,.1\nMAT1,1,1.+4,,.3,1.-9,1.-5,20.\n", ["PCOMP 1: its TREF, 35, is not in the deck"]),
        ("PSHELL,1,1,.1,1,,1\nMAT1,1,1.+4,,.3,1.-9,1.-5\n", []),
        ("PSHELL,1,1,.1,1,,1\nMAT1,1,1.+4,,.3,1.-9,,35.\n", []),
    ],
)
def test_a_reference_temperature_is_told_to_be_lost(tmp_path, cards, told):
    """Nastran has no strain at TREF, Abaqus none at the initial temperature."""
    model = nastran(tmp_path, f"GRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nGRID,4,,,1.\nCQUAD4,1,1,1,2,3,4\n{cards}")
    notes = write_deck(replace(model, mass_form="consistent"), tmp_path / "copy.inp")
    assert [note.rpartition(": it expands")[0] for note in notes if "TREF" in note] == told


def test_an_expansion_over_temperature_is_told_to_be_lost(tmp_path):
    text = PLATE + "*SHELL SECTION, ELSET=P, MATERIAL=Steel\n 1.\n" + STEEL + "*EXPANSION\n 1e-5, 0.\n 2e-5, 100.\n"
    (tmp_path / "deck.inp").write_text(text, encoding="utf-8")
    notes = write_deck(read_deck(tmp_path / "deck.inp"), tmp_path / "copy.inp")
    assert notes == ("Steel: its expansion, which depends on temperature or shears, is not in the deck",)
