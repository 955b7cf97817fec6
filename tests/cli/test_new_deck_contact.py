"""`creak new` takes over what an Abaqus deck says of contact: pairs, laws, friction of general contact."""

from __future__ import annotations

import json
import re
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
    said = creak("new", folder / "strips.inp", "--json").done()
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
    assert "that is not taken over as it stands: " in words
    assert "coefficient of friction is -1" in words
    assert "unknown surface 'UNDR'" in words


NAMED = "*CONTACT\n*CONTACT INCLUSIONS, ALL EXTERIOR\n*CONTACT PROPERTY ASSIGNMENT\n, , SLICK\nOVER, UNDER, RUB\n"
SLICK = "*SURFACE INTERACTION, NAME=SLICK\n*FRICTION\n0.05,\n"


def test_general_contact_of_two_surfaces_has_their_friction_not_that_of_all(creak, tmp_path):
    gap = "*CONTACT INITIALIZATION DATA, NAME=FAR, INITIAL CLEARANCE=0.7\n*CONTACT INITIALIZATION ASSIGNMENT\nOVER, UNDER, FAR\n"
    name, table, told = contact_of(creak, tmp_path, SLICK + RUB + NAMED + gap)
    assert (name, table["friction"], table["clearance"]) == ("over-under", 0.35, 0.7)
    assert told["warnings"] == []


def test_what_the_deck_includes_alone_has_the_friction_of_all(creak, tmp_path):
    cards = "*CONTACT\n*CONTACT INCLUSIONS\nUNDER, OVER\n*CONTACT PROPERTY ASSIGNMENT\n, , RUB\n"
    assert contact_of(creak, tmp_path, RUB + cards)[:2][1]["friction"] == 0.35


@pytest.mark.parametrize("cards", ["UNDER, OVER", "OVER, UNDER", ", OVER"])
def test_what_the_deck_keeps_apart_is_no_contact(creak, tmp_path, cards):
    (tmp_path / "strips.inp").write_text(f"{two_strips()}{SLICK}{RUB}{NAMED}*CONTACT EXCLUSIONS\n{cards}\n")
    told = json.loads(creak("new", tmp_path / "strips.inp", "--json").out)
    assert told["contacts"] == []
    assert told["kept_apart"] == ["the deck keeps UPPER and LOWER out of contact"]
    assert "UPPER and LOWER out of contact" in told["to_fill_in"]


def test_a_side_that_looks_away_keeps_nothing_apart(creak, tmp_path):
    """The exclusion names the upper side of the upper strip."""
    cards = f"{RUB}{GENERAL}*SURFACE, NAME=ABOVE\nUPPER, SPOS\n*CONTACT EXCLUSIONS\n, ABOVE\n"
    assert contact_of(creak, tmp_path, cards)[2]["kept_apart"] == []


def test_what_is_kept_apart_in_part_is_a_contact_and_told(creak, tmp_path):
    """Elements 1 to 6 of 24 of the upper strip are kept apart: those of the lower one below them are three and a half."""
    some = "*ELSET, ELSET=FEW\n1, 2, 3, 4, 5, 6\n*SURFACE, NAME=FEW\nFEW, SNEG\n*CONTACT EXCLUSIONS\nFEW, OVER\n"
    _, _, told = contact_of(creak, tmp_path, RUB + GENERAL + some)
    (said,) = told["kept_apart"]
    assert said.startswith("the deck keeps UPPER and LOWER out of contact at ")


def test_clearances_by_node_become_a_table_beside_the_study(creak, tmp_path):
    """Nodes 1014 to 1026 of the lower strip; the others keep the drawn gap of 0.5 mm."""
    cards = "*NSET, NSET=MIDDLE, GENERATE\n1014, 1026\n" + RUB + PAIR + CLEAR.replace("VALUE=0.4", "TABULAR")
    _, table, told = contact_of(creak, tmp_path, cards + "MIDDLE, 0.2\n1039, 0.1\n")
    assert table["clearance"] == "strips_over-under.csv"
    assert str(tmp_path / table["clearance"]) in told["written"]
    rows = (tmp_path / table["clearance"]).read_text().splitlines()
    assert rows[0] == "node,clearance"
    assert dict(r.split(",") for r in rows[1:]) == {**{str(n): "0.2" for n in range(1014, 1027)}, "1039": "0.1"}
    assert told["contacts"][0]["start"] == pytest.approx(0.1)


def test_one_clearance_of_all_nodes_is_a_number(creak, tmp_path):
    cards = (
        "*NSET, NSET=ALL, GENERATE\n1001, 1039\n" + RUB + PAIR + CLEAR.replace("VALUE=0.4", "TABULAR") + "ALL, 0.2\n"
    )
    assert contact_of(creak, tmp_path, cards)[1]["clearance"] == 0.2


def test_friction_over_the_slip_rate_keeps_its_area(creak, tmp_path):
    """0.4 that falls to 0.2 in a line over 10 mm/s: an area of 1 above 0.2, which is (0.4 - 0.2) decay."""
    _, table, told = contact_of(creak, tmp_path, RUB.replace("0.35,", "0.4, 0.\n0.2, 10.\n0.2, 20.") + PAIR)
    assert table["friction"] == pytest.approx({"static": 0.4, "kinetic": 0.2, "decay": 5.0})
    assert "exp(-v / 5)" in " ".join(told["warnings"])


@pytest.mark.parametrize(
    ("table", "mu", "words"),
    [("0.2, 0.\n0.4, 10.", 0.2, "at any speed"), ("0.3, 0., 1.\n0.2, 0., 9.", 0.3, "the sliding speed alone")],
)
def test_friction_that_creak_has_no_law_for_is_told(creak, tmp_path, table, mu, words):
    _, found, told = contact_of(creak, tmp_path, RUB.replace("0.35,", table) + PAIR)
    assert found["friction"] == mu
    assert words in " ".join(told["warnings"])


@pytest.mark.parametrize("fit", ["", "*CONTACT INITIALIZATION DATA, NAME=FIT, INTERFERENCE FIT\n"])
def test_names_that_general_contact_has_no_data_for_are_told(creak, tmp_path, fit):
    cards = (
        f"*CONTACT PROPERTY ASSIGNMENT\nOVER, UNDER, NONE\n{fit}*CONTACT INITIALIZATION ASSIGNMENT\nOVER, UNDER, FIT\n"
    )
    name, _, told = contact_of(creak, tmp_path, f"*CONTACT\n{cards}")
    words = " ".join(told["warnings"])
    assert name == "upper-lower"
    assert "PROPERTY ASSIGNMENT names 'NONE'" in words
    assert "INITIALIZATION ASSIGNMENT names 'FIT'" in words
    assert ("creak does not follow it" in words) is bool(fit)


def test_laws_that_are_not_followed_are_told(creak, tmp_path):
    law = LINEAR.replace("LINEAR", "EXPONENTIAL").replace("1500.", "0.1, 5.") + "*SURFACE BEHAVIOR, NO SEPARATION\n"
    _, table, told = contact_of(creak, tmp_path, RUB + law + PAIR)
    words = " ".join(told["warnings"])
    assert table["stiffness"] == "auto"
    assert "PRESSURE-OVERCLOSURE=EXPONENTIAL" in words
    assert "*SURFACE BEHAVIOR, NOSEPARATION" in words


def test_a_pair_that_never_faces_each_other_is_told_with_the_unit_of_the_limit(creak, tmp_path):
    (tmp_path / "strips.inp").write_text(two_strips().replace("UPPER, SNEG", "UPPER, SPOS") + RUB + PAIR)
    creak("new", tmp_path / "strips.inp").done()
    text = (tmp_path / "strips.toml").read_text()
    assert re.search(r"never face each other: .* within [0-9.]+ mm\b", " ".join(text.replace("#", " ").split()))
