"""What the commands print can be read at 80 columns: three lines first, sets last, no broken words."""

import io
import shlex

import pytest

from creak.cli.console import Terminal
from creak.cli.output import Output, broken, pieces
from helpers_decks import two_strips

WIDE = [
    ["", "f_max, Hz", "x exc.", "retained + modes", "unknowns", "offline", "a step", "frequency", "impulse"],
    ["* craig-bampton", "1500", "15", "1,234 + 567", "1,801", "12 s", "30 us", "0.21 %", "1.8 %"],
]


@pytest.fixture
def strips(tmp_path):
    deck = tmp_path / "strips.inp"
    deck.write_text(two_strips() + "".join(f"*NSET, NSET=MORE_{i}\n1,\n" for i in range(20)))
    return deck


def test_the_first_three_lines_say_what_the_deck_is(creak, strips):
    size, made_of, ready = creak("info", strips).out.splitlines()[:3]
    for word in ("78 nodes", "48 elements", " x ", " mm", "mass"):
        assert word in size
    assert made_of.startswith("2 parts (UPPER, LOWER); 1 material (")
    assert "mm thick; units: materials and size fit mm-t-s" in made_of
    assert ready.startswith("the model is whole: nothing that changes the answer is left out; look at")


def test_a_deck_that_does_not_run_says_so_in_its_third_line(creak, strips):
    strips.write_text(strips.read_text() + "*EMBEDDED ELEMENT\nUPPER\n")
    said = creak("info", strips).out.splitlines()
    assert said[2].startswith("does not run as it is: *EMBEDDED ELEMENT not used")
    assert said[3].startswith("not read: *EMBEDDED ELEMENT"), "what changes the answer comes first"


def test_sets_come_last_and_are_folded(creak, strips):
    lines = creak("info", strips).out.splitlines()
    sets = next(i for i, line in enumerate(lines) if line.startswith("node sets: "))
    assert all(line.startswith(("element sets: ", "surfaces: ")) for line in lines[sets + 1 : -1])
    assert lines[-1].startswith("next: creak new ")
    assert "MORE_19" not in lines[sets]
    assert lines[sets].endswith(" more (--sets: all)")
    assert "MORE_19 (1)" in creak("info", strips, "--sets").out


@pytest.mark.parametrize("width", [60, 80, 100])
def test_wide_tables_go_on_below_with_whole_words(width):
    output = Output()
    output.console = Terminal(file=io.StringIO(), width=width)
    output.table("Ways", WIDE, left=(0,))
    text = output.console.file.getvalue()
    assert max(map(len, text.splitlines())) <= width
    for cell in (*WIDE[0], *WIDE[1]):
        assert cell in text
    assert text.count("* craig-bampton") == text.count("f_max, Hz") * text.count(
        "\N{BOX DRAWINGS HEAVY DOWN AND RIGHT}"
    )


def test_rows_are_told_apart_where_a_table_goes_on():
    cells = [["way", "f_max, Hz", *(f"figure {k}" for k in range(9))]]
    cells += [["craig-bampton", f, *["0.1 %"] * 9] for f in ("300", "600")]
    found = pieces(cells, 80)
    assert len(found) > 1
    assert all(columns[:2] == [0, 1] for columns in found)
    assert sorted({k for columns in found for k in columns}) == list(range(11))
    assert all(columns[0] == 0 for columns in pieces([cells[0], cells[1]], 80))


def test_lines_on_a_terminal_break_between_words():
    words = "the contact stiffness of surface-to-surface pairs is used as it is, " * 3
    text = broken(words, 40)
    assert max(map(len, text.splitlines())) <= 40
    assert text.split() == words.split()


def test_the_next_command_can_be_pasted(creak, strips, tmp_path):
    folder = tmp_path / "my decks; $(rm)"
    folder.mkdir()
    (folder / "a b.inp").write_text(strips.read_text())
    said = creak("new", folder / "a b.inp").out
    line = next((x for x in said.splitlines() if x.startswith("next: ")), None)
    assert line is not None, said
    assert shlex.split(line) == ["next:", "creak", "run", str(folder / "a b.toml"), "--quick"]
