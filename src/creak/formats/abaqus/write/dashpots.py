"""Springs whose damping follows their stiffness: Abaqus has none, so it becomes dashpots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.formats.deck.refusals import unwritable
from creak.model.materials import AxialSpring, Bushing, NodalMatrices, Section, Spring, rayleigh
from creak.model.mesh import ElementBlock, Model


def with_dashpots(model: Model) -> tuple[Model, list[str]]:
    """The model with beta K of springs, bushings and matrices as dashpots, and which became one.

    Connectors hold both; a spring gets a dashpot beside it, an element of its own above all others.

    Raises
    ------
    InputError : a mass matrix that is damped in proportion to itself.
    """
    label = max((int(b.ids.max()) for b in model.blocks if b.ids.size), default=0)
    kept: list[ElementBlock] = []
    beside: list[ElementBlock] = []
    made: dict[int, tuple[Section, Section | None]] = {}
    notes: list[str] = []
    for block in model.blocks:
        section = block.section
        if id(section) not in made:
            made[id(section)] = _split(section)
            if made[id(section)][0] is not section:
                notes.append(f"{section.name}: its damping, proportional to its stiffness, is a dashpot in the deck")
        spring, dashpot = made[id(section)]
        kept.append(replace(block, section=spring))
        if dashpot is not None:
            ids = np.arange(label + 1, label + 1 + block.ids.size)
            label += block.ids.size
            beside.append(replace(block, section=dashpot, ids=ids))
    return replace(model, blocks=(*kept, *beside)), notes


def _split(section: Section) -> tuple[Section, Section | None]:
    """The section without beta, and the dashpot that stands beside it."""
    if not isinstance(section, Spring | AxialSpring | Bushing | NodalMatrices) or not any(rayleigh(section)):
        return section, None
    name = f"{section.name} DASHPOT"
    if isinstance(section, Spring | AxialSpring):
        dashpot = section.damping + section.beta * section.stiffness
        spring = replace(section, damping=0.0, beta=0.0)
        return spring, replace(spring, name=name, stiffness=0.0, damping=dashpot)
    damping = section.damping + section.beta * section.stiffness
    if isinstance(section, NodalMatrices):
        none = np.zeros_like(section.stiffness)
        if section.alpha:
            why = f"they damp by {section.alpha:g} 1/s times their mass, which *MASS, TYPE=ANISOTROPIC does not"
            raise unwritable(f"the matrices {section.name!r}", why)
        if section.mass.any():
            return replace(section, damping=damping, beta=0.0), None
        return replace(section, damping=none, beta=0.0), NodalMatrices(name, none, none, damping)
    return replace(section, damping=damping, beta=0.0), None
