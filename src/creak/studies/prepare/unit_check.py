"""A model's figures against the units it is said to be in: metres taken for millimetres, kilograms for tonnes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.model.faces import element_volumes
from creak.model.materials import (
    AnisotropicMaterial,
    GeneralShell,
    Material,
    PointMass,
    Section,
    SheetMaterial,
    ShellSection,
)
from creak.model.mesh import Model
from creak.model.units import METRES, UNITS, UnitsName
from creak.studies.file.places import Places
from creak.words import listed, percent

MODULUS = (1e4, 2e12)
"""Pa: Young's moduli from soft foam to beyond diamond."""
DENSITY = (5.0, 25_000.0)
"""kg/m^3: from light foam to beyond tungsten."""
SOUND = (10.0, 30_000.0)
"""m/s: sqrt(E / density), from soft rubber to beyond diamond."""
METAL = (5000.0, 5e9)
"""kg/m^3 and Pa: solids denser than this are metals, none of which is softer."""
HALF = 0.5
"""Share of the volume from which on the study's units are what is wrong, not the material's."""
FOAM = (50.0, 1e8)
"""kg/m^3 and Pa: solids lighter than this are foams, none of which is stiffer."""
STRUCTURAL = (100.0, 300.0)
"""kg/m^3 and m/s that a material must reach in another system to be taken for one of that system: foams and rubbers
are too odd to tell."""
SIZE = (0.01, 100.0)
"""m across the whole model."""
THICKNESS = (1e-5, 0.1)
"""m of most shells."""
SPREAD = (1e-3, 3e4)
"""kg/m^3: mass over the volume of the box round the model."""
FREQUENCY = (0.1, 2e4)
"""Hz: first natural frequency."""
SHARE = 0.1
"""Materials of fewer elements than this share are not judged: rigid or massless helpers have odd figures. Of more of
the volume than this share in another system nothing is run."""
SLIMMEST = 0.02
"""Sides of the box count as at least this share of its diagonal: plates have no thickness in their nodes."""


@dataclass(frozen=True)
class UnitSystem:
    """What the units of a deck are in SI."""

    name: str
    length: float
    """m"""
    stress: float
    """Pa"""
    density: float
    """kg/m^3"""
    words: tuple[str, str, str, str]
    """Units of length, stress, density and mass."""

    @property
    def mass(self) -> float:
        """kg"""
        return self.density * self.length**3

    @property
    def force(self) -> float:
        """N"""
        return self.stress * self.length**2


SYSTEMS = {
    name: UnitSystem(
        name, METRES[name], u.newton * u.per_metre**2, u.to_kg * u.per_metre**3, (u.length, u.stress, u.density, u.mass)
    )
    for name, u in UNITS.items()
}
"""What a study can name."""
OTHERS = (
    UnitSystem("mm-kg-ms", 1e-3, 1e9, 1e9, ("mm", "GPa", "kg/mm^3", "kg")),
    UnitSystem("mm-g-ms", 1e-3, 1e6, 1e6, ("mm", "MPa", "g/mm^3", "g")),
    UnitSystem("mm-kg-s", 1e-3, 1e3, 1e9, ("mm", "kPa", "kg/mm^3", "kg")),
)
"""What else decks are written in."""


@dataclass(frozen=True)
class Stuff:
    """A material as far as units show in it."""

    name: str
    modulus: float
    density: float
    elements: int
    volume: float
    """length^3 of all of them"""
    where: str
    """file:line of the first of them"""


def unit_warnings(model: Model, units: str, *, mass: float | None = None, frequency: float | None = None) -> list[str]:
    """Sentences about figures that can hardly be meant in `units`; empty where all are plausible.

    Ranges are wide: a factor of 1000 is found, a factor of 2 is not.

    Parameters
    ----------
    units : as the study says.
    mass : of the whole model, in its units; frequency : the first that is not zero, Hz. None: not looked at.
    """
    declared = SYSTEMS[units]
    known = _by_material(model)
    most = _odd(known, declared)[1] > HALF
    found = [text for stuff in _frequent(known) if (text := _material(model, stuff, declared, most=most))]
    found = found or _lengths(model, declared)
    if mass is not None:
        found = found or _mass(model, declared, mass)
    if frequency is not None and not found and not FREQUENCY[0] <= frequency <= FREQUENCY[1]:
        found = [f"the first natural frequency is {frequency:.3g} Hz: are density, modulus and lengths all in {units}?"]
    return found


def check_units(model: Model, units: str, places: Places) -> None:
    """Raise InputError where a good share of the volume is of materials in the other system that a study can name.

    Light skins and small helpers, whose figures are often odd, have next to no volume: of them is warned alone. So is
    of figures that fit no system which a study can name: a run in units without a name is right but for its labels.
    """
    declared = SYSTEMS[units]
    told = _by_material(model)
    odd, share = _odd([m for m in told if (_system_of(m, declared) or declared).name in SYSTEMS], declared)
    if share <= SHARE:
        return
    first = max(odd, key=lambda m: m.volume)
    other = _system_of(first, declared)
    assert other is not None
    right = [m.name for m in told if m.modulus > 0.0 and m.density > 0.0 and _fits(m, declared)]
    part = share * first.volume / sum(m.volume for m in odd)
    beside = f"; {listed(right)} fits {units}" if right else ""
    low, high = _ranges(declared)
    cure = _remedy(model, first, other, declared, most=share > HALF)
    also = f", and convert {listed(right)} as well" if right and share > HALF else ""
    raise InputError(
        f"the study is in {units}, but {_figures(first)} is in {other.name}: {percent(part)} of the model's volume, "
        f"its elements from {first.where} on{beside}",
        where=places.where("model", "units"),
        expected=f"one system of units; in {units} {low} and {high}",
        fix=f"These figures fit {other.name}: {cure}{also}.",
    )


def other_units(model: Model, units: str) -> str | None:
    """That most of the deck is in another system than the study says, in a sentence; None: it is not.

    Its figures fit together, but none of them is in the unit that it is labelled with.
    """
    declared = SYSTEMS[units]
    odd, share = _odd(_by_material(model), declared)
    other = _system_of(max(odd, key=lambda m: m.volume), declared) if share > HALF else None
    return None if other is None else f"the deck looks to be in {other.name}, not in {units} as the study says"


def guessed_units(model: Model) -> list[UnitSystem]:
    """Systems in which materials and size are plausible, those first in which a material is a structural one, then
    those that a study can name; empty without materials."""
    known = materials(model)
    if not known:
        return []
    fits = [s for s in (*SYSTEMS.values(), *OTHERS) if all(_fits(m, s) for m in known) and not _size(model, s)]
    return sorted(fits, key=lambda s: not any(_structural(m, s) for m in known))


def likely_units(model: Model, units: str) -> UnitSystem:
    """The named units where materials and size are plausible in them or leave it open, else the first that fits."""
    found = guessed_units(model)
    return SYSTEMS[units] if not found or SYSTEMS[units] in found else found[0]


def units_of_study(model: Model) -> UnitsName:
    """The likeliest system (`guessed_units`) where a study can name it, else mm-t-s."""
    likeliest = [s.name for s in guessed_units(model)[:1]]
    return next((name for name in get_args(UnitsName) if name in likeliest), "mm-t-s")


def named_systems(names: Iterable[str]) -> list[UnitSystem]:
    """The systems of these names."""
    known = {s.name: s for s in (*SYSTEMS.values(), *OTHERS)}
    return [known[name] for name in names]


def materials(model: Model) -> list[Stuff]:
    """What makes up a good share of the model's elements, the most frequent first."""
    return _frequent(_by_material(model))


def _frequent(known: Sequence[Stuff]) -> list[Stuff]:
    whole = max((m.elements for m in known), default=0)
    return sorted((m for m in known if m.elements >= SHARE * whole), key=lambda m: -m.elements)


def _by_material(model: Model) -> list[Stuff]:
    """The materials of all elements, in the order of the deck."""
    found: dict[tuple[str, float, float], Stuff] = {}
    for block in model.blocks:
        volume = float(element_volumes(block.kind, block.nodes_idx, model.nodes.coords, block.section).sum())
        for name, modulus, density, share in _stuffs(block.section):
            known = found.get((name, modulus, density), Stuff(name, modulus, density, 0, 0.0, block.where))
            found[name, modulus, density] = replace(
                known, elements=known.elements + block.ids.size, volume=known.volume + share * volume
            )
    return list(found.values())


def _stuffs(section: Section) -> Iterator[tuple[str, float, float, float]]:
    """Name, modulus, density and share of the volume of the materials of a section."""
    if isinstance(section, GeneralShell) and not section.plies:
        if section.thickness > 0.0 and not section.rigid:
            modulus, density = float(section.A[0, 0]) / section.thickness, section.mass / section.thickness
            yield section.name, modulus, density, 1.0
        return
    known = [(getattr(section, "material", None), 1.0)]
    if isinstance(section, GeneralShell):
        whole = sum(p.thickness for p in section.plies)
        known = [(p.material, p.thickness / whole) for p in section.plies]
    for m, share in known:
        if isinstance(m, Material):
            yield m.name, m.youngs_modulus, m.density, share
        elif isinstance(m, AnisotropicMaterial):
            yield m.name, float(m.elasticity[:3, :3].diagonal().max()), m.density, share
        elif isinstance(m, SheetMaterial):
            yield m.name, float(m.in_plane[:2, :2].diagonal().max()), m.density, share


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]


def _modulus_fits(stuff: Stuff, system: UnitSystem) -> bool:
    return stuff.modulus <= 0.0 or _within(stuff.modulus * system.stress, MODULUS)


def _density_fits(stuff: Stuff, system: UnitSystem) -> bool:
    return stuff.density <= 0.0 or _within(stuff.density * system.density, DENSITY)


def _fits(stuff: Stuff, system: UnitSystem) -> bool:
    speed = _sound(stuff, system)
    modulus, density = stuff.modulus * system.stress, stuff.density * system.density
    soft_metal = density > METAL[0] and 0.0 < modulus < METAL[1]
    stiff_foam = 0.0 < density < FOAM[0] and modulus > FOAM[1]
    plausible = _modulus_fits(stuff, system) and _density_fits(stuff, system)
    return plausible and not soft_metal and not stiff_foam and (speed is None or _within(speed, SOUND))


def _sound(stuff: Stuff, system: UnitSystem) -> float | None:
    """m/s; None where modulus or density are not known."""
    if stuff.modulus <= 0.0 or stuff.density <= 0.0:
        return None
    return math.sqrt(stuff.modulus * system.stress / (stuff.density * system.density))


def _odd(known: Sequence[Stuff], declared: UnitSystem) -> tuple[list[Stuff], float]:
    """Materials in another system than the declared one, and their share of the volume of all that have a density."""
    odd = [m for m in known if _system_of(m, declared) is not None]
    whole = sum(m.volume for m in known if m.modulus > 0.0 and m.density > 0.0)
    return odd, sum(m.volume for m in odd) / whole if whole else 0.0


def _material(model: Model, stuff: Stuff, declared: UnitSystem, *, most: bool) -> str:
    """What is odd about a material of a model; empty where nothing is."""
    if _fits(stuff, declared):
        return ""
    other = _system_of(stuff, declared)
    if other is not None:
        cure = _remedy(model, stuff, other, declared, most=most)
        return f"{_figures(stuff)} is in {other.name}, not in {declared.name}: {cure}"
    wrong = [
        words
        for value, words in zip((_modulus_fits, _density_fits), _ranges(declared), strict=True)
        if not value(stuff, declared)
    ]
    if not wrong:
        return (
            f"{_figures(stuff)} would carry sound at {_sound(stuff, declared):.3g} m/s in {declared.name}: look at "
            "both figures"
        )
    return f"{_figures(stuff)} is of no solid in {declared.name}, where {' and '.join(wrong)}"


def _figures(stuff: Stuff) -> str:
    return f"material {stuff.name} (E = {stuff.modulus:g}, density = {stuff.density:g})"


def _ranges(system: UnitSystem) -> tuple[str, str]:
    """Between what modulus and density of solids lie."""
    (soft, stiff), (light, heavy) = (x / system.stress for x in MODULUS), (x / system.density for x in DENSITY)
    _, stress, density, _ = system.words
    return f"E lies between {soft:g} and {stiff:g} {stress}", f"density lies between {light:g} and {heavy:g} {density}"


def _system_of(stuff: Stuff, declared: UnitSystem) -> UnitSystem | None:
    """The system in which a material is a structural one that fits not the declared one; None: it does, or none."""
    if _fits(stuff, declared):
        return None
    for system in (*SYSTEMS.values(), *OTHERS):
        if _fits(stuff, system) and _structural(stuff, system):
            return system
    return None


def _structural(stuff: Stuff, system: UnitSystem) -> bool:
    return stuff.density * system.density >= STRUCTURAL[0] and (_sound(stuff, system) or 0.0) >= STRUCTURAL[1]


def _remedy(model: Model, stuff: Stuff, other: UnitSystem, declared: UnitSystem, *, most: bool) -> str:
    """Name the other system, or convert the material where lengths or other materials are of the declared one.

    Parameters
    ----------
    most : whether most of the model is in another system than the declared one.
    """
    modulus, density = (
        stuff.modulus * other.stress / declared.stress,
        stuff.density * other.density / declared.density,
    )
    given = f"give {stuff.name} E = {modulus:.6g} and density = {density:.6g}"
    named = (
        f'set [model] units = "{other.name}", or --units {other.name} where a deck is run by itself'
        if other.name in SYSTEMS
        else f"convert the deck to {declared.name}"
    )
    of_declared, of_other = (not _lengths(model, system) for system in (declared, other))
    if of_declared and not of_other:
        return f"the lengths are in {declared.name}, so {given}"
    if most and of_declared:
        return f"{named}; or, where its {across(model):.3g} {declared.words[0]} across are right, {given}"
    return named if most else given


def _lengths(model: Model, system: UnitSystem) -> list[str]:
    """What is odd about size and thickness."""
    return _size(model, system) or _thickness(model, system)


def _size(model: Model, declared: UnitSystem) -> list[str]:
    size, unit = across(model), declared.words[0] or "units of length"
    if not size or _within(size * declared.length, SIZE):
        return []
    return [f"the model is {size:.3g} {unit} across: are its coordinates in {unit}, as {declared.name} has them?"]


def across(model: Model) -> float:
    """Diagonal of the box round all nodes of elements; 0 without."""
    box = _box(model)
    return float(np.linalg.norm(box))


def _box(model: Model) -> FloatArray:
    used = [b.nodes_idx.ravel() for b in model.blocks]
    return np.ptp(model.nodes.coords[np.concatenate(used)], axis=0) if used else np.zeros(3)


def _thickness(model: Model, declared: UnitSystem) -> list[str]:
    """Most shells thinner than foil or thicker than armour."""
    shells = [
        (b.section.thickness, b.ids.size)
        for b in model.blocks
        if isinstance(b.section, ShellSection | GeneralShell)
        and b.section.thickness > 0.0
        and not getattr(b.section, "rigid", False)
    ]
    odd = [t for t, n in shells if not _within(t * declared.length, THICKNESS) for _ in range(n)]
    if not odd or 2 * len(odd) < sum(n for _, n in shells):
        return []
    return [f"shells are {odd[0]:g} {declared.words[0]} thick: is their thickness in {declared.name}?"]


def _mass(model: Model, declared: UnitSystem, mass: float) -> list[str]:
    box = _box(model)
    volume = float(np.maximum(box, SLIMMEST * np.linalg.norm(box)).prod())
    if not volume or not mass or not materials(model):
        return []
    if _within(mass * declared.mass / (volume * declared.length**3), SPREAD):
        return []
    points = sum(b.section.mass * b.ids.size for b in model.blocks if isinstance(b.section, PointMass))
    told = f", {points:.3g} of it point masses" if points else ""
    return [f"the model has a mass of {mass:.3g} {declared.words[3]}{told}: is it in {declared.name}?"]
