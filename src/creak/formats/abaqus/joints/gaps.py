"""GAPUNI elements and their *GAP -> stops between pairs of nodes."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.abaqus.joints.interactions import law_of_gap
from creak.formats.abaqus.mesh.elements import Elements
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.names import Registry
from creak.formats.abaqus.text.numbers import floats, positive
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.formats.deck.stops import Gap, in_a_study, stops_of
from creak.model.mesh import Unread
from creak.model.steps import Stop


def read_gaps(
    deck: Outline, elements: Elements, names: Registry, coords: FloatArray, *, own_step: bool
) -> tuple[Stop, ...]:
    """Gaps of one *GAP and direction together: h = d + n . (u_2 - u_1) stays above 0.

    d is the initial clearance of the data line (below 0: they overlap) and n its direction, without one from the first
    node to the second. They are hard, or have PRESSURE-OVERCLOSURE=LINEAR times the contact area of the data line; with
    the *FRICTION of the *GAP. Others (GAPCYL, GAPSPHER, other laws) are listed as not read.

    Parameters
    ----------
    own_step : whether the deck's own step is to be run; else each stop is listed with what a study must say of it.

    Raises
    ------
    InputError : unknown elements, a clearance that is no number, nodes that coincide without a direction.
    """
    found = list[Gap]()
    for scope, block in deck.blocks("GAP"):
        found += _of_block(deck, scope, block, elements, names, coords)
    stops = stops_of(found)
    if not own_step:
        for stop in stops:
            deck.unread.setdefault(Unread("*GAP", stop.where, True, in_a_study(stop)))
    return stops


def _of_block(
    deck: Outline, scope: Scope, block: Block, elements: Elements, names: Registry, coords: FloatArray
) -> Iterator[Gap]:
    rows = names.find(block.need("ELSET"), scope.name, block.where)
    round_ones = sorted({elements.of(int(row)).name for row in rows} - {"GAPUNI"})
    flaws = list[str]()
    law = law_of_gap(deck, block, flaws)
    clearance, given, area = _data(block)
    refused = "".join(flaws[:1])
    if round_ones:
        refused = f"creak has stops along one line, and {round_ones[0]} keeps its nodes at a distance in all directions"
    elif law.law not in ("hard", "linear") or law.damping:
        refused = "of the laws of a *GAP creak reads HARD and LINEAR, without damping"
    if refused:
        deck.note(block, f"{refused}; give it in the study as [[connector]] or [contact.NAME]", changes=True)
        return
    owner = ".".join(name for name in (scope.name, block.need("ELSET").upper()) if name)
    stiffness = law.stiffness * area if law.law == "linear" else inf
    for row in rows.tolist():
        a, b = elements.nodes_idx[row, :2].tolist()
        line = scope.rotation @ given if given.any() else coords[b] - coords[a]
        if not line.any():
            raise InputError(
                f"the nodes of gap element {elements.ids[row]} coincide",
                where=block.where,
                expected="a direction: clearance, cosine x, y, z",
                fix="Give the direction in which the second node leaves the first.",
            )
        yield Gap(owner, (a, b), line, clearance, stiffness, elements.where(row), law.friction)


def _data(block: Block) -> tuple[float, FloatArray, float]:
    """Clearance, direction (3,) (zeros: that of the nodes) and contact area."""
    rows = list(block.rows())
    if not rows:
        return 0.0, np.zeros(3), 1.0
    fields, where = rows[0]
    clearance, *direction = floats(fields, where, "clearance or direction of the gap", 4)
    area = positive(fields[4], where, "contact area") if len(fields) > 4 and fields[4] else 1.0
    return clearance, np.array(direction), area
