"""A model's figures against the units it is said to be in: metres taken for millimetres, kilograms for tonnes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
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
from creak.model.units import METRES, UNITS

MODULUS = (1e4, 2e12)
"""Pa: Young's moduli from soft foam to beyond diamond."""
DENSITY = (12.0, 25_000.0)
"""kg/m^3: from light foam to beyond tungsten."""
SOUND = (10.0, 30_000.0)
"""m/s: sqrt(E / density), from soft rubber to beyond diamond."""
METAL = (5000.0, 5e9)
"""kg/m^3 and Pa: solids denser than this are metals, none of which is softer."""
SIZE = (0.01, 100.0)
"""m across the whole model."""
THICKNESS = (1e-5, 0.1)
"""m of most shells."""
SPREAD = (1e-3, 3e4)
"""kg/m^3: mass over the volume of the box round the model."""
FREQUENCY = (0.1, 2e4)
"""Hz: first natural frequency."""
SHARE = 0.1
"""Materials of fewer elements than this share are not judged: rigid or massless helpers have odd figures."""
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
        name, METRES[name], u.per_metre**2, u.to_kg * u.per_metre**3, (u.length, u.stress, u.density, u.mass)
    )
    for name, u in UNITS.items()
}
"""What a study can name."""
OTHERS = (
    UnitSystem("mm-kg-ms", 1e-3, 1e9, 1e9, ("mm", "GPa", "kg/mm^3", "kg")),
    UnitSystem("mm-g-ms", 1e-3, 1e6, 1e6, ("mm", "MPa", "g/mm^3", "g")),
    UnitSystem("mm-kg-s", 1e-3, 1e3, 1e9, ("mm", "kPa", "kg/mm^3", "kg")),
    UnitSystem("in-lbf-s", 0.0254, 6894.757, 1.068688e7, ("in", "psi", "lbf s^2/in^4", "lbf s^2/in")),
)
"""What else decks are written in."""


@dataclass(frozen=True)
class Stuff:
    """A material as far as units show in it."""

    name: str
    modulus: float
    density: float
    elements: int


def unit_warnings(model: Model, units: str, *, mass: float | None = None, frequency: float | None = None) -> list[str]:
    """Sentences about figures that can hardly be meant in `units`; empty where all are plausible.

    Ranges are wide: a factor of 1000 is found, a factor of 2 is not.

    Parameters
    ----------
    units : "mm-t-s" or "m-kg-s", as the study says.
    mass : of the whole model, in its units; frequency : the first that is not zero, Hz. None: not looked at.
    """
    declared = SYSTEMS[units]
    found = [text for stuff in materials(model) if (text := _material(stuff, declared, across(model)))]
    found = found or _size(model, declared) or _thickness(model, declared)
    if mass is not None:
        found = found or _mass(model, declared, mass)
    if frequency is not None and not found and not FREQUENCY[0] <= frequency <= FREQUENCY[1]:
        found = [f"the first natural frequency is {frequency:.3g} Hz: are density, modulus and lengths all in {units}?"]
    return found


def other_units(model: Model, units: str) -> str | None:
    """The first material whose figures are of another system than the study's, in a sentence; None: there is none."""
    declared = SYSTEMS[units]
    stuff = next((m for m in materials(model) if _system_of(m, declared) is not None), None)
    return (
        None
        if stuff is None
        else f"materials and study are of two systems of units: {_material(stuff, declared, across(model))}"
    )


def guessed_units(model: Model) -> list[UnitSystem]:
    """Systems in which materials and size are plausible, the ones a study can name first; empty without materials."""
    known = materials(model)
    if not known:
        return []
    return [s for s in (*SYSTEMS.values(), *OTHERS) if all(_fits(m, s) for m in known) and not _size(model, s)]


def likely_units(model: Model, units: str) -> UnitSystem:
    """The named units where materials and size are plausible in them or leave it open, else the first that fits."""
    found = guessed_units(model)
    return SYSTEMS[units] if not found or SYSTEMS[units] in found else found[0]


def named_systems(names: Iterable[str]) -> list[UnitSystem]:
    """The systems of these names."""
    known = {s.name: s for s in (*SYSTEMS.values(), *OTHERS)}
    return [known[name] for name in names]


def materials(model: Model) -> list[Stuff]:
    """What makes up a good share of the model's elements, the most frequent first."""
    count: dict[tuple[str, float, float], int] = {}
    for block in model.blocks:
        for name, modulus, density in _stuffs(block.section):
            key = (name, modulus, density)
            count[key] = count.get(key, 0) + block.ids.size
    whole = max(count.values(), default=0)
    found = [Stuff(*key, n) for key, n in count.items() if n >= SHARE * whole]
    return sorted(found, key=lambda s: -s.elements)


def _stuffs(section: Section) -> Iterator[tuple[str, float, float]]:
    """Name, modulus and density of the materials of a section; figures of zero say nothing and are left out."""
    if isinstance(section, GeneralShell) and not section.plies:
        if section.thickness > 0.0 and not section.rigid:
            modulus, density = float(section.A[0, 0]) / section.thickness, section.mass / section.thickness
            yield section.name, modulus, density
        return
    known = (
        (p.material for p in section.plies)
        if isinstance(section, GeneralShell)
        else [getattr(section, "material", None)]
    )
    for m in known:
        if isinstance(m, Material):
            yield m.name, m.youngs_modulus, m.density
        elif isinstance(m, AnisotropicMaterial):
            yield m.name, float(m.elasticity[:3, :3].diagonal().max()), m.density
        elif isinstance(m, SheetMaterial):
            yield m.name, float(m.in_plane[:2, :2].diagonal().max()), m.density


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]


def _fits(stuff: Stuff, system: UnitSystem) -> bool:
    modulus = stuff.modulus <= 0.0 or _within(stuff.modulus * system.stress, MODULUS)
    density = stuff.density <= 0.0 or _within(stuff.density * system.density, DENSITY)
    speed = _sound(stuff, system)
    heavy = stuff.density * system.density > METAL[0] and 0.0 < stuff.modulus * system.stress < METAL[1]
    return modulus and density and not heavy and (speed is None or _within(speed, SOUND))


def _sound(stuff: Stuff, system: UnitSystem) -> float | None:
    """m/s; None where modulus or density are not known."""
    if stuff.modulus <= 0.0 or stuff.density <= 0.0:
        return None
    return math.sqrt(stuff.modulus * system.stress / (stuff.density * system.density))


def _material(stuff: Stuff, declared: UnitSystem, size: float) -> str:
    """What is odd about a material of a model of this size; empty where nothing is."""
    if _fits(stuff, declared):
        return ""
    name = f"material {stuff.name} (E = {stuff.modulus:g}, density = {stuff.density:g})"
    other = _system_of(stuff, declared)
    if other is not None:
        return f"{name} is in {other.name}, not in {declared.name}: {_remedy(stuff, other, declared, size)}"
    _, stress, density, _ = declared.words
    wrong = []
    if stuff.modulus > 0.0 and not _within(stuff.modulus * declared.stress, MODULUS):
        low, high = (x / declared.stress for x in MODULUS)
        wrong.append(f"E lies between {low:g} and {high:g} {stress}")
    if stuff.density > 0.0 and not _within(stuff.density * declared.density, DENSITY):
        low, high = (x / declared.density for x in DENSITY)
        wrong.append(f"density lies between {low:g} and {high:g} {density}")
    if not wrong:
        return f"{name} would carry sound at {_sound(stuff, declared):.3g} m/s in {declared.name}: look at both figures"
    return f"{name} is of no solid in {declared.name}, where {' and '.join(wrong)}"


def _system_of(stuff: Stuff, declared: UnitSystem) -> UnitSystem | None:
    """The system that a material fits which does not fit the declared one; None: it does, or it fits none."""
    if _fits(stuff, declared) or not (stuff.modulus > 0.0 and stuff.density > 0.0):
        return None
    return next((s for s in (*SYSTEMS.values(), *OTHERS) if _fits(stuff, s)), None)


def _remedy(stuff: Stuff, other: UnitSystem, declared: UnitSystem, size: float) -> str:
    """Convert the material where the lengths are of the declared system, else name the other one."""
    lengths = [_within(size * system.length, SIZE) for system in (declared, other)]
    if lengths == [True, False]:
        modulus, density = (
            stuff.modulus * other.stress / declared.stress,
            stuff.density * other.density / declared.density,
        )
        return f"its lengths are, so give E = {modulus:.6g} and density = {density:.6g}"
    if other.name not in SYSTEMS:
        return f"convert the deck to {declared.name}"
    return f'set [model] units = "{other.name}", or --units {other.name} where a deck is run by itself'


def _size(model: Model, declared: UnitSystem) -> list[str]:
    size, unit = across(model), declared.words[0] or "units of length"
    if not size or _within(size * declared.length, SIZE):
        return []
    return [f"the model is {size:.3g} {unit} across: are its coordinates in {declared.name}?"]


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
