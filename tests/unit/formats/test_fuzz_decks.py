"""Damaged decks and studies end in a model or in one message; `python -m benchmarks.fuzz` reads more of them."""

from __future__ import annotations

import random

import pytest

import fuzz_decks
from creak.errors import InputError
from fuzz_decks import Tally, damaged, fuzz, one, samples

COUNTS = {"abaqus": 200, "nastran": 200, "study": 80}


@pytest.mark.parametrize("kind", COUNTS)
def test_damaged_files_end_in_a_model_or_a_message(kind):
    tally = fuzz(kind, 0, COUNTS[kind])
    assert tally.faults == []
    assert sum(tally.ended.values()) == COUNTS[kind]
    assert tally.ended["InputError"] > COUNTS[kind] // 4
    assert sum(n for end, n in tally.ended.items() if end.startswith(("model", "study"))) > COUNTS[kind] // 20


@pytest.mark.parametrize("kind", COUNTS)
def test_the_files_themselves_are_good(kind, tmp_path):
    (tmp_path / "strips.inp").write_text(fuzz_decks.STRIPS, encoding="utf-8")
    for text in samples(kind):
        path = tmp_path / {"abaqus": "deck.inp", "nastran": "deck.bdf", "study": "study.toml"}[kind]
        path.write_text(text, encoding="utf-8")
        assert fuzz_decks.READERS[kind](path) in ("model", "study")


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
