"""Section and property keywords -> the section of every element."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError
from creak.formats.abaqus.beams import read_beam_general_section, read_beam_section
from creak.formats.abaqus.elements import SOLIDS, TYPES, Elements
from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.materials import RawMaterial, find_material
from creak.formats.abaqus.names import Registry
from creak.formats.abaqus.numbers import positive
from creak.formats.abaqus.outline import Outline, Scope
from creak.formats.abaqus.points import read_dashpot, read_mass, read_rotary_inertia, read_spring
from creak.model.materials import Section, ShellSection, SolidSection, TrussSection

Materials = dict[str, RawMaterial]


@dataclass(frozen=True)
class Assigned:
    """Sections and which element has which."""

    sections: tuple[Section, ...]
    section_idx: IntArray
    """(n_elem,) rows into `sections`."""


def read_sections(deck: Outline, elements: Elements, names: Registry, materials: Materials) -> Assigned:
    """Read every section keyword and give each element its section.

    Raises
    ------
    InputError : unknown set or material, bad dimensions, wrong element type, an element with two
        sections or none.
    """
    sections: list[Section] = []
    places: list[str] = []
    section_idx = np.full(elements.ids.size, -1, dtype=np.int64)
    for scope, block in deck.blocks(*_READERS):
        rows = names.find(block.need("ELSET"), scope.name, block.where)
        _check_types(block, rows, elements)
        _check_free(block, rows, section_idx, elements, places)
        section_idx[rows] = len(sections)
        reader = read_truss_section if _is_truss(block, rows, elements) else _READERS[block.name]
        sections.append(reader(scope, block, materials))
        places.append(block.where)
        _list_directions(deck, scope, block)
    _check_all(elements, section_idx)
    return Assigned(tuple(sections), section_idx)


def read_shell_section(scope: Scope, block: Block, materials: Materials) -> Section:
    """*SHELL SECTION: homogeneous, mid-surface at the nodes, thickness on the data line."""
    for param in ("COMPOSITE", "OFFSET", "NODAL THICKNESS", "SHELL THICKNESS", "STACK DIRECTION"):
        value = block.option(param)
        if block.has(param) and not (param == "OFFSET" and value in ("0", "0.", "0.0", "MID", "MIDDLE")):
            raise InputError(
                f"*SHELL SECTION with {param} is not supported yet",
                expected="one thickness, reference surface in the middle",
                where=block.where,
                fix="Use a homogeneous section without this parameter.",
            )
    material = find_material(block.need("MATERIAL"), materials, block.where)
    fields, where = first_row(block, "the thickness")
    return ShellSection(block.get("ELSET"), material, positive(fields[0], where, "shell thickness"))


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
            raise InputError(
                f"*SOLID SECTION with {param} is not supported",
                expected="one material",
                where=block.where,
                fix="Give every material its elements and a section of its own.",
            )
    return SolidSection(block.get("ELSET"), find_material(block.need("MATERIAL"), materials, block.where))


def _is_truss(block: Block, rows: IntArray, elements: Elements) -> bool:
    """Is this the *SOLID SECTION of trusses?

    Raises
    ------
    InputError : it holds trusses and solids.
    """
    if block.name != "SOLID SECTION" or not rows.size:
        return False
    solid = np.array([t.kind in SOLIDS for t in TYPES])[elements.type_idx[rows]]
    if solid.any() and not solid.all():
        raise InputError(
            f"*SOLID SECTION, ELSET={block.get('ELSET')} holds both solids and trusses",
            expected="one kind",
            where=block.where,
            fix="Make two sections of it.",
        )
    return not solid.any()


def first_row(block: Block, what: str) -> tuple[list[str], str]:
    """First data line.

    Raises
    ------
    InputError : there is none.
    """
    for fields, where in block.rows():
        return fields, where
    raise InputError(
        f"*{block.name} has no data line", expected=f"a line with {what}", where=block.where, fix="Add it."
    )


_Reader = Callable[[Scope, Block, Materials], Section]
_READERS: dict[str, _Reader] = {
    "SHELL SECTION": read_shell_section,
    "BEAM SECTION": read_beam_section,
    "BEAM GENERAL SECTION": read_beam_general_section,
    "SOLID SECTION": read_solid_section,
    "MASS": read_mass,
    "ROTARY INERTIA": read_rotary_inertia,
    "SPRING": read_spring,
    "DASHPOT": read_dashpot,
}


def _check_types(block: Block, rows: IntArray, elements: Elements) -> None:
    for row_type in np.unique(elements.type_idx[rows]):
        row = int(rows[int(np.argmax(elements.type_idx[rows] == row_type))])
        kind = elements.of(row)
        if block.name not in kind.sections:
            raise InputError(
                f"*{block.name}, ELSET={block.get('ELSET')} holds element {elements.ids[row]} "
                f"of type {kind.name}",
                expected=f"*{' or *'.join(kind.sections)} for {kind.name}",
                where=block.where,
                fix="Leave the element out of the set, or use the right section.",
            )


def _check_free(
    block: Block, rows: IntArray, section_idx: IntArray, elements: Elements, places: list[str]
) -> None:
    taken = section_idx[rows] >= 0
    if taken.any():
        row = int(rows[int(np.argmax(taken))])
        raise InputError(
            f"element {elements.ids[row]} gets a second section; the first is at "
            f"{places[int(section_idx[row])]}",
            expected="one section for each element",
            where=block.where,
            fix="Make the element sets disjoint.",
        )


def _check_all(elements: Elements, section_idx: IntArray) -> None:
    without = np.flatnonzero(section_idx < 0)
    if without.size == 0:
        return
    kind = elements.of(int(without[0]))
    same = without[elements.type_idx[without] == elements.type_idx[without[0]]]
    shown = ", ".join(str(i) for i in elements.ids[same[:5]]) + (", ..." if same.size > 5 else "")
    count = f"{same.size} element{'s' if same.size > 1 else ''}"
    raise InputError(
        f"{count} of type {kind.name} ha{'ve' if same.size > 1 else 's'} no section: {shown}",
        expected=f"*{' or *'.join(kind.sections)} with an ELSET that holds each of them",
        where=elements.where(int(without[0])),
        fix=f"Add *{kind.sections[0]} for them.",
    )


def _list_directions(deck: Outline, scope: Scope, block: Block) -> None:
    if scope.rotated and block.name in ("SPRING", "DASHPOT"):
        deck.note(
            block,
            f"creak takes its directions as global, though instance {scope.name!r} is rotated",
            changes=True,
            what=f"*{block.name} in a rotated instance",
        )
