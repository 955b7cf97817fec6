"""Model -> Abaqus deck."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.write.conditions import condition_lines, constraint_lines, set_lines, surface_lines
from creak.formats.abaqus.write.directions import by_direction, without_surfaces
from creak.formats.abaqus.write.elements import Written, element_lines
from creak.formats.abaqus.write.names import ROOT, Scopes, quoted, vector
from creak.formats.abaqus.write.sections import lost_expansion
from creak.formats.deck.catalogue import stop_on_unread
from creak.formats.deck.refusals import unwritable
from creak.formats.written_deck import write_checked
from creak.model.comparison import difference
from creak.model.materials import AxialSpring, Bushing, NodalMatrices, Section, Spring, rayleigh
from creak.model.mesh import ElementBlock, Model


def write_deck(model: Model, path: str | Path, ignore: Sequence[str] = ()) -> tuple[str, ...]:
    """Write the model data of a Model as an Abaqus deck, and read it back: the file appears only if nothing is lost.

    Flat, or one *PART and *INSTANCE for each instance, in global coordinates. Numbers have all their digits. Reading
    gives the same model back, as `model.comparison.difference` sees it, names of sections and materials aside:
    couplings that belong to no surface of the model get node surfaces `_COUPLING-n`, sections that belong to no
    element set `_SECTION-n`, a second material of one name a number. Beams whose axis 1 no third node gives have a
    section for each direction. Element types are those of the formulation (S4R becomes S4). Damping of springs that
    follows their stiffness becomes dashpots.

    Parameters
    ----------
    ignore : keywords of `Model.unread` that may be left out although they change the answer.

    Returns
    -------
    Which damping of springs became dashpots, and what is lost because it bears on contact or on thermal loads only.

    Raises
    ------
    InputError : the model holds what creak does not read from Abaqus decks (lumped mass, masses along turned axes,
        axes that vary inside a section), ties, or keywords that were not read; named, and nothing is written.
    """
    stop_on_unread(model, ignore)
    if model.mass_form != "consistent":
        raise InputError(
            f"the mass of this deck is {model.mass_form}; creak reads Abaqus decks with consistent mass",
            where=model.source,
            fix="Accept another mass with --mass consistent (the answer changes with it).",
        )
    model, damped = with_dashpots(model)
    model, notes = without_surfaces(by_direction(model))
    text = "\n".join(deck_lines(model)) + "\n"
    write_checked(path, text, lambda copy: _lost(model, copy), kind="an Abaqus", source=model.source)
    return (*damped, *notes, *lost_expansion(block.section for block in model.blocks))


def deck_lines(model: Model) -> list[str]:
    """Lines of the deck.

    Raises
    ------
    InputError : as `write_deck`.
    """
    scopes = Scopes(model)
    out = Written({scope: _nodes(model, scopes, scope) for scope in scopes.all})
    element_lines(model, scopes, out)
    set_lines(model, scopes, out)
    conditions, weights = constraint_lines(model, scopes, out)
    surface_lines(model, scopes, weights, out)
    conditions += condition_lines(model, scopes)
    lines = ["*HEADING", f"written by creak from {Path(model.source).name}"]
    for scope, name in enumerate(scopes.names):
        lines += [f"*PART, NAME={quoted(_part_name(model, name))}", *out.lines[scope], "*END PART"]
    inside = [*out.lines[ROOT], *conditions]
    if scopes.names:
        placed = [line for name in scopes.names for line in _instance(model, name)]
        inside = ["*ASSEMBLY, NAME=ASSEMBLY", *placed, *inside, "*END ASSEMBLY"]
    return [*lines, *inside, *out.materials.lines()]


def _nodes(model: Model, scopes: Scopes, scope: int) -> list[str]:
    rows = (scopes.of_node == scope).nonzero()[0].tolist()
    lines = [f"{int(model.nodes.ids[r])}, {vector(model.nodes.coords[r])}" for r in rows]
    return ["*NODE", *lines] if lines else []


def _instance(model: Model, name: str) -> list[str]:
    return [f"*INSTANCE, NAME={quoted(name)}, PART={quoted(_part_name(model, name))}", "*END INSTANCE"]


def _part_name(model: Model, instance: str) -> str:
    """The *PART of an instance: its alias where it has one."""
    return next((p.aliases[0] for p in model.parts if p.name == instance and p.aliases), instance)


def _same_part_names(copy: Model, model: Model) -> Model:
    """Parts of a flat deck are named after sets that happen to hold them: the names of the model instead."""
    if model.nodes.instance or len(copy.parts) != len(model.parts):
        return copy
    pairs = zip(copy.parts, model.parts, strict=True)
    return replace(copy, parts=tuple(replace(p, name=q.name, aliases=q.aliases) for p, q in pairs))


def _lost(model: Model, path: Path) -> str:
    """What the written deck lacks of the model."""
    return difference(model, _same_part_names(read_deck(path), model), names=False)


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
