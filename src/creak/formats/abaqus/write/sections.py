"""Sections and materials -> keyword lines of an Abaqus deck."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.formats.abaqus.sections.beam_shapes import WALL, shape_of
from creak.formats.abaqus.write.directions import turned_spring
from creak.formats.abaqus.write.names import listed, number, numbers, quoted, vector
from creak.formats.deck.cross_section import CrossSection
from creak.formats.deck.refusals import unwritable
from creak.formats.written_deck import inverted
from creak.model.laminates import laminate
from creak.model.materials import (
    AnisotropicMaterial,
    AnyMaterial,
    AxialSpring,
    BeamSection,
    Bushing,
    GeneralShell,
    Material,
    NodalMatrices,
    PointMass,
    Section,
    ShellSection,
    SolidSection,
    Spring,
    TrussSection,
)

_ABAQUS_ORDER = np.array([0, 1, 2, 3, 5, 4])


class Materials:
    """Materials under the names they are written by; two of one name are told apart by a number."""

    def __init__(self) -> None:
        self.written: dict[str, AnyMaterial] = {}

    def name(self, material: AnyMaterial) -> str:
        count, name = 1, material.name
        while name.upper() in self.written and not _same(self.written[name.upper()], material):
            count += 1
            name = f"{material.name}-{count}"
        self.written[name.upper()] = material if name == material.name else replace(material, name=name)
        return name

    def lines(self) -> list[str]:
        return [line for m in self.written.values() for line in material_lines(m)]


def _same(a: AnyMaterial, b: AnyMaterial) -> bool:
    return a is b or material_lines(a) == material_lines(replace(b, name=a.name))


def material_lines(material: AnyMaterial) -> list[str]:
    """*MATERIAL with *ELASTIC, *DENSITY, *DAMPING and *EXPANSION.

    Raises
    ------
    InputError : a sheet whose engineering constants are not known.
    """
    if isinstance(material, Material):
        elastic = ["*ELASTIC", numbers((material.youngs_modulus, material.poisson_ratio))]
    elif isinstance(material, AnisotropicMaterial):
        D = material.elasticity[np.ix_(_ABAQUS_ORDER, _ABAQUS_ORDER)]
        elastic = ["*ELASTIC, TYPE=ANISOTROPIC", *listed([number(v) for v in triangle(D)])]
    elif material.constants:
        elastic = ["*ELASTIC, TYPE=LAMINA", numbers(material.constants)]
    else:
        raise unwritable(f"material {material.name!r}", "a sheet that is not orthotropic in its own axes")
    damping = [f"*DAMPING, ALPHA={number(material.alpha)}, BETA={number(material.beta)}"]
    return [
        f"*MATERIAL, NAME={quoted(material.name)}",
        *elastic,
        "*DENSITY",
        number(material.density),
        *(damping if material.alpha or material.beta else []),
        *_expansion(material),
    ]


def _expansion(material: AnyMaterial) -> list[str]:
    """*EXPANSION; nothing for one that depends on temperature or shears. A TREF is left to the initial temperature."""
    heat = material.expansion
    if heat is None or heat.flaw or any(heat.strain[3:]):
        return []
    a, b, c = heat.strain[:3]
    return ["*EXPANSION", number(a)] if a == b == c else ["*EXPANSION, TYPE=ORTHO", numbers((a, b, c))]


def lost_expansion(sections: Iterable[Section]) -> list[str]:
    """What the deck does not say of the thermal expansion of sections: TREF, and what `_expansion` leaves out."""
    notes: list[str] = []
    for section in sections:
        shell = section if isinstance(section, GeneralShell) else None
        own = getattr(section, "material", None)
        materials = shell.made_of.materials if shell and shell.made_of else (own,) if own else ()
        for material in materials:
            if material.expansion is not None and not _expansion(material):
                why = "its expansion, which depends on temperature or shears, is not in the deck"
                notes.append(f"{material.name}: {why}")
        of = shell or own
        if of is not None and of.expansion is not None and of.expansion.reference is not None:
            why = f"its TREF, {of.expansion.reference:g}, is not in the deck: it expands from the initial temperature"
            notes.append(f"{of.name}: {why}")
    return list(dict.fromkeys(notes))


def triangle(matrix: FloatArray) -> list[float]:
    """Columns of the upper triangle, as `elasticity.symmetric` reads them."""
    return [float(v) for v in matrix[np.tril_indices(len(matrix))]]


def section_lines(section: Section, elset: str, materials: Materials, orientation: str, at_nodes: bool) -> list[str]:
    """Keyword lines of a section on an element set.

    Parameters
    ----------
    orientation : name of the *ORIENTATION of its elements, empty for none.
    at_nodes : whether nodes, not the section, give the thickness of its shells.

    Raises
    ------
    InputError : the section is of a kind, or has values, that Abaqus keywords do not say.
    """
    if isinstance(section, Bushing):
        return _bushing(section, elset, orientation)
    elset = quoted(elset)
    also = f", ORIENTATION={orientation}" if orientation else ""
    if isinstance(section, ShellSection | GeneralShell):
        also += ", NODAL THICKNESS" if at_nodes else ""
        return [*_shell(section, elset, materials, also), *_area_mass(section, elset)]
    if isinstance(section, BeamSection):
        return _beam(section, elset, materials)
    if isinstance(section, TrussSection):
        head = f"*SOLID SECTION, ELSET={elset}, MATERIAL={quoted(materials.name(section.material))}"
        return [head, number(section.area)]
    if isinstance(section, SolidSection):
        return [f"*SOLID SECTION, ELSET={elset}, MATERIAL={quoted(materials.name(section.material))}{also}"]
    if isinstance(section, PointMass):
        return _point_mass(section, elset)
    if isinstance(section, NodalMatrices):
        turned = turned_spring(section)
        return _directed_mass(section, elset) if turned is None else _spring(turned.spring, elset, also)
    return _spring(section, elset, also)


def _shell(section: ShellSection | GeneralShell, elset: str, materials: Materials, also: str) -> list[str]:
    if isinstance(section, GeneralShell):
        return _general_shell(section, elset, materials, also)
    head = f"*SHELL SECTION, ELSET={elset}, MATERIAL={quoted(materials.name(section.material))}{also}"
    return [head, number(section.thickness)]


def _area_mass(section: ShellSection | GeneralShell, elset: str) -> list[str]:
    if not section.area_mass:
        return []
    return [f"*NONSTRUCTURAL MASS, ELSET={elset}, UNITS=MASS PER AREA", number(section.area_mass)]


def _general_shell(section: GeneralShell, elset: str, materials: Materials, also: str) -> list[str]:
    """Of plies where they are known, else by its stiffness."""
    total = sum(p.thickness for p in section.plies)
    if not section.plies:
        if section.offset or section.alpha or section.beta:
            raise unwritable(
                f"shell section {section.name!r}", "its plies are not known, and it has an offset or damping"
            )
        full = np.block([[section.A, section.B], [section.B.T, section.D]])
        head = f"*SHELL GENERAL SECTION, ELSET={elset}, DENSITY={number(section.mass)}{also}"
        return [head, *listed([number(v) for v in triangle(full)]), *_shear_lines(section.S)]
    guess = -(section.bottom + 0.5 * total) / total
    offset = 0.0
    if section.bottom != -0.5 * total:
        offset = inverted(lambda x: -0.5 * total - x * total, section.bottom, guess)
    shear = laminate("", section.plies, section.bottom).S
    lines = [f"*SHELL SECTION, ELSET={elset}, COMPOSITE{also}" + (f", OFFSET={number(offset)}" if offset else "")]
    for p in section.plies:
        degrees = inverted(math.radians, p.angle, math.degrees(p.angle))
        lines.append(f"{number(p.thickness)}, 3, {quoted(materials.name(p.material))}, {number(degrees)}")
    return lines if np.array_equal(shear, section.S) else [*lines, *_shear_lines(section.S)]


def _shear_lines(S: FloatArray) -> list[str]:
    return ["*TRANSVERSE SHEAR STIFFNESS", numbers((S[0, 0], S[1, 1], S[0, 1]))]


def _beam(section: BeamSection, elset: str, materials: Materials) -> list[str]:
    """By its shape where the shape says all, else by area and second moments."""
    if section.line_mass or section.twist_inertia is not None:
        why = "it has mass per length or a twist inertia of its own"
        if section.twist_inertia == 0.0 and not section.line_mass:
            why = "it has no inertia about its axis, as CBAR, and Abaqus's beams have rho (I11 + I22), as CBEAM"
        raise unwritable(f"beam section {section.name!r}", why)
    shape = shape_of(section.profile, section.dimensions)
    offset = None if shape is None else _offset(section, shape)
    if shape is not None and offset is not None:
        material = quoted(materials.name(section.material))
        head = f"*BEAM SECTION, ELSET={elset}, MATERIAL={material}, SECTION={section.profile}"
        lines = [head, *_size_lines(section.profile, section.dimensions), numbers(section.axis1)]
        lines += ["*BEAM SECTION OFFSET", numbers(offset)] if any(offset) else []
        return lines + _beam_shear(section, shape.shear_factors[0] * shape.area)
    if section.angle and not section.dimensions:
        raise unwritable(f"beam section {section.name!r}", "its second moments in axes 1 and 2 are not known")
    return _beam_by_moments(section, elset)


def _offset(section: BeamSection, shape: CrossSection) -> tuple[float, float] | None:
    """Of the section from where its shape lies by itself, to the last bit; None where it is no offset of the whole."""
    found = []
    for c, own in zip(section.centroid, shape.centroid, strict=True):
        found.append(0.0 if c == own else inverted(lambda o, own=own: own + o, c, c - own))  # type: ignore[misc]
    moved = tuple(s + o for s, o in zip(shape.shear_centre, found, strict=True))
    return (found[0], found[1]) if moved == section.shear_centre else None


def _size_lines(profile: str, size: tuple[float, ...]) -> list[str]:
    if profile != "ARBITRARY":
        return [numbers(size)]
    return [numbers(size[:6]), *(numbers(size[k : k + WALL]) for k in range(6, len(size), WALL))]


def _beam_by_moments(section: BeamSection, elset: str) -> list[str]:
    m = section.material
    if m.alpha or m.beta:
        raise unwritable(f"beam section {section.name!r}", "*BEAM GENERAL SECTION has no damping")
    profile, size = section.profile, section.dimensions
    if not size:
        profile, size = "GENERAL", (section.area, section.i11, 0.0, section.i22, section.torsion)
    shear = inverted(lambda g: m.youngs_modulus / (2.0 * g) - 1.0, m.poisson_ratio, m.shear_modulus)
    lines = [
        f"*BEAM GENERAL SECTION, ELSET={elset}, SECTION={profile}, DENSITY={number(m.density)}",
        *_size_lines(profile, size),
        numbers(section.axis1),
        numbers((m.youngs_modulus, shear)),
    ]
    shape = shape_of(profile, size)
    if any(section.centroid) or shape is not None:
        lines += ["*CENTROID", numbers(section.centroid)]
    if any(section.shear_centre) or shape is not None:
        lines += ["*SHEAR CENTER", numbers(section.shear_centre)]
    factor = 1.0 if shape is None else shape.shear_factors[0]
    return lines + _beam_shear(section, factor * section.area)


def _beam_shear(section: BeamSection, default: float) -> list[str]:
    """*TRANSVERSE SHEAR STIFFNESS where it differs from k A G; none for beams rigid in shear (B33)."""
    areas = (section.shear_area1, section.shear_area2)
    if areas == (0.0, 0.0) or areas == (default, default):
        return []
    G = section.material.shear_modulus
    k13, k23 = (inverted(lambda k, a=a: k / G, a, a * G) for a in areas)  # type: ignore[misc]
    return ["*TRANSVERSE SHEAR STIFFNESS", numbers((k23, k13))]


def _point_mass(section: PointMass, elset: str) -> list[str]:
    alpha = f", ALPHA={number(section.alpha)}" if section.alpha else ""
    if any(section.offset) or (section.mass and any(section.inertia)):
        why = "its centre is beside its node, or it has mass and inertia in one element"
        raise unwritable(f"mass {section.name!r}", why)
    if any(section.inertia):
        return [f"*ROTARY INERTIA, ELSET={elset}{alpha}", numbers(section.inertia)]
    return [f"*MASS, ELSET={elset}{alpha}", number(section.mass)]


def _directed_mass(section: NodalMatrices, elset: str) -> list[str]:
    m = np.diag(section.mass)[:3]
    plain = section.mass.shape == (6, 6) and np.array_equal(section.mass, np.diag([*m, 0.0, 0.0, 0.0]))
    if not plain or section.stiffness.any() or section.damping.any():
        why = "they are those of a mass along turned axes, or of more than one spring or dashpot"
        raise unwritable(f"the matrices {section.name!r}", why)
    return [f"*MASS, ELSET={elset}, TYPE=ANISOTROPIC", vector(m)]


def _spring(section: Spring | AxialSpring, elset: str, also: str) -> list[str]:
    if section.stiffness and section.damping:
        raise unwritable(f"spring {section.name!r}", "it damps as well; Abaqus has an element for each")
    keyword, value = ("DASHPOT", section.damping) if section.damping else ("SPRING", section.stiffness)
    dofs = ""
    if isinstance(section, Spring):
        dofs = f"{section.dof1}, {section.dof2}" if section.dof2 else f"{section.dof1}"
    return [f"*{keyword}, ELSET={elset}{also}", dofs, number(value)]


def _bushing(section: Bushing, elset: str, orientation: str) -> list[str]:
    kinds = {1.0: "CARTESIAN, ROTATION", 0.5: "BUSHING"}
    if section.location not in kinds:
        why = f"its springs act at {section.location:g} of the way between its nodes"
        raise unwritable(f"bushing {section.name!r}", why)
    name = quoted(f"BEHAVIOR-{elset}")
    lines = [f"*CONNECTOR SECTION, ELSET={quoted(elset)}, BEHAVIOR={name}", kinds[section.location]]
    lines += [orientation] if orientation else []
    lines.append(f"*CONNECTOR BEHAVIOR, NAME={name}")
    for keyword, matrix in (("ELASTICITY", section.stiffness), ("DAMPING", section.damping)):
        if matrix.any():
            lines += [f"*CONNECTOR {keyword}", *listed([number(v) for v in triangle(matrix)])]
    return lines
