"""Units that cannot be meant; each mistake is one that decks have, a factor of 1000 or more."""

from __future__ import annotations

import re

import pytest

from creak.assembly.coupling import Driven
from creak.assembly.rigid import free_motions, loose_motions, loose_words
from creak.formats.abaqus.reader import read_deck
from creak.studies.prepare.unit_check import guessed_units, unit_warnings
from helpers_decks import two_strips


@pytest.fixture
def model(tmp_path):
    def make(*changes):
        text = two_strips()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "strips.inp"
        path.write_text(text)
        return read_deck(path)

    return make


def in_metres(text: str) -> str:
    """The strips' nodes and thicknesses divided by 1000."""

    def scaled(match):
        x = [float(v) / 1000.0 for v in match[2].split(",")]
        return match[1] + ", ".join(f"{v:.9g}" for v in x)

    text = re.sub(r"(?m)^(\d+, )(\d+\.\d{6}, \d+\.\d{6}, \d+\.\d{6})$", scaled, text)
    return text.replace("STEEL\n1.0,", "STEEL\n1e-3,").replace("STEEL\n1.5,", "STEEL\n1.5e-3,")


SI = (("210000., 0.3", "2.1e11, 0.3"), ("7.85e-9", "7850."))


def test_steel_strips_in_millimetres_and_tonnes_are_plausible(model):
    assert unit_warnings(model(), "mm-t-s", mass=4.7e-5, frequency=360.0) == []
    assert guessed_units(model())[0].name == "mm-t-s"


@pytest.mark.parametrize(
    ("changes", "units", "words"),
    [
        (SI, "mm-t-s", ["STEEL (E = 2.1e+11, density = 7850) is in m-kg-s, not in mm-t-s"]),
        ((), "m-kg-s", ["STEEL (E = 210000, density = 7.85e-09) is in mm-t-s, not in m-kg-s"]),
        ((("7.85e-9", "7850."),), "mm-t-s", ["of no solid in mm-t-s", "density lies between", "2.5e-08 t/mm^3"]),
        ((("210000., 0.3", "2.1e11, 0.3"),), "mm-t-s", ["of no solid in mm-t-s", "E lies between", "MPa"]),
        ((("210000., 0.3", "210., 0.3"), ("7.85e-9", "7.85e-6")), "mm-t-s", ["is in mm-kg-ms", "convert the deck"]),
        ((("210000., 0.3", "3.05e7, 0.3"), ("7.85e-9", "7.35e-4")), "mm-t-s", ["is in in-lbf-s, not in mm-t-s"]),
        ((("210000., 0.3", "0.21, 0.3"),), "mm-t-s", ["would carry sound at 5.17 m/s"]),
        (
            (("STEEL\n1.0,", "STEEL\n0.001,"), ("STEEL\n1.5,", "STEEL\n0.0015,")),
            "mm-t-s",
            ["shells are 0.001 mm thick"],
        ),
    ],
)
def test_materials_and_thickness(model, changes, units, words):
    found = unit_warnings(model(*changes), units)
    assert len(found) == 1
    assert all(word in found[0] for word in words), found


def test_coordinates_in_metres(tmp_path):
    path = tmp_path / "strips.inp"
    path.write_text(in_metres(two_strips()))
    found = unit_warnings(read_deck(path), "mm-t-s")
    assert found == ["the model is 0.122 mm across: are its coordinates in mm, as mm-t-s has them?"]


def test_a_deck_all_in_si_is_guessed(tmp_path):
    text = in_metres(two_strips())
    for old, new in SI:
        text = text.replace(old, new)
    path = tmp_path / "strips.inp"
    path.write_text(text)
    model = read_deck(path)
    assert unit_warnings(model, "m-kg-s", mass=0.047, frequency=360.0) == []
    assert [s.name for s in guessed_units(model)] == ["m-kg-s"]


def test_point_masses_in_kg(model):
    """5 t on strips of 0.05 kg: 9e5 kg/m^3 in the box round them."""
    heavy = model(("*BOUNDARY\n", "*ELEMENT, TYPE=MASS, ELSET=M\n9001, 13\n*MASS, ELSET=M\n5.0,\n*BOUNDARY\n"))
    assert unit_warnings(heavy, "mm-t-s", mass=5.00005) == [
        "the model has a mass of 5 t, 5 of it point masses: is it in mm-t-s?"
    ]
    light = model(("*BOUNDARY\n", "*ELEMENT, TYPE=MASS, ELSET=M\n9001, 13\n*MASS, ELSET=M\n5e-6,\n*BOUNDARY\n"))
    assert unit_warnings(light, "mm-t-s", mass=5.2e-5) == []


@pytest.mark.parametrize("frequency", [0.003, 4e5])
def test_first_frequency(model, frequency):
    assert f"{frequency:.3g} Hz" in unit_warnings(model(), "mm-t-s", frequency=frequency)[0]


def test_odd_helpers_are_not_judged(model):
    """A rigid dummy of one element among 48."""
    dummy = (
        "*ELEMENT, TYPE=S4, ELSET=DUMMY\n5001, 1, 2, 15, 14\n*MATERIAL, NAME=RIGID\n*ELASTIC\n1e12, 0.3\n*DENSITY\n1e-30,\n"
        "*SHELL SECTION, ELSET=DUMMY, MATERIAL=RIGID\n1.0,\n*BOUNDARY\n"
    )
    assert unit_warnings(model(("*BOUNDARY\n", dummy)), "mm-t-s") == []


@pytest.mark.parametrize(
    ("held", "motions"),
    [
        ("", ["along x", "along y", "along z", "about x", "about y", "about z"]),
        ("ROOT_UPPER, 1, 2\nROOT_UPPER, 4, 6\n", ["along z"]),
        # Held at three points of the root line x = 0, which runs along y: a hinge.
        ("ROOT_UPPER, 1, 3\n", ["about y"]),
        ("1, 1, 3\n", ["about x", "about y", "about z"]),
    ],
)
def test_free_motions_have_names(model, held, motions):
    found = model(("ROOT_UPPER, 1, 2\nROOT_UPPER, 4, 6\n", held))
    assert free_motions(found, Driven({}), "UPPER") == motions
    assert loose_words(loose_motions(found, Driven({}), ["UPPER"])) == f"UPPER ({', '.join(motions)})"
