"""NSM cards: mass per area or length, total mass spread over elements, sets of sets."""

from __future__ import annotations

import pytest

from creak.errors import InputError
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.writer import write_nastran
from helpers_nastran import read, rigid_mass, unread

PLATE = (
    "GRID,1,,0.,0.,0.\nGRID,2,,4.,0.,0.\nGRID,3,,4.,2.,0.\nGRID,4,,0.,2.,0.\nGRID,5,,7.,0.,0.\nGRID,6,,7.,2.,0.\n"
    "CQUAD4,1,1,1,2,3,4\nCTRIA3,2,2,2,5,6\nCTRIA3,3,2,2,6,3\nPSHELL,1,1,.5,1,,1\nPSHELL,2,1,.5\n"
    "CBAR,11,5,1,2,0.,0.,1.\nPBAR,5,1,1.,1.,1.,1.\nCONROD,12,4,3,1,2.\nMAT1,1,1.+5,,.3\nPARAM,WTMASS,2.\n"
)


def mass(tmp_path, cards, case="NSM = 1\n"):
    """Half the mass and its centre: WTMASS is 2."""
    M = 0.5 * rigid_mass(read(tmp_path, PLATE + cards, case))
    return M[0, 0], -M[0, 5] / M[0, 0] if M[0, 0] else 0.0


@pytest.mark.parametrize(
    ("cards", "wanted"),
    [
        ("NSM,1,PSHELL,1,.25,2,.5", 0.25 * 8.0 + 0.5 * 6.0),
        ("NSM1,1,ELEMENT,.25,1,THRU,2", 0.25 * (8.0 + 3.0)),
        ("NSM1,1,PSHELL,.25,ALL", 0.25 * 14.0),
        ("NSML,1,PSHELL,1,3.,2,5.", 8.0),
        ("NSML1,1,PSHELL,7.,1,2", 7.0),
        ("NSML1,1,ELEMENT,7.,2,3", 7.0),
        ("NSM1,1,PBAR,.5,5", 2.0),
        ("NSM,1,CONROD,12,.5", 2.0),
        ("NSMADD,1,7,8\nNSM1,7,PBAR,.5,5\nNSML1,8,PBAR,6.,5", 8.0),
        ("NSML1,2,PSHELL,7.,1,2", 0.0),
    ],
)
def test_total(tmp_path, cards, wanted):
    case = "NSM = 2\nSUBCASE 1\nNSM = 1\n" if cards.startswith("NSML1,2") else "NSM = 1\n"
    cards = cards + "\nNSM1,1,PBAR,0.,5" if cards.startswith("NSML1,2") else cards
    assert mass(tmp_path, cards + "\n", case)[0] == pytest.approx(wanted)


def test_spread_by_area(tmp_path):
    """7 over 14 of area: the centre of mass is that of the whole plate, at y = 1."""
    assert mass(tmp_path, "NSML1,1,PSHELL,7.,1,2\n") == pytest.approx((7.0, 1.0))


@pytest.mark.parametrize("form", ["", "PARAM,COUPMASS,1\n"])
@pytest.mark.parametrize(
    ("own", "nsm", "card"),
    [
        ("2.,2.,2.,2.", ".3", ""),
        ("1.,2.,3.,2.", ".3", ""),
        ("2.,2.,2.,2.", "", "NSM1,1,PSHELL,.3,ALL\n"),
        ("1.,3.,3.,1.", "", "NSML1,1,PSHELL,2.4,1\n"),
    ],
)
@pytest.mark.parametrize("bending", ["1", "2"])
def test_elements_with_a_thickness_of_their_own(tmp_path, form, own, nsm, card, bending):
    """(rho t + NSM) A with the mean thickness 2 of the element, not the 1 of PSHELL: (.1 2 + .3) 8."""
    bulk = (
        "GRID,1,,0.,0.,0.\nGRID,2,,4.,0.,0.\nGRID,3,,4.,2.,0.\nGRID,4,,0.,2.,0.\n"
        f"CQUAD4,1,1,1,2,3,4\n,,,{own}\nPSHELL,1,1,1.,{bending},,1,,{nsm}\nMAT1,1,1.+5,,.3,.1\nMAT1,2,1.+4,,.3,.1\n{form}"
    )
    model = read(tmp_path, bulk + card, "NSM = 1\n" if card else "")
    assert rigid_mass(model)[0, 0] == pytest.approx((0.1 * 2.0 + 0.3) * 8.0)
    write_nastran(model, tmp_path / "copy.bdf")
    assert rigid_mass(read_nastran(tmp_path / "copy.bdf")) == pytest.approx(rigid_mass(model), rel=1e-9, abs=1e-9)


def test_not_taken(tmp_path):
    """Without NSM in the case control Nastran adds nothing; bulk data alone takes the only set."""
    cards = "NSM1,3,PSHELL,.25,1\n"
    model = read(tmp_path, PLATE + cards, "TITLE = x\n")
    assert rigid_mass(model)[0, 0] == 0.0
    assert unread(model)["NSM1"] is False
    alone = tmp_path / "alone.bdf"
    alone.write_text(PLATE + cards, encoding="utf-8")
    assert rigid_mass(read_nastran(alone))[0, 0] == pytest.approx(4.0)


def test_converted(tmp_path):
    """The heavier elements are written with properties of their own."""
    model = read(
        tmp_path, PLATE.replace("MAT1,1,1.+5,,.3", "MAT1,1,1.+5,,.3,.1") + "NSM1,1,ELEMENT,.25,1,2,11\n", "NSM = 1\n"
    )
    write_nastran(model, tmp_path / "copy.bdf")
    assert rigid_mass(read_nastran(tmp_path / "copy.bdf")) == pytest.approx(rigid_mass(model), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("cards", "message"),
    [
        ("NSM,2,PSHELL,1,.25", "NSM = 1 in the case control, but no card has this set"),
        ("NSM,1,PSOLID,1,.25", "field 3 of NSM is 'PSOLID'; expected PSHELL"),
        ("NSML1,1,ELEMENT,3.,1,11", "spreads one mass over shells and bars"),
    ],
)
def test_mistakes(tmp_path, cards, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, PLATE + cards + "\n", "NSM = 1\n")


TYPES = (
    "GRID,1,,0.,0.,0.\nGRID,2,,4.,0.,0.\nGRID,3,,4.,3.,0.\nGRID,4,,0.,3.,0.\nGRID,5,,10.,0.,0.\nGRID,6,,10.,3.,0.\n"
    "CQUAD4,1,1,1,2,3,4\nPSHELL,1,1,.5,1,,1\nCQUAD4,2,2,2,5,6,3\nPCOMP,2\n,1,.5\nMAT1,1,1.+5,,.3\n"
    "CBAR,11,11,1,4,0.,0.,1.\nPBAR,11,1,1.,1.,1.,1.\nCBAR,12,12,1,3,0.,0.,1.\nPBARL,12,1,,ROD\n,1.\n"
    "CBEAM,13,13,1,2,0.,0.,1.\nPBEAM,13,1,1.,1.,1.,,1.\nCBEAM,14,14,2,5,0.,0.,1.\nPBEAML,14,1,,ROD\n,1.\n"
    "CROD,15,11,4,6\nPROD,11,1,1.\nCTUBE,16,16,5,6\nPTUBE,16,1,1.\nCONROD,17,2,6,1,1.\nPARAM,WTMASS,2.\n"
)
"""Every type once: areas 12 (PSHELL) and 18 (PCOMP), lengths PBAR 3, PBARL 5, PBEAM 4, PBEAML 6, PROD 10, PTUBE 3 and
CONROD the root of 45. PROD has the id of the PBAR, 11."""


@pytest.mark.parametrize(
    ("cards", "wanted"),
    [
        ("NSM1,1,PSHELL,.1,ALL", 0.1 * 30.0),
        ("NSM1,1,PCOMP,.1,ALL", 0.1 * 30.0),
        ("NSML1,1,PCOMPG,7.,ALL", 7.0),
        ("NSM1,1,PSHELL,.1,1", 0.1 * 12.0),
        ("NSM1,1,PBAR,.1,ALL", 0.1 * 8.0),
        ("NSM1,1,PBARL,.1,ALL", 0.1 * 8.0),
        ("NSM1,1,PBAR,.1,11", 0.1 * 3.0),
        ("NSM,1,PBAR,11,.1,13,.1", 0.1 * 3.0),
        ("NSM1,1,PBEAM,.1,ALL", 0.1 * 10.0),
        ("NSM1,1,PBEAML,.1,14", 0.1 * 6.0),
        ("NSM1,1,PROD,.1,ALL", 0.1 * 10.0),
        ("NSM1,1,PROD,.1,11", 0.1 * 10.0),
        ("NSM1,1,PROD,.1,1,THRU,20", 0.1 * 10.0),
        ("NSM1,1,PTUBE,.1,ALL", 0.1 * 3.0),
        ("NSM1,1,CONROD,.1,ALL", 0.1 * 45.0**0.5),
        ("NSM1,1,CONROD,.1,11,17", 0.1 * 45.0**0.5),
        ("NSM1,1,PBEAM,.1,11", 0.0),
    ],
)
def test_type(tmp_path, cards, wanted):
    """A type reaches its own elements and those that Nastran counts with them (PBARL as PBAR, PBEAML as PBEAM, PCOMP as
    PSHELL), whatever ids other types have."""
    M = rigid_mass(read(tmp_path, f"{TYPES}{cards}\n", "NSM = 1\n"))
    assert 0.5 * M[0, 0] == pytest.approx(wanted, abs=1e-12)


def test_one_mass_over_the_elements_of_a_type(tmp_path):
    """5 along the PROD alone, from x = 0 to 10 at y = 3."""
    M = 0.5 * rigid_mass(read(tmp_path, f"{TYPES}NSML1,1,PROD,5.,ALL\n", "NSM = 1\n"))
    assert (M[0, 0], -M[0, 5], M[1, 5]) == pytest.approx((5.0, 5.0 * 3.0, 5.0 * 5.0))


@pytest.mark.parametrize(
    ("card", "why"),
    [
        ("NSM1,1,PTUBE,.1,11,16", "11 is of type PBAR, not PTUBE"),
        ("NSM1,1,CONROD,.1,11", "11 is of type PBAR, not CONROD"),
        ("NSM1,1,PBEAM,.1,ALL", "PBEAML is taken with PBEAM, as Nastran does"),
        ("NSM1,1,PTUBE,.1,1,THRU,20", None),
        ("NSM1,1,PROD,.1,11", None),
    ],
)
def test_what_other_types_have_is_told(tmp_path, card, why):
    found = [u.why for u in read(tmp_path, f"{TYPES}{card}\n", "NSM = 1\n").unread if u.keyword.startswith("NSM")]
    assert (why is None) == (not found)
    assert why is None or any(text.startswith(why) for text in found)


@pytest.mark.parametrize(
    ("offsets", "length"), [("", 100.0), ("20.,0.,0.,-20.,0.,0.", 60.0), ("0.,0.,9.", 10081.0**0.5)]
)
@pytest.mark.parametrize("kind", ["PBAR", "ELEMENT"])
def test_one_mass_over_bars_with_offsets(tmp_path, offsets, length, kind):
    """The share per length is that between the ends of the offsets, where the bar is."""
    bulk = (
        "GRID,1,,0.,0.,0.\nGRID,2,,100.,0.,0.\nMAT1,1,7.+4,,.3\nPBAR,13,1,10.,10.,10.,10.\n"
        f"CBAR,13,13,1,2,0.,1.,0.\n,,,{offsets}\nNSML1,5,{kind},1.-3,13\n"
    )
    model = read(tmp_path, bulk, "NSM = 5\n")
    assert rigid_mass(model)[0, 0] == pytest.approx(1e-3)
    assert model.blocks[0].section.line_mass == pytest.approx(1e-3 / length, rel=1e-6)


@pytest.mark.parametrize("card", ["NSM1,5,ELEMENT,1.-6,13", "NSM,5,ELEMENT,13,1.-6", "NSML1,5,ELEMENT,1.-4,13"])
def test_a_tapered_bar_by_its_id(tmp_path, card):
    """1e-6 along the 100 of the whole bar, whose middle is at x = 50 and whose inertia is m L^2/3 about its end."""
    bulk = (
        "GRID,1,,0.,0.,0.\nGRID,2,,100.,0.,0.\nGRID,3,,0.,50.,0.\nMAT1,1,7.+4,,.3\nCBEAM,13,13,1,2,0.,1.,0.\n"
        "PBEAM,13,1,20.,10.,10.,,10.\n,,,,,,,,\n,YES,1.,10.,5.,5.,,5.\nCROD,14,14,1,3\nPROD,14,1,1.\nPARAM,COUPMASS,1\n"
    )
    M = rigid_mass(read(tmp_path, f"{bulk}{card}\n", "NSM = 5\n"))
    assert (M[0, 0], M[1, 5], M[5, 5]) == pytest.approx((1e-4, 1e-4 * 50.0, 1e-4 * 1e4 / 3.0), rel=1e-4)
