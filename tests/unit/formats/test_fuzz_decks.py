"""Damaged decks and studies end in a model or in one message; `python -m benchmarks.fuzz` reads more of them."""

from __future__ import annotations

import random

import pytest

import fuzz_decks
from creak.errors import InputError
from creak.formats.decks import read_model
from fuzz_decks import Tally, damaged, fuzz, one, samples
from helpers_decks import write_study

RECORDED = {"section": "decks"}

pytestmark = pytest.mark.once

COUNTS = {"abaqus": 100, "nastran": 80, "lsdyna": 80, "study": 80, "sweep": 40}


@pytest.mark.slow
@pytest.mark.parametrize("kind", COUNTS)
def test_damaged_files_end_in_a_model_or_a_message(kind, measured):
    tally = fuzz(kind, 0, COUNTS[kind])
    assert tally.faults == []
    assert sum(tally.ended.values()) == COUNTS[kind]
    assert tally.ended["InputError"] > COUNTS[kind] // 4
    assert sum(n for end, n in tally.ended.items() if end.startswith(("model", "study", "sweep"))) > COUNTS[kind] // 20
    measured(
        f"files damaged at random, {kind}: of {COUNTS[kind]} those that end otherwise than in a model or a message",
        len(tally.faults),
        0.0,
        source="",
    )


@pytest.mark.parametrize("kind", COUNTS)
def test_the_files_themselves_are_good(kind, tmp_path):
    write_study(tmp_path, fuzz_decks.STUDIES[0], {"strips.inp": fuzz_decks.STRIPS})
    for text in samples(kind):
        path = tmp_path / fuzz_decks.FILES[kind]
        path.write_text(text, encoding="utf-8")
        assert fuzz_decks.READERS[kind](path) in ("model", "study", "sweep")


@pytest.mark.parametrize(
    ("kind", "blocks", "unread"),
    [
        ("lsdyna", "quad4 hex8 beam2 nodal2 mass", []),
        ("nastran", "quad4 tri3 beam2 truss2 hex8 tet4 spring1 spring2 nodal1 bush2 mass", ["ASET1"]),  # Guyan's
    ],
)
def test_the_first_file_has_nearly_every_card(kind, blocks, unread, tmp_path):
    path = tmp_path / fuzz_decks.FILES[kind]
    path.write_text(samples(kind)[0], encoding="utf-8")
    model = read_model(path)
    assert {b.kind for b in model.blocks} == set(blocks.split())
    assert [u.keyword for u in model.unread if u.changes_answer] == unread


def test_damage_follows_from_the_seed():
    assert damaged(random.Random(7), "a, 1\nb, 2") == damaged(random.Random(7), "a, 1\nb, 2")
    assert len({damaged(random.Random(k), "a, 1\nb, 2") for k in range(40)}) > 20


def _raise(error):
    def reader(path):
        raise error

    return reader


def _wait(path):
    while True:
        pass


@pytest.mark.parametrize(
    ("reader", "word"),
    [(_raise(KeyError("x")), "KeyError"), (_raise(InputError("")), "message"), (_wait, "more than"), (str, None)],
)
def test_the_fuzzer_sees_faults(monkeypatch, tmp_path, reader, word):
    monkeypatch.setitem(fuzz_decks.READERS, "abaqus", reader)
    monkeypatch.setattr(fuzz_decks, "LIMIT", 0.05)
    tally = Tally()
    one("abaqus", 1, tmp_path, tally)
    assert len(tally.faults) == (word is not None)
    assert word is None or word in tally.faults[0]


FOUND = {
    "SPOINT range": ("nastran", "SPOINT,20,THRU,22", "SPOINT,20,THRU,999999999999", "1,000,000"),
    "element id": ("nastran", "CELAS2,11,", "CELAS2,99999999999999999999999,", "15 digits"),
    "scalar point id": ("nastran", "SPOINT,20,THRU,22", "SPOINT,20,99999999999999999999999", "15 digits"),
    "walls of a box": ("nastran", ",1.,2.,.1,.1\nCBAR,5", ",.1,.1,.1,.1\nCBAR,5", "BOX"),
    "size of a box": ("nastran", ",1.,2.,.1,.1\nCBAR,5", ",1e200,2e200,.1,.1\nCBAR,5", "PBARL"),
    "far grid": ("nastran", "GRID,8,,0.,1.,1.", "GRID,8,,0.,1e200,1.", "field 5 of GRID"),
    "far node": ("abaqus", " 10, 0., 0., 0.\n", " 10, 1e200, 0., 0.\n", "node 10"),
    "thick ply": ("abaqus", " 0.4, 3, Carbon, 45.", " 1e300, 3, Carbon, 45.", "thick"),
}


@pytest.mark.parametrize("name", FOUND)
def test_what_the_fuzzer_found_is_named(name, tmp_path):
    kind, old, new, word = FOUND[name]
    text = samples(kind)[0]
    assert old in text
    path = tmp_path / ("deck.inp" if kind == "abaqus" else "deck.bdf")
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=word) as stop:
        fuzz_decks.READERS[kind](path)
    assert path.name in str(stop.value)
