"""*CONTACT PAIR whose surfaces are tied: TIED, or an interaction with PRESSURE-OVERCLOSURE=TIED (CalculiX)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from creak.errors import InputError
from creak.formats.abaqus.loads.prestress import step_of_modes
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.numbers import to_float
from creak.formats.abaqus.text.outline import Outline

NAME = "CONTACT PAIR, TIED"


def tied_pairs(deck: Outline) -> Iterator[Block]:
    """Each tied pair of the model data and of the steps up to the modes, written as a *TIE; it is no contact any more.

    ADJUST, a distance or a node set, says which nodes are tied (POSITION TOLERANCE, TIED NSET). Rotations stay free, as
    in Abaqus.
    """
    places = [deck.set_aside, *(step.blocks for step in deck.steps[: step_of_modes(deck) + 1])]
    bonded = _bonded([block for blocks in places for block in blocks])
    for blocks in places:
        tied = [
            b for b in blocks if b.name == "CONTACT PAIR" and (b.has("TIED") or b.get("INTERACTION").upper() in bonded)
        ]
        ours = {b.where for b in tied}
        blocks[:] = [b for b in blocks if b.where not in ours or b.name != "CONTACT PAIR"]
        deck.unread = {u: None for u in deck.unread if u.where not in ours}
        yield from (_as_tie(deck, block) for block in tied)


def _bonded(blocks: list[Block]) -> set[str]:
    """Names of the interactions that tie."""
    found, name = set(), ""
    for block in blocks:
        if block.name == "SURFACE INTERACTION":
            name = block.get("NAME").upper()
        elif block.name == "SURFACE BEHAVIOR" and block.option("PRESSURE-OVERCLOSURE") == "TIED":
            found.add(name)
    return found


def _as_tie(deck: Outline, block: Block) -> Block:
    params = {"NAME": block.get("CPSET") or block.get("INTERACTION") or "TIED", "NOROTATION": "", "ADJUST": "NO"}
    given = block.get("ADJUST")
    if given:
        try:
            params["POSITIONTOLERANCE"] = repr(to_float(given, block.where, "ADJUST"))
        except InputError:
            params["TIEDNSET"] = given
    deck.note(
        block,
        "the pair is read as a tie: its nodes follow the main surface, and nothing opens or slides",
        changes=False,
        what=f"*{NAME}",
    )
    return replace(block, name=NAME, params=params, options=[])
