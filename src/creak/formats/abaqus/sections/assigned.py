"""Section and property keywords -> the section of every element."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.abaqus.joints.connectors import Connector, read_connectors
from creak.formats.abaqus.joints.points import (
    read_dashpot,
    read_mass,
    read_rotary_inertia,
    read_spring,
    turned_point,
    turned_spring,
)
from creak.formats.abaqus.mesh.elements import TYPES, Elements
from creak.formats.abaqus.sections.beams import read_beam_general_section, read_beam_section
from creak.formats.abaqus.sections.materials import RawMaterial, find_material, find_solid_material
from creak.formats.abaqus.sections.orientations import constant_axes
from creak.formats.abaqus.sections.own_data import Geometry, own_data
from creak.formats.abaqus.sections.shells import (
    read_cohesive_section,
    read_continuum_shell,
    read_membrane_section,
    read_shell_general_section,
    read_shell_section,
    rigid_section,
)
from creak.formats.abaqus.text.fields import Registry, positive
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.model.faces import FACES
from creak.model.materials import (
    AxialSpring,
    BeamSection,
    Bushing,
    NodalMatrices,
    PointMass,
    Section,
    SolidSection,
    Spring,
    TrussSection,
)
from creak.model.mesh import COMMON, Own
from creak.words import first_few

Materials = dict[str, RawMaterial]
_Reader = Callable[[Scope, Block, Materials], Section]
EACH = "Give each direction an element and a rectangular system."


@dataclass(frozen=True)
class Assigned:
    """Sections and which element has which."""

    sections: tuple[Section, ...]
    section_idx: IntArray
    """(n_elem,) rows into `sections`."""
    own: Mapping[int, Own]
    """Row into `sections` -> what its elements, in ascending rows of the element table, have of their own."""
    connectors: tuple[Connector, ...] = ()
    """Connectors with rigid components."""

    def own_of(self, rows: IntArray) -> Own:
        """Of elements (ascending rows of the element table) that share one section."""
        section = int(self.section_idx[rows[0]])
        if section not in self.own:
            return COMMON
        return self.own[section].take(np.searchsorted(np.flatnonzero(self.section_idx == section), rows))


def read_sections(
    deck: Outline, elements: Elements, names: Registry, materials: Materials, geometry: Geometry
) -> Assigned:
    """Read every section keyword and give each element its section.

    Raises
    ------
    InputError : unknown set, material or orientation, bad dimensions, wrong element type, an element with two
        sections or none.
    """
    found = _Found(elements)
    for scope, block in deck.blocks(*_READERS):
        rows = names.find(block.need("ELSET"), scope.name, block.where)
        _check_types(block, rows, elements)
        found.check_free(block, rows)
        section = _reader(block, rows, elements)(scope, block, materials)
        if isinstance(section, BeamSection) and section.profile == "CIRC":
            _radius_or_diameter(deck, block, elements.of(int(rows[0])).name)
        frame = constant_axes(deck, scope, block, geometry.orientations, EACH) if isinstance(section, Spring) else None
        if isinstance(section, NodalMatrices) or (isinstance(section, PointMass) and block.get("ORIENTATION")):
            turn = constant_axes(deck, scope, block, geometry.orientations, EACH)
            section = section if turn is None else turned_point(section, turn)
        for some, kind in _kinds(section, np.sort(rows), elements, frame):
            found.add(block, some, kind, own_data(deck, scope, block, kind, elements, some, geometry))
    found.add_rigid(deck, names, materials, geometry.coords)
    connectors = read_connectors(deck, elements, names, geometry)
    for made in connectors.sections:
        found.check_free(made.block, made.rows)
        found.add(made.block, made.rows, made.section, made.own)
    found.check_all()
    return Assigned(tuple(found.sections), found.section_idx, found.own, connectors.rigid)


def _radius_or_diameter(deck: Outline, block: Block, element: str) -> None:
    """CIRC of one number is a radius in Abaqus and a diameter in CalculiX, which alone has B32R."""
    fields, _ = next(iter(block.rows()))
    if element == "B32R" and not any(fields[1:]):
        why = "creak takes the one number of CIRC for the radius, as Abaqus does; CalculiX, which alone has B32R, "
        why += "takes it for the diameter: give that twice"
        deck.note(block, why, changes=True, what=f"*{block.name}, CIRC")


def _kinds(
    section: Section, rows: IntArray, elements: Elements, frame: FloatArray | None
) -> list[tuple[IntArray, Section]]:
    """The section as each type of its elements has it: B33 is rigid in shear, SPRINGA acts along its line."""
    names = np.array([t.name for t in TYPES])[elements.type_idx[rows]]
    if isinstance(section, BeamSection):
        other: Section = replace(section, shear_area1=0.0, shear_area2=0.0)
        mask = names == "B33"
    elif isinstance(section, Spring):
        other = AxialSpring(section.name, section.stiffness, section.damping)
        mask = np.isin(names, AXIAL)
        if not section.dof1 and not mask.all():
            raise InputError(
                f"springs or dashpots of type {names[~mask][0]} without a degree of freedom",
                expected="a first data line with it",
                where=elements.where(int(rows[~mask][0])),
                fix="Only SPRINGA and DASHPOTA have a blank first line.",
            )
        if frame is not None and not mask.all():
            pairs: list[tuple[IntArray, Section]] = [(rows[mask], other)]
            for n in (1, 2):
                of_nodes = elements.of_kinds((f"spring{n}",))[rows]
                pairs.append((rows[~mask & of_nodes], turned_spring(section, frame, n)))
            return [(some, kind) for some, kind in pairs if some.size]
    else:
        return [(rows, section)]
    both: list[tuple[IntArray, Section]] = [(rows[~mask], section), (rows[mask], other)]
    return [(some, kind) for some, kind in both if some.size]


class _Found:
    """Sections while the elements get them."""

    def __init__(self, elements: Elements) -> None:
        self.elements, self.section_idx = elements, np.full(elements.ids.size, -1, dtype=np.int64)
        self.sections: list[Section] = []
        self.own: dict[int, Own] = {}
        self._places: list[str] = []

    def add(self, block: Block, rows: IntArray, section: Section, own: Own = COMMON) -> None:
        """Give elements a section."""
        self.section_idx[rows] = len(self.sections)
        if own is not COMMON:
            self.own[len(self.sections)] = own
        self.sections.append(section)
        self._places.append(block.where)

    def add_rigid(self, deck: Outline, names: Registry, materials: Materials, coords: FloatArray) -> None:
        """*RIGID BODY is the section of its rigid elements."""
        rigid = np.array([t.sections == ("RIGID BODY",) for t in TYPES])[self.elements.type_idx]
        for scope, block in deck.blocks("RIGID BODY"):
            if not block.has("ELSET"):
                continue
            rows = names.find(block.need("ELSET"), scope.name, block.where)
            rows = rows[rigid[rows] & (self.section_idx[rows] < 0)]
            for n_node, kind in ((3, "tri3"), (4, "quad4")):
                some = rows[self.elements.of_kinds((kind,))[rows]]
                if some.size:
                    corners = coords[self.elements.nodes_idx[some, :n_node]]
                    self.add(block, some, rigid_section(block, corners, materials))

    def check_free(self, block: Block, rows: IntArray) -> None:
        """Raise InputError where one of the elements has a section."""
        taken = self.section_idx[rows] >= 0
        if taken.any():
            row = int(rows[int(np.argmax(taken))])
            first = self._places[int(self.section_idx[row])]
            raise block.error(
                f"element {self.elements.ids[row]} gets a second section; the first is at {first}",
                expected="one section for each element",
                fix="Make the element sets disjoint.",
            )

    def check_all(self) -> None:
        """Raise InputError where an element has none."""
        elements, without = self.elements, np.flatnonzero(self.section_idx < 0)
        if without.size == 0:
            return
        kind = elements.of(int(without[0]))
        same = without[elements.type_idx[without] == elements.type_idx[without[0]]]
        count = f"{same.size} element{'s' if same.size > 1 else ''}"
        lack = f"ha{'ve' if same.size > 1 else 's'} no section"
        raise InputError(
            f"{count} of type {kind.name} {lack}: {first_few(elements.ids[same].tolist())}",
            expected=f"*{' or *'.join(kind.sections)} with an ELSET that holds each of them",
            where=elements.where(int(without[0])),
            fix=f"Add *{kind.sections[0]} for them.",
        )


def read_truss_section(scope: Scope, block: Block, materials: Materials) -> Section:
    """*SOLID SECTION of trusses: area on the data line, 1 when there is none."""
    material = find_material(block.need("MATERIAL"), materials, block.where)
    rows = list(block.rows())
    area = positive(rows[0][0][0], rows[0][1], "area of the truss") if rows else 1.0
    return TrussSection(block.get("ELSET"), material, area)


def read_solid_section(scope: Scope, block: Block, materials: Materials) -> Section:
    """*SOLID SECTION of solids: homogeneous; what the data line says (a thickness of plane elements) is not used."""
    for param in ("COMPOSITE", "SYMMETRIC", "LAYUP"):
        if block.has(param):
            raise block.error(
                f"*SOLID SECTION with {param} is not supported",
                expected="one material",
                fix="Give every material its elements and a section of its own.",
            )
    return SolidSection(block.get("ELSET"), find_solid_material(block.need("MATERIAL"), materials, block.where))


def _reader(block: Block, rows: IntArray, elements: Elements) -> _Reader:
    """What reads a section; those of trusses and of continuum shells have the keywords of others."""
    if _is_truss(block, rows, elements):
        return read_truss_section
    continuum = elements.of_kinds(FACES)[rows]
    if block.name == "SHELL SECTION" and continuum.any():
        if not continuum.all():
            raise block.error(
                f"*SHELL SECTION, ELSET={block.get('ELSET')} holds both shells and continuum shells",
                expected="one kind",
                fix="Make two sections of it.",
            )
        return read_continuum_shell
    return _READERS[block.name]


def _is_truss(block: Block, rows: IntArray, elements: Elements) -> bool:
    """Is this the *SOLID SECTION of trusses?

    Raises
    ------
    InputError : it holds trusses and solids.
    """
    if block.name != "SOLID SECTION" or not rows.size:
        return False
    solid = elements.of_kinds(FACES)[rows]
    if solid.any() and not solid.all():
        raise block.error(
            f"*SOLID SECTION, ELSET={block.get('ELSET')} holds both solids and trusses",
            expected="one kind",
            fix="Make two sections of it.",
        )
    return not solid.any()


AXIAL = ("SPRINGA", "DASHPOTA")
"""Types that act along the line between their nodes."""


def _nothing(scope: Scope, block: Block, materials: Materials) -> Section:
    """Elements of a *DISTRIBUTING COUPLING have neither stiffness nor mass; those of a *GAP are stops."""
    return Bushing(block.get("ELSET"), np.zeros((6, 6)), np.zeros((6, 6)))


_READERS: dict[str, _Reader] = {
    "SHELL SECTION": read_shell_section,
    "SHELL GENERAL SECTION": read_shell_general_section,
    "DISTRIBUTING COUPLING": _nothing,
    "GAP": _nothing,
    "BEAM SECTION": read_beam_section,
    "BEAM GENERAL SECTION": read_beam_general_section,
    "SOLID SECTION": read_solid_section,
    "MASS": read_mass,
    "ROTARY INERTIA": read_rotary_inertia,
    "SPRING": read_spring,
    "DASHPOT": read_dashpot,
    "MEMBRANE SECTION": read_membrane_section,
    "COHESIVE SECTION": read_cohesive_section,
}


def _check_types(block: Block, rows: IntArray, elements: Elements) -> None:
    for row_type in np.unique(elements.type_idx[rows]):
        row = int(rows[int(np.argmax(elements.type_idx[rows] == row_type))])
        kind = elements.of(row)
        if block.name not in kind.sections:
            raise block.error(
                f"*{block.name}, ELSET={block.get('ELSET')} holds element {elements.ids[row]} of type {kind.name}",
                expected=f"*{' or *'.join(kind.sections)} for {kind.name}",
                fix="Leave the element out of the set, or use the right section.",
            )
