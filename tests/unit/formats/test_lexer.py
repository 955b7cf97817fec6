"""The lexer: keyword blocks, their parameters, and where every line stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from creak.errors import InputError
from creak.formats.abaqus.text.lexer import lex


def _write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_keywords_and_parameters_ignore_case_and_blanks(tmp_path: Path) -> None:
    deck = _write(tmp_path / "a.inp", "*Shell   Section, ElSet = Skin, material=steel\n1.\n")
    (block,) = lex(deck)
    assert block.name == "SHELL SECTION"
    assert block.get("ELSET") == "Skin"
    assert block.get("Material") == "steel"


def test_keyword_line_that_ends_in_comma_goes_on(tmp_path: Path) -> None:
    deck = _write(tmp_path / "a.inp", "*ELEMENT, TYPE=S4,\n** in between\n ELSET=SKIN\n1, 1, 2, 3, 4\n")
    (block,) = lex(deck)
    assert block.get("ELSET") == "SKIN"
    assert block.lines == ["1, 1, 2, 3, 4"]
    assert block.place(block.codes[0]) == f"{deck}:4"


def test_quoted_names_keep_commas_and_blanks(tmp_path: Path) -> None:
    deck = _write(tmp_path / "a.inp", '*NSET, NSET="left, front"\n"inner, rear", 5\n')
    (block,) = lex(deck)
    assert block.get("NSET") == "left, front"
    assert next(block.rows())[0] == ["inner, rear", "5"]


def test_each_part_of_a_name_may_have_quotes(tmp_path: Path) -> None:
    lines = '"P 1-1"."S, 1", 1\n"P 1-1".17, 1\nP 1-1."S  1", 1\n"P.1"."a=b", 1\n'
    deck = _write(tmp_path / "a.inp", f'*ELSET, ELSET="a=b", INSTANCE="Assy 1"."P, 1-1"\n{lines}')
    (block,) = lex(deck)
    assert (block.get("ELSET"), block.get("INSTANCE")) == ("a=b", "Assy 1.P, 1-1")
    assert [fields[0] for fields, _ in block.rows()] == ["P 1-1.S, 1", "P 1-1.17", "P 1-1.S 1", "P.1.a=b"]


def test_include_is_relative_to_the_including_file_and_keeps_line_numbers(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    _write(tmp_path / "sub" / "nodes.inc", "1, 0., 0., 0.\n2, 1., 0., 0.\n")
    _write(tmp_path / "sub" / "mesh.inc", "** mesh\n*NODE\n*INCLUDE, INPUT=nodes.inc\n3, 2., 0., 0.\n")
    deck = _write(tmp_path / "a.inp", "*HEADING\n*INCLUDE, INPUT=sub/mesh.inc\n*ELEMENT, TYPE=S4\n")
    _, nodes, elements = lex(deck)
    places = [nodes.place(c) for c in nodes.codes]
    inner, mesh = tmp_path / "sub" / "nodes.inc", tmp_path / "sub" / "mesh.inc"
    assert places == [f"{inner}:1", f"{inner}:2", f"{mesh}:4"]
    assert elements.where == f"{deck}:3"


def test_input_parameter_brings_data_lines(tmp_path: Path) -> None:
    _write(tmp_path / "nodes.txt", "1, 0., 0., 0.\n")
    (block,) = lex(_write(tmp_path / "a.inp", "*NODE, INPUT=nodes.txt\n"))
    assert block.lines == ["1, 0., 0., 0."]


def test_windows_line_ends_and_latin_1(tmp_path: Path) -> None:
    deck = tmp_path / "a.inp"
    deck.write_bytes("*HEADING\r\n Tür\r\n".encode("latin-1"))
    (block,) = lex(deck)
    assert block.lines == ["Tür"]


def test_an_include_inside_an_included_file_may_lie_beside_the_deck(tmp_path: Path) -> None:
    """As Abaqus looks it up; the one beside the including file goes first."""
    (tmp_path / "sub").mkdir()
    _write(tmp_path / "sub" / "mesh.inc", "*NODE\n*INCLUDE, INPUT=nodes.inc\n")
    _write(tmp_path / "nodes.inc", "1, 0., 0., 0.\n")
    deck = _write(tmp_path / "a.inp", "*HEADING\n*INCLUDE, INPUT=sub/mesh.inc\n")
    assert [row for b in lex(deck) if b.name == "NODE" for row, _ in b.rows()] == [["1", "0.", "0.", "0."]]
    _write(tmp_path / "sub" / "nodes.inc", "7, 0., 0., 0.\n")
    assert [row[0] for b in lex(deck) if b.name == "NODE" for row, _ in b.rows()] == ["7"]


def test_missing_include_names_the_line(tmp_path: Path) -> None:
    deck = _write(tmp_path / "a.inp", "*HEADING\n*INCLUDE, INPUT=gone.inc\n")
    with pytest.raises(InputError, match=r"a\.inp:2: there is no included file .*gone\.inc"):
        lex(deck)


def test_include_of_itself(tmp_path: Path) -> None:
    deck = _write(tmp_path / "a.inp", "*INCLUDE, INPUT=a.inp\n")
    with pytest.raises(InputError, match="includes itself"):
        lex(deck)


def test_missing_deck(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no deck"):
        lex(tmp_path / "gone.inp")


def test_folder_instead_of_deck(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot read the deck"):
        lex(tmp_path)


def test_binary_file(tmp_path: Path) -> None:
    deck = tmp_path / "a.inp"
    deck.write_bytes(b"\x7fELF\0\0\x01")
    with pytest.raises(InputError, match="not a text file"):
        lex(deck)


def test_text_that_is_no_deck(tmp_path: Path) -> None:
    deck = _write(tmp_path / "a.inp", "\nhello\n")
    with pytest.raises(InputError, match=r"a\.inp:2: data before the first keyword: 'hello'"):
        lex(deck)
