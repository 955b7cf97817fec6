"""Parameters of the keywords that only a deck's own step uses."""

from __future__ import annotations

from creak.formats.abaqus.text.lexer import Block, squeeze
from creak.formats.abaqus.text.outline import Outline


def list_params(deck: Outline, block: Block, known: str) -> None:
    """List every parameter that is not in `known` (names with commas between them) as one that changes the answer."""
    names = {squeeze(name) for name in known.split(",")}
    for param in block.params:
        if param not in names:
            deck.note(block, "creak does not read this parameter", changes=True, what=f"*{block.name}, {param}")
