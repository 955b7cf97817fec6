"""Names that a terminal, a file system or a spreadsheet would take for something else."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest
from rich.text import Text

from creak.cli.console import Terminal, printable
from creak.cli.output import Output, ProgressBars
from creak.digest import LONGEST, file_stem
from creak.errors import InputError
from creak.formats.matrices.superelements import FORMATS, read_superelement, write_superelement
from creak.formats.measured.csv_rows import plain_cell
from creak.formats.measured.histories import Histories, write_csv
from creak.studies.file.reader import read_study
from helpers_decks import STUDY, two_strips, write_strips
from helpers_matrices import random_superelement

NASTY = [
    *("[/nope]", "[red]", "[bold]x[/bold]", "a:x:b", ":smile:", "\x1b[31mred", "a\x07b", "\u202etxt.inp"),
    *("a\rb", "\udcff"),
]


def terminal(**options):
    """A terminal that keeps what is written to it."""
    return Terminal(file=io.StringIO(), force_terminal=True, color_system=None, width=200, **options)


@pytest.mark.parametrize("name", NASTY)
def test_a_terminal_shows_names_as_they_are(name):
    console = terminal()
    console.print(f"part {name} end")
    with ProgressBars(console) as bars:
        bars(f"reduce {name}", 0, 4)
        bars(f"reduce {name}", 4, 4)
    output = Output()
    output.console = terminal()
    output.table(name, [[name, "n"], [name, "1"]])
    output.say(name)
    assert f"part {printable(name)} end" in console.file.getvalue()
    said, drawn = console.file.getvalue(), output.console.file.getvalue()
    assert f"reduce {printable(name)}" in said
    assert drawn.count(printable(name)) >= 4  # title, head, cell, line
    for text in (said, drawn):
        assert "\x1b[31m" not in text
        assert not {"\x07", "\u202e", "\udcff"} & set(text)


def test_what_is_harmless_stays():
    for text in ("door, 3 mm", "T\u00fcr \u2192 \u7530", "a\tb\nc", "50 \u00b5m \U0001f600"):
        assert printable(text) == text
    assert printable("\x1b[2J\x00\x9b") == r"\x1b[2J\x00\x9b"


def test_a_long_name_leaves_the_table_readable():
    output = Output()
    output.console = Terminal(file=io.StringIO(), width=80)
    output.table("Parts", [["part", "nodes", "mass"], ["N" * 300, "39", "1.884e-05"]])
    assert "1.884e-05" in output.console.file.getvalue()


@pytest.mark.parametrize("name", ["[/nope]", "[red]", "\x1b[31mred", "N" * 300, "A B"])
def test_decks_whose_parts_have_such_names_are_told_of(name, tmp_path, creak):
    deck = two_strips().replace("ELSET=UPPER", f'ELSET="{name}"').replace("\nUPPER, SNEG", f'\n"{name}", SNEG')
    (tmp_path / "a:x:b.inp").write_text(deck)
    said = creak("info", tmp_path / "a:x:b.inp").done()
    text = said.out + said.err
    assert printable(name.upper())[:20] in text
    assert "a:x:b.inp" in text.replace("\n", "")
    assert "\x1b[31" not in text


def test_two_names_never_share_a_file():
    names = [
        "A B",
        "A_B",
        "A.B",
        "A/B",
        "A\\B",
        "",
        "_",
        "..",
        "N" * 300,
        "N" * 299 + "M",
        "\u7530" * 200,
        "\udcff",
        "a\0b",
    ]
    stems = [file_stem(name) for name in names]
    assert len({s.lower() for s in stems}) == len(names)
    assert all(0 < len(s.encode()) <= LONGEST and not set("./\\\0") & set(s) for s in stems)
    assert file_stem("PANEL-1_left") == "PANEL-1_left"


@pytest.mark.parametrize("format", FORMATS)
def test_parts_with_and_without_a_blank_are_exported_beside_each_other(format, tmp_path):
    from dataclasses import replace

    one = random_superelement()
    two = replace(one, K=2.0 * one.K)
    written = [write_superelement(replace(s, name=n), tmp_path, format) for s, n in ((one, "A B"), (two, "A_B"))]
    assert not set(written[0]) & set(written[1])
    norms = [np.linalg.norm(np.asarray(read_superelement(files[0]).K)) for files in written]
    assert norms[1] == pytest.approx(2.0 * norms[0], rel=1e-9)


@pytest.mark.parametrize(
    ("cell", "shown"),
    [
        ("=1+2", "'=1+2"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("-x", "'-x"),
        ("-1.5", "-1.5"),
        ("+3", "+3"),
        (-2.0, -2.0),
        ("a=b", "a=b"),
    ],
)
def test_no_cell_is_a_formula(cell, shown):
    assert plain_cell(cell) == shown


def test_histories_of_a_channel_called_like_a_formula(tmp_path):
    one, six = np.zeros((2, 1)), np.zeros((2, 1, 6))
    ids = np.array([1])
    time = np.array([0.0, 1.0])
    names = ('=HYPERLINK("http://x")',), ("=1+1",)
    write_csv(
        Histories("reduced", "mm-t-s", time, ids, names[0], six, names[1], ids, one, -one, one), tmp_path / "h.csv"
    )
    rows = list(csv.reader((tmp_path / "h.csv").read_text().splitlines()))
    assert not [cell for cell in rows[0] if cell.startswith("=")]
    assert all(float(cell) == float(cell) for row in rows[1:] for cell in row)


@pytest.mark.parametrize(
    ("old", "new"),
    [('"Two strips"', '"Two\\u0000strips"'), ("contact.tip", 'contact."a\\u0000b"'), ('"UNDER"', '"\\u0000"')],
)
def test_a_zero_byte_stops_a_study_before_it_runs(old, new, tmp_path):
    path = write_strips(tmp_path, study=STUDY.replace(old, new, 1))
    with pytest.raises(InputError, match="zero byte"):
        read_study(path)


def test_messages_are_short_whatever_they_quote(tmp_path, creak):
    (tmp_path / "a.inp").write_text("*NODE\n*INCLUDE, INPUT=b.inp\n")
    (tmp_path / "b.inp").write_text(f"1, {'x' * 100_000}\x1b[31m, 0, 0\n")
    said = creak("info", tmp_path / "a.inp")
    assert said.status == 2
    text = said.err
    assert len(text) < 2000
    assert "b.inp:1" in text
    assert "\x1b[31m" not in text


def test_text_objects_pass_unchanged():
    console = terminal()
    console.print(Text("[red]"))
    assert "[red]" in console.file.getvalue()
