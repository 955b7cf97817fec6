"""Damaged decks end in a Model or in an InputError, never in anything else."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from creak.errors import InputError
from creak.model.mesh import Model

Reader = Callable[[str], Model]

NOISE = '*,.=-019eEdDnaZ_ "\t\x0b\x85é٣'
VALUES = ("nan", "1e308", "-1", "0", "1e-320", "9" * 23, "", "inf", "1e999", "0.5", "17")


def _damaged(rng: random.Random, text: str) -> str:
    lines = text.split("\n")
    for _ in range(rng.choice([1, 1, 2, 3])):
        k = rng.randrange(len(lines))
        kind = rng.choice(["delete", "noise", "truncate", "repeat", "value", "swap"])
        if kind == "delete" and len(lines) > 1:
            del lines[k]
        elif kind == "noise":
            chars = list(lines[k] or " ")
            chars[rng.randrange(len(chars))] = rng.choice(NOISE)
            lines[k] = "".join(chars)
        elif kind == "truncate":
            lines = lines[: k + 1]
            lines[k] = lines[k][: rng.randrange(len(lines[k]) + 1)]
        elif kind == "repeat":
            lines.insert(rng.randrange(len(lines)), lines[k])
        elif kind == "value":
            fields = lines[k].split(",")
            fields[rng.randrange(len(fields))] = rng.choice(VALUES)
            lines[k] = ",".join(fields)
        else:
            j = rng.randrange(len(lines))
            lines[k], lines[j] = lines[j], lines[k]
    return "\n".join(lines)


@pytest.mark.parametrize("deck", ["flat", "parts"])
def test_damaged_decks(read: Reader, request: pytest.FixtureRequest, deck: str) -> None:
    text: str = request.getfixturevalue(deck)
    places: list[str] = []
    for seed in range(200):
        try:
            assert isinstance(read(_damaged(random.Random(seed), text)), Model)
        except InputError as error:
            places.append(str(error))
    assert all("deck.inp" in place for place in places)
