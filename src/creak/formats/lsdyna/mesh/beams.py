"""*ELEMENT_BEAM with *SECTION_BEAM -> beam and truss elements."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.cross_section import CrossSection, principal, rectangle, rectangle_torsion, tube
from creak.formats.lsdyna.sections.parts import PartCard, Properties
from creak.formats.lsdyna.text.deck import EIGHTS, Card, Deck
from creak.model.materials import BeamSection, Material, TrussSection

INTEGRATED = (1, 4, 5, 9, 11)
"""ELFORM of beams whose section is given by its shape."""
RESULTANT = (2, 13)
"""ELFORM of beams whose section is given by area and moments."""
TRUSS = 3
WELD = 9
"""ELFORM of spot weld beams, which are round."""
PARALLEL = 1e-6


def read_beams(deck: Deck, properties: Properties) -> None:
    """Add all beams and trusses to the deck's groups.

    Raises
    ------
    InputError : an unknown node, part or section, an id twice, zero length, a section that creak does not know.
    """
    sections: dict[int, BeamSection | TrussSection] = {}
    for named in deck.named("ELEMENT_BEAM"):
        for card in named.cards(EIGHTS):
            part = properties.part(card, 1)
            found = properties.section(part, "SECTION_BEAM")
            if found is None:
                continue
            pid = part.identifier
            if pid not in sections:
                sections[pid] = _section(found.cards, part, properties)
            _add(deck, card, pid, sections[pid])


def _add(deck: Deck, card: Card, pid: int, section: BeamSection | TrussSection) -> None:
    for i, what in ((5, "RT1"), (6, "RR1"), (7, "RT2"), (8, "RR2")):
        if card.integer(i):
            raise card.wrong(i, f"{what} 0: creak does not release the ends of beams", "Join the nodes by springs.")
    nodes = [deck.nodes.row(card, i) for i in (2, 3)]
    ends = deck.nodes.array[nodes]
    line = ends[1] - ends[0]
    if not np.linalg.norm(line) > 0.0:
        raise card.error(f"beam element {card.text(0)} has zero length", fix="Check its nodes.")
    identifier = card.defined(0, "e")
    if isinstance(section, TrussSection):
        deck.add("beam", pid, "truss2", section, identifier, nodes, card)
        return
    deck.add("beam", pid, "beam2", section, identifier, nodes, card, axis1=_axis_s(deck, card, line, ends[0], section))


def _axis_s(deck: Deck, card: Card, line: FloatArray, start: FloatArray, section: BeamSection) -> FloatArray:
    """Towards node N3; across the beam any way where the section is the same all round and N3 says nothing."""
    v = deck.nodes.array[deck.nodes.row(card, 4)] - start if card.integer(4) else np.zeros(3)
    if np.linalg.norm(np.cross(line, v)) > PARALLEL * np.linalg.norm(line) * np.linalg.norm(v):
        return np.asarray(v)
    if abs(section.i11 - section.i22) <= 1e-9 * section.i11 and section.shear_area1 == section.shear_area2:
        return np.eye(3)[int(np.argmin(np.abs(line)))]
    raise card.error(
        f"beam element {card.text(0)} has no orientation node beside its axis",
        expected="N3, a node off the line of the beam",
    )


def _section(cards: tuple[Card, ...], part: PartCard, properties: Properties) -> BeamSection | TrussSection:
    """Axis 1 is s, towards the third node, axis 2 is t."""
    first, second = cards
    form, material = first.integer(1) or 1, properties.material(part)
    if second.text(0).upper().startswith("SECTION"):
        raise second.wrong(0, "numbers", "Write the area and moments of the standard section in its place.")
    added = _line_mass(properties.deck, first, form)
    if form == TRUSS:
        area = second.real(0)
        if not area > 0.0:
            raise second.wrong(0, "an area above 0")
        return TrussSection(part.name, replace(material, density=material.density + added / area), area)
    if form in RESULTANT:
        return _resultant(first, second, part.name, material, added)
    if form not in INTEGRATED:
        raise first.wrong(1, "ELFORM 1, 2, 3, 4, 5, 9, 11 or 13", "creak does not read this kind of beam.")
    shape = _shape(first, second, form)
    if not shape.sound:
        raise InputError(f"section {first.text(0)} has no area", where=second.where, expected="TS1, TT1 above 0")
    return BeamSection(
        part.name,
        material,
        shape.area,
        shape.i11,
        shape.i22,
        shape.torsion,
        radius=shape.radius,
        shear_area1=shape.shear_factors[0] * shape.area,
        shear_area2=shape.shear_factors[1] * shape.area,
        line_mass=added,
    )


def _line_mass(deck: Deck, first: Card, form: int) -> float:
    """NSM, a mass per length; LS-DYNA leaves out that of spot welds."""
    added = first.real(6)
    if added < 0.0:
        raise first.wrong(6, "NSM, a mass per length of zero or more")
    if form == WELD and added:
        why = "spot weld beams have no nonstructural mass, in LS-DYNA neither"
        deck.note(first.where, "*SECTION_BEAM, NSM", why, changes=False)
        return 0.0
    return added


def _resultant(first: Card, second: Card, name: str, material: Material, added: float) -> BeamSection:
    """A, ISS, ITT, J, SA (0: rigid in shear), IST."""
    area, i_ss, i_tt, torsion, shear, i_st = (second.real(i) for i in range(6))
    if not (area > 0.0 and i_ss > 0.0 and i_tt > 0.0 and i_ss * i_tt > i_st**2) or shear < 0.0:
        raise InputError(
            f"section {first.text(0)} has A = {area:g}, ISS = {i_ss:g}, ITT = {i_tt:g}, IST = {i_st:g}, SA = {shear:g}",
            where=second.where,
            expected="A, ISS, ITT above 0, ISS ITT > IST^2",
        )
    torsion = torsion or i_ss + i_tt
    i11, i22, angle = principal(i_ss, i_tt, i_st)
    return BeamSection(
        name,
        material,
        area,
        i11,
        i22,
        torsion,
        shear_area1=shear,
        shear_area2=shear,
        angle=angle,
        line_mass=added,
        profile="GENERAL",
        dimensions=(area, i_ss, i_st, i_tt, torsion),
    )


def _shape(first: Card, second: Card, form: int) -> CrossSection:
    """Rectangle TS1 x TT1, or a tube of diameters TS1 and TT1 (CST 1), the same at both ends."""
    ts1, ts2, tt1, tt2 = (second.real(i) for i in range(4))
    if (ts2 or ts1) != ts1 or (tt2 or tt1) != tt1:
        raise second.wrong(1, "the same section at both ends", "Divide the beam into pieces of one section each.")
    if second.real(4) or second.real(5):
        raise second.wrong(4, "NSLOC and NTLOC 0: the nodes on the axis of the beam", "Join them by rigid links.")
    kind, shear = first.real(4), first.real(2, 1.0) or 1.0
    if form in (WELD, 5) or kind == 1.0:
        return tube(0.5 * ts1, 0.5 * tt1, shear)
    if kind != 0.0 or first.real(3) < 0.0:
        raise first.wrong(4, "CST 0 (rectangle) or 1 (tube)", "creak does not read *INTEGRATION_BEAM: use ELFORM 2.")
    if not min(ts1, tt1) > 0.0:
        return CrossSection(0.0, 0.0, 0.0, 0.0, math.nan)
    return rectangle(ts1, tt1, rectangle_torsion(ts1, tt1), shear)
