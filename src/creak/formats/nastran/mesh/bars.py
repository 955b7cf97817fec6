"""CBAR, CBEAM, CROD, CONROD and CTUBE with their properties -> beam and truss elements."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.cross_section import CrossSection, principal
from creak.formats.deck.equations import relative_motion
from creak.formats.deck.refusals import referred
from creak.formats.nastran.sections.bar_shapes import (
    Profile,
    is_off_centre,
    pbeam_stations,
    pbeaml_dimensions,
    pbeaml_stations,
    read_shape,
    tapered,
    uniform,
)
from creak.formats.nastran.sections.materials import Materials
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, unique_cards
from creak.model.constraints import Constraint
from creak.model.materials import BeamSection, TrussSection

_PROPERTIES = {"CBAR": ("PBAR", "PBARL"), "CBEAM": ("PBEAM", "PBEAML")}
_DEFAULTS = {"CBAR": "BAROR", "CBEAM": "BEAMOR"}
_OFFT = re.compile("[GB][GOE]{2}")
"""Frames of the orientation vector (G: displacement frame of GA, B: basic) and of the offsets at A and B (G:
displacement frame of the grid, O: axes from GA to GB, which E, its older name, means too)."""
PARALLEL = 1e-6


def read_bars(deck: Deck, materials: Materials) -> list[Constraint]:
    """Add bars, beams, rods and tubes to the deck's groups; returns the joints of released ends (PA, PB).

    Raises
    ------
    InputError : unknown grid, property or material, an id twice, zero length, an orientation along the bar, a bad OFFT.
    """
    joints: list[Constraint] = []
    for name, kinds in _PROPERTIES.items():
        properties = unique_cards(deck.cards(*kinds), "property")
        sections = {pid: _section(deck, card, materials) for pid, card in properties.items()}
        default = next(deck.cards(_DEFAULTS[name]), Card(_DEFAULTS[name], (), ""))
        for card in deck.cards(name):
            pid = card.integer(1, default.integer(1, card.integer(0)))
            identifier = deck.new_element(card, pid)
            referred(properties, pid, card, "property", " or ".join(kinds))
            joints += _add_bar(deck, card, default, identifier, sections[pid])
    _read_rods(deck, materials)
    return joints


def _section(deck: Deck, card: Card, materials: Materials) -> Profile:
    readers = {"PBAR": _pbar, "PBARL": _shaped, "PBEAM": _pbeam, "PBEAML": _shaped}
    found = readers[card.name](deck, card, materials)
    return found if isinstance(found, Profile) else uniform(found)


def _beam(
    deck: Deck,
    card: Card,
    materials: Materials,
    of: CrossSection,
    nsm: float,
    k: tuple[float, float],
) -> BeamSection:
    """I1 is bending in plane 1 (about axis 2), so i22. With I12 the axes turn to the principal ones; of K1, K2 a CBAR
    has none then, as in Nastran, a CBEAM the mean. Nastran's CBEAM has inertia about its axis, its CBAR none."""
    material, factor = materials.isotropic(card.integer(1), card)
    if min(of.area, of.i22, of.i11, of.torsion) < 0.0 or of.i22 * of.i11 < of.i12**2:
        raise card.error(
            f"{card.name} {card.integer(0)} has A = {of.area:g}, I1 = {of.i22:g}, I2 = {of.i11:g}, J = {of.torsion:g}",
            expected="no negative value, I1 I2 > I12^2",
        )
    i11, i22, angle = principal(of.i11, of.i22, of.i12)
    turned = (of.area, of.i11, of.i12, of.i22, of.torsion * factor) if angle else ()
    if angle:
        k = (0.0, 0.0) if card.name.startswith("PBAR") else (0.5 * sum(k), 0.5 * sum(k))
    return BeamSection(
        f"{card.name} {card.integer(0)}",
        material,
        of.area,
        i11,
        i22,
        of.torsion * factor,
        radius=of.radius,
        shear_area1=k[0] * of.area * factor,
        shear_area2=k[1] * of.area * factor,
        angle=angle,
        line_mass=nsm * deck.mass_factor,
        twist_inertia=0.0 if card.name.startswith("PBAR") else None,
        profile="GENERAL" if turned else "",
        dimensions=turned,
    )


def _pbar(deck: Deck, card: Card, materials: Materials) -> BeamSection:
    """A, I1, I2, J, NSM; K1, K2 (0: rigid in shear), I12."""
    area, i1, i2, torsion, nsm = (card.real(i, 0.0) for i in range(2, 7))
    k = (card.real(16, 0.0), card.real(17, 0.0))
    return _beam(deck, card, materials, CrossSection(area, i2, i1, card.real(18, 0.0), torsion), nsm, k)


def _shaped(deck: Deck, card: Card, materials: Materials) -> BeamSection | Profile:
    shape, nsm = read_shape(card, 8)
    kind = card.text(3).upper()
    k = shape.shear_factors
    if card.name == "PBEAML":
        along = pbeaml_dimensions(card)
        if any(is_off_centre(kind, dims) for _, (*dims, _) in along):
            why = f"the shear centre of {kind} is taken at the centroid"
            deck.note(card, why, changes=True, what=f"PBEAML, {kind}")
        return tapered(pbeaml_stations(card, along), lambda v: _of_values(deck, card, materials, v, k, shape.radius))
    return _beam(deck, card, materials, shape, nsm, k)


def _pbeam(deck: Deck, card: Card, materials: Materials) -> Profile:
    """A, I1, I2, I12, J, NSM at the stations; K1, K2 (default 1)."""
    stations, at = pbeam_stations(card)
    for i, n, what in ((4, 2, "NSI"), (6, 2, "CW"), (8, 4, "M1, M2"), (12, 4, "N1, N2")):
        if any(card.real(at + i + j, 0.0) for j in range(n)):
            deck.note(card, f"creak does not read {what}", changes=True, what=f"PBEAM, {what}")
    k = (card.real(at, 1.0), card.real(at + 1, 1.0))
    return tapered(stations, lambda v: _of_values(deck, card, materials, v, k))


def _of_values(
    deck: Deck, card: Card, materials: Materials, values: Sequence[float], k: tuple[float, float], radius: float = 0.0
) -> BeamSection:
    """The section of A, I1, I2, I12, J and NSM."""
    area, i1, i2, i12, torsion, nsm = values
    return _beam(deck, card, materials, CrossSection(area, i2, i1, i12, torsion, radius=radius), nsm, k)


def _add_bar(deck: Deck, card: Card, default: Card, identifier: int, profile: Profile) -> list[Constraint]:
    nodes = deck.nodes(card, (2, 3))
    offt = _frames(card if card.text(7) else default)
    ends = np.array([deck.grids.place(row) for row in nodes])
    v = _orientation(deck, card, default, nodes, offt)
    arms = _offsets(deck, card, nodes, ends, v, offt)
    line = ends[1] + arms[1] - ends[0] - arms[0]
    length = float(np.linalg.norm(line))
    if not length > 1e-12 * max(float(np.abs(ends).max()), 1e-300):
        raise card.error(f"{card.name} {identifier} has zero length", fix="Check its grids and offsets.")
    if not np.linalg.norm(np.cross(line, v)) > PARALLEL * length * np.linalg.norm(v):
        raise card.error(
            f"the orientation vector of {card.name} {identifier} lies along it",
            expected="a vector across the bar",
            fix="Change X1, X2, X3 or G0.",
        )
    joints: list[Constraint] = []
    for end, i in ((0, 8), (1, 9)):
        pins = card.components(i)
        if pins:
            nodes[end], more = _released(deck, card, nodes[end], arms[end], pins, _bar_axes(line, v))
            arms[end] = 0.0
            joints += more
    _add_pieces(deck, card, identifier, profile, nodes, arms, v / np.linalg.norm(v))
    return joints


def _add_pieces(
    deck: Deck, card: Card, identifier: int, profile: Profile, nodes: list[int], arms: FloatArray, v: FloatArray
) -> None:
    """The bar; a tapered one as pieces between nodes of its own, the first under the id of the bar."""
    start, end = (deck.grids.place(row) + arm for row, arm in zip(nodes, arms, strict=True))
    last, none = nodes[0], np.zeros(3)
    n = len(profile.sections)
    for k, (x, section) in enumerate(zip(profile.ends, profile.sections, strict=True)):
        following = nodes[1] if k == n - 1 else deck.grids.add(start + x * (end - start))
        mine = np.array([arms[0] if k == 0 else none, arms[1] if k == n - 1 else none])
        own = {"axis1": v, "arms": mine} if mine.any() else {"axis1": v}
        one = deck.further_piece(identifier) if k else identifier
        deck.add((section.name, k), "beam2", section, one, [last, following], card, **own)
        last = following
    if n > 1:
        why = f"each tapered bar is computed as {n} pieces with nodes of their own"
        deck.note(card, why, changes=False, what=f"{section.name}, taper")


def _frames(card: Card) -> str:
    """OFFT of a bar or of its defaults."""
    offt = (card.text(7) or "GGG").upper()
    if not _OFFT.fullmatch(offt):
        raise card.wrong(
            7,
            "OFFT: G or B, then G or O (E) for each end, as in GGG, BGG or GOO",
            "Give the orientation vector in the frame of GA (G) or the basic one (B), the offsets in those of the "
            "grids (G) or of the bar (O).",
        )
    return offt


def _orientation(deck: Deck, card: Card, default: Card, nodes: list[int], offt: str) -> FloatArray:
    """X1, X2, X3 in the displacement frame of GA (or basic, OFFT = B..), or the grid G0."""
    source = card if any(card.text(i) for i in (4, 5, 6)) else default
    if source.is_integer(4) and not source.text(5) and not source.text(6):
        return deck.grids.place(deck.grids.row(source.integer(4), card)) - deck.grids.place(nodes[0])
    v = np.array([source.real(i, 0.0) for i in (4, 5, 6)])
    if not v.any():
        raise card.error(f"{card.title} has no orientation vector", expected="X1, X2, X3 or G0")
    axes = deck.grids.axes.get(nodes[0])
    return v if axes is None or offt.startswith("B") else axes @ v


def _offsets(deck: Deck, card: Card, nodes: list[int], ends: FloatArray, v: FloatArray, offt: str) -> FloatArray:
    """(2, 3) W1A.. and W1B.. in the displacement frame of each grid, or in the axes from GA to GB (OFFT = .O., .E.)."""
    arms = np.array([[card.real(10 + 3 * k + i, 0.0) for i in range(3)] for k in range(2)])
    for k in range(2):
        if not arms[k].any():
            continue
        if offt[1 + k] in "OE":
            arms[k] = _bar_axes(ends[1] - ends[0], v) @ arms[k]
        elif nodes[k] in deck.grids.axes:
            arms[k] = deck.grids.axes[nodes[k]] @ arms[k]
    return arms


def _bar_axes(line: FloatArray, v: FloatArray) -> FloatArray:
    """(3, 3), columns x along the bar, y in plane 1, z in plane 2."""
    x = line / np.linalg.norm(line)
    z = np.cross(x, v)
    z = z / np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _released(
    deck: Deck, card: Card, node: int, arm: FloatArray, pins: tuple[int, ...], axes: FloatArray
) -> tuple[int, list[Constraint]]:
    """A node of its own for an end with released dofs (bar axes), tied to the grid in the others."""
    new = deck.grids.add(deck.grids.place(node) + arm)
    kept = [d for d in range(1, 7) if d not in pins]
    rows = np.zeros((len(kept), 6))
    for k, d in enumerate(kept):
        rows[k, 3 * ((d - 1) // 3) : 3 * ((d - 1) // 3) + 3] = axes[:, (d - 1) % 3]
    return new, list(relative_motion(new, node, arm, rows, card.where))


class _Rod(NamedTuple):
    """What a rod is made of, and the card that says so."""

    owner: Card
    material: int
    area: float
    torsion: float
    """Constant of torsion."""
    nsm: float
    """Weight or mass per length besides."""


def _read_rods(deck: Deck, materials: Materials) -> None:
    rods = unique_cards(deck.cards("PROD"), "property")
    tubes = unique_cards(deck.cards("PTUBE"), "property")
    for card in deck.cards("CROD"):
        pid = card.integer(1, card.integer(0))
        owner = referred(rods, pid, card, "property", "PROD")
        rod = _Rod(owner, owner.integer(1), *(owner.real(i, 0.0) for i in (2, 3, 5)))
        _add_rod(deck, card, pid, (2, 3), rod, materials)
    for card in deck.cards("CONROD"):
        rod = _Rod(card, card.integer(3), *(card.real(i, 0.0) for i in (4, 5, 7)))
        _add_rod(deck, card, None, (1, 2), rod, materials)
    for card in deck.cards("CTUBE"):
        pid = card.integer(1, card.integer(0))
        owner = referred(tubes, pid, card, "property", "PTUBE")
        _add_rod(deck, card, pid, (2, 3), _tube(deck, owner), materials)


def _tube(deck: Deck, card: Card) -> _Rod:
    """Thickness blank or 0: a solid rod."""
    outer = card.real(2)
    inner = outer - 2.0 * (card.real(3, 0.0) or 0.5 * outer)
    if card.real(5, outer) != outer:
        deck.note(card, "creak takes the diameter of end A all along", changes=True, what="PTUBE, OD2")
    area, torsion = math.pi / 4.0 * (outer**2 - inner**2), math.pi / 32.0 * (outer**4 - inner**4)
    return _Rod(card, card.integer(1), area, torsion, card.real(4, 0.0))


def _add_rod(deck: Deck, card: Card, pid: int | None, ends: tuple[int, int], rod: _Rod, materials: Materials) -> None:
    """Axial force, and torque where J > 0: then a beam without bending."""
    identifier = deck.new_element(card, pid)
    nodes = deck.nodes(card, ends)
    line = deck.grids.place(nodes[1]) - deck.grids.place(nodes[0])
    if not np.linalg.norm(line) > 0.0:
        raise card.error(f"{card.name} {identifier} has zero length", fix="Check its grids.")
    owner, mid, area, torsion, nsm = rod
    material, factor = materials.isotropic(mid, owner)
    if area < 0.0 or torsion < 0.0 or not area + torsion > 0.0:
        raise owner.error(f"{owner.title} has A = {area:g} and J = {torsion:g}", expected="A > 0 or J > 0")
    name = owner.title
    if torsion == 0.0 and nsm == 0.0:
        deck.add((name,), "truss2", TrussSection(name, material, area), identifier, nodes, card)
        return
    section = BeamSection(
        name, material, area, 0.0, 0.0, torsion * factor, line_mass=nsm * deck.mass_factor, twist_inertia=0.0
    )
    across = np.eye(3)[int(np.argmin(np.abs(line)))]
    deck.add((name,), "beam2", section, identifier, nodes, card, axis1=across)
