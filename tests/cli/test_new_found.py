"""`creak new` finds edges on faces, node sets and joints, and asks about what is doubtful."""

from __future__ import annotations

import json
import re
import tomllib

import numpy as np
import pytest
from PIL import Image

from creak.contact.pair import ContactPair
from creak.contact.surface_to_surface import surface_to_surface
from creak.formats.decks import read_model
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, patch, two_strips, write_strips
from helpers_ribs import bolted_bracket, deck, rib_on_plate

SINE = 'signal = { type = "sine", frequency = 5.0, amplitude = 0.01 }\n[time]\nend = 0.1\n'
EDGE = ["1001", "1002", "1003", "1004", "1005"]


def new(creak, folder, text, *more):
    """What is told for machines, and the words of the study."""
    (folder / "own.inp").write_text(text)
    said = creak("new", folder / "own.inp", "--json", *more).done()
    return json.loads(said.out), (folder / "own.toml").read_text()


def gaps(folder):
    return set_up(read_study(folder / "own.toml")).contacts.gap0


def answered(text):
    """The question's table, and what belongs to it, made live: all lines after the one that says so."""
    before, _, rest = text.partition("uncomment the lines")
    first, _, rest = rest.partition("\n")
    block, blank, after = rest.partition("\n\n")
    return f"{before}uncomment the lines{first}\n" + re.sub(r"(?m)^# ?", "", block) + blank + after


@pytest.mark.parametrize(("height", "gap"), [(1.3, 0.3), (1.0, 0.0)])
def test_the_edge_of_a_rib_is_half_of_the_plate_from_its_middle(creak, tmp_path, height, gap):
    """The rib has no thickness past its edge: 1 mm of the plate alone is taken off."""
    told, text = new(creak, tmp_path, rib_on_plate(height))
    (contact,) = told["contacts"]
    assert told["ready"]
    assert contact["gap"] == pytest.approx(gap, abs=1e-9)
    study = tomllib.loads(text)
    assert study["nodes"]["RIB_EDGE_ON_PLATE"]["labels"] == EDGE
    assert study["contact"]["rib-plate"]["method"] == "node-to-surface"
    assert gaps(tmp_path) == pytest.approx(np.full(5, gap), abs=1e-9)
    assert told["warnings"] == []


def test_a_rib_drawn_on_the_middle_of_the_plate_stands_on_it(creak, tmp_path):
    """The position does not tell the side there, but the rib does."""
    told, text = new(creak, tmp_path, rib_on_plate(0.0))
    table = tomllib.loads(text)["contact"]["rib-plate"]
    assert (table["clearance"], table["normal"]) == (0.0, [0.0, 0.0, 1.0])
    assert told["ready"]
    assert told["warnings"] == []
    contacts = set_up(read_study(tmp_path / "own.toml")).contacts
    assert contacts.gap0 == pytest.approx(np.zeros(5))
    up = contacts.G[:, np.flatnonzero(contacts.labels % 6 == 2)]
    assert up.max() == pytest.approx(1.0), "the rib's nodes open the gap where they rise"


def test_a_rib_below_the_plate_is_not_turned(creak, tmp_path):
    told, text = new(creak, tmp_path, rib_on_plate(-20.0))
    assert told["contacts"][0]["normal"] == [0.0, 0.0, -1.0]
    assert tomllib.loads(text)["contact"]["rib-plate"]["clearance"] == 0.0


def test_the_decks_own_set_of_the_edge_is_named(creak, tmp_path):
    told, text = new(creak, tmp_path, rib_on_plate(1.3, "*NSET, NSET=FOOT\n1001, 1002, 1003, 1004, 1005\n"))
    assert told["contacts"][0]["secondary"] == "FOOT"
    assert "nodes" not in tomllib.loads(text)


def test_an_edge_that_reaches_through_is_a_question_with_a_picture(creak, tmp_path):
    told, text = new(creak, tmp_path, rib_on_plate(-0.5))
    (contact,) = told["contacts"]
    assert contact["question"] == "overlap"
    assert not told["ready"]
    assert "rib-plate" in told["to_fill_in"]
    assert "# QUESTION: Do RIB and PLATE touch at rest? They are drawn 1.5 mm inside each other" in text
    assert "# Picture: own_question_1.png" in text
    assert str(tmp_path / "own_question_1.png") in told["written"]
    with Image.open(tmp_path / "own_question_1.png") as picture:
        colours = np.asarray(picture.convert("RGB")).reshape(-1, 3).astype(int)
    blue, sand = (np.abs(colours - c).sum(axis=1).min() for c in ((127, 168, 207), (227, 191, 130)))
    assert max(blue, sand) < 60, "both parts are painted"
    (tmp_path / "own.toml").write_text(answered(text))
    assert gaps(tmp_path) == pytest.approx(np.zeros(5))


def test_a_rib_that_stands_through_the_plate_is_a_warning(creak, tmp_path):
    """No node of it is near as an edge on a face, so no contact is found; `creak new`, info and run say why."""
    told, _ = new(creak, tmp_path, rib_on_plate(-5.0))
    words = (
        "RIB is drawn through PLATE: 3 edge(s) of its elements pierce it, by 4 mm or more beyond the far face at node"
    )
    info = creak("info", tmp_path / "own.inp").err
    assert words in info
    assert "1002" in info
    study = STUDY.replace("strips.inp", "own.inp").partition("[contact")[0]
    (tmp_path / "own.toml").write_text(study + '[excitation.top]\nnode_set = "FEET"\ndof = "z"\n' + SINE)
    assert any(words in note for note in set_up(read_study(tmp_path / "own.toml")).notes)
    assert any(words in warning for warning in told["warnings"])


def test_what_is_a_little_too_far_is_asked(creak, tmp_path):
    """1 % of the model's size is 0.69 mm, the edge is 1 mm away."""
    told, text = new(creak, tmp_path, rib_on_plate(2.0))
    assert told["contacts"][0]["question"] == "far"
    assert "Can RIB and PLATE touch? They are 1 mm apart, farther than 0.6" in text
    (tmp_path / "own.toml").write_text(answered(text))
    assert gaps(tmp_path) == pytest.approx(np.ones(5))
    told, _ = new(creak, tmp_path, rib_on_plate(2.0), "--distance", 1.5, "--overwrite")
    assert told["contacts"][0]["question"] == ""


def test_two_edges_are_asked_about_and_offered_a_stop(creak, tmp_path):
    one = patch(1, "ONE", (0.0, 0.0, 0.0), (40.0, 0.0, 0.0), (0.0, 40.0, 0.0))
    two = patch(101, "TWO", (40.5, 0.0, 0.0), (40.0, 0.0, 0.0), (0.0, 40.0, 0.0))
    held = "*NSET, NSET=ENDS\n1, 6, 105, 110\n*BOUNDARY\nENDS, 1, 2\nENDS, 4, 6\n"
    told, text = new(creak, tmp_path, deck([("ONE", one), ("TWO", two)], held))
    (contact,) = told["contacts"]
    assert (contact["question"], contact["gap"]) == ("edges", pytest.approx(0.5))
    (tmp_path / "own.toml").write_text(answered(text))
    stop = set_up(read_study(tmp_path / "own.toml")).connectors
    assert stop.gap0 == pytest.approx([0.5])


def test_nodes_of_a_part_without_names_of_its_own_are_listed(creak, tmp_path):
    """Both strips are in one element set; the surface of one of them is the only name."""
    text = re.sub("ELSET=(UPPER|LOWER)", "ELSET=ALL", two_strips())
    text = text.replace("*SURFACE, NAME=UNDER\nUPPER, SNEG\n*SURFACE, NAME=OVER\nLOWER, SPOS\n", "")
    first, second = [m.start() for m in re.finditer(r"\*SHELL SECTION", text)]
    bottom = "*ELSET, ELSET=BOTTOM, GENERATE\n1001, 1024, 1\n"
    told, words = new(creak, tmp_path, text[:first] + bottom + text[second:])
    (contact,) = told["contacts"]
    assert told["ready"], told["to_fill_in"]
    assert (contact["main"], contact["method"], len(contact["labels"])) == ("BOTTOM", "node-to-surface", 39)
    assert gaps(tmp_path) == pytest.approx(np.full(39, contact["gap"]), rel=1e-3)
    assert tomllib.loads(words)["contact"]


def test_joints_between_parts_are_told(creak, tmp_path):
    spring = "*ELEMENT, TYPE=SPRING2, ELSET=CLIP\n9001, 3, 1013\n*SPRING, ELSET=CLIP\n3, 3\n100.\n"
    told, text = new(creak, tmp_path, rib_on_plate(1.3, spring + "*MPC\nBEAM, 1012, 2\n"))
    assert told["joints"] == [
        "1 spring or dashpot element(s) between RIB and PLATE, first at nodes 1013 and 3",
        "1 rigid link(s) between RIB and PLATE, first at nodes 1012 and 2",
    ], "nodes in the order of the parts, whichever the deck names first"
    assert all(f"#   {joint}" in text for joint in told["joints"])


def test_driving_a_contact_along_its_normal_is_a_warning_and_along_its_surface_is_not(tmp_path):
    drive = 'node_set = "ROOT_UPPER"\ndof = "z"'
    for dof, warned in (("z", 1), ("x", 0)):
        study = write_strips(tmp_path, study=STUDY.replace(drive, f'node_set = "TIP_UPPER"\ndof = "{dof}"'))
        extra = "ROOT_UPPER, 3\n"
        (tmp_path / "strips.inp").write_text(two_strips() + extra)
        notes = [n for n in set_up(read_study(study)).notes if "along its normal" in n and "push these by a force" in n]
        assert len(notes) == warned


def test_the_bolted_foot_of_a_bracket_is_asked_and_its_tongue_is_a_contact(creak, tmp_path):
    told, text = new(creak, tmp_path, bolted_bracket(0.3))
    live, asked = told["contacts"]
    assert (live["question"], live["method"], live["gap"]) == ("", "node-to-surface", pytest.approx(0.3))
    assert {int(label) for label in live["labels"]} >= {2008, 2013}
    assert "2001" not in live["labels"]
    assert asked["question"] == "pressed"
    assert "Can BRACKET and PLATE part where they are joined?" in text
    assert gaps(tmp_path).min() == pytest.approx(0.3, abs=1e-9)
    assert told["ready"]
    loose = bolted_bracket(0.3).replace("*MPC\nBEAM, 2115, 9\nBEAM, 2118, 10\n", "")
    (contact,) = new(creak, tmp_path, loose, "--overwrite")[0]["contacts"]
    assert (contact["question"], contact["start"]) == ("", 0.0), "what only lies on the other knocks as it is"


def test_a_sheet_that_is_welded_flat_on_another_is_asked(creak, tmp_path):
    """A bushing stands for the weld; without it the sheets only lie on each other."""
    weld = (
        "*ELEMENT, TYPE=CONN3D2, ELSET=WELD\n9001, 20, 1020\n*CONNECTOR SECTION, ELSET=WELD, BEHAVIOR=STIFF\nBUSHING\n"
    )
    weld += "*CONNECTOR BEHAVIOR, NAME=STIFF\n" + "".join(
        f"*CONNECTOR ELASTICITY, COMPONENT={k}\n1e4,\n" for k in range(1, 7)
    )
    for more, question in ((weld, "pressed"), ("", "")):
        told, _ = new(creak, tmp_path, two_strips(0.0).replace("*BOUNDARY\n", f"{more}*BOUNDARY\n", 1), "--overwrite")
        assert [c["question"] for c in told["contacts"]] == [question]
        assert told["contacts"][0]["start"] == pytest.approx(0.0, abs=1e-9)


def nastran_plates(z, thickness=2.0, *, offset="", corners="", turned=False):
    """A plate of 100 x 100 in z = 0 under another one in z, 1 thick; ZOFFS and T1 to T4 of the lower one's elements."""
    lines = ["SOL 103", "CEND", "SPC=1", "BEGIN BULK"]
    for first, n, height in ((0, 4, 0.0), (100, 3, z)):
        for j in range(n + 1):
            lines += [
                f"GRID,{first + (n + 1) * j + i + 1},,{100 * i / n:.6g},{100 * j / n:.6g},{height}"
                for i in range(n + 1)
            ]
        for j in range(n):
            for i in range(n):
                a = first + (n + 1) * j + i + 1
                ring = [a, a + 1, a + n + 2, a + n + 1]
                nodes = ",".join(map(str, ring[::-1] if turned and not first else ring))
                more = "" if first else f",,{offset},+\n+,,,{corners}" if corners else f",,{offset}" if offset else ""
                lines.append(f"CQUAD4,{first + n * j + i + 1},{1 if not first else 2},{nodes}{more}")
    lines += ["MAT1,1,210000.,,.3,7.85-9", f"PSHELL,1,1,{thickness},1,,1", "PSHELL,2,1,1.,1,,1"]
    return "\n".join([*lines, "SPC1,1,123456,1", "SPC1,1,123456,101", "ENDDATA", ""])


def test_names_of_the_deck_come_before_numbers(creak, tmp_path):
    """A property's number is a set as well; its comment is what the user calls it."""
    (tmp_path / "plates.bdf").write_text(
        nastran_plates(2.3).replace("PSHELL,1,", "$ Femap Property 1 : Floor\nPSHELL,1,")
    )
    said = creak("new", tmp_path / "plates.bdf", "--json")
    (contact,) = json.loads(said.out)["contacts"]
    assert {contact["secondary"], contact["main"]} == {"FLOOR", "PID_2"}
    assert set(contact["name"].split("-")) == {"floor", "pid_2"}


@pytest.mark.parametrize(
    ("deck", "gap", "side"),
    [
        (nastran_plates(2.3), 0.8, ""),
        (nastran_plates(3.0, offset="1.2"), 0.3, ".SPOS"),
        (nastran_plates(3.0, offset="-1.2", turned=True), 0.3, ".SNEG"),
        (nastran_plates(7.2, offset="5."), 0.7, ".SPOS"),
        (nastran_plates(4.3, corners="6.,6.,6.,6."), 0.8, ""),
    ],
)
def test_offset_and_thickness_of_shells_count(creak, tmp_path, deck, gap, side):
    """The gap is z less half of the upper plate, half of the lower one and its offset; the study takes the side."""
    (tmp_path / "plates.bdf").write_text(deck, encoding="utf-8")
    said = creak("new", tmp_path / "plates.bdf", "--json")
    (contact,) = json.loads(said.out)["contacts"]
    assert contact["gap"] == pytest.approx(gap, rel=1e-9)
    text = (tmp_path / "plates.toml").read_text()
    assert f'"PID_1{side}"' in text
    study = tomllib.loads(text)["contact"][contact["name"]]
    pair = ContactPair("c", study["secondary"], study["main"])
    operator, _ = surface_to_surface(read_model(tmp_path / "plates.bdf"), pair)
    np.testing.assert_allclose(operator.gap0, gap, rtol=1e-9)


@pytest.mark.parametrize(("height", "told"), [(3.1, "0.1 mm from"), (2.5, "0.5 mm inside"), (9.0, "")])
def test_a_rod_of_beams_beside_a_plate_is_told(creak, tmp_path, height, told):
    """Its radius of 2 and half of the plate's 2 are taken off."""
    plate = "".join(f"{11 * j + i + 1}, {10 * i}, {10 * j}, 0.\n" for j in range(11) for i in range(11))
    shells = "".join(
        f"{10 * j + i + 1}, {11 * j + i + 1}, {11 * j + i + 2}, {11 * j + i + 13}, {11 * j + i + 12}\n"
        for j in range(10)
        for i in range(10)
    )
    rod = "".join(f"{501 + i}, {10 * i}, 50., {height}\n" for i in range(11))
    beams = "".join(f"{501 + i}, {501 + i}, {502 + i}\n" for i in range(10))
    text = (
        f"*NODE\n{plate}{rod}*ELEMENT, TYPE=S4, ELSET=PLATE\n{shells}*ELEMENT, TYPE=B31, ELSET=ROD\n{beams}"
        "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., .3\n*DENSITY\n7.85E-9,\n"
        "*SHELL SECTION, ELSET=PLATE, MATERIAL=STEEL\n2.,\n"
        "*BEAM SECTION, SECTION=CIRC, ELSET=ROD, MATERIAL=STEEL\n2.\n0., 1., 0.\n*BOUNDARY\n1, 1, 6\n501, 1, 6\n"
    )
    found, _ = new(creak, tmp_path, text)
    assert [told in warning for warning in found["warnings"]] == ([True] if told else [])
