"""What decks share: cross-sections, the catalogue of keywords, connected pieces.

What a keyword that is left out means: harmless, or a change of the answer.
What a card that is left out means: harmless, or a change of the answer that hangs on the analysis.
"""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.sections.beam_shapes import SHAPES as ABAQUS
from creak.formats.deck.catalogue import Catalogue, Meaning, listed
from creak.formats.deck.cross_section import composed, principal
from creak.formats.deck.parts import NO_LINKS, Rows, join_neighbours, number_points
from creak.formats.decks import read_model
from creak.formats.nastran.reader import read_nastran_run
from creak.formats.nastran.sections.bar_shapes import SHAPES as NASTRAN
from creak.formats.nastran.text.known_cards import CHANGES, HARMLESS, READ
from helpers_nastran import read


@pytest.mark.parametrize(
    ("abaqus", "nastran"),
    [
        (("BOX", (20.0, 30.0, 2.0, 3.0, 2.0, 3.0)), ("BOX", (30.0, 20.0, 2.0, 3.0))),
        (("I", (15.0, 30.0, 20.0, 24.0, 2.0, 3.0, 1.5)), ("I", (30.0, 20.0, 24.0, 1.5, 2.0, 3.0))),
        (("CIRC", (4.0,)), ("ROD", (4.0,))),
        (("PIPE", (4.0, 0.5)), ("TUBE2", (4.0, 0.5))),
    ],
)
def test_one_section_has_the_same_moments_in_both_formats(abaqus, nastran):
    """The height of Nastran's I lies along axis 1, of Abaqus's along axis 2; the box is given turned."""
    a, n = ABAQUS[abaqus[0]][1](abaqus[1]), NASTRAN[nastran[0]][1](*nastran[1])
    turned = (n.area, n.i22, n.i11, n.torsion) if abaqus[0] == "I" else (n.area, n.i11, n.i22, n.torsion)
    assert (a.area, a.i11, a.i22, a.torsion) == pytest.approx(turned, rel=1e-12)


def test_unequal_angle_is_turned_to_its_principal_axes():
    """Moments of a fine grid of points about axes through the centroid, turned by the angle."""
    angle = composed([(0.5, 5.0, 1.0, 10.0), (3.5, 0.5, 5.0, 1.0)])
    i1, i2, turn = principal(angle.i11, angle.i22, angle.i12)
    x, y = np.meshgrid(np.arange(0.005, 6.0, 0.01), np.arange(0.005, 10.0, 0.01))
    inside = (x < 1.0) | (y < 1.0)
    x, y = x[inside] - x[inside].mean(), y[inside] - y[inside].mean()
    along, across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    assert (i1, i2) == pytest.approx((1e-4 * (across**2).sum(), 1e-4 * (along**2).sum()), rel=1e-4)
    assert abs((along * across).sum()) < 1e-6 * (across**2).sum()


CATALOGUE = Catalogue("word", {"MASS": Meaning("read"), **listed("harmless", {"it draws": "PLOT, PAINT"})})


@pytest.mark.parametrize(
    ("name", "role", "why"),
    [
        ("MASS", "read", ""),
        ("PAINT", "harmless", "it draws"),
        ("MASSS", "changes", "creak does not know this word. Did you mean 'MASS'?"),
        ("XYZZY", "changes", "creak does not know this word"),
    ],
)
def test_an_unknown_word_changes_the_answer(name, role, why):
    assert (CATALOGUE.meaning(name).role, CATALOGUE.meaning(name).why) == (role, why)


def test_the_first_misspelled_word_is_hinted_at():
    named = [("XYZZY", "Xyzzy", "a:1"), ("PLOTT", "Plott", "a:2"), ("MASSS", "Masss", "a:3"), ("PLOTT", "Plott", "a:4")]
    assert CATALOGUE.misspelled(named) == "Note that Plott at a:2 is not a word that creak knows. Did you mean 'PLOT'?"
    assert CATALOGUE.misspelled(named[:1]) == ""


def test_loose_nodes_join_the_one_part_that_they_reach():
    """0, 1 are part 0 and 2 is part 1: 3-4 hang on part 0, 5 on both, 6 on none, 7 has mass and a spring to part 1."""
    of_node = np.array([0, 0, 1, -1, -1, -1, -1, -1])
    join_neighbours(Rows.of_lists([[0, 3], [4, 3], [1, 5], [2, 5]]), of_node)
    assert of_node.tolist() == [0, 0, 1, 0, 0, -1, -1, -1]
    count = number_points(Rows.of_lists([[6], [2, 7]]), NO_LINKS, np.array([7]), of_node, 2)
    assert (count, of_node.tolist()) == (4, [0, 0, 1, 0, 0, -1, 2, 3])


ROD = (
    "*NODE, NSET=ALL\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=T3D2, ELSET=E\n1, 1, 2\n"
    "*MATERIAL, NAME=M\n*ELASTIC\n2.E5, .3\n*DENSITY\n1.E-9\n*SOLID SECTION, ELSET=E, MATERIAL=M\n1.\n"
)
DESIGN = "*DESIGN PARAMETER\nh\n*DESIGN VARIABLES, TYPE=COORDINATE\nALL\n"
STEPS = (
    "*STEP\n*FREQUENCY\n2\n*END STEP\n*STEP\n*SENSITIVITY\n*DESIGN RESPONSE, NAME=R\nEIGENFREQUENCY\n"
    "*OBJECTIVE\nR\n*CONSTRAINT\nR, LE, 1., 2.\n*FILTER, TYPE=LINEAR\n3.\n*NODE FILE\nSEN\n*END STEP\n"
)


def test_design_and_its_sensitivities_change_nothing(tmp_path):
    path = tmp_path / "d.inp"
    path.write_text(ROD + DESIGN + STEPS)
    found = {u.keyword: u for u in read_deck(path).unread}
    assert not [u.keyword for u in found.values() if u.changes_answer]
    for name in ("DESIGN PARAMETER", "DESIGN VARIABLES"):
        assert "design only" in found[f"*{name}"].why


BULK = "GRID,1,,0.,0.,0.,,123456\nGRID,2,,1.,0.,0.\nCROD,1,1,1,2\nPROD,1,1,1.\nMAT1,1,2.+5,,.3,1.-9\n"


def meaning(tmp_path, cards, case=""):
    """Card -> whether it changes the answer."""
    return {u.keyword: u.changes_answer for u in read(tmp_path, BULK + cards + "\n", case).unread}


@pytest.mark.parametrize(
    ("cards", "case", "changes"),
    [
        ("ASET1,123,2", "", True),
        ("OMIT1,123,2", "", True),
        ("ASET1,123,2\nQSET1,1,1001\nSPOINT,1001", "", None),
        ("SUPORT,2,123", "", False),
        ("MATT1,1,5\nTABLEM1,5\n,0.,1.,ENDT", "TEMPERATURE(INITIAL) = 3", True),
        ("MATT1,1,5\nTABLEM1,5\n,0.,1.,ENDT", "", False),
        ("TEMPD,3,20.", "TEMPERATURE(LOAD) = 3", False),
        ("GRAV,3,,9.81,0.,0.,-1.", "LOAD = 3", False),
        ("SPCD,3,2,1,.1", "", False),
        ("PBUSHT,1,K,5", "", False),
        ("TABDMP1,1,CRIT\n,0.,.02,ENDT", "SDAMPING = 1", False),
        ("MATS1,1,,PLASTIC,0.,1,1,200.", "", False),
        ("NLPARM,1,5", "NLPARM = 1", False),
        ("PARAM,LMODES,20", "", False),
        ("PARAM,KDAMP,-1", "", False),
        ("PARAM,LGDISP,1", "", False),
        ("PARAM,INREL,-1", "", True),
        ("BOLT,1,1,2", "", True),
        ("CSUPER,1,2,2", "", True),
        ("MDLPRM,HDOT,2", "", False),
        ("MDLPRM,OFFDEF,NOMASS", "", True),
        ("PSET,1,2", "", False),
        ("PSET,1,2", "ADAPT = 1", True),
        ("PARAM,WTMAS,.00259", "", True),
        ("PARAM,ALPHA1FL,.1", "", None),
    ],
)
def test_meaning(tmp_path, cards, case, changes):
    found = meaning(tmp_path, cards, case + "\n")
    name = cards.split(",")[0] if not cards.startswith("PARAM") else ",".join(cards.split(",")[:2])
    assert found.get(name) == changes
    assert not any(value for key, value in found.items() if key != name)


@pytest.mark.parametrize(
    "card",
    [
        *("CBARAO,1,SCALE,.2,.4", "SEQGP,1,2,2,1", "AECOMPL,A,B", "YPARAM,1", "DSCONS,1,A", "SPLINE3,1,2,3", "UXVEC,1"),
        *("PANLST1,1,2", "CAERO5,1,2", "AEFORCE,1.1,A", "MONSUM,A,b, c", "PLOTTET,1,2", "DVSET,1,2", "SET4,1,PROP"),
    ],
)
def test_cards_of_design_air_and_plots_change_nothing(tmp_path, card):
    assert meaning(tmp_path, card) == {card.split(",")[0]: False}


def test_a_displacement_of_spc_is_zero_in_modes(tmp_path):
    """As in Nastran; it is told."""
    model = read(tmp_path, BULK + "SPC,3,2,1,.1\n", "SPC = 3\n")
    assert {u.keyword: u.changes_answer for u in model.unread} == {"SPC, D": False}
    assert model.fixed[-1].nodes_idx.tolist() == [1]
    held = BULK + "SPC,3,2,1,.1\nTLOAD1,7,6,,LOAD,8\nTABLED1,8\n,0.,0.,1.,1.,ENDT\nFORCE,6,2,,1.,0.,1.\nTSTEP,5,9,.1\n"
    (tmp_path / "run.bdf").write_text(f"SOL 109\nCEND\nSPC = 3\nDLOAD = 7\nTSTEP = 5\nBEGIN BULK\n{held}ENDDATA\n")
    assert {u.keyword for u in read_nastran_run(tmp_path / "run.bdf")[0].unread if u.changes_answer} == {"SPC, D"}


@pytest.mark.parametrize(
    ("case", "changes"),
    [
        ("MPCS = 1", True),
        ("METHD = 1", True),
        ("METHOD = 1\nSUBCASE 1\nSPC = 1\nSUBCASE 2\nSPC = 2", True),
        ("SPC = 1\nSUBCASE 1\nLOAD = 1\nSUBCASE 2\nLOAD = 2", False),
        ("SUBCASE 1\nSPC = 2\nLOAD = 1\nSUBCASE 2\nSPC = 1\nMETHOD = 1", False),
        ("SPCFORCES = ALL\nSPCF = ALL\nMPCF = ALL\nOLOAD = ALL\nCMETHOD = 1\nSUBTITLE = x\nSDISP = 1", False),
    ],
)
def test_commands_of_another_structure_are_no_matter_of_output(tmp_path, case, changes):
    """A command that looks misspelled, and a subcase with other supports."""
    assert any(meaning(tmp_path, "SPC1,1,123,2\nSPC1,2,12,2", case + "\n").values()) == changes


@pytest.mark.parametrize("solution", ["103", "SEMODES", "MODES", "3", "3,1", "12"])
def test_condensed_mass_is_told_for_each_name_of_a_solution(tmp_path, solution):
    """Also for rigid formats of NASTRAN and words of MYSTRAN."""
    path = tmp_path / "deck.bdf"
    path.write_text(f"SOL {solution}\nCEND\nBEGIN BULK\n{BULK}ASET1,12 6,2\nDEBUG,185,1\nENDDATA\n")
    assert {u.keyword: u.changes_answer for u in read_model(path).unread} == {"ASET1": True, "DEBUG": False}


def test_dofs_may_stand_apart(tmp_path):
    model = read(tmp_path, BULK + "SPC1     1       12  6   2\n", "SPC = 1\n")
    assert model.fixed[-1].dofs == (1, 2, 6)
    held = "GRDSET                                                  12 4 6\nGRID    9               0.      5.\n"
    assert (1, 2, 4, 6) in [f.dofs for f in read(tmp_path, BULK + held).fixed]


def test_words_of_a_parameter_of_the_case_control_stand_anywhere(tmp_path):
    cards = BULK + "SPC1,1,123,2\n"
    light, heavy = (read(tmp_path, cards, f"{line}\n") for line in ("param post 0", "  PARAM   wtmass  2.  $ twice"))
    (mass,) = (b.section.material.density for b in light.blocks if b.kind == "truss2")
    assert [b.section.material.density for b in heavy.blocks if b.kind == "truss2"] == [2.0 * mass]
    assert not any(u.changes_answer for u in light.unread)


def test_each_card_has_one_meaning():
    names = [*READ, *HARMLESS, *CHANGES]
    assert len(set(names)) == len(names)
    assert all(len(known.why) > 10 for known in (*HARMLESS.values(), *CHANGES.values()))


def test_a_known_card_is_no_misspelling(tmp_path):
    """The hint beside an error names no card that creak knows."""
    for known in ("CGAP,9,9,1,2,1.,0.,0.", "MATT1,1,5", "TSTEP,1,10,.1", "PBUSHT,1,K,5"):
        with pytest.raises(InputError, match="CROD 2 uses property 7") as error:
            read(tmp_path, BULK + known + "\nCROD,2,7,1,2\n")
        assert "not a card" not in str(error.value)
    with pytest.raises(InputError, match=r"CRODD at .* is not a card that creak knows. Did you mean 'CROD'"):
        read(tmp_path, BULK + "CRODD,3,1,1,2\nCROD,2,7,1,2\n")


def test_gravity_is_said_to_be_that_of_static_in_a_study(tmp_path):
    listed = {u.keyword: u.why for u in read(tmp_path, BULK + "GRAV,3,,9.81,0.,0.,-1.\n", "LOAD = 3\n").unread}
    assert "[[static]]" in listed["GRAV"]


def test_structural_damping_acts_over_frequency_alone(tmp_path):
    """As in Abaqus's direct integration: it stops nothing, and the modal damping that does the same is named."""
    path = tmp_path / "d.inp"
    path.write_text(ROD.replace("*DENSITY", "*DAMPING, ALPHA=3., STRUCTURAL=.04\n*DENSITY"))
    model = read_deck(path)
    (found,) = model.unread
    assert (found.keyword, found.changes_answer, found.damps) == ("*DAMPING, STRUCTURAL", False, True)
    assert "modal = 0.02" in found.why
    assert model.blocks[0].section.material.alpha == 3.0
    path.write_text(ROD.replace("*DENSITY", "*DAMPING, STRUCTURAL=-.04\n*DENSITY"))
    with pytest.raises(InputError, match=r"damping STRUCTURAL of material 'M' is -0\.04"):
        read_deck(path)


def test_an_element_that_is_treated_as_another_was_read(tmp_path):
    path = tmp_path / "d.inp"
    path.write_text(
        ROD.replace("T3D2", "B31").replace(
            "*SOLID SECTION, ELSET=E, MATERIAL=M\n1.",
            "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=CIRC\n1.\n0., 0., 1.",
        )
    )
    (found,) = read_deck(path).unread
    assert (found.keyword, found.word) == ("*ELEMENT, TYPE=B31", "read")
