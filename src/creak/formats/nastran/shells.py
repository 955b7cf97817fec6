"""CQUAD4, CTRIA3 (and CQUADR, CTRIAR) -> shell elements."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.nastran.bulk_data import Card
from creak.formats.nastran.coordinate_systems import axes_at
from creak.formats.nastran.deck import Deck, referred, unique_cards
from creak.formats.nastran.materials import Materials
from creak.formats.nastran.shell_sections import is_directed, shell_section
from creak.model.materials import GeneralShell, ShellSection

_CORNERS = {"CQUAD4": 4, "CQUADR": 4, "CTRIA3": 3, "CTRIAR": 3}
_KIND = {4: "quad4", 3: "tri3"}
SHELL_PROPERTIES = ("PSHELL", "PCOMP", "PCOMPG")


@dataclass(frozen=True)
class _Fields:
    """Where the fields of a shell element stand."""

    theta: int
    zoffs: int
    flag: int
    t1: int


_AT = {4: _Fields(6, 7, 9, 10), 3: _Fields(5, 6, 9, 10)}


def read_shells(deck: Deck, materials: Materials) -> None:
    """Add all shell elements to the deck's groups.

    Raises
    ------
    InputError : an unknown grid or property, an id twice, a thickness that is not positive.
    """
    properties = unique_cards(deck.cards(*SHELL_PROPERTIES), "property")
    sections: dict[tuple[int, float], ShellSection | GeneralShell] = {}
    for name, n in _CORNERS.items():
        for card in deck.cards(name):
            _add_shell(deck, card, n, properties, sections, materials)
        for card in deck.cards(name) if name.endswith("R") else ():
            deck.note(card, "read as the shell with the same corners", changes=False)
            break


def _add_shell(
    deck: Deck,
    card: Card,
    n: int,
    properties: dict[int, Card],
    sections: dict[tuple[int, float], ShellSection | GeneralShell],
    materials: Materials,
) -> None:
    pid, at = card.integer(1, card.integer(0)), _AT[n]
    identifier = deck.new_element(card, pid)
    owner = referred(properties, pid, card, "property", ", ".join(SHELL_PROPERTIES))
    nodes = deck.nodes(card, range(2, 2 + n))
    corners = np.array([deck.grids.place(row) for row in nodes])
    own: dict[str, FloatArray] = {}
    thickness, t = _thicknesses(card, owner, n, at)
    if (pid, t) not in sections:
        sections[pid, t] = shell_section(deck, owner, materials, t)
    section = sections[pid, t]
    if thickness is not None:
        own["thickness"] = thickness
    normal = _normal(corners, card)
    if card.text(at.zoffs):
        own["arms"] = np.tile(card.real(at.zoffs) * normal, (n, 1))
    if is_directed(section):
        own["axis1"] = _material_axis(deck, card, at.theta, corners, normal)
    deck.add((pid, t), _KIND[n], section, identifier, nodes, card, **own)


def _thicknesses(card: Card, owner: Card, n: int, at: _Fields) -> tuple[FloatArray | None, float]:
    """Thickness at the corners over that of the section (None: as the section), and that of a section without T."""
    if owner.name != "PSHELL" or not any(card.fields[at.t1 : at.t1 + n]):
        return None, 0.0
    relative = card.integer(at.flag, 0) == 1
    own = owner.real(2, 0.0)
    if not own and (relative or not all(card.fields[at.t1 : at.t1 + n])):
        raise InputError(
            f"{card.name} {card.text(0)} lacks thicknesses that PSHELL {owner.text(0)} does not give",
            where=card.where,
            expected="T on PSHELL or T1 to T4",
        )
    values = np.array([card.real(at.t1 + i, 1.0 if relative else own) for i in range(n)])
    if not (values > 0.0).all():
        raise InputError(
            f"{card.name} {card.text(0)} has a corner without thickness", where=card.where, expected="T1 to T4 > 0"
        )
    base = 1.0 if relative else own or float(values.mean())
    return values / base, 0.0 if own else base


def _normal(corners: FloatArray, card: Card) -> FloatArray:
    (a, b, c), (d, e, f) = (corners[2] - corners[0]).tolist(), (corners[-1] - corners[1]).tolist()
    normal = np.array([b * f - c * e, c * d - a * f, a * e - b * d])
    size = math.sqrt(float(normal @ normal))
    if not size > 1e-12 * (a * a + b * b + c * c + d * d + e * e + f * f):
        raise InputError(
            f"{card.name} {card.text(0)} has zero area",
            where=card.where,
            fix="Check the coordinates and the order of its grids.",
        )
    return normal / size


def _material_axis(deck: Deck, card: Card, field: int, corners: FloatArray, normal: FloatArray) -> FloatArray:
    """THETA (real): from side G1-G2 about the normal, degrees. MCID (integer): x axis of a system."""
    if card.text(field) and card.is_integer(field):
        return axes_at(deck.system(card.integer(field), card), corners.mean(axis=0))[:, 0]
    angle = math.radians(card.real(field, 0.0))
    side = corners[1] - corners[0]
    side = side - (side @ normal) * normal
    return np.cos(angle) * side + np.sin(angle) * np.cross(normal, side)
