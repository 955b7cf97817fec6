"""*DISTRIBUTION: values element by element, for orientations and shell thickness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.names import Registry, lookup, qualified
from creak.formats.abaqus.text.numbers import floats
from creak.formats.abaqus.text.outline import Outline, Scope

WIDTH = {"COORD3D": 3, "LENGTH": 1, "RATIO": 1, "ANGLE": 1, "AREA": 1, "DENSITY": 1, "MODULUS": 1}
"""Numbers of each word of a *DISTRIBUTION TABLE."""


@dataclass(frozen=True, eq=False)
class Distribution:
    """Values of elements."""

    values: FloatArray
    """(n_elem, k) rows as the element table; the default where the deck gives none."""
    words: tuple[str, ...]
    """What the k numbers are: COORD3D, LENGTH, ..."""
    where: str


Distributions = dict[str, Distribution | InputError]
"""Qualified name -> distribution, or what is wrong with it: only those that something uses must be right."""


def read_distributions(deck: Outline, elements: Registry, n_elem: int) -> Distributions:
    """Distributions over elements by qualified name: a default on the first data line, then element or set, values."""
    tables = {
        qualified(scope.name, block.need("NAME")): (block, tuple(" ".join(f.upper().split()) for f in fields))
        for scope, block in deck.blocks("DISTRIBUTION TABLE")
        for fields, _ in [next(iter(block.rows()), ([], ""))]
    }
    found: Distributions = {}
    for scope, block in deck.blocks("DISTRIBUTION"):
        try:
            one: Distribution | InputError = _distribution(deck, scope, block, tables, elements, n_elem)
        except InputError as error:
            one = error
        found[qualified(scope.name, block.need("NAME"))] = one
    return found


def find_distribution(
    name: str, known: Distributions, scope: Scope, deck: Outline, words: tuple[str, ...], where: str
) -> Distribution | None:
    """The distribution of a name, None where there is none of it.

    Raises
    ------
    InputError : its lines are wrong, or it is of other quantities than `words`.
    """
    found = lookup(known, name, scope.name, deck.assembly)
    if isinstance(found, InputError):
        raise found
    if found is not None and found.words != words:
        raise InputError(
            f"distribution {name!r} is of {', '.join(found.words) or 'nothing'}",
            expected=", ".join(words),
            where=where,
            fix="Name another distribution, or correct its *DISTRIBUTION TABLE.",
        )
    return found


def _distribution(
    deck: Outline,
    scope: Scope,
    block: Block,
    tables: dict[str, tuple[Block, tuple[str, ...]]],
    elements: Registry,
    n_elem: int,
) -> Distribution:
    entry = lookup(tables, block.need("TABLE"), scope.name, deck.assembly)
    if entry is None:
        raise block.error(
            f"unknown *DISTRIBUTION TABLE {block.get('TABLE')!r}", fix=suggest(block.get("TABLE"), tables)
        )
    words = entry[1]
    if block.option("LOCATION", "ELEMENT") != "ELEMENT" or not words or any(w not in WIDTH for w in words):
        raise block.error(
            f"*DISTRIBUTION, LOCATION={block.option('LOCATION', 'ELEMENT')} of {', '.join(words) or 'nothing'}",
            expected=f"LOCATION=ELEMENT, and a table of {', '.join(WIDTH)}",
            fix="Give thickness at nodes by *NODAL THICKNESS.",
        )
    n = sum(WIDTH[w] for w in words)
    values = np.full((n_elem, n), np.nan)
    for fields, where in block.rows():
        numbers = floats(fields[1:], where, "value of the distribution", n)
        rows = elements.find(fields[0], scope.name, where) if fields[0] else slice(None)
        values[rows] = numbers
    return Distribution(values, words, block.where)
