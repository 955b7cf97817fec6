"""[material.NAME] and [section.NAME] tables: numbers of the deck's materials and sections that the study changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from creak.errors import InputError, suggest
from creak.model.materials import (
    AnisotropicMaterial,
    AxialSpring,
    Bushing,
    GeneralShell,
    Material,
    PointMass,
    Section,
    ShellSection,
    Spring,
    has_stiffness,
)
from creak.model.mesh import Model
from creak.studies.file.design.property_tables import MaterialTable, SectionTable
from creak.studies.file.places import Places

AnySolid = Material | AnisotropicMaterial


def with_properties(
    model: Model, materials: Mapping[str, MaterialTable], sections: Mapping[str, SectionTable], places: Places
) -> tuple[Model, list[str]]:
    """The model with other materials and sections, and what was changed. Names are case-insensitive.

    Raises
    ------
    InputError : a name that the deck does not have, or a number that its material or section has not.
    """
    if not materials and not sections:
        return model, []
    known, notes = properties_of(model), []
    for kind, tables in (("material", materials), ("section", sections)):
        for name, table in tables.items():
            for word in table.given:
                key = _known(known, kind, name, word, places.where(kind, name, word))
                value = getattr(table, word)
                model = _changed(model, key, value)
                notes.append(f"[{kind}.{name}]: {word} is {value:g} in place of {known[key]:g}")
    return model, notes


def properties_of(model: Model) -> dict[tuple[str, str, str], float]:
    """(material or section, NAME, key) -> value, of all that the tables can change.

    A material whose density differs between sections, as by the nonstructural mass of a property, is left out with it.
    """
    found: dict[tuple[str, str, str], float] = {}
    unlike: set[tuple[str, str, str]] = set()
    for block in model.blocks:
        for key, value in _numbers(block.section):
            unlike |= {key} if found.setdefault(key, value) != value else set()
    return {key: value for key, value in found.items() if key not in unlike}


def _numbers(section: Section) -> Iterator[tuple[tuple[str, str, str], float]]:
    name, material = section.name.upper(), _material(section)
    if material is not None and not getattr(section, "rigid", False):
        if isinstance(material, Material):
            yield ("material", material.name.upper(), "youngs_modulus"), material.youngs_modulus
        if material.density > 0.0:
            yield ("material", material.name.upper(), "density"), material.density
    if not name:
        return
    if isinstance(section, ShellSection):
        yield ("section", name, "thickness"), section.thickness
    elif isinstance(section, Spring | AxialSpring) and section.stiffness > 0.0:
        yield ("section", name, "stiffness"), section.stiffness
    elif (isinstance(section, GeneralShell) and not section.rigid) or (
        isinstance(section, Bushing) and has_stiffness(section)
    ):
        yield ("section", name, "stiffness_factor"), 1.0
    elif isinstance(section, PointMass) and section.mass > 0.0:
        yield ("section", name, "mass"), section.mass


def _material(section: Section) -> AnySolid | None:
    """The material that stiffness and mass of a section are made of; a laminate's are in its resultants already."""
    found = getattr(section, "material", None)
    return found if isinstance(found, AnySolid) else None


def _known(
    known: Mapping[tuple[str, str, str], float], kind: str, name: str, word: str, where: str
) -> tuple[str, str, str]:
    key = (kind, name.upper(), word)
    if key in known:
        return key
    names = {n for k, n, _ in known if k == kind}
    words = [w for k, n, w in known if (k, n) == (kind, name.upper())]
    if words:
        raise InputError(
            f"the {kind} {name!r} of the deck has no single {word}",
            where=where,
            expected=" or ".join(words),
            fix="Give what it has; a density that differs between sections holds mass of their own.",
        )
    raise InputError(
        f"the deck has no {kind} {name!r} with numbers that a study changes", where=where, fix=suggest(name, names)
    )


def _changed(model: Model, key: tuple[str, str, str], value: float) -> Model:
    blocks = [
        replace(b, section=s) if (s := _other(b.section, key, value)) is not b.section else b for b in model.blocks
    ]
    return replace(model, blocks=tuple(blocks))


def _other(section: Section, key: tuple[str, str, str], value: float) -> Section:
    """The section with another value; itself where the key is not one of its own."""
    kind, _, word = key
    if key not in dict(_numbers(section)):
        return section
    if kind == "material":
        material = _material(section)
        assert material is not None
        return replace(section, material=replace(material, **{word: value}))  # type: ignore[arg-type]
    if isinstance(section, GeneralShell):
        scaled = {n: value * getattr(section, n) for n in ("A", "B", "D", "S")}
        return replace(section, **scaled)
    if isinstance(section, Bushing):
        return replace(section, stiffness=value * section.stiffness)
    return replace(section, **{word: value})  # type: ignore[arg-type]
