"""Sections, INCLUDE, case control, frames, what is not read, and mistakes of the file."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.deck.coordinate_systems import point_in_basic
from creak.formats.deck.text import Line
from creak.formats.nastran.mesh.grids import read_systems
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.text.bulk_data import cards_of, id_list
from creak.model.constraints import oblique_supports
from helpers_nastran import read, unread
from helpers_refusal import refusal

BULK = "GRID,1,,0.\nGRID,2,,1.\nCROD,1,1,1,2\nPROD,1,1,3.\nMAT1,1,2.+5,,.3,1.-9\n"


def cards(text):
    return cards_of(Line(line, f"deck:{i}") for i, line in enumerate(text.splitlines(), start=1))


def test_fields_are_counted_over_lines():
    """Field 13 is the second data field of the second line, which is where the message points."""
    (card,) = cards("CBAR    1       1       1       2       0.      1.      0.\n                5       1.x\n")
    assert card.integer(9) == 5
    with pytest.raises(InputError, match=r"deck:2: field 14 of CBAR is '1\.x'; expected a real number"):
        card.real(10)
    with pytest.raises(InputError, match=r"deck:1: field 6 of CBAR is '0\.'; expected an integer"):
        card.integer(4)


def test_large_and_free_fields():
    large = "GRID*   " + "7".rjust(16) + 16 * " " + "1.5-3".rjust(16) + "\n*       " + "2.".rjust(16) + "\n"
    for text in (large, "GRID*,7,,1.5-3,\n*,2.\n"):
        (card,) = cards(text)
        assert (card.integer(0), card.real(2), card.real(4)) == (7, 1.5e-3, 2.0)


def test_continuations_by_name():
    """In any order and case; the first character of field 10 is free; a name that nothing asks for is an error."""
    text = "PBAR,1,1,1.,1.,1.,1.,,,+a\nPBAR,2,1,1.,1.,1.,1.,,,QB\n+A,5.\n+B,6."
    first, second = cards(text)
    assert (first.real(8), second.real(8)) == (5.0, 6.0)
    assert first.place(8) == "deck:3"
    with pytest.raises(
        InputError, match="deck:3: no line asks for continuation 'C', which follows a line of PBAR that asks for 'QB'"
    ):
        cards(text.replace("+A,5", "+C,5"))


PARENT, ANSWER, SECOND, OTHER, DESC = (
    "RBE2    70      9001    123456  103     104     105     203     204     +R1\n",
    "+R1     205     303     304     305     306     307     308     309     +R2\n",
    "+R2     310\n",
    "MAT1    7       2.1+5           .3      7.85-9\n",
    "DESC    5       left, right, above\n",
)


@pytest.mark.parametrize(
    "lines",
    [
        (OTHER, PARENT, ANSWER, SECOND),
        (PARENT, OTHER, ANSWER, SECOND),
        (PARENT, DESC, ANSWER, OTHER, SECOND),
        (PARENT, OTHER, ANSWER, "        310\n"),
        (PARENT, OTHER, SECOND, ANSWER),
        (ANSWER, SECOND, OTHER, PARENT),
        (ANSWER, "+       310\n", OTHER, PARENT),
        (SECOND, ANSWER, OTHER, PARENT),
        (OTHER, SECOND, PARENT, ANSWER),
    ],
)
def test_a_named_continuation_may_stand_anywhere(lines):
    """Also behind a card that asks for nothing, and before the line that asks for it; that card stays as it is."""
    found = {card.name: card for card in cards("".join(lines))}
    ids = [*(103, 104, 105, 203, 204), *(205, 303, 304, 305, 306, 307, 308, 309), 310]
    assert list(id_list(found["RBE2"], 3)) == ids
    assert found["RBE2"].place(8) == f"deck:{lines.index(ANSWER) + 1}"
    assert not any(found["MAT1"].fields[5:])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            OTHER + "+ABC    1.\n",
            "deck:2: no line asks for continuation 'ABC', which follows a line of MAT1; expected a",
        ),
        (
            "SPC1,1,126,1,THRU,407\n+ABC,1,2,3\n",
            "deck:2: no line asks for continuation 'ABC'.* a line with 'ABC' in field",
        ),
        (PARENT + ANSWER + SECOND + SECOND, "deck:4: no line asks for continuation 'R2'"),
        ("+A,1.,,,,,,,,+A\n" + OTHER, "deck:1: no line asks for continuation 'A'; expected"),
    ],
)
def test_a_continuation_that_no_line_asks_for_is_refused(text, message):
    with pytest.raises(InputError, match=message):
        cards(text)


def test_replication():
    """= repeats a field, == the rest, *x counts on; =n repeats the replication."""
    text = "GRID,101,17,1.,10.5,,17,3456\n=,*1,=,*(.2),==\n=,*(1),=,*.2,==\n=3\nGRID,7,,1."
    found = cards(text)
    assert [c.integer(0) for c in found] == [101, 102, 103, 104, 105, 106, 7]
    assert [c.real(2) for c in found[:6]] == pytest.approx([1.0, 1.2, 1.4, 1.6, 1.8, 2.0])
    assert {c.fields[3:7] for c in found[:6]} == {("10.5", "", "17", "3456")}
    fixed = cards(
        "CBAR    1       1       1       2       0.      1.      0.\n=       *1      =       *1      *1      ==\n=(2)\n"
    )
    assert [c.fields[:4] for c in fixed] == [(str(i), "1", str(i), str(i + 1)) for i in range(1, 5)]
    with pytest.raises(InputError, match="deck:2: a replicated field adds '1' to 'A'"):
        cards("SET1,A\n=,*1")


def test_too_many_fields():
    with pytest.raises(InputError, match="deck:1: the line has 11 fields; expected at most 10"):
        cards("GRID,1,,1.,2.,3.,,,,,5")


def test_id_lists():
    (card,) = cards("SET1,1,3,THRU,9,BY,3,20\n,30,THRU,32")
    assert list(id_list(card, 1)) == [3, 6, 9, 20, 30, 31, 32]


def test_chained_systems():
    """System 3 lies in cylinder 2, which lies in 1, moved by 10 along y; 4 is given by grids, one of them in system 1."""
    text = (
        "CORD2R,1,,0.,10.,0.,0.,10.,1.\n,1.,10.,0.\nCORD2C,2,1,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
        "CORD2R,3,2,2.,90.,0.,2.,90.,1.\n,3.,90.,0.\nCORD1R,4,1,2,3\nGRID,1,1,0.,0.,0.\nGRID,2,1,0.,0.,4.\nGRID,3,,1.,10."
    )
    systems = read_systems(cards(text))
    np.testing.assert_allclose(point_in_basic(systems[3], np.array([1.0, 0.0, 0.0])), [0.0, 13.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(point_in_basic(systems[4], np.array([1.0, 2.0, 3.0])), [1.0, 12.0, 3.0], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("CORD2R,1,2,0.,0.,0.,0.,0.,1.\n,1.\nCORD2R,2,1,0.,0.,0.,0.,0.,1.\n,1.", "CORD2R 2 refers to system 1"),
        ("CORD2R,1,7,0.,0.,0.,0.,0.,1.\n,1.", "CORD2R 1 refers to system 7"),
        ("CORD2R,1,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.", "three points of CORD2R 1 lie on a line"),
        ("CORD1R,1,5,6,7", "CORD1R uses grid 5, which is not defined"),
        ("CORD1R,1,5,6,7\nGRID,5,1\nGRID,6,,1.\nGRID,7,,,1.", "GRID 5 refers to system 1"),
        ("CORD2R,1,,0.,0.,0.,0.,0.,1.\n,1.\nCORD2R,1,,0.,0.,0.,0.,0.,1.\n,2.", "coordinate system 1 is defined twice"),
    ],
)
def test_wrong_systems(text, message):
    with pytest.raises(InputError, match=message):
        read_systems(cards(text))


def test_grid_defaults(tmp_path):
    """GRDSET gives CP, CD and PS where GRID leaves them blank."""
    frame = "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n"
    model = read(tmp_path, frame + "GRDSET,,5,,,,5,3\n" + BULK)
    np.testing.assert_allclose(model.nodes.coords[1], [0.0, 1.0, 0.0], atol=1e-15)
    held = {(e.nodes_idx.tolist()[0], *e.dofs.tolist()) for e in oblique_supports(model.constraints, model.fixed)}
    assert (model.nodes.count, model.fixed, held) == (2, (), {(0, 3), (1, 3)})  # and no node but the two of the deck
    assert read(tmp_path, "GRDSET,,,,,,,3\n" + BULK).fixed[0].dofs == (3,)


def test_include(tmp_path):
    """Nested, in quotes over two lines, with backslashes, in case control and bulk; relative to the including file."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "grids.bdf").write_text("GRID,1,,0.\ninclude more.bdf\n")
    (tmp_path / "parts" / "more.bdf").write_text("GRID,2,,1.\n")
    (tmp_path / "case.inc").write_text("SPC = 4\n")
    bulk = BULK.replace("GRID,1,,0.\nGRID,2,,1.\n", "INCLUDE 'parts\\\n  grids.bdf'\n") + "SPC1,4,1,1\n"
    model = read(tmp_path, bulk, "include 'case.inc'\n")
    assert model.nodes.ids.tolist() == [1, 2]
    assert len(model.fixed) == 1


def test_all_in_included_files(tmp_path):
    """A main file of INCLUDE lines only: the sections are those of what it includes."""
    (tmp_path / "head.bdf").write_text("SOL 103\nCEND\nSPC = 4\n")
    (tmp_path / "bulk.bdf").write_text(f"BEGIN BULK\n{BULK}SPC1,4,1,1\nENDDATA\n")
    main = tmp_path / "main.bdf"
    main.write_text("INCLUDE head.bdf\nINCLUDE bulk.bdf\n")
    model = read_nastran(main)
    assert len(model.fixed) == 1
    assert unread(model) == {}


def test_missing_and_circular_include(tmp_path):
    with pytest.raises(InputError, match=r"deck\.bdf:4: there is no included file nothing\.bdf"):
        read(tmp_path, "INCLUDE nothing.bdf\n" + BULK)
    with pytest.raises(InputError, match="includes itself"):
        read(tmp_path, "INCLUDE deck.bdf\n" + BULK)


def test_files_that_are_no_decks(tmp_path):
    path = tmp_path / "a.bdf"
    with pytest.raises(InputError, match="there is no deck"):
        read_nastran(path)
    path.write_bytes(b"\x00\x01\x02")
    with pytest.raises(InputError, match="not a text file"):
        read_nastran(path)
    path.write_text("hello world\n")
    with pytest.raises(InputError, match="no GRID cards"):
        read_nastran(path)


@pytest.mark.parametrize("end", ["\n", ""])
def test_a_deck_without_enddata_is_read_to_its_end(tmp_path, end):
    """And told; a line without an end may be whole."""
    path = tmp_path / "deck.bdf"
    path.write_text("SOL 103\nCEND\nBEGIN BULK\n" + BULK.rstrip() + end)
    model = read_nastran(path)
    assert model.nodes.count == 2
    assert [(u.keyword, u.changes_answer) for u in model.unread] == [("ENDDATA", False)]
    assert "MAT1 1 is the last card" in model.unread[0].why
    assert model.unread[0].where == f"{path}:8"


@pytest.mark.parametrize(
    ("last", "words"),
    [
        ("GRID,3,,1.,2.\nGRID,4,,1", "has fewer fields than all others of its name"),
        ("GRID,3,,1.,2.\nPBAR,1,1,1.,1.,1.,1.,,,+a\n", "PBAR 1 goes on in a line that is not there"),
        ("PBAR    1       1       1.      1.      1.      1.                      +\n", "PBAR 1 goes on"),
    ],
)
def test_a_deck_that_is_cut_off_is_refused(tmp_path, last, words):
    path = tmp_path / "deck.bdf"
    text = "SOL 103\nCEND\nBEGIN BULK\n" + BULK.replace("0.\n", "0.,0.\n").replace(",,1.\n", ",,1.,0.\n") + last
    path.write_text(text)
    error = refusal(read_nastran, path)
    assert words in error.what
    assert error.where == f"{path}:{len(text.splitlines())}"
    assert "ENDDATA" in error.expected
    assert "Get the whole file" in error.fix


def test_formulas_and_sentences_are_no_fields(tmp_path):
    """Their commas part nothing, and they may go on over lines."""
    prose = (
        "DEQATN  10      F(A,B)=A+B*2.+MAX(A,B)\n        MIN(A,B)\nDEQATN,11,F(A,B,C,D,E,F,G,H,I,J)=A+B+C+D,E,F,G\n"
        "DESC    5       left, right, above, below, before, behind, inside, outside, more\n"
    )
    model = read(tmp_path, prose + BULK)
    assert unread(model) == {"DEQATN": False, "DESC": False}
    assert model.nodes.count == 2


def test_set_of_all(tmp_path):
    """All grids; what a plot packet calls the same is another set."""
    model = read(tmp_path, BULK, "SET 5 = ALL\nSET 6 = 2\nDISPLACEMENT = 5\nOUTPUT(PLOT)\nSET 6 = ALL\n")
    assert model.node_set("SET_5").tolist() == [0, 1]
    assert model.node_set("SET_6").tolist() == [1]
    assert "SET_5" not in model.element_sets


def test_sections_after_enddata_are_not_read(tmp_path):
    assert read(tmp_path, BULK + "ENDDATA\nGRID,1,,5.\n").nodes.count == 2


def test_superelement_sections(tmp_path):
    """The residual structure is read, and that it is not all is said."""
    model = read(tmp_path, BULK + "BEGIN SUPER=1\nGRID,1,,7.\n")
    assert model.nodes.count == 2
    assert unread(model)["BEGIN SUPER=1"]


def test_unread_cards(tmp_path):
    """Harmless ones, ones that change the answer, unknown ones with a hint; parameters; subcases."""
    extra = "EIGRL,1,,,10\nFORCE,1,1,,1.,1.,0.,0.\nCGAP,9,9,1,2,1.,0.,0.\nPGAP,9,.1,,1.+6\nCHEXXA,1\nPARAM,K6ROT,10.\nPARAM,INREL,-1\nPARAM,POST,-1\n"
    case = "TITLE = x\nK2PP = STIFF\nSUBCASE 1\nLOAD = 3\nSUBCASE 2\nSPC = 5\n"
    model = read(tmp_path, BULK + extra, case)
    found = unread(model)
    assert {k: v for k, v in found.items() if not v}.keys() == {
        "EIGRL",
        "FORCE",
        "PARAM,K6ROT",
        "PARAM",
        "case control",
    }
    assert {k: v for k, v in found.items() if v}.keys() == {"CGAP", "CHEXXA", "PARAM,INREL", "K2PP", "SUBCASE 2"}
    why = {u.keyword: u.why for u in model.unread}
    assert "Did you mean 'CHEXA'" in why["CHEXXA"]
    assert "TITLE, LOAD" in why["case control"]
    assert all(u.where.startswith(str(tmp_path)) for u in model.unread)


def test_damping(tmp_path):
    """GE acts where W4 is given, G where W3 is; ALPHA1 and ALPHA2 are Rayleigh's numbers."""
    bulk = BULK.replace(",.3,1.-9", ",.3,1.-9,,,.04")
    assert read(tmp_path, bulk).blocks[0].section.material.beta == 0.0
    assert unread(read(tmp_path, bulk))["MAT1, GE"] is False
    material = (
        read(tmp_path, bulk + "PARAM,W4,200.\nPARAM,G,.1\nPARAM,W3,50.\nPARAM,ALPHA1,3.\n").blocks[0].section.material
    )
    assert material.beta == pytest.approx(0.04 / 200.0 + 0.1 / 50.0)
    assert material.alpha == 3.0


@pytest.mark.parametrize(
    ("card", "message"),
    [
        ("GRID,1,,9.", "grid 1 is defined twice, first at .*deck.bdf:4"),
        ("GRID,3,8,1.", "deck.bdf:9: GRID 3 needs coordinate system 8"),
        ("GRID,3,,1.,,,-1\nSPC1,1,1,3", "SPC1 1 uses grid 3, which is a fluid point"),
        ("GRID,x,,1.", "field 2 of GRID is 'x'; expected an integer"),
        ("GRID,3,,1.e", "field 4 of GRID is '1.e'; expected a real number"),
        ("MAT1,1,3.+5,,.3", "material 1 is defined twice"),
        ("MAT1,2,,,.3\nPROD,9,2,1.\nCROD,9,9,1,2", "MAT1 2 has neither E nor G"),
        ("MAT1,2,1.,,.5\nPSOLID,9,2", "MAT1 2 has E = 1 and nu = 0.5"),
        (
            "MAT8,2,1.,1.,1.1,1.\nPSHELL,9,2,1.\nGRID,3,,0.,1.\nCTRIA3,9,9,1,2,3",
            "elastic constants are those of no stable material",
        ),
        ("PARAM,WTMASS,abc", "field 3 of PARAM is 'abc'; expected a real number"),
    ],
)
def test_mistakes(tmp_path, card, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, BULK + card + "\n")


def test_parameters_in_the_case_control(tmp_path):
    """PARAM stands there too; a later one in the bulk data counts."""
    assert read(tmp_path, BULK, "PARAM,WTMASS,2.\nPARAM,COUPMASS,1\n").blocks[0].section.material.density == 2e-9
    assert read(tmp_path, BULK, "PARAM,COUPMASS,1\n").mass_form == "linear"
    assert read(tmp_path, BULK).mass_form == "lumped"


@pytest.mark.parametrize("before", ["TITLE = bracket, left,", "subtitle = one,", "LABEL=a,", "SET 4 = 1,\n2"])
def test_a_title_that_ends_with_a_comma_does_not_swallow_the_next_command(tmp_path, before):
    """A SET goes on after a comma, a title does not: SPC = 1 took no effect."""
    assert len(read(tmp_path, BULK + "SPC1,1,123456,1\n", f"{before}\nSPC = 1\n").fixed) == 1


def test_equal_cards_count_once(tmp_path):
    assert read(tmp_path, BULK + "GRID,1,,0.\nMAT1,1,2.+5,,.3,1.-9\n").nodes.count == 2


def test_bad_set_number(tmp_path):
    with pytest.raises(InputError, match="SPC = 'ABC'; expected the number of a set"):
        read(tmp_path, BULK, "SPC = ABC\n")


def test_latin_1_comments_end_where_the_line_ends(tmp_path):
    """Byte 0x85, an ellipsis on Windows, ends no line."""
    path = tmp_path / "a.bdf"
    text = f"SOL 103\nCEND\nBEGIN BULK\n$ Blech \x85 T\xfcr\n{BULK}\nENDDATA\n"
    path.write_bytes(text.encode("latin-1"))
    assert unread(read_nastran(path)) == {}


PRESTRESS = "SUBCASE 1\nSPC = 1\nLOAD = 3\nSUBCASE 2\nSPC = 2\nMETHOD = 1\n"


@pytest.mark.parametrize(
    ("case", "told"),
    [
        (PRESTRESS + "STATSUB = 1\n", True),
        (PRESTRESS + "STATSUB(PRELOAD) = 1\n", True),
        ("METHOD = 1\n" + PRESTRESS.replace("METHOD = 1\n", "STATSUB = 1\n"), True),
        (PRESTRESS, False),
    ],
)
def test_modes_after_a_static_subcase(tmp_path, case, told):
    """STATSUB in any subcase stiffens the structure; without it the subcase of the METHOD counts: its SPC holds grid 2."""
    model = read(tmp_path, BULK + "SPC1,1,1,1\nSPC1,2,1,2\n", case)
    assert unread(model).get("STATSUB", False) == told
    if not told:
        assert [f.nodes_idx.tolist() for f in model.fixed] == [[1]]
        assert [u.why for u in model.unread if u.keyword == "SUBCASE 1"] == [
            "creak takes the first subcase that has a METHOD"
        ]


@pytest.mark.parametrize("card", ["BSET1,1,1", "BSET,1,1", "CSET1,1,1", "SESET,1,1", "ASET,1,1", "OMIT,1,1"])
def test_condensed_mass_changes_modes(tmp_path, card):
    """Guyan, unless the deck keeps modes of what is condensed (QSET)."""
    case, name = "METHOD = 1\n", card.split(",")[0]
    assert unread(read(tmp_path, BULK + card + "\n", case))[name]
    assert not unread(read(tmp_path, BULK + card + "\nSPOINT,99\nQSET1,,99\n", case)).get(name, False)
