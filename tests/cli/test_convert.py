"""`creak convert` from Abaqus and Nastran decks to one another and to matrices."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from creak.formats.abaqus.reader import read_deck
from creak.formats.matrices.superelements import read_superelement
from creak.formats.nastran.reader import read_nastran
from creak.model.comparison import difference
from creak.studies.models.deck_modes import deck_modes
from helpers_decks import two_strips
from helpers_same_model import mesh, nastran_deck

FLAT_PLATE = (
    "\n".join(
        line
        for line in nastran_deck(mesh()).splitlines()
        if not line.startswith(("CBEAM", ",,,0.", "PBEAM", ",,,,", ",YES", ",0.8,0.6", ",4.-5"))
    )
    + "\n"
)
"""The sample without its offset beams and the inertia of its mass, which an Abaqus deck of creak cannot say."""


@pytest.fixture
def run(creak, tmp_path, monkeypatch):
    (tmp_path / "strips.inp").write_text(two_strips(), encoding="utf-8")
    (tmp_path / "plate.bdf").write_text(FLAT_PLATE, encoding="utf-8")
    (tmp_path / "beams.bdf").write_text(nastran_deck(mesh()), encoding="utf-8")

    def call(*arguments):
        monkeypatch.chdir(tmp_path)
        return creak("convert", *arguments)

    return call


def test_abaqus_to_abaqus(run, tmp_path):
    assert "wrote new/copy.inp" in run("strips.inp", "new/copy.inp").done().words
    assert difference(read_deck(tmp_path / "strips.inp"), read_deck(tmp_path / "new" / "copy.inp")) == ""


def test_nastran_to_abaqus(run, tmp_path):
    run("plate.bdf", "plate.inp", "--mass", "consistent").done()
    model = replace(read_nastran(tmp_path / "plate.bdf"), mass_form="consistent")
    assert difference(model, read_deck(tmp_path / "plate.inp"), names=False) == ""


def test_abaqus_to_nastran_and_back(run, tmp_path):
    assert "surface UNDER is UNDER.SNEG in the deck" in run("strips.inp", "strips.bdf", "--mass", "linear").done().words
    run("strips.bdf", "again.inp", "--mass", "consistent").done()
    first, again = read_deck(tmp_path / "strips.inp"), read_deck(tmp_path / "again.inp")
    assert difference(replace(first, surfaces={}), again, names=False, tolerance=1e-13, by_element=True) == ""
    assert set(first.node_sets) | set(first.element_sets) <= set(again.node_sets) | set(again.element_sets)


def test_gaps_are_contact_whose_node_sets_go_on(run, tmp_path):
    """What is said of them can be written into a study of the new deck as it stands."""
    gap = "*ELEMENT, TYPE=GAPUNI, ELSET=G\n9001, 1, 13\n*GAP, ELSET=G\n0.5, 0., 0., 1.\n*BOUNDARY\n"
    (tmp_path / "gap.inp").write_text(two_strips().replace("*BOUNDARY\n", gap, 1), encoding="utf-8")
    told = 'it is contact; a study of what is written has it as [[connector]] type = "play", nodes = ["GAP_G.A",'
    assert told in run("gap.inp", "free.inp").done().words
    assert {"GAP_G.A", "GAP_G.B"} <= set(read_deck(tmp_path / "free.inp").node_sets)
    assert "[[connector]]" in run("gap.inp", "k.npz", "--matrices", "npz").done().words


@pytest.mark.parametrize(("form", "file"), [("npz", "k.npz"), ("mtx", "k_K.mtx"), ("op4", "k.op4"), ("dmig", "k.pch")])
def test_matrices_have_the_frequencies_of_the_deck(run, tmp_path, form, file):
    """Text formats keep all digits of a double. An eigenvalue that is zero comes out as the round-off of the largest."""
    run("strips.inp", "k", "--matrices", form).done()
    assert (tmp_path / file).exists()
    found = read_superelement(tmp_path / file)
    K, M = (A.toarray() if hasattr(A, "toarray") else np.asarray(A) for A in (found.K, found.M))
    values = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    round_off = float(np.sqrt(np.finfo(float).eps * values[-1])) / (2.0 * np.pi)
    assert round_off < 1e-3 * np.sqrt(values[1]) / (2.0 * np.pi)
    expected = deck_modes(tmp_path / "strips.inp", count=6).frequencies
    assert_allclose(np.sqrt(np.maximum(values[:6], 0.0)) / (2.0 * np.pi), expected, rtol=1e-5, atol=round_off)


REFUSED = {
    "lumped mass": (("plate.bdf", "plate.inp"), "--mass consistent"),
    "rigid arms": (("beams.bdf", "beams.inp", "--mass", "consistent"), "rigid arms"),
    "no such format": (("strips.inp", "k", "--matrices", "matlab"), "npz"),
    "no such mass": (("strips.inp", "k.inp", "--mass", "heavy"), "lumped"),
    "consistent mass to Nastran": (("strips.inp", "k.bdf"), "--mass linear"),
    "the same file": (("strips.inp", "./strips.inp"), "same file"),
    "no deck": (("none.inp", "k.inp"), "none.inp"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_status_2_and_nothing_written(run, tmp_path, name):
    arguments, word = REFUSED[name]
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    said = run(*arguments)
    said.refuses(word)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


INSTANCES = """*PART, NAME=P
*NODE
1, 0., 0., 0.
2, 10., 0., 0.
3, 10., 10., 0.
12, 0., 10., 0.
*ELEMENT, TYPE=S4, ELSET=ALL
1, 1, 2, 3, 12
*SHELL SECTION, ELSET=ALL, MATERIAL=STEEL
1.
*END PART
*ASSEMBLY, NAME=A
*INSTANCE, NAME=ONE, PART=P
*END INSTANCE
*INSTANCE, NAME=TWO, PART=P
0., 0., 5.
*END INSTANCE
*END ASSEMBLY
*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.3
*DENSITY
7.85e-9
"""


def test_nodes_of_instances_that_share_labels_are_told_apart(run, tmp_path):
    (tmp_path / "two.inp").write_text(INSTANCES, encoding="utf-8")
    assert (
        "nodes have numbers: 100 + label are of ONE, 200 + label are of TWO"
        in run("two.inp", "k", "--matrices", "npz").done().words
    )
    found = read_superelement(tmp_path / "k.npz")
    assert set(found.node_ids.tolist()) == {101, 102, 103, 112, 201, 202, 203, 212}
    assert_allclose(found.positions[203], [10.0, 10.0, 5.0])
