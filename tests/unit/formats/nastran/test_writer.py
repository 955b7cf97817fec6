"""Nastran decks written from models: read back they are the same model, with the same K, M and C."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.assembly.part import common_rayleigh
from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.deck.text import Line
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.text.bulk_data import cards_of
from creak.formats.nastran.write.fields import WIDTH, card, fitted
from creak.formats.nastran.writer import write_nastran
from creak.model.comparison import difference
from creak.model.mesh import Model
from creak_thesis.door.writer import write_door
from fuzz_samples import SOLIDS, STRIPS
from helpers_dynamic_decks import STEP, cantilever_deck, stop_deck
from helpers_nastran import assembled, read
from helpers_same_model import abaqus_deck, mesh, nastran_deck

QUOTIENT = 1e-12
"""A few roundings of 1e-16 in A/T, T1/T and the like, and their sums in sections of plies."""
ROUND_OFF = 1e-13
"""Entries of matrices over the root of their diagonals; the sum of some ten such numbers."""

MAT = "MAT1,1,210000.,,.3,7.85-9\n"
PLATE = "GRID,5,,.1\nGRID,2,,10.3\nGRID,9,,10.,8.,.3\nGRID,11,,,8.\nGRID,3,,20.,4.7,1.D-17\nGRID,40,,20.,-1.,7.\n"
SHELLS = PLATE + "CQUAD4,70,7,5,2,9,11{}\nCTRIA3,8,7,2,3,9\n"
BARS = "GRID,1\nGRID,2,,10.,.1,.3\nGRID,3,,17.,3.\nGRID,4,,,5.\n"
TURNED = "CORD2C,5,,0.,0.,0.,0.,0.,1.\n,.6,.8,0.\n"
SHEET = "MAT8,8,9000.,3000.,.28,1500.,1100.,800.,1.3-9\n"
GENERAL_SHELL = (
    SHELLS.format("")
    + "PSHELL,7,1,.7,2,.8,3,.9,1.-9\n,,,4\n"
    + MAT
    + "MAT2,2,3.,1.,.1,4.,.2,2.\nMAT2,3,1.,.1,,2.\nMAT2,4,.01,,,.02,,.03\n"
)

IDENTICAL = {
    "same model": None,
    "thickness and offset": SHELLS.format(",,.13,\n,,,.5,.6,.7,.8") + "PSHELL,7,1,.77,1,,1,,2.-9\n" + MAT,
    "no T on the property": PLATE + "CQUAD4,70,7,5,2,9,11\n,,,.5,.6,.7,.8\nPSHELL,7,1,,1,,1\n" + MAT,
    "plies": TURNED + SHELLS.format(",5") + "PCOMP,7,-.3,1.-9,,,,,SYM\n,8,.2,17.3,,1,.31,-45.\n" + SHEET + MAT,
    "material angle": SHELLS.format(",33.3") + "PCOMP,7\n,8,.2,17.3\n" + SHEET,
    "G of its own": SHELLS.format("") + "PCOMP,7\n,1,.2,17.3\nMAT1,1,1000.,700.,.3,1.-9\n",
    "four materials": GENERAL_SHELL,
    "membrane": SHELLS.format("") + "PSHELL,7,1,.7\n" + MAT,
    "damping": SHELLS.format("") + "PSHELL,7,1,.7,1,,1\nPARAM,ALPHA1,3.\nPARAM,ALPHA2,1.-5\n" + MAT,
    "loss factors": SHELLS.format("") + "PSHELL,7,1,.7,1,,1\nCROD,9,9,3,40\nPROD,9,2,1.\nPARAM,W4,300.\n"
    "MAT1,1,210000.,,.3,7.85-9\n,.1\nMAT1,2,70000.,,.3,2.7-9\n,.3\n",
    "bars": BARS
    + "CBAR,1,3,1,2,0.,1.,.2\n,,,.1,.2,.3,.4,.5,.6\nCBEAM,2,4,2,3,4\nCBAR,3,3,2,4,1.,0.,.2\nCROD,4,5,1,3\nCROD,5,6,1,4\n"
    "PBAR,3,1,8.,10.,3.,7.,1.-9\n,,,,,,,,\n,.8,.6\nPBEAM,4,1,8.,10.,3.,,7.\nPROD,5,1,2.\nPROD,6,1,2.,3.,,4.-9\n" + MAT,
    "solids": "GRID,1\nGRID,2,,1.\nGRID,3,,1.,1.\nGRID,4,,0.,1.\nGRID,5,,0.,0.,1.\nGRID,6,,1.,0.,1.\nGRID,7,,1.,1.,1.\n"
    "GRID,8,,0.,1.,1.\nGRID,9,,2.,0.,.5\nCHEXA,1,5,1,2,3,4,5,6\n,7,8\nCTETRA,2,6,2,9,3,6\nPSOLID,5,1\nPSOLID,6,9,4\n"
    "CORD2R,4,,0.,0.,0.,0.,.1,1.\n,.6,.8,0.\n" + MAT + "MAT9,9,30.,1.,2.,,,,20.\n,3.,,,,10.,,,\n,4.,,,5.,,6.,1.-9\n",
    "springs": TURNED + BARS + "CELAS2,1,7.,1,2\nCELAS2,2,7.,1,2,3,4\nCDAMP2,3,5.,2,1,4,1\nCVISC,4,9,1,2\nPVISC,9,3.3\n"
    "CBUSH,5,5,1,2,0.,1.,.3,,.25\nCBUSH,6,6,1,3,,,,5\nCBUSH,7,7,4,,,,,0\nPBUSH,5,K,1.,2.,3.,4.,5.,6.\n,B,.1,.2\n"
    "PBUSH,6,B,1.,2.,,3.\nPBUSH,7,K,,,3.\nCONM2,20,1,,2.\nCONM2,21,2,5,3.,.1,.2,.3\n,1.,.1,2.,.2,.3,3.\n"
    "CONM1,22,3,5,1.,.1,2.,.2,.3\n,3.\nCONM2,23,4,,1.\n",
    "damping of the whole": BARS
    + "CELAS2,1,7.,1,2\nCBUSH,5,5,1,2,0.,1.,.3\nPBUSH,5,K,1.,2.\nCROD,4,6,1,3\nPROD,6,1,2.\nCONM2,20,1,,2.\n"
    "CONM1,22,3,,1.\nCONM2,23,2,,1.\nPARAM,ALPHA1,3.\nPARAM,G,.1\nPARAM,W3,100.\n" + MAT,
    "loss factors of springs": BARS
    + "CELAS2,1,7.,1,2,,,.1\nCELAS2,2,7.,1,2,3,4,.2\nCELAS2,3,7.,1,3\nCBUSH,5,5,1,2,0.,1.,.3\nCBUSH,6,6,1,3,,,,0\n"
    "CBUSH,7,7,4,,,,,0\nPBUSH,5,K,1.,2.,3.\n,B,.1\n,GE,.3\nPBUSH,6,K,1.,2.,3.,4.\n,GE,.1,.2,.1\nPBUSH,7,K,4.\n"
    "CONM2,20,1,,2.\nCONM2,21,2,,3.\nCONM2,22,3,,1.\nCONM2,23,4,,1.\nPARAM,W4,100.\nPARAM,ALPHA1,2.\n",
    "constraints": BARS
    + "CBAR,1,3,1,2,0.,1.,.2\nCBAR,2,3,3,4,0.,1.,.2\nPBAR,3,1,8.,10.,3.,7.\nGRID,30,,1.,1.,1.\nGRID,31,,2.,1.,1.\n"
    "RBE2,50,1,1235,30\nRBE3,51,,31,123456,1.3,123,1,2,\n,.7,123,3,4\nRBAR,52,1,4\nMPC,1,30,4,2.,2,1,-3.\n,,3,2,.1\n"
    "SPC1,1,135,1,2\nSPC,1,3,23,,4,1\nCONM2,60,31,,1.\n" + MAT,
    "sets": PLATE
    + "CQUAD4,70,7,5,2,9,11\nCTRIA3,8,8,2,3,9\nPSHELL,7,1,.7,1,,1\nPSHELL,8,1,.7,1,,1\n"
    + MAT
    + 'SET1,3,2,9,5\nSET1,70,70,8,9\nSET3,5,ELEM,8,70\n$HMNAME PROP          8"Skin of it"\n'
    '$HMSET        3        1 "Rim" 4\nASET1,123,9,2\n',
}


def _model(tmp_path, name: str) -> Model:
    if name == "same model":
        (tmp_path / "deck.bdf").write_text(nastran_deck(mesh()), encoding="utf-8")
        return read_nastran(tmp_path / "deck.bdf")
    return read(tmp_path, IDENTICAL[name])


def matrices(model: Model) -> list[np.ndarray]:
    """K, M, C over all dofs in the order of the nodes."""
    system, rayleigh = assembled(model), common_rayleigh(model)
    order = np.argsort(system.coordinates)
    extra = np.zeros((system.n, system.n)) if system.damping.extra is None else to_dense(system.damping.extra)
    K, M, C = (to_dense(A)[np.ix_(order, order)] for A in (system.K, system.M, extra))
    return [system.coordinates[order], K, M, C, np.array([rayleigh.alpha, rayleigh.beta])]


def assert_same_matrices(a: Model, b: Model) -> None:
    one, other = matrices(a), matrices(b)
    np.testing.assert_array_equal(one[0], other[0])
    for x, y in zip(one[1:4], other[1:4], strict=True):
        size = np.sqrt(np.maximum(np.abs(np.diag(x)), np.abs(np.diag(y))))
        size[size == 0.0] = 1.0
        assert (np.abs(x - y) / np.outer(size, size)).max() < ROUND_OFF
    np.testing.assert_allclose(one[4], other[4], rtol=1e-14)


@pytest.mark.parametrize("name", IDENTICAL)
def test_reading_what_was_written_gives_the_same_model(tmp_path, name):
    model = _model(tmp_path, name)
    write_nastran(model, tmp_path / "copy.bdf")
    copy = read_nastran(tmp_path / "copy.bdf")
    assert difference(model, copy, names=False, tolerance=QUOTIENT) == ""
    assert not [u for u in copy.unread if u.changes_answer]
    assert_same_matrices(model, copy)


ABAQUS = {
    "same model": abaqus_deck(mesh()),
    "strips": STRIPS,
    "mass on a stop": stop_deck(),
    "cantilever": cantilever_deck(STEP),
    "tie and solids": SOLIDS.replace("*CENTROID\n 0.1, 0.2\n*SHEAR CENTER\n 0.2, 0.1\n", ""),
}


@pytest.mark.parametrize("form", ["linear", "lumped"])
@pytest.mark.parametrize("name", ABAQUS)
def test_an_abaqus_model_keeps_its_matrices(tmp_path, name, form):
    (tmp_path / "deck.inp").write_text(ABAQUS[name], encoding="utf-8")
    model = replace(read_deck(tmp_path / "deck.inp"), mass_form=form)
    write_nastran(model, tmp_path / "copy.bdf")
    copy = read_nastran(tmp_path / "copy.bdf")
    assert copy.mass_form == form
    assert_same_matrices(model, copy)
    for sets, other in ((model.node_sets, copy.node_sets), (model.element_sets, copy.element_sets)):
        assert {n for n, rows in sets.items() if len(rows)} <= set(other)


def test_a_beam_beside_its_nodes(tmp_path):
    """Centroid and shear centre at one point off the line, axes turned: offsets W and another orientation vector."""
    beam = (
        "*NODE\n 1, 0.\n 2, 10., 1., 2.\n*ELEMENT, TYPE=B31, ELSET=B\n 1, 1, 2\n"
        "*BEAM GENERAL SECTION, ELSET=B, DENSITY=1e-9\n 2., 3., .5, 4., 5.\n 0., .2, 1.\n 1000., 411.\n"
        "*CENTROID\n .1, .2\n*SHEAR CENTER\n .1, .2\n*TRANSVERSE SHEAR STIFFNESS\n 500., 600.\n*BOUNDARY\n 1, 1, 6\n"
    )
    (tmp_path / "deck.inp").write_text(beam, encoding="utf-8")
    model = replace(read_deck(tmp_path / "deck.inp"), mass_form="linear")
    write_nastran(model, tmp_path / "copy.bdf")
    K, other = matrices(model)[1], matrices(read_nastran(tmp_path / "copy.bdf"))[1]
    np.testing.assert_allclose(K, other, atol=1e-13 * np.abs(K).max())


def test_springs_along_turned_axes_become_matrices(tmp_path):
    """CELAS, CDAMP and CMASS in displacement frames: K2GG, B2GG and M2GG."""
    grids = (
        TURNED + "GRID,1,,1.,2.,3.,5\nGRID,2,,2.,2.,3.,5\nGRID,3,,9.\nCONM2,20,1,,2.\nCONM2,21,2,,2.\nCONM2,22,3,,2.\n"
    )
    model = read(tmp_path, grids + "CELAS2,1,7.,1,1,2,2\nCDAMP2,2,5.,1,1\nCMASS2,3,.1,1,5,2,5\nCELAS2,4,3.,3,1\n")
    write_nastran(model, tmp_path / "copy.bdf")
    text = (tmp_path / "copy.bdf").read_text()
    assert all(f"{word} = " in text for word in ("K2GG", "B2GG", "M2GG"))
    assert_same_matrices(model, read_nastran(tmp_path / "copy.bdf"))


def test_supports_along_turned_axes(tmp_path):
    bulk = TURNED + "GRID,1,,1.,2.,3.,5,13\nGRID,2,,4.\nCBAR,1,3,1,2,0.,1.,.2\nPBAR,3,1,8.,10.,3.,7.\n" + MAT
    model = read(tmp_path, bulk + "SPC1,1,2,2\n")
    write_nastran(model, tmp_path / "copy.bdf")
    assert_same_matrices(model, read_nastran(tmp_path / "copy.bdf"))


def test_initial_velocity(tmp_path):
    bulk = f"{TURNED}{BARS.replace('GRID,4,,,5.', 'GRID,4,,,5.,,5')}CONM2,20,1,,2.\nCONM2,21,4,,2.\nTIC,1,1,3,,-1.\nTIC,1,4,1,,.1\n"
    model = read(tmp_path, bulk, case="IC = 1\n")
    assert len(model.initial_velocity) == 3
    write_nastran(model, tmp_path / "copy.bdf")
    assert read_nastran(tmp_path / "copy.bdf").initial_velocity == model.initial_velocity


def test_labels_of_instances_are_told_apart(tmp_path):
    """A door has parts whose nodes have the same labels; surfaces become element sets."""
    deck = next(p for p in write_door(40.0, tmp_path) if p.suffix == ".inp")
    model = replace(read_deck(deck), mass_form="linear")
    notes = write_nastran(model, tmp_path / "door.bdf")
    copy = read_nastran(tmp_path / "door.bdf")
    assert np.unique(copy.nodes.ids).size == copy.nodes.count == model.nodes.count
    assert "PANEL_EDGE" in copy.surfaces
    assert any("PANEL_EDGE" in note for note in notes)


NAMES = [
    "PLATE TOP",
    "PLATE_TOP",
    "A, B",
    "A=B.C",
    "$#*'()/:;<>|&%+",
    "ÄÖ 1",
    "SET_03",
    "SET_0",
    "PID_1",
    "1 2",
    "17",
    "X.SPOS",
]


@pytest.mark.parametrize("name", NAMES)
def test_names_of_any_characters_stay_but_for_blanks(tmp_path, name):
    """Of surfaces, element sets and node sets, in comments."""
    deck = (
        "*NODE\n 1, 0.\n 2, 10.\n 3, 10., 8.\n 4, 0., 8.\n*ELEMENT, TYPE=S4, ELSET=P\n 1, 1, 2, 3, 4\n 2, 4, 3, 2, 1\n"
        "*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.\n*MATERIAL, NAME=STEEL\n*ELASTIC\n 210000., 0.3\n*DENSITY\n 1e-9\n"
        f'*ELSET, ELSET="{name}"\n 2\n*NSET, NSET="{name}"\n 3, 1\n*ELSET, ELSET=PLATE_TOP\n 1\n'
        f'*SURFACE, NAME="{name} AREA"\n 1, SPOS\n'
    )
    (tmp_path / "deck.inp").write_text(deck, encoding="utf-8")
    model = replace(read_deck(tmp_path / "deck.inp"), mass_form="linear")
    notes = write_nastran(model, tmp_path / "copy.bdf")
    copy = read_nastran(tmp_path / "copy.bdf")
    plain = "PLATE_TOP_2" if name == "PLATE TOP" else name.replace(" ", "_")
    assert any(f"{name!r} is {plain}" in note for note in notes) == (plain != name)
    sets = {n: copy.blocks[0].ids[rows[:, 1]].tolist() for n, rows in copy.element_sets.items()}
    assert sets[plain] == ([2, 1] if name == "PLATE_TOP" else [2])
    assert 1 in sets["PLATE_TOP"]
    assert sets[f"{name} AREA".replace(" ", "_")] == [1]
    assert copy.nodes.ids[copy.node_sets[plain]].tolist() == [3, 1]


def test_element_sets_lose_what_becomes_matrices(tmp_path):
    """Case control names grids 1 and 2; springs of these labels, along turned axes, are no elements in the deck."""
    bulk = TURNED + "GRID,1,,1.,2.,3.,5\nGRID,2,,2.,2.,3.,5\nCONM2,20,1,,2.\nCONM2,21,2,,2.\n"
    springs = "CELAS2,1,7.,1,1\nCELAS2,2,7.,2,2\nSET3,5,ELEM,1,20\n"
    model = read(tmp_path, bulk + springs, case="SET 3 = 1,2\nDISPLACEMENT = 3\n")
    assert {"SET_3", "SET_5"} <= set(model.element_sets)
    notes = write_nastran(model, tmp_path / "copy.bdf")
    copy = read_nastran(tmp_path / "copy.bdf")
    assert any("2 element set(s) lose springs" in note and "SET_3, SET_5" in note for note in notes)
    assert copy.nodes.ids[copy.node_sets["SET_3"]].tolist() == [1, 2]
    assert [copy.blocks[b].ids[r] for b, r in copy.element_sets["SET_5"]] == [20]
    assert_same_matrices(model, copy)


REFUSED = {
    "mass form": (replace, "--mass linear"),
    "shear centre": (
        "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=I\n 1., 6., 4., 5., .3, .4, .5\n 0., 1., 0.\n",
        "shear centre",
    ),
    "damping of single masses": (
        "*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=CIRC\n 1.\n 0., 1., 0.\n"
        "*ELEMENT, TYPE=MASS, ELSET=M\n 9, 1\n*MASS, ELSET=M, ALPHA=.3\n .1\n",
        "mass-proportional",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_deck_cannot_say_is_refused_and_nothing_is_written(tmp_path, name):
    text, word = REFUSED[name]
    section = text if isinstance(text, str) else REFUSED["damping of single masses"][0].partition("*ELEMENT")[0]
    beam = "*NODE\n 1, 0.\n 2, 10.\n*ELEMENT, TYPE=B31, ELSET=B\n 1, 1, 2\n"
    steel = "*MATERIAL, NAME=STEEL\n*ELASTIC\n 210000., 0.3\n*DENSITY\n 7.85e-9\n"
    (tmp_path / "deck.inp").write_text(beam + section + steel, encoding="utf-8")
    model = read_deck(tmp_path / "deck.inp")
    model = replace(model, mass_form="linear") if isinstance(text, str) else model
    with pytest.raises(InputError, match=word):
        write_nastran(model, tmp_path / "copy.bdf")
    assert [p.name for p in tmp_path.iterdir()] == ["deck.inp"]


CHANGES = {
    "coordinate": ("GRID           2       0    10.3", "GRID           2       0    10.4"),
    "thickness": ("PSHELL         7       1      .7", "PSHELL         7       1     .71"),
    "support": (" 12", " 13"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_loss_would_be_seen(tmp_path, monkeypatch, name):
    """The check of the written deck: a line that says something else stops the writer."""
    model = read(tmp_path, SHELLS.format("") + "PSHELL,7,1,.7,1,,1\nSPC1,1,12,5\n" + MAT)
    from creak.formats.nastran import writer

    old, new = CHANGES[name]
    lines = writer.deck_lines
    monkeypatch.setattr(writer, "deck_lines", lambda m, n: [s.replace(old, new) for s in lines(m, n)])
    with pytest.raises(InputError, match="without a loss"):
        write_nastran(model, tmp_path / "copy.bdf")
    assert not (tmp_path / "copy.bdf").exists()


def test_numbers_keep_all_bits():
    draw = random.Random(3)
    values = [0.0, -1.0, 5.1e-60, -9.7976931348623157e59, 1.0 / 3.0, 123456789012345678.0]
    values += [draw.uniform(-1.0, 1.0) * 10.0 ** draw.randint(-40, 40) for _ in range(500)]
    for value in values:
        for width in (8, 16):
            text = fitted(value, width)
            assert text is None or len(text) <= width
        lines = [Line(line, "") for line in card("X", [7, value, None, 1.5, value])]
        (found,) = cards_of(lines)
        assert (found.integer(0), found.text(2)) == (7, "")
        assert [found.real(i) for i in (1, 3, 4)] == [value, 1.5, value]
        assert max(len(line.text) for line in lines) <= WIDTH
        assert lines[0].text[1] != "*" or len(lines) % 2 == 0
        assert len({"," in line.text for line in lines if line.text != "*"}) == 1


def test_lines_of_four_long_numbers_keep_ten_digits():
    draw = random.Random(4)
    for _ in range(200):
        values = [draw.uniform(-1.0, 1.0) * 10.0 ** draw.randint(-50, 59) for _ in range(8)]
        lines = [Line(line, "") for line in card("CORD2R", values)]
        assert max(len(line.text) for line in lines) <= WIDTH
        (found,) = cards_of(lines)
        for k, value in enumerate(values):
            assert found.real(k) == pytest.approx(value, rel=6e-10)


@pytest.mark.parametrize(
    ("sides", "told"),
    [
        (
            "1, SPOS\n 2, SNEG",
            "S is S in the deck: both sides of its 2 elements, of which 2 had one side in the surface",
        ),
        ("1, SPOS\n 1, SNEG\n 2, SNEG", "S is S in the deck: both sides of its 2 elements, of which 1 had one side"),
        ("1, SPOS\n 1, SNEG\n 2, SPOS\n 2, SNEG", "S is S in the deck"),
        ("1, SNEG\n 2, SNEG", "S is S.SNEG in the deck"),
        ("1\n 2", "S is S in the deck"),
    ],
)
def test_a_surface_with_sides_of_both_kinds_says_what_is_lost(tmp_path, sides, told):
    deck = (
        "*NODE\n 1, 0.\n 2, 10.\n 3, 10., 8.\n 4, 0., 8.\n 5, 20.\n 6, 20., 8.\n*ELEMENT, TYPE=S4, ELSET=P\n 1, 1, 2, 3, 4\n"
        " 2, 2, 5, 6, 3\n*SHELL SECTION, ELSET=P, MATERIAL=STEEL\n 1.\n*MATERIAL, NAME=STEEL\n*ELASTIC\n 210000., 0.3\n"
        f"*DENSITY\n 1e-9\n*SURFACE, NAME=S\n {sides}\n"
    )
    (tmp_path / "deck.inp").write_text(deck, encoding="utf-8")
    notes = write_nastran(replace(read_deck(tmp_path / "deck.inp"), mass_form="linear"), tmp_path / "copy.bdf")
    (note,) = (n for n in notes if n.startswith("surface S "))
    assert note.startswith(f"surface {told}")
    assert ("both sides" in note) == ("both sides" in told)
    read = read_nastran(tmp_path / "copy.bdf").surfaces["S"]
    assert set(read.side.tolist()) == {0}
