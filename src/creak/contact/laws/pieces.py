"""A law of normal contact as a rising curve of straight pieces, the one form that the solvers see.

Every normal law of creak is a monotone graph between overclosure y = -g and force p >= 0. Read as y(p) it is a
function, also where the force may take any value at one overclosure (hard contact, jump of a closing damper):

    y(p) = overclosure[s] + compliance[s] (p - force[s])     for force[s] <= p <= force[s + 1]

and complementarity of p >= 0 with g + y(p) >= 0 is the whole law. The last piece has no end.
"""

from __future__ import annotations

from typing import NamedTuple

from creak.arrays import FloatArray, IntArray
from creak.linalg.compiled import either


class Pieces(NamedTuple):
    """Pieces of n channels, joined; channel i owns first[i] to first[i + 1]."""

    first: IntArray
    """(n + 1,)"""
    force: FloatArray
    """Force at which a piece starts; 0 for the first of a channel."""
    overclosure: FloatArray
    """Overclosure there, length, >= 0."""
    compliance: FloatArray
    """dy/dp, length / force; 0 on a vertical piece."""


@either
def add_piece(law, at, force, overclosure, compliance):  # type: ignore[no-untyped-def]
    """Write one piece; returns the place of the next."""
    law.force[at] = force
    law.overclosure[at] = overclosure
    law.compliance[at] = compliance
    return at + 1


@either
def piece_of(law, channel, p):  # type: ignore[no-untyped-def]
    """The piece that holds the force p; the higher one at a corner, the first one for p < 0."""
    s = law.first[channel]
    while s + 1 < law.first[channel + 1] and law.force[s + 1] <= p:
        s += 1
    return s


@either
def overclosure_at(law, s, p):  # type: ignore[no-untyped-def]
    """y(p) on the line of piece s."""
    return law.overclosure[s] + law.compliance[s] * (p - law.force[s])


@either
def force_against(law, channel, gap, compliance):  # type: ignore[no-untyped-def]
    """The p >= 0 with gap + compliance p + y(p) = 0 (0 if that is open): one channel alone, exact.

    compliance > 0, or law without vertical last piece.
    """
    s = law.first[channel]
    if gap + law.overclosure[s] >= 0.0:
        return 0.0
    last = law.first[channel + 1] - 1
    while s < last and gap + compliance * law.force[s + 1] + law.overclosure[s + 1] < 0.0:
        s += 1
    lack = gap + compliance * law.force[s] + law.overclosure[s]
    return law.force[s] - lack / (compliance + law.compliance[s])
