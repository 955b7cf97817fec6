"""[material.NAME] and [section.NAME] tables: numbers of the deck's materials and sections that the study changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from creak.errors import InputError, suggest
from creak.formats.deck.text import plain_name
from creak.model.elasticity import isotropic_sheet
from creak.model.laminates import of_other_materials, of_thickness, remade
from creak.model.materials import (
    AnisotropicMaterial,
    AnyMaterial,
    AxialSpring,
    Bushing,
    GeneralShell,
    Material,
    NodalMatrices,
    PointMass,
    Section,
    SheetMaterial,
    ShellSection,
    Spring,
    has_stiffness,
)
from creak.model.mesh import Model
from creak.studies.file.model_tables import MaterialTable, SectionTable
from creak.studies.file.places import Places

FACTOR = "stiffness_factor"
"""Key of what has no single stiffness."""


def with_properties(
    model: Model, materials: Mapping[str, MaterialTable], sections: Mapping[str, SectionTable], places: Places
) -> tuple[Model, list[str]]:
    """The model with other materials and sections, and what was changed. Names are case-insensitive.

    An element set stands for the sections that it holds all elements of, as the title of a part, or of several, does.

    Raises
    ------
    InputError : a name that the deck does not have, or a number that its material or section has not.
    """
    if not materials and not sections:
        return model, []
    known, notes, seen = properties_of(model), list[str](), dict[str, str]()
    for kind, tables in (("material", materials), ("section", sections)):
        for name, table in tables.items():
            for word in table.given:
                value = getattr(table, word)
                for own in sections_of(model, name) if kind == "section" else (name,):
                    if kind == "section" and seen.setdefault(own.upper(), name) != name:
                        raise InputError(
                            f"[section.{seen[own.upper()]}] and [section.{name}] both change {own}",
                            where=places.where(kind, name),
                            expected="one table for each section",
                            fix="Leave one of them out.",
                        )
                    key = _known(model, known, kind, own, word, places.where(kind, name, word))
                    model = _changed(model, key, value)
                    of = "" if own.upper() == name.upper() else f" of {own}"
                    notes.append(f"[{kind}.{name}]: {word}{of} is {value:g} in place of {known[key]:g}")
    return model, notes


def properties_of(model: Model) -> dict[tuple[str, str, str], float]:
    """(material or section, NAME, key) -> value, of all that the tables can change.

    A material whose density differs between sections, as by the nonstructural mass of a property, is left out with it.
    Springs of one name whose stiffnesses differ have a factor.
    """
    found: dict[tuple[str, str, str], float] = {}
    unlike: set[tuple[str, str, str]] = set()
    for block in model.blocks:
        for key, value in _numbers(block.section):
            unlike |= {key} if found.setdefault(key, value) != value else set()
    alike = {key: value for key, value in found.items() if key not in unlike}
    return alike | {
        (kind, name, FACTOR): 1.0 for kind, name, word in unlike if (kind, word) == ("section", "stiffness")
    }


def _numbers(section: Section) -> Iterator[tuple[tuple[str, str, str], float]]:
    name = section.name.upper()
    for material in _materials(section):
        isotropic = _isotropic(material)
        if isotropic is not None:
            yield ("material", material.name.upper(), "youngs_modulus"), isotropic.youngs_modulus
        if material.density > 0.0 and not isinstance(section, Bushing):
            yield ("material", material.name.upper(), "density"), material.density
    if not name:
        return
    if isinstance(section, ShellSection):
        yield ("section", name, "thickness"), section.thickness
    if isinstance(section, GeneralShell) and section.made_of and section.made_of.single_thickness:
        yield ("section", name, "thickness"), section.made_of.single_thickness
    if isinstance(section, Spring | AxialSpring) and section.stiffness > 0.0:
        yield ("section", name, "stiffness"), section.stiffness
    elif (isinstance(section, GeneralShell) and not section.rigid) or (
        isinstance(section, Bushing | NodalMatrices) and has_stiffness(section)
    ):
        yield ("section", name, FACTOR), 1.0
    elif isinstance(section, PointMass) and section.mass > 0.0:
        yield ("section", name, "mass"), section.mass


def _materials(section: Section) -> tuple[AnyMaterial, ...]:
    """What stiffness and mass of a section are made of; of shells and bushings given by their matrices nothing."""
    if isinstance(section, GeneralShell):
        return section.made_of.materials if section.made_of else ()
    if isinstance(section, Bushing):
        return (section.made_of,) if section.made_of else ()
    found = getattr(section, "material", None)
    return (found,) if isinstance(found, Material | AnisotropicMaterial) else ()


def _isotropic(material: AnyMaterial) -> Material | None:
    if isinstance(material, SheetMaterial):
        return material.isotropic.material if material.isotropic else None
    return material if isinstance(material, Material) else None


def sections_of(model: Model, name: str) -> tuple[str, ...]:
    """The sections whose elements a set holds, all of them and no others; else the name itself."""
    members = model.element_sets.get(name.upper())
    if members is None or any(b.section.name.upper() == name.upper() for b in model.blocks):
        return (name,)
    names = {model.blocks[row].section.name: None for row in np.unique(members[:, 0]).tolist()}
    every = sum(b.ids.size for b in model.blocks if b.section.name in names)
    return tuple(names) if "" not in names and every == len(members) else (name,)


def _known(
    model: Model, known: Mapping[tuple[str, str, str], float], kind: str, name: str, word: str, where: str
) -> tuple[str, str, str]:
    key = (kind, name.upper(), word)
    if key in known:
        return key
    names = [n for k, n, _ in known if k == kind]
    words = [w for k, n, w in known if (k, n) == (kind, name.upper())]
    if words:
        raise InputError(
            f"the {kind} {name!r} of the deck has no single {word}",
            where=where,
            expected=" or ".join(words),
            fix="Give what it has; one number cannot replace thicknesses that differ between elements or plies, or a "
            "density that differs between sections, which holds mass of their own.",
        )
    sets = [n for n in model.element_sets if kind == "section" and sections_of(model, n) != (n,)]
    raise InputError(
        f"the deck has no {kind} {name!r} with numbers that a study changes",
        where=where,
        fix=suggest(plain_name(name), [*names, *sets]),
    )


def _changed(model: Model, key: tuple[str, str, str], value: float) -> Model:
    of = {id(b.section): b.section for b in model.blocks}
    other = {i: _other(section, key, value) for i, section in of.items()}
    blocks = [replace(b, section=s) if (s := other[id(b.section)]) is not b.section else b for b in model.blocks]
    return replace(model, blocks=tuple(blocks))


def _other(section: Section, key: tuple[str, str, str], value: float) -> Section:
    """The section with another value; itself where the key is not one of its own."""
    kind, name, word = key
    if word == FACTOR and isinstance(section, Spring | AxialSpring) and section.name.upper() == name:
        return replace(section, stiffness=value * section.stiffness)
    if key not in dict(_numbers(section)):
        return section
    if kind == "material":
        return _of_other_material(section, name, word, value)
    if isinstance(section, GeneralShell) and word == "thickness":
        assert section.made_of is not None
        return remade(section, of_thickness(section.made_of, value))
    if isinstance(section, GeneralShell):
        scaled = {n: value * getattr(section, n) for n in ("A", "B", "D", "S")}
        return replace(section, **scaled, made_of=None)
    if isinstance(section, Bushing):
        return replace(section, stiffness=value * section.stiffness, made_of=None)
    if isinstance(section, NodalMatrices):
        return replace(section, stiffness=value * section.stiffness)
    return replace(section, **{word: value})  # type: ignore[arg-type]


def _of_other_material(section: Section, name: str, word: str, value: float) -> Section:
    """The section where a material that it is made of has another number."""
    if isinstance(section, GeneralShell) and section.made_of is not None:
        return remade(section, of_other_materials(section.made_of, lambda m: _other_material(m, name, word, value)))
    (old,) = _materials(section)
    new = _other_material(old, name, word, value)
    if isinstance(section, Bushing) and isinstance(old, Material):
        factor = value / old.youngs_modulus
        return replace(section, stiffness=factor * section.stiffness, made_of=new)  # type: ignore[arg-type]
    return replace(section, material=new)  # type: ignore[arg-type]


def _other_material(material: AnyMaterial, name: str, word: str, value: float) -> AnyMaterial:
    """The material with another number; itself where it has another name. G follows E by its ratio to it."""
    if material.name.upper() != name:
        return material
    if isinstance(material, SheetMaterial) and material.isotropic is not None:
        changed = replace(material.isotropic.material, **{word: value})  # type: ignore[arg-type]
        return isotropic_sheet(replace(material.isotropic, material=changed))
    return replace(material, **{word: value})  # type: ignore[arg-type]
