"""Damaged Nastran decks end in a Model or in an InputError that names a place, never in anything else."""

from __future__ import annotations

import random

import pytest

from creak.errors import InputError
from creak.formats.nastran.reader import read_nastran
from creak.model.mesh import Model
from fuzz_samples import CARDS

pytestmark = pytest.mark.once

DECK = CARDS.replace("MPC,1,7,", "RBE1,4,1,123456\n,UM,8,12\nMPC,1,7,")
VALUES = (
    "",
    "0",
    "1",
    "-1",
    "99",
    "1.5",
    "abc",
    "THRU",
    "nan",
    "1e400",
    "UM",
    "+",
    "*",
    "$",
    "BY",
    "-5.",
    "0.",
    "1_0",
    "\u0663",
)


def _damaged(rng: random.Random) -> str:
    lines = DECK.splitlines()
    for _ in range(rng.choice([1, 1, 2])):
        k = rng.randrange(len(lines))
        kind = rng.choice(["value", "value", "value", "delete", "truncate", "repeat"])
        if kind == "value":
            fields = lines[k].split(",")
            fields[rng.randrange(len(fields))] = rng.choice(VALUES)
            lines[k] = ",".join(fields)
        elif kind == "delete":
            del lines[k]
        elif kind == "truncate":
            lines[k] = lines[k][: rng.randrange(len(lines[k]) + 1)]
        else:
            lines.insert(rng.randrange(len(lines)), lines[k])
    return "\n".join(lines)


def test_the_deck_itself(tmp_path):
    """One of nearly every card; only Guyan's ASET is not followed."""
    path = tmp_path / "deck.bdf"
    path.write_text(DECK)
    model = read_nastran(path)
    assert [u.keyword for u in model.unread if u.changes_answer] == ["ASET1"]
    assert {b.kind for b in model.blocks} == {
        "quad4",
        "tri3",
        "beam2",
        "truss2",
        "hex8",
        "tet4",
        "spring1",
        "spring2",
        "nodal1",
        "bush2",
        "mass",
    }


@pytest.mark.parametrize("first", [0, 100])
def test_damaged_decks(tmp_path, first):
    path = tmp_path / "deck.bdf"
    places: list[str] = []
    for seed in range(first, first + 100):
        path.write_text(_damaged(random.Random(seed)), encoding="utf-8")
        try:
            assert isinstance(read_nastran(path), Model)
        except InputError as error:
            places.append(str(error))
    assert places
    assert all("deck.bdf" in place for place in places)
