"""Hard contact, exact: 0 <= p, g >= 0, p g = 0 at the end of the step (Signorini's condition).

Nothing to choose and no penetration; dampers of the channel have no meaning and are ignored. Source: Moreau,
Unilateral contact and dry friction in finite freedom dynamics, 1988; Brogliato, Nonsmooth Mechanics, 2016. Valid
with any scheme as an equation; a scheme without numerical dissipation chatters on it when the contact nodes have mass.
Forces of channels that hold the same motion (redundant) are not unique, their sum in the structure is.
"""

from __future__ import annotations

from creak.contact.laws.pieces import add_piece
from creak.linalg.compiled import either


@either
def hard_pieces(law, at):  # type: ignore[no-untyped-def]
    """One vertical piece: any force at zero gap. Returns the next place."""
    return add_piece(law, at, 0.0, 0.0, 0.0)
