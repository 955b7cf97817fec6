"""What a card that is left out means: harmless, or a change of the answer that hangs on the analysis."""

from __future__ import annotations

import pytest

from creak.errors import InputError
from creak.formats.decks import read_model
from creak.formats.nastran.reader import read_nastran_run
from creak.formats.nastran.text.known_cards import CHANGES, HARMLESS, READ
from helpers_nastran import read

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
