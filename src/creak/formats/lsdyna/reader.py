"""LS-DYNA keyword deck -> Model."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError
from creak.formats.deck.parts import Group, blocks_of, flat_parts
from creak.formats.deck.refusals import reading
from creak.formats.deck.surfaces import surfaces
from creak.formats.deck.text import plain_name
from creak.formats.lsdyna.joints.contact import described_contact, read_ties
from creak.formats.lsdyna.joints.points import read_points
from creak.formats.lsdyna.joints.rigid import read_rigid
from creak.formats.lsdyna.loads.supports import read_supports, support_sets
from creak.formats.lsdyna.loads.velocities import read_initial_velocity
from creak.formats.lsdyna.mesh.beams import read_beams
from creak.formats.lsdyna.mesh.nodes import Transforms, read_nodes, read_orientations, read_systems
from creak.formats.lsdyna.mesh.sets import ELEMENT_SETS, FaceFinder, Sets, nodes_of, read_sets, segment_surface
from creak.formats.lsdyna.mesh.shells import read_shells
from creak.formats.lsdyna.mesh.solids import read_solids
from creak.formats.lsdyna.sections.damping import read_damping
from creak.formats.lsdyna.sections.parts import Properties, read_laws, read_properties
from creak.formats.lsdyna.text.deck import Block, Deck
from creak.formats.lsdyna.text.keywords import KEYWORDS, list_unread, sorted_blocks
from creak.formats.lsdyna.text.lexer import read_blocks
from creak.model.faces import FACES, SHELL_FACETS
from creak.model.materials import BeamSection, Discrete, PointMass, TrussSection
from creak.model.mesh import ElementBlock, Model, Nodes, Surface
from creak.model.steps import DeckRun


def read_lsdyna(path: str | Path) -> Model:
    """Read the linear part of an LS-DYNA keyword deck (.k, .key, .dyn).

    Shells and solids become creak's own, whatever ELFORM says, with consistent mass; of material laws the elastic side
    is taken. What is not used is listed in `Model.unread`; an entry with `changes_answer` is one that the caller should
    stop on.

    Raises
    ------
    InputError : anything wrong with the deck, with file and line.
    """
    blocks = read_blocks(Path(path))
    named = [(b.name, f"*{b.name}", b.where) for b in blocks]
    with reading(path, lambda: "" if any(b.name == "NODE" for b in blocks) else KEYWORDS.misspelled(named)):
        return _model(blocks, str(path))


def read_lsdyna_run(path: str | Path) -> tuple[Model, DeckRun]:
    """creak runs no analysis that an LS-DYNA deck itself asks for.

    Raises
    ------
    InputError : always, or what is wrong with the deck before.
    """
    read_lsdyna(path)
    raise InputError(
        "creak does not run an LS-DYNA deck by its own controls",
        where=path,
        expected="a study file",
        fix=f"Write one: creak new {Path(path).name} --out study.toml",
    )


def _model(source: list[Block], path: str) -> Model:
    by_name, unread = sorted_blocks(source)
    if "NODE" not in by_name:
        raise InputError("the deck has no *NODE", where=path, fix="Is this the right file?")
    deck = Deck(by_name)
    transforms = Transforms(deck)
    of_nodes = read_nodes(deck, transforms)
    systems = read_systems(deck, transforms)
    properties = read_properties(deck, read_laws(deck), unread)
    read_shells(deck, properties, transforms)
    read_solids(deck, properties, transforms)
    read_beams(deck, properties)
    stops = read_points(deck, properties, read_orientations(deck, transforms))
    sets = read_sets(deck)
    fixed, skew = read_supports(deck, of_nodes, sets, systems)
    rigid, held = read_rigid(deck, properties, sets, fixed)
    constraints = [*rigid, *read_ties(deck, properties, sets, rigid), *skew]
    velocity = read_initial_velocity(deck, sets, systems, constraints)
    curves = read_damping(deck, sets, properties.parts.keys())
    list_unread(deck, [*unread, *curves])
    parts, of_node = flat_parts(list(deck.groups.values()), len(deck.nodes.ids), constraints, _part_name)
    blocks = blocks_of(deck.groups, of_node)
    element_sets = _element_sets(deck, blocks, properties, sets)
    skins = {**surfaces(blocks, element_sets), **_segment_surfaces(blocks, sets)}
    contact, of_sets = described_contact(deck, properties, sets, blocks, skins)
    return Model(
        source=path,
        nodes=Nodes(np.array(deck.nodes.ids, dtype=np.int64), deck.nodes.array),
        blocks=blocks,
        parts=parts,
        element_sets=element_sets,
        node_sets={
            **support_sets(fixed),
            **_node_sets(sets),
            **{name: rows for stop in stops for name, rows in stop.node_sets.items()},
        },
        surfaces={**skins, **of_sets},
        constraints=tuple(constraints),
        fixed=(*fixed, *held),
        initial_velocity=velocity,
        unread=tuple(deck.unread),
        contact=contact,
        stops=stops,
    )


def _part_name(group: Group, identifier: int) -> str:
    """Sections are named after the part that they were made for."""
    return group.section.name


def _node_sets(sets: Sets) -> dict[str, IntArray]:
    found: dict[str, list[int]] = {f"SET_NODE_{i}": rows for i, rows in sets.nodes.items()}
    for (keyword, i), title in sets.titles.items():
        if keyword == "SET_NODE":
            found.setdefault(plain_name(title), sets.nodes[i])
    return {name: np.array(rows, dtype=np.int64) for name, rows in found.items() if rows}


def _element_sets(
    deck: Deck, blocks: tuple[ElementBlock, ...], properties: Properties, sets: Sets
) -> dict[str, IntArray]:
    """PART_<id> and title of every part, of parts with one title together; SET_PART_<id>, SET_SHELL_<id>, ... and title
    of every set."""
    place = {(_family(b), int(i)): (n, k) for n, b in enumerate(blocks) for k, i in enumerate(b.ids.tolist())}
    of_part: dict[int, list[tuple[int, int]]] = {}
    for key, at in place.items():
        of_part.setdefault(deck.part_of.get(key, 0), []).append(at)
    found: dict[str, list[tuple[int, int]]] = {}
    titled: dict[str, list[tuple[int, int]]] = {}
    for pid, part in properties.parts.items():
        found[part.name] = of_part.get(pid, [])
        if part.title:
            titled.setdefault(plain_name(part.title), []).extend(found[part.name])
    found |= {title: places for title, places in titled.items() if title not in found}
    for i, pids in sets.parts.items():
        found[f"SET_PART_{i}"] = [at for pid in pids for at in of_part.get(pid, [])]
    for keyword, family in ELEMENT_SETS.items():
        for (of, i), ids in sets.elements.items():
            if of == family:
                found[f"{keyword}_{i}"] = [place[family, e] for e in ids if (family, e) in place]
    for (keyword, i), title in sets.titles.items():
        if f"{keyword}_{i}" in found:
            found.setdefault(plain_name(title), found[f"{keyword}_{i}"])
    return {name: np.array(rows, dtype=np.int64).reshape(-1, 2) for name, rows in found.items() if rows}


def _segment_surfaces(blocks: tuple[ElementBlock, ...], sets: Sets) -> dict[str, Surface]:
    """SET_SEGMENT_<id> and title."""
    if not sets.segments:
        return {}
    finder = FaceFinder(nodes_of(blocks))
    found = {}
    for i, segments in sets.segments.items():
        for name in (f"SET_SEGMENT_{i}", plain_name(sets.titles.get(("SET_SEGMENT", i), ""))):
            if name and segments:
                found[name] = segment_surface(name, segments, finder)
    return found


def _family(block: ElementBlock) -> str:
    """Elements of one family have ids of their own."""
    if block.kind in SHELL_FACETS:
        return "shell"
    if block.kind in FACES:
        return "solid"
    if isinstance(block.section, BeamSection | TrussSection):
        return "beam"
    assert isinstance(block.section, PointMass | Discrete)
    return "mass" if isinstance(block.section, PointMass) else "discrete"
