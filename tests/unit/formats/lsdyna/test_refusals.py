"""Decks that are wrong: one message with file and line; and what is left out is named."""

from __future__ import annotations

import re

import pytest

from creak.errors import InputError
from creak.formats.deck.catalogue import stop_on_unread
from creak.formats.lsdyna.reader import read_lsdyna, read_lsdyna_run
from creak.formats.lsdyna.text.lexer import lsdyna_files

NODES = "*NODE\n1,0.,0.,0.\n2,1.,0.,0.\n3,1.,1.,0.\n4,0.,1.,0.\n5,0.,0.,1.\n6,1.,0.,1.\n7,1.,1.,1.\n8,0.,1.,1.\n"
SHELL = "*ELEMENT_SHELL\n1,1,1,2,3,4\n"
PART = "*PART\nplate\n1,1,1\n*SECTION_SHELL\n1,2\n0.1\n"
STEEL = "*MAT_ELASTIC\n1,7.8e-9,2.1e5,.3\n"
WHOLE = f"*KEYWORD\n{NODES}{SHELL}{PART}{STEEL}"
SOLID = "*ELEMENT_SOLID\n9,2,1,2,3,4,5,6,7,8\n*PART\nbody\n2,2,1\n*SECTION_SOLID\n2,1\n"
SPRING = "*ELEMENT_DISCRETE\n5,3,1,2,0\n*PART\nclip\n3,3,3\n*SECTION_DISCRETE\n3,0\n0.\n*MAT_SPRING_ELASTIC\n3,10.\n"
BEAM = "*ELEMENT_BEAM\n4,4,1,2,3\n*PART\nrod\n4,4,1\n*SECTION_BEAM\n4,1,,,0\n.1,.1,.2,.2\n"
BODY = "*CONSTRAINED_NODAL_RIGID_BODY\n9,,5\n*SET_NODE_LIST\n5\n1,2,3\n"


def read(folder, text):
    path = folder / "deck.k"
    path.write_text(text, encoding="utf-8")
    return read_lsdyna(path)


def line_of(text, words):
    return next(i for i, line in enumerate(text.split("\n"), start=1) if words in line)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("2,1.,0.,0.", "2,1.,x,0.", "field 3 of *NODE is 'x'; expected a real number"),
        ("2,1.,0.,0.", "2,&L,0.,0.", "&L has no value; expected a name that *PARAMETER gives a value"),
        ("2,1.,0.,0.", "-2,1.,0.,0.", "expected an id above 0"),
        ("2,1.,0.,0.", "1,1.,0.,0.", "node 1 is defined twice, in different places"),
        ("2,1.,0.,0.", "2,1.,0.,0.,0,0,9", "a line of *NODE has 7 values; expected at most 6"),
        ("2,1.,0.,0.", "2,1.,0.,0.,8", "a constraint code from 0 to 7"),
        ("1,1,1,2,3,4", "1,1,1,2,3,44", "*ELEMENT_SHELL uses node 44, which is not defined"),
        ("1,1,1,2,3,4", "1,7,1,2,3,4", "*ELEMENT_SHELL uses part 7, which is not defined; expected a *PART"),
        ("1,1,1,2,3,4", "1,1,1,2,3,2", "shell element 1 uses a node twice"),
        ("1,1,1,2,3,4", "1,1,1,2,3,4,5", "expected 3, 4 or 8 nodes"),
        ("1,1,1,2,3,4", "1,1,1,2,3,4\n1,1,1,2,3,4", "shell element 1 is defined twice, first at "),
        ("1,1,1\n", "1,5,1\n", "*PART uses section 5, which is not defined; expected a *SECTION_SHELL"),
        ("1,1,1\n", "1,1,5\n", "*PART uses material 5, which is not defined"),
        ("\n1,2\n0.1", "\n1,13\n0.1", "field 2 of *SECTION_SHELL is '13'; expected ELFORM of a shell with bending"),
        ("\n0.1\n", "\n0.\n", "shell element 1 has thickness 0; expected T1"),
        ("\n0.1\n", "\n", "*SECTION_SHELL has 1 data lines; expected 2 lines for each section"),
        ("2.1e5,.3", "0.,.3", "expected E > 0"),
        ("2.1e5,.3", "2.1e5,.5", "Poisson's ratio above -1 and below 0.5"),
        ("9,2,1,2,3,4,5,6,7,8", "9,2,1,2,3,4,5,6,7,7", "solid element 9 has the nodes 1 2 3 4 5 6 7 7"),
        ("\n2,1\n", "\n2,7\n", "ELFORM of a structural solid"),
        ("5,3,1,2,0", "5,3,1,0,0", "discrete element 5 has no direction"),
        ("5,3,1,2,0", "5,3,1,2,6", "uses orientation 6, which is not defined; expected a *DEFINE_SD_ORIENTATION"),
        ("3,3,3\n", "3,3,1\n", "PART_3 of discrete elements has a *MAT_ELASTIC"),
        ("4,4,1,2,3", "4,4,1,2,3,1", "RT1 0: creak does not release the ends of beams"),
        (".1,.1,.2,.2", ".1,.3,.2,.2", "the same section at both ends"),
        ("4,4,1,2,3", "4,4,1,2,0", "beam element 4 has no orientation node beside its axis"),
        ("9,,5", "9,,6", "*CONSTRAINED_NODAL_RIGID_BODY uses node set 6, which is not defined; expected a *SET_NODE"),
        ("9,,5", "9,,5,,,7", "DRFLAG 0"),
        ("\n1,2,3\n", "\n", "rigid body NRB_9 has no nodes"),
        ("\n1,2,3\n", "\n1,2,33\n", "*SET_NODE_LIST 5 holds 33, which is not defined"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, old, new, said):
    text = WHOLE + SOLID + SPRING + BEAM + BODY
    assert text.count(old) == 1
    with pytest.raises(InputError, match=re.escape(said)) as error:
        read(tmp_path, text.replace(old, new))
    assert str(error.value).startswith(f"{tmp_path / 'deck.k'}:")
    assert str(error.value).split(":")[1].isdigit()


def test_the_whole_deck_is_read(tmp_path):
    model = read(tmp_path, WHOLE + SOLID + SPRING + BEAM + BODY)
    assert sorted(b.kind for b in model.blocks) == ["axial2", "beam2", "hex8", "quad4"]
    assert model.unread == ()


@pytest.mark.parametrize(("first", "second"), [("0,0", "4,7"), ("4,7", "0,0"), ("4,0", "0,7"), ("4,7", "4,7")])
def test_a_node_that_is_there_twice_is_held_by_both_cards(tmp_path, first, second):
    """TC 4: x and y; RC 7: all rotations."""
    text = WHOLE.replace("2,1.,0.,0.\n", f"2,1.,0.,0.,{first}\n").replace(SHELL, f"*NODE\n2,1.,0.,0.,{second}\n{SHELL}")
    model = read(tmp_path, text)
    assert model.nodes.ids.tolist() == list(range(1, 9))
    assert {(int(n), d) for f in model.fixed for n in f.nodes_idx for d in f.dofs} == {(1, d) for d in (1, 2, 4, 5, 6)}


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("1,2\n*KEYWORD\n", 1, "data before the first keyword"),
        ("*KEYWORD\n-----BEGIN PGP MESSAGE-----\n", 2, "encrypted"),
        ("*KEYWORD\n*INCLUDE\nnone.k\n", 3, "there is no included file"),
        ("*KEYWORD\n*INCLUDE\n", 2, "*INCLUDE names no file"),
        ("*KEYWORD\n*INCLUDE\ndeck.k\n", 3, "includes itself"),
        (f"{WHOLE}*INCLUDE_TRANSFORM\npart.k\n\n\n1.,1.e-3\n", 0, "no factor on mass, time, length or temperature"),
        (f"{WHOLE}*BOUNDARY_SPC_NODE\n3,8,1\n", 0, "uses coordinate system 8, which is not defined"),
        (f"{WHOLE}*CONTACT_TIED_SURFACE_TO_SURFACE\n1,2,3,3\n", 0, "uses part 2, which is not defined"),
        (f"{WHOLE}*CONTACT_TIED_SURFACE_TO_SURFACE\n1,1,3,7\n", 0, "field 4 of *CONTACT_TIED"),
        (f"{WHOLE}*SET_SEGMENT\n1\n1,2,5\n", 0, "a segment of *SET_SEGMENT is no face of a shell or solid"),
        (f"{WHOLE}*CONSTRAINED_SPOTWELD\n1,1\n", 0, "a spotweld joins a node to itself"),
        (f"{WHOLE}*DEFINE_TRANSFORMATION\n1\nPOS6P,1,2,3\n", 0, "TRANSL, ROTATE, SCALE, MIRROR or POINT"),
        (
            f"{WHOLE}*MAT_RIGID\n4,7.8e-9,2.1e5,.3\n1,4,0\n*PART\nstiff\n5,1,4\n*ELEMENT_SHELL\n5,5,5,6,7,8\n",
            0,
            "7 (no r",
        ),
    ],
)
def test_what_cannot_be_followed_is_refused(tmp_path, text, line, said):
    (tmp_path / "part.k").write_text("*KEYWORD\n", encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(said)) as error:
        read(tmp_path, text)
    assert not line or str(error.value).startswith(f"{tmp_path / 'deck.k'}:{line}:")


@pytest.mark.parametrize(
    ("keyword", "changes"),
    [
        ("*CONTROL_TERMINATION\n0.01\n", False),
        ("*DATABASE_BINARY_D3PLOT\n0.001\n", False),
        ("*LOAD_NODE_POINT\n3,3,1,1.\n", False),
        ("*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0\n", False),
        ("*DEFINE_CURVE\n1\n0.,1.\n", False),
        ("*MAT_NULL\n7,1.e-9\n", False),
        ("*ELEMENT_SEATBELT\n1,2,3,4\n", True),
        ("*ELEMENT_SHELL_COMPOSITE\n1,2,3,4\n", True),
        ("*CONTACT_TIEBREAK_NODES_TO_SURFACE\n0\n", True),
        ("*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE_TIEBREAK\n0\n", True),
        ("*CONSTRAINED_INTERPOLATION\n1\n", True),
        ("*INITIAL_STRESS_SHELL\n1\n", True),
        ("*INITIAL_VELOCITY_RIGID_BODY\n1,,,9.\n", True),
        ("*BOUNDARY_SPC_SYMMETRY_PLANE\n1\n", True),
        ("*PARAMETER_MUTABLE\nR  L,1.\n", True),
        ("*PARAMETER_DUPLICATION\n1\n", False),
        ("*ELEMNT_SHELL\n1\n", True),
    ],
)
def test_what_is_not_read_is_listed(tmp_path, keyword, changes):
    text = WHOLE + keyword
    (found,) = read(tmp_path, text).unread
    name = keyword.split("\n")[0]
    assert (found.keyword, found.changes_answer) == (name, changes)
    assert found.where == f"{tmp_path / 'deck.k'}:{line_of(text, name)}"


def test_a_misspelled_keyword_is_guessed(tmp_path):
    (found,) = read(tmp_path, f"{WHOLE}*ELEMNT_SHELL\n1\n").unread
    assert "Did you mean 'ELEMENT_SHELL'?" in found.why


def test_elements_of_an_unread_material_are_left_out_by_name(tmp_path):
    """The run stops at it, and goes on without them where that is asked for."""
    text = WHOLE + SOLID.replace("2,2,1\n", "2,2,8\n") + "*MAT_HONEYCOMB\n8,1.e-9,10.,.0\n"
    model = read(tmp_path, text)
    assert [b.kind for b in model.blocks] == ["quad4"]
    assert model.unread[0].keyword == "*MAT_HONEYCOMB"
    with pytest.raises(InputError, match=r"\*MAT_HONEYCOMB is not read .* the elements of PART_2 are left out"):
        stop_on_unread(model, ())
    stop_on_unread(model, ["MAT_HONEYCOMB"])


@pytest.mark.parametrize(
    ("keyword", "why"),
    [
        ("*MAT_ADD_EROSION\n1,0,.3\n\n", "nothing that is added to it"),
        ("*MAT_ADD_DAMAGE_GISSMO_TITLE\ntorn\n1,0,.3\n", "nothing that is added to it"),
        ("*MAT_THERMAL_ISOTROPIC\n1,7.8e-9\n4.5e8,50.\n", "creak has no heat"),
        ("*MAT_T01\n1,7.8e-9\n4.5e8,50.\n", ""),
        ("*MAT_HONEYCOMB\n1,1.e-9,10.,.0\n", "no part that has elements uses it"),
    ],
)
def test_what_is_added_to_a_material_that_is_read_leaves_its_elements(tmp_path, keyword, why):
    """It has the id of the material, or one of another kind."""
    model = read(tmp_path, WHOLE + keyword)
    assert [b.kind for b in model.blocks] == ["quad4"]
    (found,) = model.unread
    assert (found.keyword, found.changes_answer) == (keyword.split("\n")[0], False)
    assert why in found.why


def test_what_is_added_to_a_material_that_is_not_read_is_not_that_material(tmp_path):
    text = WHOLE.replace("*MAT_ELASTIC\n1,7.8e-9,2.1e5,.3\n", "*MAT_HONEYCOMB\n1,1.e-9\n*MAT_ADD_EROSION\n1,0,.3\n")
    model = read(tmp_path, text)
    assert [u.keyword for u in model.unread if u.changes_answer] == ["*MAT_HONEYCOMB"]


def test_the_decks_own_analysis_is_refused(tmp_path):
    read(tmp_path, WHOLE)
    with pytest.raises(InputError, match=r"creak new deck\.k --out study\.toml"):
        read_lsdyna_run(tmp_path / "deck.k")


def test_files_of_a_deck_are_found(tmp_path):
    for name, text in {
        "deck.k": "*INCLUDE\na.k\n*INCLUDE_TRANSFORM\nb.k\n\n",
        "a.k": "*NODE\n",
        "b.k": "*END\n",
    }.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert [p.name for p in lsdyna_files(tmp_path / "deck.k")] == ["deck.k", "a.k", "b.k"]
