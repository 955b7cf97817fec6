"""*NONSTRUCTURAL MASS: mass smeared over elements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.abaqus.mesh.elements import TYPES, Elements
from creak.formats.abaqus.sections.assigned import Assigned
from creak.formats.abaqus.text.fields import Registry, positive
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline
from creak.model import laminates
from creak.model.faces import element_volumes
from creak.model.materials import (
    BeamSection,
    GeneralShell,
    Section,
    ShellSection,
    SolidSection,
    Structural,
    TrussSection,
)

UNITS = ("TOTAL MASS", "MASS PER VOLUME", "MASS PER AREA", "MASS PER LENGTH")


def with_added_mass(
    deck: Outline, elements: Elements, names: Registry, assigned: Assigned, coords: FloatArray
) -> Assigned:
    """Sections with the mass of every *NONSTRUCTURAL MASS: as a higher density, of shells as a mass per area.

    TOTAL MASS is spread in proportion to the elements' mass, or to their volume (DISTRIBUTION=VOLUME PROPORTIONAL):
    on shells of unlike thickness as a density.

    Raises
    ------
    InputError : unknown set or units, no value, mass per area of elements that are no shells and the like.
    """
    for scope, block in deck.blocks("NONSTRUCTURAL MASS"):
        rows = np.unique(names.find(block.need("ELSET"), scope.name, block.where))
        rows = rows[[isinstance(assigned.sections[s], Structural) for s in assigned.section_idx[rows]]]
        lines = list(block.rows())
        units = block.need("UNITS").upper()
        if units not in UNITS or not lines or not rows.size:
            raise block.error(
                f"*NONSTRUCTURAL MASS, UNITS={units} on {rows.size} structural elements",
                expected=f"UNITS={', '.join(UNITS)}, a set with shells, beams or solids and a value",
                fix="Correct the keyword.",
            )
        value = positive(lines[0][0][0], lines[0][1], "nonstructural mass")
        assigned = _added(block, units, value, rows, elements, assigned, coords)
    return assigned


def _added(
    block: Block, units: str, value: float, rows: IntArray, elements: Elements, assigned: Assigned, coords: FloatArray
) -> Assigned:
    section_of = assigned.section_idx[rows]
    used = np.unique(section_of)
    proportional = block.option("DISTRIBUTION", "MASS PROPORTIONAL") == "MASS PROPORTIONAL"
    if units == "TOTAL MASS":
        volume = _volumes(rows, elements, assigned, coords)
        weight = np.array([density(assigned.sections[s]) if proportional else 1.0 for s in section_of])
        value /= float(volume @ weight)
    sections, section_idx, own = list(assigned.sections), assigned.section_idx.copy(), dict(assigned.own)
    for s in used.tolist():
        section = assigned.sections[s]
        if units == "TOTAL MASS":
            more = value * density(section) if proportional else value
        else:
            more = value / _per_volume(block, units, section)
        even = isinstance(section, ShellSection) and (s not in own or own[s].thickness is None)
        by_area = units == "MASS PER AREA" or (units == "TOTAL MASS" and even)
        mine = rows[section_of == s]
        every = np.flatnonzero(section_idx == s)
        if s in own:
            old = own[s]
            own[len(sections)] = old.take(np.searchsorted(every, mine))
            own[s] = old.take(np.flatnonzero(~np.isin(every, mine)))
        section_idx[mine] = len(sections)
        sections.append(_heavier_by_area(section, more) if by_area else denser(section, more))
    return replace(assigned, sections=tuple(sections), section_idx=section_idx, own=own)


def density(section: Section) -> float:
    """Mass per volume."""
    if isinstance(section, GeneralShell):
        return section.mass / section.thickness
    if isinstance(section, BeamSection):
        return section.material.density + section.line_mass / section.area
    return section.material.density if isinstance(section, Structural) else 0.0


def _heavier_by_area(section: Section, more: float) -> Section:
    """The shell with a further mass per area of `more` times its thickness."""
    assert isinstance(section, ShellSection | GeneralShell)
    return replace(section, area_mass=section.area_mass + more * section.thickness)


def denser(section: Section, more: float) -> Section:
    """The section with `more` mass per volume."""
    if isinstance(section, GeneralShell):
        return laminates.denser(section, more)
    if isinstance(section, SolidSection):
        return replace(section, material=replace(section.material, density=section.material.density + more))
    if isinstance(section, ShellSection | BeamSection | TrussSection):
        return replace(section, material=replace(section.material, density=section.material.density + more))
    return section


def _per_volume(block: Block, units: str, section: Section) -> float:
    """Area or length of the section per volume, inverted: thickness, area, or one."""
    if units == "MASS PER VOLUME":
        return 1.0
    if units == "MASS PER AREA" and isinstance(section, ShellSection | GeneralShell):
        return section.thickness
    if units == "MASS PER LENGTH" and isinstance(section, BeamSection | TrussSection):
        return section.area
    raise block.error(
        f"*NONSTRUCTURAL MASS, UNITS={units} on elements that have none of it",
        expected="mass per area on shells, per length on beams and trusses",
        fix="Name a set of one kind of element.",
    )


def _volumes(rows: IntArray, elements: Elements, assigned: Assigned, coords: FloatArray) -> FloatArray:
    """(n,) volumes of structural elements, shells with the thickness of their own."""
    out = np.zeros(rows.size)
    kinds = np.array([t.kind for t in TYPES])[elements.type_idx[rows]]
    for kind in np.unique(kinds):
        for s in np.unique(assigned.section_idx[rows[kinds == kind]]).tolist():
            mine = np.flatnonzero((kinds == kind) & (assigned.section_idx[rows] == s))
            thickness = assigned.own_of(rows[mine]).thickness
            nodes_idx = elements.nodes_idx[rows[mine]]
            out[mine] = element_volumes(str(kind), nodes_idx, coords, assigned.sections[s], thickness)
    return out
