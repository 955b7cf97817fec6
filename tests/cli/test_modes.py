"""`creak modes`: tables, files, wrong input."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from creak.studies.models.deck_modes import deck_modes
from helpers_decks import STUDY, two_strips, write_strips
from helpers_punch import punched
from helpers_ties import sections, sheet


@pytest.fixture
def deck(tmp_path):
    path = tmp_path / "strips.inp"
    path.write_text(two_strips())
    return path


def test_tables_and_files(creak, deck, tmp_path):
    out = tmp_path / "new"
    said = creak(
        "modes",
        deck,
        "--count",
        3,
        "--about",
        "0,5,-1.5",
        "--vtk",
        out / "m.vtu",
        "--uff",
        out / "m.unv",
        "--pch",
        out / "m.pch",
    )
    assert said.status == 0, said.words
    for word in (
        "rotations about 0, 5, -1.5 mm",
        "model, t",
        "Cumulative",
        "Participation",
        "residual",
        "Sturm count agrees",
    ):
        assert word in said.words
    assert ET.parse(out / "m.vtu").getroot().get("type") == "UnstructuredGrid"
    assert (out / "m.unv").read_bytes().count(b"    -1\r\n    55\r\n") == 3
    found = deck_modes(deck, count=3)
    for punch, frequency, motion in zip(punched(out / "m.pch"), found.frequencies, found.motion(), strict=True):
        eigenvalue = float(punch.after("$EIGENVALUE =").split()[0])
        assert eigenvalue == pytest.approx((2.0 * math.pi * frequency) ** 2, rel=1e-7)
        assert list(punch.rows) == found.model.nodes.ids.tolist()
        np.testing.assert_allclose([*punch.rows.values()], motion, rtol=5.1e-7, atol=1e-99)
        assert np.abs(motion[:, 3:]).max() > 0.0


@pytest.mark.parametrize(
    ("modulus", "density", "told"),
    [("210.", "7.85e-6", True), ("2.1e8", "7.85e-6", False), ("2.1e5", "7.85e-9", False)],
)
def test_frequencies_of_decks_in_milliseconds_are_told_to_be_in_khz(creak, tmp_path, modulus, density, told):
    """mm-kg-ms of LS-DYNA, mm-kg-s, mm-t-s: what counts is the unit of time."""
    path = tmp_path / "strips.inp"
    path.write_text(two_strips().replace("210000., 0.3", f"{modulus}, 0.3").replace("7.85e-9", density))
    said = creak("modes", path, "--count", 2).done()
    assert ("fit mm-kg-ms, with times in ms" in " ".join(said.err.split())) == told


def test_modes_of_a_study(creak, tmp_path):
    """A quarter of the modulus halves all frequencies, and the root that it shakes is held."""
    study = write_strips(tmp_path, study=f"{STUDY}[material.STEEL]\nyoungs_modulus = 52500.0\n")
    said = creak("modes", study, "--count", 3, "--json", "-", "--quiet").done()
    found = json.loads(said.out)["frequencies"]
    (tmp_path / "strips.inp").write_text(two_strips() + "ROOT_UPPER, 3\n")
    held = np.array(deck_modes(tmp_path / "strips.inp", count=3).frequencies)
    np.testing.assert_allclose(found, 0.5 * held, rtol=1e-9)
    study.write_text(f"{STUDY}[superelement.BOX]\nfile = 'box.op4'\n")
    assert "effective masses are not known" in creak("modes", study).words


@pytest.mark.parametrize("name", ["-", "new/m.json"])
def test_figures_for_machines(creak, deck, tmp_path, name):
    said = creak("modes", deck, "--count", 3, "--json", name if name == "-" else tmp_path / name, "--quiet").done()
    data = json.loads(said.words if name == "-" else (tmp_path / name).read_text())
    assert list(data)[:3] == ["frequencies", "mass", "rigid"]
    assert len(data["effective_mass"]["effective"]) == 3
    # The upper strip is free in z: its 2 of 5 thicknesses are the share that the rigid mode carries.
    assert data["effective_mass"]["cumulative_share"][0][2] == pytest.approx(0.4, abs=1e-6)


def test_no_modes_in_the_range(creak, deck):
    deck.write_text(two_strips() + "ROOT_UPPER, 3\n")
    said = creak("modes", deck, "--f-max", "1").done()
    assert "no modes: none in the range" in said.words
    assert "0 rigid-body mode(s)" in said.words


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--about", "1,2"], ["--about 1,2", "X,Y,Z"]),
        (["--about", "1,2,nan"], ["three numbers"]),
        (["--vtk", "shape.vtk"], [".vtu"]),
        (["--uff", "."], ["is a folder"]),
        (["--json", "/proc/a.json"], ["cannot write to /proc", "Name another file."]),
        (["--uff", "out.unv", "--json", "./out.unv"], ["two outputs are written to out.unv"]),
        (["--count", "0"], ["count = 0; expected a whole number, 1 or more"]),
        (["--count", "3", "--f-max", "5"], ["one of them"]),
    ],
)
def test_wrong_options(creak, deck, options, words):
    said = creak("modes", deck, *options)
    assert said.status == 2
    assert all(word in said.words for word in words)


def test_unread_keywords_stop_it_and_are_listed_by_info(creak, deck):
    deck.write_text(two_strips() + "*EMBEDDED ELEMENT\nUPPER\n")
    said = creak("modes", deck)
    said.refuses("strips.inp:", "--ignore 'EMBEDDED ELEMENT'")
    assert "not read: *EMBEDDED ELEMENT" in creak("info", deck).words
    said = creak("modes", deck, "--count", 1, "--ignore", "EMBEDDED ELEMENT")
    assert (said.status, said.err) == (0, "")


@pytest.mark.parametrize("word", ["NOSUCH", "BOUNDARY"])
def test_an_ignored_word_that_names_nothing_unread_is_told(creak, deck, word):
    deck.write_text(two_strips() + "*EMBEDDED ELEMENT\nUPPER\n")
    ignored = ("--ignore", "*Embedded Element", "--ignore", word)
    told = f"warning: --ignore {word!r} names nothing that was left unread (EMBEDDED ELEMENT): it changes nothing"
    for command in (["modes", deck, "--count", 1], ["convert", deck, deck.with_suffix(".bdf"), "--mass", "linear"]):
        said = creak(*command, *ignored).done()
        assert told in said.words
        assert said.words.count("left unread") == 1


@pytest.mark.parametrize("command", ["modes", "info"])
def test_nodes_that_a_tie_leaves_out_are_told(creak, tmp_path, command):
    """A sheet that reaches beyond the other one by a row of its four."""
    sheets = sheet("LOWER", 1, (4, 4), (0.0, 0.0, 0.0), (40.0, 40.0))
    sheets += sheet("UPPER", 10_001, (3, 3), (20.0, 5.0, 2.0), (30.0, 30.0)) + sections("LOWER", "UPPER", thickness=2.0)
    (tmp_path / "tied.inp").write_text(f"{sheets}*TIE, NAME=T\nUPPER_FACE, LOWER_FACE\n*BOUNDARY\nLOWER_NODES, 1, 6\n")
    said = creak(command, tmp_path / "tied.inp", *(["--count", 1] if command == "modes" else [])).done()
    words = " ".join(said.out.split())
    assert "read: *TIE, NAME=T (" in words
    assert "4 of 16 nodes of 'UPPER_FACE' lie farther than" in words
    assert "not read: *TIE, NAME" not in words
