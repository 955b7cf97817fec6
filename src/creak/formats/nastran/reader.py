"""Nastran deck -> Model."""

from __future__ import annotations

from pathlib import Path

from creak.errors import InputError
from creak.formats.deck.parts import blocks_of, flat_parts
from creak.formats.deck.refusals import reading
from creak.formats.deck.surfaces import surfaces
from creak.formats.nastran.joints.direct_matrices import read_direct_matrices
from creak.formats.nastran.joints.fasteners import following_grids, read_fasteners
from creak.formats.nastran.joints.gaps import list_gaps
from creak.formats.nastran.joints.glue import CARDS as OF_GLUE
from creak.formats.nastran.joints.glue import read_glue, read_shell_to_solid
from creak.formats.nastran.joints.points import read_points
from creak.formats.nastran.joints.region_pairs import CARDS as OF_CONTACT
from creak.formats.nastran.joints.region_pairs import described_contact
from creak.formats.nastran.joints.rigid import read_rigid
from creak.formats.nastran.loads.modal_damping import CARD as DAMPING
from creak.formats.nastran.loads.modal_damping import list_damping
from creak.formats.nastran.loads.sets import named_loads, temperatures
from creak.formats.nastran.loads.supports import read_initial_velocity, read_supports, support_sets
from creak.formats.nastran.loads.transient import cards_of, read_transient
from creak.formats.nastran.mesh.bars import read_bars
from creak.formats.nastran.mesh.grids import Permanent, read_grids, read_systems
from creak.formats.nastran.mesh.sets import element_sets, named_regions, node_sets, untyped_sets
from creak.formats.nastran.mesh.shells import read_shells
from creak.formats.nastran.mesh.solids import read_solids
from creak.formats.nastran.sections.added_mass import add_mass
from creak.formats.nastran.sections.materials import read_materials
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.case_control import read_case_control
from creak.formats.nastran.text.deck import Deck, middle_equations
from creak.formats.nastran.text.deck_file import DeckFile, read_deck_file
from creak.formats.nastran.text.known_cards import CARDS, list_unread
from creak.model.constraints import Constraint
from creak.model.mesh import Model, Unread
from creak.model.steps import DeckRun


def read_nastran(path: str | Path) -> Model:
    """Read a Nastran deck (.bdf, .dat, .nas), or bulk data alone.

    The supports and multi-point constraints are those of the first subcase. Displacement frames (CD) are turned into
    global dofs: springs and masses become matrices, constraints equations. Mass is lumped at the grids unless
    PARAM,COUPMASS is positive, as in Nastran, and multiplied by PARAM,WTMASS. What is not used is listed in
    `Model.unread`; an entry with `changes_answer` is one that the caller should stop on.

    Raises
    ------
    InputError : anything wrong with the deck, with file and line.
    """
    return _read(path, own_run=False)[0]


def read_nastran_run(path: str | Path) -> tuple[Model, DeckRun]:
    """Read a Nastran deck for a run of its own SOL 109 or 112 (`transient.read_transient`).

    `Model.fixed` holds what is held at zero in that run; `Model.unread` lists what is not used in it.

    Raises
    ------
    InputError : anything wrong with the deck, with file and line.
    """
    model, run = _read(path, own_run=True)
    assert run is not None
    return model, run


def _read(path: str | Path, *, own_run: bool) -> tuple[Model, DeckRun | None]:
    source = read_deck_file(Path(path))
    with reading(path, lambda: CARDS.misspelled((c.name, c.name, c.where) for c in source.cards)):
        return _model(source, str(path), own_run)


def _model(source: DeckFile, path: str, own_run: bool) -> tuple[Model, DeckRun | None]:
    """The model, and the deck's own run where it is wanted."""
    deck, permanent = _deck(source, path, own_run)
    materials = read_materials(deck)
    read_shells(deck, materials)
    read_solids(deck, materials)
    constraints: list[Constraint] = [*middle_equations(deck), *read_bars(deck, materials)]
    add_mass(deck)
    fasteners, given_ends = read_fasteners(deck, materials)
    constraints += fasteners
    read_points(deck)
    read_direct_matrices(deck)
    constraints += read_rigid(deck)
    constraints += read_shell_to_solid(deck)
    glue = read_glue(deck)
    constraints += glue
    fixed, skew = read_supports(deck, permanent, own_run)
    constraints += following_grids(deck, given_ends, [*constraints, *skew], fixed)
    run = read_transient(deck, fixed) if own_run else None
    stops = list_gaps(deck) if run is None else ()
    used = {"CGAP", "PGAP"} if run is None else cards_of(run)
    used |= {DAMPING} if run is None and list_damping(deck) else set()
    n = len(deck.grids.ids)
    parts, of_node = flat_parts(list(deck.groups.values()), n, [*constraints, *skew], deck.property_name)
    blocks = blocks_of(deck.groups, of_node)
    regions = named_regions(deck)
    sets = element_sets(deck, blocks, source.property_names, source.set_names, regions)
    skins = surfaces(blocks, sets, {name: faces for name, (_, faces) in regions.items() if faces})
    contact = described_contact(deck, skins)
    used |= (OF_GLUE if glue else set()) | (OF_CONTACT if contact is not None and run is None else set())
    list_unread(deck, used, own_run=own_run)
    of_nodes = {
        **support_sets(deck, source.support_names),
        **node_sets(deck, source.set_names),
        **{n: rows for stop in stops for n, rows in stop.node_sets.items()},
    }
    model = Model(
        source=path,
        nodes=deck.grids.nodes(),
        blocks=blocks,
        parts=parts,
        element_sets=sets,
        node_sets=of_nodes,
        surfaces=skins,
        constraints=(*constraints, *skew),
        fixed=tuple(fixed) if run is None else run.step.fixed,
        initial_velocity=read_initial_velocity(deck),
        unread=tuple(deck.unread),
        initial_temperature=temperatures(deck, deck.case.initial_temperature),
        static_loads=named_loads(deck) if run is None else {},
        mass_form="lumped" if deck.param("COUPMASS", -1.0) <= 0.0 else "linear",
        contact=contact if run is None else None,
        frames=dict(deck.grids.axes),
        untyped=tuple(n for n in untyped_sets(deck, source.set_names) if n in sets and n in of_nodes),
        stops=stops,
    )
    return model, run


def _deck(source: DeckFile, path: str, own_run: bool) -> tuple[Deck, list[Permanent]]:
    """The cards with their points, and the dofs that GRID cards hold."""
    by_name: dict[str, list[Card]] = {}
    for card in source.cards:
        by_name.setdefault(card.name, []).append(card)
    if "GRID" not in by_name:
        raise InputError("the deck has no GRID cards", where=path, fix="Is this the right file?")
    systems = read_systems(source.cards)
    grids, permanent = read_grids(by_name, systems)
    case = read_case_control(source.executive, source.case, own_run)
    params = {card.text(0).upper(): card for card in by_name.get("PARAM", [])}
    deck = Deck(by_name, case, systems, grids, params, list(case.unread))
    for line in source.others:
        why = "creak reads the residual structure; read each superelement's bulk data as a deck of its own"
        deck.unread.append(Unread(line.text, line.where, True, why))
    for line in source.not_found:
        deck.unread.append(Unread("INCLUDE", line.where, False, "executive control (DMAP) that was not found"))
    if source.unended:
        why = f"it is missing: the deck was read to the end of the file, where {source.unended} is the last card"
        deck.unread.append(Unread("ENDDATA", source.last, False, why))
    return deck, permanent
