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
