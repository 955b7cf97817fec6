"""Abaqus deck -> Model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from creak.arrays import IntArray
from creak.errors import InputError
from creak.formats.abaqus.joints.connectors import joint_constraints
from creak.formats.abaqus.joints.contact import described_contact
from creak.formats.abaqus.joints.couplings import Placement, read_couplings
from creak.formats.abaqus.joints.fasteners import extended, read_fasteners, spring_blocks
from creak.formats.abaqus.joints.interactions import read_gaps
from creak.formats.abaqus.joints.links import read_links
from creak.formats.abaqus.joints.ties import read_ties
from creak.formats.abaqus.loads.boundary import read_boundaries, read_initial_velocity
from creak.formats.abaqus.loads.modal_steps import list_damping
from creak.formats.abaqus.loads.pressures import Bodies
from creak.formats.abaqus.loads.prestress import held_in_modes, list_prestress, read_static
from creak.formats.abaqus.loads.steps import list_yielding, read_run
from creak.formats.abaqus.loads.temperatures import node_temperatures
from creak.formats.abaqus.mesh.directions import held_along_axes, note_transformed, read_transforms
from creak.formats.abaqus.mesh.elements import read_elements
from creak.formats.abaqus.mesh.nodes import read_nodes
from creak.formats.abaqus.mesh.parts import make_blocks, read_parts
from creak.formats.abaqus.mesh.sets import RawSurface, read_sets, read_surfaces
from creak.formats.abaqus.sections.added_mass import with_added_mass
from creak.formats.abaqus.sections.assigned import read_sections
from creak.formats.abaqus.sections.materials import read_materials
from creak.formats.abaqus.sections.orientations import read_distributions, read_orientations
from creak.formats.abaqus.sections.own_data import Geometry, read_nodal_thickness
from creak.formats.abaqus.text.fields import with_short_names
from creak.formats.abaqus.text.keywords import misspelled
from creak.formats.abaqus.text.lexer import lex, with_parameters
from creak.formats.abaqus.text.outline import Outline, outline
from creak.formats.deck.refusals import reading
from creak.model.mesh import Model, Surface
from creak.model.steps import DeckRun

T = TypeVar("T")


def read_deck(path: str | Path) -> Model:
    """Read an Abaqus deck, flat or with parts and instances.

    Model data are read; of the steps only the zero-valued *BOUNDARY lines of the first one, because the
    study file defines the step. Everything else is listed in `Model.unread`; an entry with
    `changes_answer` is one that the caller should stop on. An instance is a part; in a flat deck the
    connected pieces of structure are (see `parts.read_parts`).

    Parameters
    ----------
    path : the .inp file; files it includes are found relative to it.

    Raises
    ------
    InputError : anything wrong with the deck, with file and line.
    """
    return _read(path, lambda deck: _model(deck, str(path), own_step=False)[0])


def read_deck_run(path: str | Path) -> tuple[Model, DeckRun]:
    """Read an Abaqus deck for a run of its own *DYNAMIC step (`steps.read_run`).

    `Model.fixed` holds what is held at zero in that step; `Model.unread` lists what of the step is not used.

    Raises
    ------
    InputError : anything wrong with the deck, with file and line.
    """

    def both(deck: Outline) -> tuple[Model, DeckRun]:
        model, run = _model(deck, str(path), own_step=True)
        assert run is not None
        return model, run

    return _read(path, both)


def _read(path: str | Path, made: Callable[[Outline], T]) -> T:
    blocks = with_parameters(lex(path))
    if not blocks:
        raise InputError(
            "the deck is empty",
            expected="keywords such as *NODE and *ELEMENT",
            where=path,
            fix="Is this the right file?",
        )
    with reading(path, lambda: misspelled(blocks)):
        return made(outline(blocks))


def _model(deck: Outline, source: str, *, own_step: bool) -> tuple[Model, DeckRun | None]:
    """The model, and the step that is to be run by itself, if any is."""
    nodes, node_names = read_nodes(deck)
    try:
        elements, element_names = read_elements(deck, node_names)
    except InputError as error:
        raise _not_generated(deck, error) from None
    read_sets(deck, elements, node_names, element_names)
    surfaces = read_surfaces(deck, nodes.coords, elements, node_names, element_names)
    distributions = read_distributions(deck, element_names, elements.ids.size)
    place = Placement(
        nodes.coords,
        read_orientations(deck, node_names, nodes.coords, distributions),
        read_transforms(deck, node_names, nodes.coords),
    )
    thickness = read_nodal_thickness(deck, node_names, nodes.count)
    geometry = Geometry(nodes.coords, place.orientations, thickness, distributions)
    assigned = read_sections(deck, elements, element_names, read_materials(deck), geometry)
    assigned = with_added_mass(deck, elements, element_names, assigned, nodes.coords)
    constraints = read_couplings(deck, surfaces, elements, node_names, element_names, place)
    fasteners = read_fasteners(deck, surfaces, node_names, geometry)
    nodes = extended(nodes, fasteners.points)
    constraints += fasteners.constraints
    constraints += joint_constraints((*assigned.connectors, *fasteners.joints), nodes.coords)
    constraints += read_links(deck, node_names, nodes.coords, place.transforms)
    constraints += read_ties(deck, nodes, elements, assigned, surfaces, node_names)
    note_transformed(deck, place.transforms, node_names)
    stops = read_gaps(deck, elements, element_names, nodes.coords, own_step=own_step)
    run = None
    if own_step:
        bodies = Bodies(nodes.coords, elements, element_names, with_short_names(surfaces, deck.instances))
        run = replace(read_run(deck, node_names, bodies, place.transforms), stops=stops)
    if run is None:
        list_damping(deck)
        list_yielding(deck)
    static = list_prestress(deck) if run is None else None
    held = held_in_modes(deck, static)
    fixed = read_boundaries(deck, node_names, held) if run is None else list(run.step.fixed)
    fixed, skew = held_along_axes(fixed, place.transforms)
    constraints += skew
    velocity = read_initial_velocity(deck, node_names)
    prestress = read_static(deck, static, node_names, place.transforms)
    partition = read_parts(deck, nodes, elements, element_names, constraints)
    made = make_blocks(elements, assigned, partition, nodes.coords)
    kept = made.place[:, 0] >= 0
    sets = {
        n: made.place[rows[kept[rows]]] for n, rows in element_names.sets.items() if not rows.size or kept[rows].any()
    }
    model = Model(
        source=source,
        nodes=nodes,
        blocks=(*made.blocks, *spring_blocks(fasteners, elements, partition.parts, nodes.count)),
        parts=partition.parts,
        node_sets={
            **with_short_names(node_names.sets, deck.instances),
            **{name: rows for stop in stops for name, rows in stop.node_sets.items() if run is None},
        },
        element_sets=with_short_names(sets, deck.instances),
        surfaces=with_short_names(_surfaces(surfaces, made.place), deck.instances),
        constraints=tuple(constraints),
        fixed=tuple(fixed),
        initial_velocity=tuple(velocity),
        unread=tuple(deck.unread),
        prestress=prestress,
        initial_temperature=node_temperatures(deck, node_names),
        contact=described_contact(deck, with_short_names(surfaces, deck.instances), node_names)
        if run is None
        else None,
        stops=stops if run is None else (),
    )
    return model, run


_GENERATORS = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY")


def _not_generated(deck: Outline, error: InputError) -> InputError:
    """An error of the elements, as what it comes from where the deck generates nodes."""
    found = next((u for u in deck.unread if u.keyword.lstrip("*") in _GENERATORS), None)
    if found is None:
        return error
    return InputError(
        f"{found.keyword} is not read, so that nodes are missing ({error})",
        where=found.where,
        expected="all nodes and elements written out",
        fix="Have your preprocessor write the flat deck.",
    )


def _surfaces(raw: Mapping[str, RawSurface], place: IntArray) -> dict[str, Surface]:
    named = {name: (s, *s.named) for name, s in raw.items()}
    return {name: Surface(s.name, place[rows], side, s.nodes_idx, s.where) for name, (s, rows, side) in named.items()}
