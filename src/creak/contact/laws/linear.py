"""Penalty with damper: p = max(0, -k g - c g') while closed (g < 0), 0 while open.

With the rate of the step g' = rate_free + a (g - gap_free) the law is a line in g: p = -k_hat g - c_hat with
k_hat = k + a c and c_hat = c (rate_free - a gap_free), c g' at zero gap being c_hat. A damper that closes (c_hat < 0)
makes the force jump to -c_hat at g = 0; there the channel may hold with any force from 0 to the jump, the closure of
the law, which keeps it monotone. A damper that opens (c_hat > 0) is never allowed to pull: the force starts at
overclosure c_hat / k_hat. Source: Kelvin-Voigt contact without tension (Wriggers, Computational Contact Mechanics,
2006). Valid for overclosures small against the bodies; the jump dissipates, energy is never created by it.
"""

from __future__ import annotations

from creak.contact.laws.pieces import add_piece
from creak.linalg.compiled import either


@either
def linear_energy(stiffness, gap):  # type: ignore[no-untyped-def]
    """Energy in the spring, k g^2 / 2 while closed."""
    return 0.5 * stiffness * gap * gap if gap < 0.0 else 0.0


@either
def linear_pieces(law, at, k_hat, c_hat):  # type: ignore[no-untyped-def]
    """Pieces of a channel with k_hat > 0: the jump, if there is one, then the spring. Returns the next place."""
    if c_hat < 0.0:
        at = add_piece(law, at, 0.0, 0.0, 0.0)
        return add_piece(law, at, -c_hat, 0.0, 1.0 / k_hat)
    return add_piece(law, at, 0.0, c_hat / k_hat, 1.0 / k_hat)
