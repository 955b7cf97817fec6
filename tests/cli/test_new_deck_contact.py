"""`creak new` takes over what an Abaqus deck says of contact: pairs, laws, friction of general contact."""

from __future__ import annotations

import json
import tomllib

import pytest

from helpers_decks import two_strips

pytestmark = pytest.mark.usefixtures("no_page")

RUB = "*SURFACE INTERACTION, NAME=RUB\n*FRICTION\n0.35,\n"
LINEAR = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1500.,\n"
PAIR = "*CONTACT PAIR, INTERACTION=RUB, TYPE=SURFACE TO SURFACE\nOVER, UNDER\n"
CLEAR = "*CLEARANCE, MASTER=UNDER, SLAVE=OVER, VALUE=0.4\n"
GENERAL = "*CONTACT\n*CONTACT INCLUSIONS, ALL EXTERIOR\n*CONTACT PROPERTY ASSIGNMENT\n, , RUB\n"
STEP = "*STEP\n*DYNAMIC, EXPLICIT\n, 0.1\n"


def contact_of(creak, folder, cards):
    """The one contact of the study that is written, and what is told."""
    (folder / "strips.inp").write_text(two_strips() + cards)
    said = creak("new", folder / "strips.inp", "--json")
    assert said.status == 0, said.words
    told = json.loads(said.out)
    assert told["ready"]
    ((name, table),) = tomllib.loads((folder / "strips.toml").read_text())["contact"].items()
    return name, table, told


def test_a_pair_with_its_law_stands_in_place_of_what_is_near(creak, tmp_path):
    """The secondary side is that of the deck, not the finer one; one contact, not two."""
    name, table, told = contact_of(creak, tmp_path, RUB + LINEAR + PAIR + CLEAR)
    assert (name, table["secondary"], table["main"]) == ("over-under", "OVER", "UNDER")
    assert (table["stiffness"], table["friction"], table["clearance"]) == (1500.0, 0.35, 0.4)
    (contact,) = told["contacts"]
    assert (contact["start"], contact["channels"]) == (pytest.approx(0.4), 39)
    assert "# Contact pair of the deck (strips.inp:" in (tmp_path / "strips.toml").read_text()


def test_a_clearance_of_a_set_of_pairs(creak, tmp_path):
    pair = PAIR.replace("INTERACTION=RUB", "INTERACTION=RUB, CPSET=ALL")
    assert contact_of(creak, tmp_path, f"{RUB}{pair}*CLEARANCE, CPSET=ALL, VALUE=0.3\n")[1]["clearance"] == 0.3


def test_friction_that_falls_and_a_curve(creak, tmp_path):
    rub = RUB.replace("*FRICTION\n0.35,", "*FRICTION, EXPONENTIAL DECAY\n0.4, 0.2, 0.5")
    curve = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR\n0., 0.\n5., 0.01\n50., 0.02\n"
    _, table, _ = contact_of(creak, tmp_path, rub + curve + PAIR)
    assert table["friction"] == {"static": 0.4, "kinetic": 0.2, "decay": 2.0}
    assert table["overclosure"] == [[0.0, 0.0], [0.01, 5.0], [0.02, 50.0]]
    assert "stiffness" not in table


def test_a_pair_node_by_node_has_its_stiffness_per_area(creak, tmp_path):
    _, table, _ = contact_of(creak, tmp_path, RUB + LINEAR + PAIR.replace("SURFACE TO", "NODE TO"))
    assert (table["method"], table["per_area"], table["stiffness"]) == ("node-to-surface", True, 1500.0)


@pytest.mark.parametrize("cards", [RUB + GENERAL, f"{RUB}{STEP}{GENERAL}*END STEP\n"])
def test_general_contact_gives_its_friction_to_what_is_near(creak, tmp_path, cards):
    name, table, _ = contact_of(creak, tmp_path, cards)
    assert (name, table["stiffness"], table["friction"]) == ("upper-lower", "auto", 0.35)


def test_what_is_wrong_with_it_is_told_and_what_is_near_is_proposed(creak, tmp_path):
    name, table, told = contact_of(creak, tmp_path, RUB.replace("0.35", "-1.") + PAIR.replace("UNDER", "UNDR"))
    assert (name, table["friction"]) == ("upper-lower", 0.0)
    words = " ".join(told["warnings"])
    assert "that is not taken over: " in words
    assert "coefficient of friction is -1" in words
    assert "unknown surface 'UNDR'" in words
