"""Damaged LS-DYNA decks end in a Model or in an InputError that names a place, never in anything else."""

from __future__ import annotations

import random

import pytest

from creak.errors import InputError
from creak.formats.lsdyna.reader import read_lsdyna
from creak.model.mesh import Model
from helpers_lsdyna import clamped_assembly

pytestmark = pytest.mark.once

VALUES = ("", "0", "-1", "99", "1.5", "abc", "nan", "1e400", "1e300", "99999999999999", "&A", "1_0", "\u0663")


def _damaged(rng: random.Random) -> str:
    lines = clamped_assembly().splitlines()
    for _ in range(rng.choice([1, 1, 2])):
        k = rng.randrange(len(lines))
        kind = rng.choice(["value", "value", "delete", "truncate", "repeat", "blank", "option"])
        if kind == "value":
            fields = lines[k].split(",")
            fields[rng.randrange(len(fields))] = rng.choice(VALUES)
            lines[k] = ",".join(fields)
        elif kind == "delete":
            del lines[k]
        elif kind == "truncate":
            lines[k] = lines[k][: rng.randrange(len(lines[k]) + 1)]
        elif kind == "repeat":
            lines.insert(rng.randrange(len(lines)), lines[k])
        elif kind == "blank":
            lines[k] = ""
        else:
            lines[k] += rng.choice(("_TITLE", "_ID", "+"))
    return "\n".join(lines)


def test_the_deck_itself(tmp_path):
    path = tmp_path / "deck.k"
    path.write_text(clamped_assembly(), encoding="utf-8")
    model = read_lsdyna(path)
    assert {b.kind for b in model.blocks} == {"quad4", "hex8", "beam2", "nodal2", "mass"}
    assert not [u for u in model.unread if u.changes_answer]


@pytest.mark.parametrize("seed", range(4))
def test_damaged_decks(tmp_path, seed):
    rng = random.Random(seed)
    path = tmp_path / "deck.k"
    said = []
    for _ in range(150):
        path.write_text(_damaged(rng), encoding="utf-8")
        try:
            assert isinstance(read_lsdyna(path), Model)
        except InputError as error:
            said.append(str(error))
    assert said
    assert all(words.startswith(str(path)) for words in said)
