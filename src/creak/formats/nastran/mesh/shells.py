"""CQUAD4, CTRIA3 (and CQUADR, CTRIAR), CQUAD8, CTRIA6 -> shell elements."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.coordinate_systems import CoordinateSystem, axes_at
from creak.formats.deck.refusals import referred
from creak.formats.nastran.sections.materials import Materials
from creak.formats.nastran.sections.shells import Layers, as_pcomp, is_directed, layers_of, shell_section
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, rows_with_middles, unique_cards
from creak.model.dofs import ALL
from creak.model.materials import GeneralShell, ShellSection

_CORNERS = {"CQUAD4": 4, "CQUADR": 4, "CTRIA3": 3, "CTRIAR": 3, "CQUAD8": 4, "CTRIA6": 3}
_KIND = {4: "quad4", 3: "tri3", 8: "quad8", 6: "tri6"}
SHELL_PROPERTIES = ("PSHELL", "PCOMP", "PCOMPG", "PCOMPP")
Sections = dict[tuple[object, ...], ShellSection | GeneralShell]
"""By property, thickness where the property has none, and stacked plies."""


@dataclass(frozen=True)
class _Fields:
    """Where the fields of a shell element stand."""

    theta: int
    zoffs: int
    flag: int
    t1: int


_AT = {
    "CQUAD4": _Fields(6, 7, 9, 10),
    "CQUADR": _Fields(6, 7, 9, 10),
    "CTRIA3": _Fields(5, 6, 9, 10),
    "CTRIAR": _Fields(5, 6, 9, 10),
    "CQUAD8": _Fields(14, 15, 16, 10),
    "CTRIA6": _Fields(8, 9, 13, 10),
}


def read_shells(deck: Deck, materials: Materials) -> None:
    """Add all shell elements to the deck's groups.

    Raises
    ------
    InputError : an unknown grid, property or system, an id twice, a thickness that is not positive, a bad TFLAG.
    """
    properties = unique_cards(deck.cards(*SHELL_PROPERTIES), "property")
    sections: Sections = {}
    stacked = {pid for pid, card in properties.items() if card.name == "PCOMPP"}
    of_stacks = [c.integer(0) for c in deck.cards(*_CORNERS) if stacked and c.integer(1, c.integer(0)) in stacked]
    layers = layers_of(deck, of_stacks) if stacked else {}
    for name, n in _CORNERS.items():
        for card in deck.cards(name):
            _add_shell(deck, card, n, properties, layers, sections, materials)
        for card in deck.cards(name) if name.endswith("R") else ():
            deck.note(card, "read as the shell with the same corners", changes=False)
            break


def _add_shell(
    deck: Deck,
    card: Card,
    n: int,
    properties: dict[int, Card],
    layers: dict[int, Layers],
    sections: Sections,
    materials: Materials,
) -> None:
    pid, at = card.integer(1, card.integer(0)), _AT[card.name]
    identifier = deck.new_element(card, pid)
    owner = referred(properties, pid, card, "property", ", ".join(SHELL_PROPERTIES))
    nodes = _grids(deck, card, n)
    corners = np.array([deck.grids.place(row) for row in nodes[:n]])
    own: dict[str, FloatArray] = {}
    thickness, t = _thicknesses(card, owner, n, at)
    mine = layers.get(identifier, ()) if owner.name == "PCOMPP" else ()
    key = (pid, t, *(layer.text(0) for layer in mine))
    if key not in sections:
        of = as_pcomp(owner, card, mine) if owner.name == "PCOMPP" else owner
        sections[key] = shell_section(deck, of, materials, t)
    section = sections[key]
    if thickness is not None:
        own["thickness"] = thickness if len(nodes) == n else np.append(thickness, _between(thickness))
    normal = _normal(corners, card)
    if card.text(at.zoffs):
        own["arms"] = card.real(at.zoffs) * _normals(deck, nodes, n, normal)
    direction = _direction(deck, card, at.theta)
    if is_directed(section):
        own["axis1"] = _material_axis(direction, corners, normal)
    deck.add(key, _KIND[len(nodes)], section, identifier, nodes, card, **own)


def _grids(deck: Deck, card: Card, n: int) -> list[int]:
    """Rows of 3, 4, 6 or 8: without any grid at the middles of its sides a CQUAD8 is a CQUAD4."""
    if card.name not in ("CQUAD8", "CTRIA6"):
        return deck.nodes(card, range(2, 2 + n))
    sides = [(k, (k + 1) % n) for k in range(n)]
    return rows_with_middles(deck, card, sides, range(2 * n), ALL)


def _between(values: FloatArray) -> FloatArray:
    """Mean of the values at the ends of each side."""
    return 0.5 * (values + np.roll(values, -1, axis=0))


def _normals(deck: Deck, nodes: list[int], n: int, normal: FloatArray) -> FloatArray:
    """(n_node, 3) unit normals at the nodes; with middle nodes those of the parabolas along the sides."""
    if len(nodes) == n:
        return np.tile(normal, (n, 1))
    x = np.array([deck.grids.place(row) for row in nodes])
    ends, middle = x[:n], x[n:]
    ahead = 4.0 * middle - 3.0 * ends - np.roll(ends, -1, axis=0)
    back = 4.0 * np.roll(middle, 1, axis=0) - 3.0 * ends - np.roll(ends, 1, axis=0)
    corner = np.cross(ahead, back)
    corner /= np.linalg.norm(corner, axis=1)[:, None]
    between = _between(corner)
    return np.concatenate([corner, between / np.linalg.norm(between, axis=1)[:, None]])


def _thicknesses(card: Card, owner: Card, n: int, at: _Fields) -> tuple[FloatArray | None, float]:
    """Thickness at the corners over that of the section (None: as the section), and that of a section without T."""
    relative = card.integer(at.flag, 0)
    if relative not in (0, 1):
        raise card.wrong(at.flag, "TFLAG: 0 or blank (T1 to T4 are thicknesses), or 1 (shares of that of PSHELL)")
    if owner.name != "PSHELL" or not any(card.fields[at.t1 : at.t1 + n]):
        return None, 0.0
    own = owner.real(2, 0.0)
    if not own and (relative or not all(card.fields[at.t1 : at.t1 + n])):
        raise card.error(
            f"{card.title} lacks thicknesses that PSHELL {owner.text(0)} does not give",
            expected="T on PSHELL or T1 to T4",
        )
    values = np.array([card.real(at.t1 + i, 1.0 if relative else own) for i in range(n)])
    if not (values > 0.0).all():
        raise card.error(f"{card.title} has a corner without thickness", expected="T1 to T4 > 0")
    base = 1.0 if relative else own or float(values.mean())
    return values / base, 0.0 if own else base


def _normal(corners: FloatArray, card: Card) -> FloatArray:
    (a, b, c), (d, e, f) = (corners[2] - corners[0]).tolist(), (corners[-1] - corners[1]).tolist()
    normal = np.array([b * f - c * e, c * d - a * f, a * e - b * d])
    size = math.sqrt(float(normal @ normal))
    if not size > 1e-12 * (a * a + b * b + c * c + d * d + e * e + f * f):
        raise card.error(f"{card.title} has zero area", fix="Check the coordinates and the order of its grids.")
    return normal / size


def _direction(deck: Deck, card: Card, field: int) -> CoordinateSystem | float:
    """MCID (integer) or THETA (real; here in radian); both are checked where the shell needs none, too."""
    if card.is_integer(field):
        return deck.system(card.integer(field), card)
    return math.radians(card.real(field, 0.0))


def _material_axis(direction: CoordinateSystem | float, corners: FloatArray, normal: FloatArray) -> FloatArray:
    """The x axis of a system, or what stands at an angle to side G1-G2 about the normal."""
    if isinstance(direction, CoordinateSystem):
        return axes_at(direction, corners.mean(axis=0))[:, 0]
    side = corners[1] - corners[0]
    side = side - (side @ normal) * normal
    return np.cos(direction) * side + np.sin(direction) * np.cross(normal, side)
