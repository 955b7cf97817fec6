"""[material.NAME] and [section.NAME]: the deck with other numbers, its frequencies by closed form, and wrong names."""

from __future__ import annotations

import numpy as np
import pytest

from creak.assembly.part import Rayleigh, part_system
from creak.errors import InputError
from creak.formats.decks import read_model
from creak.model.materials import Bushing, GeneralShell, PointMass, Spring
from creak.studies.design.properties import properties_of
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import read_study
from creak.studies.models.trials import Joined, UpdateCase, joined, start_of
from creak.studies.prepare.linear_model import linear_structure
from creak.studies.prepare.structure import modes_up_to
from creak.studies.propose.joints import joints_of
from helpers_decks import STEEL, strip, write_study

PIECES = (
    "*ELEMENT, TYPE=SPRING1, ELSET=FOOT\n900, 13\n*SPRING, ELSET=FOOT\n3\n5.\n"
    "*ELEMENT, TYPE=MASS, ELSET=TIP\n901, 39\n*MASS, ELSET=TIP\n1e-6,\n"
    "*ELEMENT, TYPE=CONN3D2, ELSET=JOINT\n902, 13, 26\n*CONNECTOR SECTION, ELSET=JOINT, BEHAVIOR=SOFT\nBUSHING\n"
    "*CONNECTOR BEHAVIOR, NAME=SOFT\n*CONNECTOR ELASTICITY, COMPONENT=3\n7.,\n"
)
SHELL = "*SHELL SECTION, ELSET=S, MATERIAL=STEEL\n1.0,\n*BOUNDARY\nROOT_S, 1, 6\n"
LAYERS = "*SHELL SECTION, ELSET=S, COMPOSITE\n0.5, 3, STEEL, 0.\n0.5, 3, STEEL, 90.\n*BOUNDARY\nROOT_S, 1, 6\n"


def study_of(folder, tables="", deck=None, shell=SHELL):
    path = write_study(
        folder,
        f'[model]\ndeck = "strip.inp"\n{tables}',
        {"strip.inp": f"*HEADING\nstrip\n{strip(1, 1, 'S', 0.0)}{STEEL}{shell}" + (deck or "")},
    )
    return read_study(path)


def section(study, kind):
    model = linear_structure(study, read_model(study.places.sibling("strip.inp"))).model
    return next(b.section for b in model.blocks if isinstance(b.section, kind))


def first_frequency(study):
    made = joined(UpdateCase(study, read_model(study.places.sibling("strip.inp")), None, None, {}, (), ()), {})
    assert isinstance(made, Joined)
    return modes_up_to(made.system, 200.0).frequencies[0]


def test_numbers_of_a_deck_by_name(tmp_path):
    study = study_of(tmp_path, deck=PIECES)
    found = properties_of(read_model(tmp_path / "strip.inp"))
    assert found == {
        ("material", "STEEL", "youngs_modulus"): 210000.0,
        ("material", "STEEL", "density"): 7.85e-9,
        ("section", "S", "thickness"): 1.0,
        ("section", "FOOT", "stiffness"): 5.0,
        ("section", "TIP", "mass"): 1e-6,
        ("section", "JOINT", "stiffness_factor"): 1.0,
    }
    assert study.config.section == {}


def test_the_changed_deck_has_the_numbers(tmp_path):
    tables = (
        "[section.foot]\nstiffness = 8.0\n[section.Tip]\nmass = 2e-6\n[section.JOINT]\nstiffness_factor = 3.0\n"
        "[material.steel]\ndensity = 8e-9\n"
    )
    study = study_of(tmp_path, tables, PIECES)
    assert section(study, Spring).stiffness == 8.0
    assert section(study, PointMass).mass == 2e-6
    assert section(study, Bushing).stiffness[2, 2] == pytest.approx(21.0)


def test_a_strip_twice_as_thick_and_four_times_as_soft_is_as_high(tmp_path):
    """f ~ t sqrt(E / rho) of a thin plate."""
    first = first_frequency(study_of(tmp_path))
    tables = "[section.S]\nthickness = 0.5\n[material.STEEL]\nyoungs_modulus = 840000.0\n"
    assert first_frequency(study_of(tmp_path, tables)) == pytest.approx(first, rel=1e-3)
    heavy = "[material.STEEL]\ndensity = 31.4e-9\n"
    assert first_frequency(study_of(tmp_path, heavy)) == pytest.approx(0.5 * first, rel=1e-9)


@pytest.mark.parametrize("added", ["TOTAL MASS\n2.4e-6", "MASS PER AREA\n1e-9"])
def test_a_thicker_plate_has_no_more_nonstructural_mass(tmp_path, added):
    """rho t A and the mass itself; its density is the material's, and the study may change it."""
    mass = f"*NONSTRUCTURAL MASS, ELSET=S, UNITS={added}\n"
    tables = "[section.S]\nthickness = 2.0\n[material.STEEL]\ndensity = 8e-9\n"
    study = study_of(tmp_path, tables, mass)
    model = linear_structure(study, read_model(study.places.sibling("strip.inp"))).model
    assert part_system(model, 0, Rayleigh(0.0, 0.0)).stats.mass == pytest.approx((8e-9 * 2.0 + 1e-9) * 120.0 * 20.0)


def test_a_laminate_has_a_factor(tmp_path):
    plain = section(study_of(tmp_path, shell=LAYERS), GeneralShell)
    stiff = section(study_of(tmp_path, "[section.S]\nstiffness_factor = 2.0\n", shell=LAYERS), GeneralShell)
    for name in ("A", "B", "D", "S"):
        np.testing.assert_allclose(getattr(stiff, name), 2.0 * getattr(plain, name))
    assert stiff.mass == plain.mass


SPRINGS = """*KEYWORD
*NODE
1,0.,0.,0.
2,1.,0.,0.
3,1.,1.,0.
4,0.,1.,0.
5,0.,0.,1.
6,1.,0.,1.
7,1.,1.,1.
8,0.,1.,1.
*ELEMENT_SHELL
1,1,1,2,3,4
2,2,5,6,7,8
*PART
floor
1,1,1
*PART
lid
2,1,1
*SECTION_SHELL
1,2
0.1
*MAT_ELASTIC
1,7.8e-9,2.1e5,.3
*ELEMENT_DISCRETE
5,3,1,5,0
6,4,2,6,9
*PART
clips
3,3,3
*PART
hooks
4,3,3
*SECTION_DISCRETE
3,0
0.
*MAT_SPRING_ELASTIC
3,10.
*DEFINE_SD_ORIENTATION
9,0,0.,0.,1.
"""


def test_springs_of_an_lsdyna_deck_go_by_the_titles_of_their_parts(tmp_path):
    """Along their line they have a stiffness; along a vector they are a matrix, which has a factor."""
    (tmp_path / "deck.k").write_text(SPRINGS)
    model = read_model(tmp_path / "deck.k")
    path = tmp_path / "study.toml"
    path.write_text(
        '[model]\ndeck = "deck.k"\n[section.clips]\nstiffness = 30.0\n[section.HOOKS]\nstiffness_factor = 4.0\n'
    )
    changed = linear_structure(read_study(path), model).model
    assert next(b.section.stiffness for b in changed.blocks if b.kind == "axial2") == 30.0
    assert next(b.section.stiffness for b in changed.blocks if b.kind == "nodal2").max() == 40.0
    assert joints_of(model) == (
        "1 spring or dashpot element(s) between PART_2 and PART_1, first at nodes 5 and 1",
        "1 spring or matrix element(s) between PART_2 and PART_1, first at nodes 6 and 2",
    )


def test_a_title_of_several_parts_is_that_of_all_and_springs_that_differ_have_a_factor(tmp_path):
    """`floor` and `lid` get one title; a second clip has twice the stiffness (S = 2)."""
    deck = SPRINGS.replace("\nlid\n", "\nfloor\n").replace("5,3,1,5,0\n", "5,3,1,5,0\n7,3,3,7,0,2.\n")
    (tmp_path / "deck.k").write_text(deck)
    model = read_model(tmp_path / "deck.k")
    assert model.element_sets["FLOOR"].shape == (2, 2)
    path = tmp_path / "study.toml"
    path.write_text(
        '[model]\ndeck = "deck.k"\n[section.floor]\nthickness = 0.3\n[section.Clips]\nstiffness_factor = 5.0\n'
    )
    changed = linear_structure(read_study(path), model).model
    assert [b.section.thickness for b in changed.blocks if b.kind == "quad4"] == [0.3, 0.3]
    assert sorted(b.section.stiffness for b in changed.blocks if b.kind == "axial2") == [50.0, 100.0]
    assert start_of(read_study(path), model, "section.hooks.stiffness_factor") == 1.0
    both = "[section.PART_1]\nthickness = 0.2\n[section.FLOOR]\nthickness = 0.3\n"
    path.write_text(f'[model]\ndeck = "deck.k"\n{both}')
    with pytest.raises(InputError, match=r"\[section.PART_1\] and \[section.FLOOR\] both change PART_1"):
        linear_structure(read_study(path), model)
    path.write_text('[model]\ndeck = "deck.k"\n[section.CLIPS]\nstiffness = 5.0\n')
    with pytest.raises(InputError, match=r"'PART_3' of the deck has no single stiffness.*expected stiffness_factor"):
        linear_structure(read_study(path), model)
    path.write_text('[model]\ndeck = "deck.k"\n[section."Clip s"]\nstiffness = 5.0\n')
    with pytest.raises(InputError, match=r"no section 'Clip s'.*Did you mean 'CLIPS'"):
        linear_structure(read_study(path), model)


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ("[section.SS]\nthickness = 2.0\n", r"the deck has no section 'SS'.*Did you mean 'S'\?"),
        ("[material.STEAL]\ndensity = 2.0\n", r"the deck has no material 'STEAL'.*Did you mean 'STEEL'\?"),
        ("[section.S]\nmass = 2.0\n", r"the section 'S' of the deck has no single mass; expected thickness"),
        ("[section.S]\n", "changes nothing: give thickness"),
        ("[section.S]\nthickness = 2.0\nmass = 1.0\n", "no section has both mass and thickness"),
        ("[section.S]\nthickness = -2.0\n", "section.S.thickness = -2.0: input should be greater than 0"),
        ("[section.S]\nthicknes = 2.0\n", r"unknown key 'section.S.thicknes'. Did you mean 'thickness'\?"),
    ],
)
def test_wrong_tables_are_one_message(tmp_path, tables, said):
    with pytest.raises(InputError, match=said):
        linear_structure(study_of(tmp_path, tables), read_model(tmp_path / "strip.inp"))


def test_a_change_may_name_what_the_study_does_not(tmp_path):
    """As `creak run --set section.S.thickness=2`: the name is the deck's."""
    study = with_changes(study_of(tmp_path), {"section.S.thickness": 2.0})
    assert study.config.section["S"].thickness == 2.0
    with pytest.raises(InputError, match=r"the change section.SS.thickness = 2.0 of .*: the deck has no section 'SS'"):
        linear_structure(
            with_changes(study_of(tmp_path), {"section.SS.thickness": 2.0}), read_model(tmp_path / "strip.inp")
        )
