"""`creak new` takes over contact of LS-DYNA decks: sides and friction; `creak info` tells it."""

from __future__ import annotations

import json
import tomllib

import pytest

from creak.formats.decks import read_model
from helpers_lsdyna import fixed_width, held, nodes, plate, shells, steel

pytestmark = pytest.mark.usefixtures("no_page")

RUBS = fixed_width(0.3, 0.2, 0.01, 0.0, 20.0)
SETS = (
    f"*SET_PART_LIST\n{fixed_width(5)}{fixed_width(1)}*SET_SEGMENT\n{fixed_width(6)}{fixed_width(101, 102, 107, 106)}"
    f"*SET_NODE_LIST_TITLE\nfew nodes\n{fixed_width(7)}{fixed_width(107, 108)}*SET_SHELL_LIST\n{fixed_width(8)}"
    f"{fixed_width(101, 102)}"
)


def plates(contact: str = "") -> str:
    """Two plates of 4 x 3 elements, 1 mm thick, 1.5 mm apart between their middles; parts 1 and 2."""
    below, above = plate(4, 3, 10.0), plate(4, 3, 10.0, first=101, z=1.5)
    pieces = [
        nodes(below[0] | above[0]),
        shells(below[1], 1.0, 1, "LOW"),
        shells(above[1], 1.0, 2, "TOP"),
        steel(),
        held([1, 6, 11, 16, 101, 106, 111, 116]),
    ]
    return "*KEYWORD\n" + "".join(p.k for p in pieces) + SETS + contact + "*END\n"


def taken(creak, folder, contact):
    """Tables of the contacts of the study that is written, and what is told."""
    (folder / "plates.k").write_text(plates(contact))
    said = creak("new", folder / "plates.k", "--distance", "1", "--json").done()
    told = json.loads(said.out)
    assert told["ready"], told["to_fill_in"]
    (table,) = tomllib.loads((folder / "plates.toml").read_text())["contact"].values()
    return table, told


FALLS = {"static": 0.3, "kinetic": 0.2, "decay": 100.0}


@pytest.mark.parametrize(
    ("keyword", "sides", "names", "channels"),
    [
        ("AUTOMATIC_SURFACE_TO_SURFACE", (2, 1, 3, 3), ("PART_2", "PART_1"), 20),
        ("AUTOMATIC_SURFACE_TO_SURFACE_MORTAR_ID", (2, 5, 3, 2), ("PART_2", "SET_PART_5"), 20),
        ("AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE", (6, 1, 0, 3), ("SET_SEGMENT_6.BOTH", "PART_1"), 4),
        ("SURFACE_TO_SURFACE_TITLE", (8, 1, 1, 3), ("SET_SHELL_8", "PART_1"), 6),
        ("AUTOMATIC_NODES_TO_SURFACE", (2, 1, 3, 3), ("PART_2", "PART_1"), 20),
        ("AUTOMATIC_SURFACE_TO_SURFACE_MPP", (2, 1, 3, 3), ("PART_2", "PART_1"), 20),
    ],
)
def test_a_pair_with_its_friction(creak, tmp_path, keyword, sides, names, channels):
    """FD + (FS - FD) exp(-DC v): DC = 0.01 s/mm is a decay over 100 mm/s."""
    title = f"{fixed_width(1)}" if keyword.endswith(("_ID", "_TITLE")) else ""
    ahead = f"{fixed_width(0, 200)}& {fixed_width(0)}" if keyword.endswith("_MPP") else ""
    table, told = taken(creak, tmp_path, f"*CONTACT_{keyword}\n{title}{ahead}{fixed_width(*sides)}{RUBS}\n")
    assert (table["secondary"], table["main"], table["friction"]) == (*names, FALLS)
    assert table.get("method", "surface-to-surface").startswith("node" if "NODES" in keyword else "surface")
    (contact,) = told["contacts"]
    assert (contact["channels"], contact["start"]) == (channels, pytest.approx(0.5))
    assert told["warnings"] == []


@pytest.mark.parametrize(("automatic", "told"), [("AUTOMATIC_", 1), ("", 0)])
def test_nodes_of_shells_have_no_thickness(creak, tmp_path, automatic, told):
    """0.5 mm to the face of the shell below; LS-DYNA's automatic contact takes 0.5 mm of their own off as well."""
    contact = f"*CONTACT_{automatic}NODES_TO_SURFACE\n{fixed_width(7, 1, 4, 3)}{RUBS}\n"
    table, said = taken(creak, tmp_path, contact)
    assert (table["secondary"], table["method"]) == ("SET_NODE_7", "node-to-surface")
    (found,) = said["contacts"]
    assert (found["channels"], found["start"]) == (2, pytest.approx(1.0))
    assert ["SET_NODE_7 have no thickness" in w for w in said["warnings"]] == [True] * told


@pytest.mark.parametrize("sides", [(0, 0, 5, 0), (0,), (5, 0, 2)])
def test_contact_of_all_parts_gives_its_friction_to_what_is_near(creak, tmp_path, sides):
    two = f"*SET_PART_LIST\n{fixed_width(9)}{fixed_width(1, 2)}"
    sides = (9, *sides[1:]) if len(sides) == 3 else sides
    table, told = taken(creak, tmp_path, f"{two}*CONTACT_AUTOMATIC_SINGLE_SURFACE\n{fixed_width(*sides)}{RUBS}\n")
    assert table["friction"] == FALLS
    assert told["warnings"] == []


@pytest.mark.parametrize(
    ("contact", "friction", "words"),
    [
        (f"{fixed_width(2, 1, 3, 3)}{fixed_width(-1.0)}\n", 0.0, "FS = -1, friction by part or table"),
        (f"{fixed_width(2, 1, 3, 3)}{fixed_width(0.1, 0.2, 1.0)}\n", 0.1, "grows from FS = 0.1 to FD = 0.2"),
        (f"{fixed_width(2, 1, 3, 3, 4)}{RUBS}\n", FALLS, "acts in a box"),
        (f"{fixed_width(2, 1, 3, 3)}{RUBS}{fixed_width(1.0, 1.0, 0.5)}", FALLS, "SST = 0.5"),
        (f"{fixed_width(12, 1, 3, 3)}{RUBS}\n", 0.0, "PART_12, which has no shells or solids"),
        (f"{fixed_width(77, 1, 4, 3)}{RUBS}\n", 0.0, "node set 77, which is not defined"),
        (f"{fixed_width(2, 1, 3, 9)}{RUBS}\n", 0.0, "field 4 of"),
    ],
)
def test_what_is_not_taken_over_is_told(creak, tmp_path, contact, friction, words):
    table, told = taken(creak, tmp_path, f"*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE\n{contact}")
    assert table["friction"] == friction
    (warning,) = told["warnings"]
    assert words in warning


def test_one_of_some_parts_and_two_general_contacts_are_told(creak, tmp_path):
    first = f"*CONTACT_AUTOMATIC_GENERAL\n{fixed_width(5, 0, 2)}{RUBS}\n"
    _, told = taken(creak, tmp_path, f"{first}*CONTACT_AUTOMATIC_SINGLE_SURFACE\n{fixed_width(0)}{fixed_width(0.7)}\n")
    assert ["is one of some parts" in w for w in told["warnings"]].count(True) == 1
    assert ["other friction than a general contact before it" in w for w in told["warnings"]].count(True) == 1


def test_info_says_what_is_taken_and_what_is_not(creak, tmp_path):
    pair = f"*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE\n{fixed_width(2, 1, 3, 3)}{RUBS}\n"
    (tmp_path / "plates.k").write_text(plates(f"{pair}*CONTACT_DRAWBEAD\n{fixed_width(1)}"))
    said = creak("info", tmp_path / "plates.k")
    assert "contact that `creak new` takes over: PART_2 - PART_1 (friction 0.3 to 0.2)" in said.words
    assert "*CONTACT_DRAWBEAD" in said.words
    assert "`creak new` takes nothing from here" in said.words


def test_contact_changes_no_answer_by_itself(tmp_path):
    (tmp_path / "plates.k").write_text(plates(f"*CONTACT_AUTOMATIC_GENERAL\n{fixed_width(0)}{RUBS}\n"))
    model = read_model(tmp_path / "plates.k")
    assert not [u for u in model.unread if u.changes_answer]
