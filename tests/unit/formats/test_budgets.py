"""Inputs that ask for more than there is: told what is too much before it is built, and nothing hangs.

Decks of many things that creak does not read: what reading them costs grows with their number alone.

Counted are calls of Python functions, which no other load of the machine changes. n of something four times over cost
four times as much, less what a deck costs at all; a search among all others for each of them would cost 16 times.
"""

from __future__ import annotations

import os
import sys
import time
import tracemalloc

import pytest

from creak.errors import InputError, shortened
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.text.fields import to_float
from creak.formats.abaqus.text.lexer import lex
from creak.formats.deck.surfaces import surfaces
from creak.formats.decks import read_model
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.text.bulk_data import ids_among
from creak.studies.file.reader import read_study
from creak.studies.file.tables import read_table
from creak.studies.sweep.cases import MOST_CASES, changed, combinations
from creak.studies.sweep.file import read_sweep
from helpers_decks import STUDY, two_strips, write_strips

GRIDS = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,5,,2.,0.,0.\n"
INCLUDE = {"inp": "*INCLUDE, INPUT={}\n", "bdf": "INCLUDE {}\n"}
READ = {"inp": read_deck, "bdf": read_nastran}


@pytest.mark.parametrize("ending", READ)
def test_files_that_include_the_next_twice_are_stopped(ending, tmp_path):
    for k in range(41):
        (tmp_path / f"f{k}.{ending}").write_text(2 * INCLUDE[ending].format(f"f{k + 1}.{ending}"))
    (tmp_path / f"f41.{ending}").write_text("$\n" if ending == "bdf" else "**\n")
    with pytest.raises(InputError, match=r"includes more than 10,000 files.*same file twice"):
        READ[ending](tmp_path / f"f0.{ending}")


@pytest.mark.parametrize("ending", READ)
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_a_pipe_or_a_device_is_not_included(ending, kind, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    name = "pipe" if kind == "pipe" else "/dev/zero"
    (tmp_path / f"a.{ending}").write_text(INCLUDE[ending].format(name))
    with pytest.raises(InputError, match=rf"a\.{ending}:1: .* is a pipe or a device; expected a plain file"):
        READ[ending](tmp_path / f"a.{ending}")


def test_a_file_may_be_included_twice(tmp_path):
    (tmp_path / "part.inp").write_text("*NSET, NSET=A\n1\n")
    (tmp_path / "a.inp").write_text("*NODE\n1, 0, 0, 0\n" + 2 * "*INCLUDE, INPUT=part.inp\n")
    assert [b.name for b in lex(tmp_path / "a.inp")] == ["NODE", "NSET", "NSET"]


def bulk(tmp_path, text):
    path = tmp_path / "a.bdf"
    path.write_text(GRIDS + text)
    return path


@pytest.mark.parametrize(
    "text",
    [
        "".join(f"SET1,{k},1,THRU,999999999\n" for k in range(1, 21)),
        "SPC1,1,123,1,THRU,999999999\n",
        "ASET1,123,1,THRU,999999999\n",
        "SET3,4,GRID,1,THRU,999999999,BY,2\n",
    ],
)
def test_wide_ranges_cost_nothing(text, tmp_path):
    """A billion numbers would take gigabytes."""
    tracemalloc.start()
    model = read_nastran(bulk(tmp_path, text))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20e6
    if "SET1,20," in text:
        assert {name: rows.tolist() for name, rows in model.node_sets.items()}["SET_20"] == [0, 1, 2]


def test_the_ids_of_ranges_are_those_that_there_are():
    known = dict.fromkeys([7, 3, 100, 5, 10**12])
    assert ids_among([range(5, 6), range(1, 10**15, 2), range(100, 101)], known) == [5, 3, 7, 100]
    assert ids_among([range(3, 5), range(6, 3)], known) == [3]


@pytest.mark.parametrize("text", ["SPOINT,11,THRU,9999999\n", "SPOINT,11,THRU,99999999999999\n"])
def test_scalar_points_are_counted_before_they_are_made(text, tmp_path):
    with pytest.raises(InputError, match=r"a\.bdf:4: SPOINT lists .* ids; expected at most 1,000,000"):
        read_nastran(bulk(tmp_path, text))


@pytest.mark.parametrize(
    "comment", ["$ Femap Property 1 : " + " " * 200_000 + "x\ty", "$ Femap Property " + "1" * 9000 + " : x"]
)
def test_a_long_comment_takes_no_time(comment, tmp_path):
    """Each blank against each other one would take minutes; CPU time, of which a busy machine takes little more."""
    begin = time.process_time()
    read_nastran(bulk(tmp_path, f"{comment}\n"))
    assert time.process_time() - begin < 20.0


def test_a_sweep_is_counted_before_it_is_built(tmp_path):
    write_strips(tmp_path)
    keys = "".join(f'"contact.tip.k{i}" = {list(range(60))}\n' for i in range(8))
    (tmp_path / "sweep.toml").write_text(f'base = "study.toml"\n[grid]\n{keys}')
    with pytest.raises(InputError, match=rf"167,961,600,000,000 cases \(60 x .*at most {MOST_CASES:,}.*fewer values"):
        combinations(read_sweep(tmp_path / "sweep.toml"))


def test_a_row_number_is_a_plain_number(tmp_path):
    play = (
        '\n[[connector]]\ntype = "play"\nnodes = ["TIP_UPPER", "TIP_LOWER"]\ndof = "z"\nupper = 0.3\nstiffness = 50.0\n'
    )
    write_strips(tmp_path, study=STUDY + play)
    for row in ("\u00b2", "9" * 5000, "\u0663"):
        (tmp_path / "sweep.toml").write_text(
            f'base = "study.toml"\n[grid]\n"connector.{row}.lower" = [-1.0, -2.0]\n', "utf-8"
        )
        sweep = read_sweep(tmp_path / "sweep.toml")
        one = combinations(sweep)[0]
        with pytest.raises(InputError, match=r"the study has 1 \[\[connector\]\]"):
            changed(sweep.data, one.changes, None)


@pytest.mark.parametrize(
    ("text", "why"),
    [("a = " + "[" * 3000 + "]" * 3000, "nested too deep"), ("a = " + "1" * 5000, "too many digits")],
)
def test_toml_that_python_cannot_hold_is_told(text, why, tmp_path):
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(InputError, match=rf"s\.toml: cannot read the study file: .*{why}"):
        read_study(tmp_path / "s.toml")


@pytest.mark.parametrize("row", ["0.1,1e308", "1e308,1", "5e-324,1", '0.1,"' + "1" * 200_000, "0.1," + "1" * 200_000])
def test_tables_of_absurd_numbers_are_told(row, tmp_path):
    (tmp_path / "t.csv").write_text(f"time,value\n0,0\n{row}\n")
    with pytest.raises(InputError, match=r"t\.csv:3: ") as stop:
        read_table(tmp_path / "t.csv", "signal")
    assert len(str(stop.value)) < 2000


@pytest.mark.parametrize("value", ["1e308", "-1e308", "1e61"])
@pytest.mark.parametrize("old", ["7.85e-9", "210000."])
def test_decks_of_absurd_numbers_are_told(value, old, tmp_path):
    deck = two_strips()
    density = next(x for x in deck.split("*DENSITY\n")[1].split(",")[:1])
    modulus = deck.split("*ELASTIC\n")[1].split(",")[0]
    number = density if old == "7.85e-9" else modulus
    (tmp_path / "a.inp").write_text(deck.replace(f"\n{number},", f"\n{value},"))
    with pytest.raises(InputError, match=r"a\.inp:\d+: "):
        read_deck(tmp_path / "a.inp")


def test_numbers_next_to_nothing_are_nothing():
    assert [to_float(text, "a.inp:1", "x") for text in ("5e-324", "-1e-61", "2e-59")] == [0.0, 0.0, 2e-59]


def test_a_text_is_cut_in_its_middle():
    assert shortened("abc") == "abc"
    cut = shortened("a" * 500 + "b" * 500, 100)
    assert len(cut) == 100
    assert cut.startswith("aaa")
    assert cut.endswith("bbb")


ABAQUS = (
    "*NODE\n1,0.,0.,0.\n2,1.,0.,0.\n*ELEMENT,TYPE=T3D2,ELSET=E\n1,1,2\n*SOLID SECTION,ELSET=E,MATERIAL=M\n1.,\n"
    "*MATERIAL,NAME=M\n*ELASTIC\n2e5,.3\n*DENSITY\n1e-9\n"
)
NASTRAN = "BEGIN BULK\nGRID,1\nGRID,2,,1.\nCROD,1,1,1,2\nPROD,1,1,1.\nMAT1,1,2.+5,,.3,1.-9\n"
N = 150
LINEAR = 4.5
"""Of 4, for tables grow in jumps."""
KINDS = {
    "harmless keywords": (ABAQUS, "*AMPLITUDE, NAME=A{0}\n0., 1.\n"),
    "unknown parameters": (ABAQUS, "*NSET, NSET=S{0}, FOO=3\n1\n"),
    "steps": (ABAQUS, "*STEP\n*FREQUENCY\n2\n*END STEP\n"),
    "material laws": (ABAQUS, "*MATERIAL, NAME=M{0}\n*ELASTIC\n2e5,.3\n*PLASTIC\n2., 0.\n"),
    "unknown cards": (NASTRAN, "ZQ{2},1\n"),
    "shared ids": (NASTRAN, "CONM2,{1},1,,1.\nCROD,{1},1,1,2\n"),
}


def calls(path, text):
    path.write_text(text + "ENDDATA\n" * (path.suffix == ".bdf"), encoding="utf-8")
    count = 0

    def counted(_frame, event, _arg):
        nonlocal count
        count += event == "call"

    sys.setprofile(counted)
    try:
        read_model(path)
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.parametrize("kind", KINDS)
def test_the_cost_grows_with_their_number(tmp_path, kind):
    head, each = KINDS[kind]
    path = tmp_path / ("deck.inp" if head is ABAQUS else "deck.bdf")
    texts = [head + "".join(each.format(i, i + 2, i + 1000) for i in range(n)) for n in (0, 0, N, 4 * N)]
    _, none, few, many = (calls(path, text) for text in texts)
    assert many - none < LINEAR * (few - none)


def test_names_that_are_like_none_are_not_looked_up_twice(tmp_path):
    """10,000 unknown keywords of one name take one look among those that creak knows."""
    path = tmp_path / "deck.inp"
    one, two = (calls(path, ABAQUS + f"*QUITE UNKNOWN {n}\n" * n) for n in (1, 2))
    assert two - one < 0.1 * one


def test_free_faces_are_found_once_for_all_properties(tmp_path, monkeypatch):
    """Of 40 properties with a tetrahedron each."""
    deck = "BEGIN BULK\nGRID,1\nGRID,2,,1.\nGRID,3,,0.,1.\nMAT1,1,2.+5,,.3,1.-9\n"
    deck += (
        "".join(f"GRID,{k},,0.,0.,{k}.\nCTETRA,{k},{k},1,2,3,{k}\nPSOLID,{k},1\n" for k in range(4, 44)) + "ENDDATA\n"
    )
    path, found = tmp_path / "deck.bdf", []
    path.write_text(deck, encoding="utf-8")
    original = surfaces.__globals__["free_faces"]
    monkeypatch.setitem(surfaces.__globals__, "free_faces", lambda *a: found.append(1) or original(*a))
    model = read_model(path)
    assert len(found) == 1
    assert {len(model.surfaces[f"PID_{k}"].facets) for k in range(4, 44)} == {3}
