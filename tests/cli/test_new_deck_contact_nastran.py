"""`creak new` takes over contact of NX, MSC and OptiStruct decks: regions, friction, clearance; `creak info` tells it."""

from __future__ import annotations

import json
import tomllib

import pytest

from helpers_nastran_strips import strips

pytestmark = pytest.mark.usefixtures("no_page")

REGIONS = "BSURF,11,1,THRU,24\nBSURF,12,1001,THRU,1024"
BODIES = "BSURF,11,1,THRU,24\nBCPROP,12,2\nBCBODY,1,3D,DEFORM,11\nBCBODY1,2,,3D,DEFORM,12"
NX = f"{REGIONS}\nBCTSET,5,11,12,.3,0.,10."
SURFACES = "SURF,11,ELEM\n,1,THRU,24\nSURF,12,ELEM\n,1001,THRU,1024"


def taken(creak, folder, deck):
    """Tables of the contacts of the study that is written, and what is told."""
    (folder / "strips.bdf").write_text(deck)
    said = creak("new", folder / "strips.bdf", "--json").done()
    told = json.loads(said.out)
    assert told["ready"]
    return tomllib.loads((folder / "strips.toml").read_text())["contact"], told


@pytest.mark.parametrize(
    ("cards", "sides"),
    [
        (NX, ("BSURF_11", "BSURF_12")),
        (f"{NX}\nBCRPARA,11,BOT\nBCRPARA,12,TOP", ("BSURF_11.SNEG", "BSURF_12.SPOS")),
        (f"{REGIONS}\nBCTADD,9,5\nBCTSET,5\n,,11,12,.3", ("BSURF_11", "BSURF_12")),
        (f"{BODIES}\nBCTABLE,3,,,1\n,SLAVE,1,,,.3\n,,0,0,0\n,MASTERS,2", ("BSURF_11", "BCPROP_12")),
        (f"{BODIES}\nBCTABL1,3,57\nBCONECT,57,,91,1,2\nBCONPRP,91,,FRIC,.3", ("BSURF_11", "BCPROP_12")),
        (f"{SURFACES}\nCONTACT,5,.3,11,12", ("SURF_11", "SURF_12")),
        (f"{SURFACES}\nPCONT,7,,,.3\nCONTACT,5,7,11,12", ("SURF_11", "SURF_12")),
    ],
)
def test_a_pair_of_each_program(creak, tmp_path, cards, sides):
    """The strips are 0.5 mm apart; all 39 grids of the upper one are over the lower one, which is named by its part."""
    contacts, told = taken(creak, tmp_path, strips(extra=cards))
    table = contacts["pid_1-pid_2"]
    assert (table["secondary"], table["main"], table["friction"]) == (*sides, 0.3)
    (contact,) = told["contacts"]
    assert (contact["channels"], contact["start"]) == (39, pytest.approx(0.5))
    assert told["warnings"] == []


def brick(base, pid, z):
    """Two CHEXA of 10 mm side by side at height z, with grids base + 1 to 12: the lower layer first."""
    grid = [
        f"GRID,{base + 6 * k + 3 * j + i + 1},,{10 * i}.,{10 * j}.,{z + 10 * k}"
        for k in (0, 1)
        for j in (0, 1)
        for i in range(3)
    ]
    ring = [[base + n for n in (1 + i, 2 + i, 5 + i, 4 + i)] for i in (0, 1)]
    hexa = [
        f"CHEXA,{base + i + 1},{pid},{','.join(map(str, [*r, *(n + 6 for n in r[:2])]))}\n,{r[2] + 6},{r[3] + 6}"
        for i, r in enumerate(ring)
    ]
    return "\n".join([*grid, *hexa]) + "\n"


def bricks(cards):
    held = "SPC1,1,123,101,THRU,104\nSPC1,1,12,207,THRU,212\nPSOLID,1,1\nPSOLID,2,1\nMAT1,1,2.+5,,.3,7.8-9\n"
    head = "SOL 101\nCEND\nSPC = 1\nBCSET = 5\nSET 1 = 207 THRU 212\nBEGIN BULK\n"
    return f"{head}{brick(100, 1, 0.0)}{brick(200, 2, 10.4)}{held}{cards}\nENDDATA\n"


FACES = "BSURFS,11,,,,201,201,202,204\n,202,202,203,206\nBSURFS,12,,,,101,107,108,110\n,102,108,109,111\n"


def test_faces_of_bsurfs_are_the_contact_not_those_behind(creak, tmp_path):
    """Six grids of the lower face of the upper bricks, 0.4 mm over the others; a set that BCSET does not name is none."""
    contacts, told = taken(creak, tmp_path, bricks(f"{FACES}BCTSET,5,11,12,.2\nBCTSET,6,12,11,.9\n"))
    ((_, table),) = contacts.items()
    assert (table["secondary"], table["main"], table["friction"]) == ("BSURFS_11", "BSURFS_12", 0.2)
    assert (told["contacts"][0]["channels"], told["contacts"][0]["start"]) == (6, pytest.approx(0.4))


def test_two_faces_of_one_element_are_both_of_the_region(creak, tmp_path):
    """A side of the brick beside its top: the info counts facets."""
    (tmp_path / "two.bdf").write_text(bricks("BSURFS,12,,,,101,107,108,110\n,101,101,104,107\n"))
    assert json.loads(creak("info", tmp_path / "two.bdf", "--json").out)["surfaces"]["BSURFS_12"] == {"facets": 2}


def test_friction_of_bodies_is_their_mean(creak, tmp_path):
    """0.2 of a BCBODY and 0.4 of a BCBODY1, for a pair that has none of its own."""
    bodies = (
        BODIES.replace("DEFORM,11", "DEFORM,11,,.2").replace("BCBODY1,2,,", "BCBODY1,2,8,") + "\nBCBDPRP,8,,FRIC,.4"
    )
    contacts, _ = taken(creak, tmp_path, strips(extra=f"{bodies}\nBCTABLE,3,,,1\n,SLAVE,1\n,MASTERS,2"))
    assert contacts["pid_1-pid_2"]["friction"] == 0.3


def test_a_region_that_is_wrong_stops_no_deck_that_does_not_need_it(creak, tmp_path):
    """A BSURF of all numbers is one of all elements; a grid that there is not makes no surface."""
    wrong = f"{NX.replace('1,THRU,24', '1,THRU,999')}\nBSURF,13,1,THRU,99999999\nBSURFS,14,,,,1,9991,9992,9993"
    (tmp_path / "strips.bdf").write_text(strips(extra=wrong))
    told = json.loads(creak("info", tmp_path / "strips.bdf", "--json").out)
    facets = {name: of["facets"] for name, of in told["surfaces"].items() if name.startswith("BSURF")}
    assert (facets["BSURF_11"], facets["BSURF_13"]) == (24, 48)
    assert "BSURFS_14" not in facets
    assert "no surface of it: " in {u["keyword"]: u["why"] for u in told["unread"]}["BSURFS"]


def test_kinetic_friction_of_optistruct(creak, tmp_path):
    contacts, _ = taken(creak, tmp_path, strips(extra=f"{SURFACES}\nPCONT,7,,,.3,.1\nCONTACT,5,7,11,12"))
    assert contacts["pid_1-pid_2"]["friction"] == {"static": 0.3, "kinetic": 0.1, "decay": 0.0}


@pytest.mark.parametrize(
    ("cards", "clearance"),
    [
        (f"{NX}\nBCTPARM,5,PENN,10.,INIPENE,3", 0.0),
        (f"{NX}\nBCTPARA,5,INIPENE,3,GAPVAL,.2", 0.2),
        (f"{NX}\nBCTPARM,6,INIPENE,3", None),
        (f"{SURFACES}\nCONTACT,5,.3,11,12,,,,.2", 0.2),
        (f"{SURFACES}\nPCONT,7,,,.3,,.1\nCONTACT,5,7,11,12", 0.1),
    ],
)
def test_gaps_that_the_deck_sets(creak, tmp_path, cards, clearance):
    contacts, _ = taken(creak, tmp_path, strips(extra=cards))
    assert contacts["pid_1-pid_2"].get("clearance") == clearance


@pytest.mark.parametrize(
    ("cards", "words"),
    [
        (f"{NX}\nBCRPARA,11,,.1", "OFFSET .1"),
        (f"{NX}\nBCRPARA,12,,,RIGID", "BCRPARA 12"),
        (f"{REGIONS}\nBCTSET,5,11,13,.3", "region 13, which has no shells or solids"),
        (f"{BODIES}\nBCTABL1,3,57\nBCONECT,57,,91,1,2\nBCONPRP,91,,FRIC,4", "a coefficient of friction; it is 0"),
        (f"{BODIES.replace('2,,3D,DEFORM', '2,,3D,RIGID')}\nBCTABLE,3,,,1\n,SECNDRY,1\n,PRIMARY,2", "which is RIGID"),
        (f"{SURFACES}\nCONTACT,5,STICK,11,12", "field 3 of CONTACT is 'STICK'"),
        (f"{BODIES}\nBCTABL1,3,58", "contact pair 58, which is not defined"),
    ],
)
def test_what_is_not_taken_over_is_told(creak, tmp_path, cards, words):
    _, told = taken(creak, tmp_path, strips(extra=cards))
    assert len(told["contacts"]) == 1, "what is near is proposed where the pair is wrong"
    assert words in " ".join(told["warnings"])


def test_the_info_tells_what_is_used_and_what_is_not(creak, tmp_path):
    (tmp_path / "strips.bdf").write_text(strips(extra=f"{NX}\nBCTPARM,5,PENN,10.,INIPENE,3\nBLSEG,4,1,2,3"))
    told = json.loads(creak("info", tmp_path / "strips.bdf", "--json").out)
    assert told["contact"] == {"BSURF_11 - BSURF_12": "friction 0.3, clearance 0.0"}
    why = {u["keyword"]: u["why"] for u in told["unread"] if not u["changes_answer"]}
    assert (
        why["BCTSET 5"] == "1 contact pair(s) for `creak new`; a run has those of its study; MIND and MAXD are not used"
    )
    assert why["BCTPARM"].endswith("(PENN)")
    assert "slide lines" in why["BLSEG"]
